"""Straight ways through balls in balls: each absorbs along its own part of the way, no more."""

from itertools import pairwise

import numpy as np
import pytest

from tests.estimators.test_absorption import CLEAR, TOLERANCE, ball, glass, lamp, seen

#: Balls around one another, of which paths know three.
DEEPEST = 3


def intervals(rng, low, high, depth=0):
    """Balls on the axis: (centre, radius, colour, how deep), those around others first."""
    if depth == DEEPEST:
        return
    middle = low + rng.uniform(0.3, 0.7) * (high - low)
    for near, far in ((low, middle), (middle, high)):
        near, far = near + 0.1 * (far - near) * rng.random(), far - 0.1 * (far - near)
        color = np.ones(3) if rng.random() < 0.2 else rng.uniform(0.3, 0.95, 3)
        yield float(0.5 * (near + far)), float(0.5 * (far - near)), color, depth
        if rng.random() < 0.7:
            yield from intervals(rng, near + 0.02, far - 0.02, depth + 1)


def left_between(balls, start, end):
    """What Beer and Lambert leave from one place of the axis to another."""
    marks = np.sort([start, end, *(z + s * r for z, r, _, _ in balls for s in (-1, 1))])
    left = np.ones(3)
    for near, far in pairwise(marks):
        middle = 0.5 * (near + far)
        around = [(d, i) for i, (z, r, _, d) in enumerate(balls) if abs(middle - z) < r]
        if around and min(start, end) < middle < max(start, end):
            left *= balls[max(around)[1]][2] ** (far - near)
    return left


@pytest.mark.parametrize("seed", range(6))
def test_each_body_dims_its_part_of_the_way(seed):
    rng = np.random.default_rng(seed)
    balls = list(intervals(rng, -3.0, 3.0))
    edges = np.array([z + s * r for z, r, _, _ in balls for s in (-1, 1)])
    # Two places that are at no surface, in balls or beyond them all.
    places = rng.uniform(-3.5, 3.5, 400)
    places = places[np.abs(places[:, None] - edges).min(axis=1) > 0.025]
    low = float(places[places < (-1.0 if seed % 2 else -3.0)][0])
    high = float(places[places > (1.0 if seed % 3 else 3.0)][0])
    nodes = {
        f"ball {i}": ball(r, dict(CLEAR) if min(color) == 1.0 else glass(color), z)
        for i, (z, r, color, _) in enumerate(balls)
    }
    nodes["lamp"] = lamp(0.02, low)
    options = {"max_depth": 2 * len(balls) + 4, "russian_roulette": "none"}
    found = seen(nodes, high, ["path", "volpath"][seed % 2], 4, options)
    np.testing.assert_allclose(found, left_between(balls, low + 0.02, high), **TOLERANCE)


@pytest.mark.parametrize("integrator", ["path", "volpath"])
def test_what_paths_forget_of_many_bodies_their_boundaries_tell(integrator):
    """Six balls around one another, from without and from the innermost one."""
    rng = np.random.default_rng(7)
    colors = rng.uniform(0.3, 0.95, (6, 3))
    balls = [(0.0, 3.0 - 0.5 * i, color, i) for i, color in enumerate(colors)]
    nodes = {f"ball {i}": ball(r, glass(c)) for i, (_, r, c, _) in enumerate(balls)}
    nodes["lamp"] = lamp(0.02, -3.2)
    options = {"max_depth": 20, "russian_roulette": "none"}
    for place in (3.3, 0.1):
        found = seen(nodes, place, integrator, 4, options)
        np.testing.assert_allclose(found, left_between(balls, -3.18, place), **TOLERANCE)
