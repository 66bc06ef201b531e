"""Prototypes that contain themselves by any way are refused, and no others."""

import itertools
import re

import numpy as np
import pytest

import alight
from alight.core.errors import SceneError
from alight.scene.nodes import sort_by_use

NAMES = "abcde"


def scene_of(uses):
    """Prototypes of which each instances several others, some of them further below."""
    prototypes = {}
    for name in NAMES:
        children = {"own": {"shape": {"type": "sphere"}}}
        for used in uses[name]:
            children = {f"of_{used}": {"instance": used, "children": children}, **children}
        prototypes[name] = {"children": children}
    nodes = {"all": {"instance": "a"}, "lamp": {"light": {"type": "point"}}}
    camera = {"type": "pinhole"}
    return {"alight": 1, "camera": camera, "prototypes": prototypes, "nodes": nodes}


@pytest.mark.parametrize("seed", range(12))
def test_a_cycle_is_found_wherever_it_leads(seed):
    rng = np.random.default_rng(seed)
    matrix = rng.random((5, 5)) < 0.25
    uses = {n: [m for m, has in zip(NAMES, row, strict=True) if has]
            for n, row in zip(NAMES, matrix, strict=True)}  # fmt: skip
    # A way of five steps exists only if one of the five comes twice.
    is_cyclic = bool(np.linalg.matrix_power(matrix.astype(int), 5).any())
    try:
        alight.load(scene_of(uses))
    except SceneError as error:
        said = str(error)
    else:
        said = ""
    found = re.search(r"contains itself: ([^\n]*)", said)
    cycle, order = sort_by_use(uses)
    assert bool(found) == bool(cycle) == is_cyclic
    for chain in (found[1].split(" -> "), cycle) if found else ():
        assert chain[0] == chain[-1]
        assert all(after in uses[name] for name, after in itertools.pairwise(chain))
    if not found:
        assert sorted(order) == [*NAMES]
        assert all(order.index(used) < order.index(n) for n in NAMES for used in uses[n])
