"""Bounds of a light tree: where a group of lights may shine, and from where it may be seen."""

import numpy as np
import pytest

from alight.bsdfs.nesting import leaves
from alight.compiled.materials import compile_materials
from alight.core.registry import modules, type_name_of
from alight.core.vec import Vec3
from alight.lights.tree.bounds import (
    NEVER,
    ROW,
    WORDS,
    Bounds,
    Groups,
    bounds_at,
    bounds_of_row,
    group_importance,
    pack,
    unpack,
)
from alight.lights.tree.build import _groups
from alight.lights.tree.split import Leaves
from alight.lights.tree.traversal import BEHIND, least_cosine
from lanewise.jit import instantiate
from lanewise.view import View
from tests.lights.test_light_tree import TREE, run
from tests.shapes.tracing import PROGRAM, vec


def pair(axis, across, angle):
    """Two small flat lamps in one place that face directions `angle` to both sides of an axis."""
    axes = np.cos(angle) * axis + np.sin(angle) * np.stack([across, -across])
    nothing, ones, words = np.zeros((2, 3)), np.ones(2), np.arange(2, dtype=np.uint32)
    dark = 0.5 * np.pi * ones
    return Leaves(nothing, nothing, axes, 0.0 * ones, dark, 0.0 * ones, ones, words, words)


def unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def test_a_pair_shines_up_to_the_edge_of_each_lamp():
    rng, n = np.random.default_rng(0), 200
    for angle in np.append(rng.uniform(0.0, 1.57, 100), rng.uniform(1.5, 1.57, 300)):
        axis = unit(rng.normal(size=3))
        across = unit(np.cross(axis, rng.normal(size=3)))
        lamps = pair(axis, across, angle)
        group = unpack(pack(_groups(lamps, np.arange(2), np.zeros(1, int))))[0]
        # To the side of the first lamp on which the group ends, or all around it.
        edge = unit(np.cross(lamps.axis[0], rng.normal(size=(n, 3))))
        edge[: n // 2] = unit(np.cross(lamps.axis[0], np.cross(lamps.axis[0], axis)))
        inside = np.abs(0.03 * rng.normal(size=(n, 1)))
        p = vec((edge * np.cos(inside) + lamps.axis[0] * np.sin(inside)).T)
        bounds = instantiate(bounds_of_row, TREE, compiled=False)(View(group), 0)
        found = run(group_importance, bounds, p, p * np.float32(0.0), np.ones(n, bool), 0.0)
        assert np.all(found.unoriented > 0.0), angle


def test_both_ways_to_read_a_group_find_the_same():
    """Each number is another one, so that none stands for its neighbour."""
    rng, n = np.random.default_rng(5), 400
    cosine, truth = rng.uniform(-1.0, 1.0, n), rng.random((2, n)) < 0.5
    groups = Groups(
        center=rng.normal(size=(n, 3)).astype(np.float32),
        radius=rng.random(n),
        behind=-rng.random(n),
        axis=unit(rng.normal(size=(n, 3))),
        cosine=cosine,
        dark=rng.uniform(-1.0, 1.0, n),
        intensity=np.exp(rng.normal(size=n)),
        flat=truth[0],
        alike=truth[1],
    )
    words = pack(groups)
    rows = unpack(words)
    packed = View(np.ascontiguousarray(words).view(np.float32))
    at = np.arange(n, dtype=np.uint32) * WORDS
    found = instantiate(bounds_at, TREE, compiled=False)(packed, at)
    read = instantiate(bounds_of_row, TREE, compiled=False)
    for i in range(n):
        for name, mine, other in zip(Bounds._fields, found, read(View(rows), i * ROW), strict=True):
            if isinstance(mine, Vec3):
                mine, other = (np.array([v.x, v.y, v.z]) for v in (mine, other))
            np.testing.assert_allclose(mine[..., i], other, rtol=1e-6, atol=1e-6, err_msg=name)
    assert 0 < (rows[:, 12] == 1.0).sum() < n


@pytest.mark.parametrize("spread", [0.0, 0.4, 1.2, 1.5])
def test_a_far_group_is_the_mean_of_the_lit_cosines_over_the_squared_distance(spread):
    """Seen at an angle to its axis, its lamps' cosines lie evenly between the ends of its cone."""
    angle, far = np.linspace(0.01, 3.1, 200), 7.0
    across, zero = np.sin(angle), 0.0 * angle
    axis, dark = vec(np.array([0.0, 0.0, 1.0])), np.cos(min(spread + 0.5 * np.pi, np.pi))
    group = Bounds(
        vec(np.zeros(3)), 1e-4, 0.0, axis, np.cos(spread), np.sin(spread), dark, 5.0, 1.0, NEVER
    )
    # From straight below the point's normal: the cosine there is 1.
    p = vec(far * np.stack([across, zero, np.cos(angle)]))
    n = vec(-np.stack([across, zero, np.cos(angle)]))
    found = run(group_importance, group, p, n, np.zeros(len(angle), bool), 0.0)
    first, last = (np.cos(np.clip(angle + end, 0.0, np.pi)) for end in (-spread, spread))
    part = (np.arange(2000) + 0.5) / 2000
    lit = np.maximum(last + np.multiply.outer(part, first - last), 0.0).mean(axis=0)
    np.testing.assert_allclose(found.unoriented, 5.0 * lit / far**2, rtol=2e-3, atol=3e-4)
    np.testing.assert_allclose(found.importance, found.unoriented, rtol=1e-3)


EXAMPLES = {module: module.EXAMPLES for module in modules("bsdfs")}


@pytest.mark.parametrize("module", EXAMPLES, ids=lambda module: type_name_of(module))
def test_only_materials_that_may_scatter_light_from_behind_look_there(module):
    for example in EXAMPLES[module]:
        _, names, _ = compile_materials([example])
        least = least_cosine(PROGRAM._replace(bsdfs=names))
        # Mixtures are what their parts are.
        parts = [leaf.bsdf for leaf in leaves(example)]
        known = all(part.one_sided for part in parts) and "bent" not in names
        assert least == (0.0 if known else BEHIND), names
