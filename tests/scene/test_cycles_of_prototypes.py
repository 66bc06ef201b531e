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


def random_uses(seed):
    matrix = np.random.default_rng(seed).random((5, 5)) < 0.25
    return {
        name: "".join(itertools.compress(NAMES, row))
        for name, row in zip(NAMES, matrix, strict=True)
    }


def only(**uses):
    return dict.fromkeys(NAMES, "") | uses


@pytest.mark.parametrize(
    "uses",
    # Of two uses only the first, or only the second, leads back.
    [only(a="cb", c="a"), only(a="bc", c="a"), *map(random_uses, range(12))],
    ids=lambda uses: ",".join(map("".join, uses.items())),
)
def test_a_cycle_is_found_wherever_it_leads(uses):
    matrix = np.array([[m in uses[n] for m in NAMES] for n in NAMES])
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
