"""Straight ways through balls in balls: each absorbs along its own part of the way, no more."""

from itertools import pairwise

import numpy as np
import pytest

from alight.bsdfs.adapters.blend import Blend
from alight.bsdfs.dielectrics.dielectric import Dielectric
from alight.bsdfs.interiors.bodies import body_below
from alight.bsdfs.matte.diffuse import Diffuse
from alight.textures.checkerboard import Checkerboard
from tests.estimators.test_absorption import CLEAR, COLOR, TOLERANCE, ball, glass, lamp, seen

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


@pytest.mark.parametrize("seed", range(4))
def test_blends_in_blends_absorb_by_their_shares(seed):
    """A share that varies over the surface, here that of a texture, counts as one half."""
    rng = np.random.default_rng(seed)

    def blend(depth):
        """(material, [(share, coefficients) of each body])."""
        kind = rng.integers(4 if depth else 2)
        if kind < 2 and depth < 3:
            weight, parts = rng.uniform(0.1, 0.9), [blend(depth + 1), blend(depth + 1)]
            share = 0.5 if kind else weight
            made = Blend(weight=Checkerboard() if kind else weight, bsdfs=[m for m, _ in parts])
            scaled = [(1.0 - share, parts[0][1]), (share, parts[1][1])]
            return made, [(factor * s, c) for factor, found in scaled for s, c in found]
        if kind == 2:
            return Diffuse(), []
        made = Dielectric(attenuation_color=rng.uniform(0.2, 1.0, 3).tolist())
        made = made.replaced(attenuation_distance=float(rng.uniform(0.5, 3.0)))
        return made, [(1.0, np.array(made.coefficients))]

    for _ in range(20):
        material, bodies = blend(0)
        whole = sum(share for share, _ in bodies)
        if bodies:
            expected = sum(share * c for share, c in bodies) / whole
            np.testing.assert_allclose(body_below(material), expected, rtol=1e-9)
        else:
            assert body_below(material) is None


def test_a_camera_in_a_body_that_moves_is_in_it_wherever_it_has_moved():
    look = {"look_at": {"origin": [0, 0, 5], "target": [0, 0, 4]}}
    frames = [{"time": 0, "translate": [0, 0, 0]}, {"time": 1, "translate": [0, 0, 5]}]
    nodes = {
        "body": ball(1.0, glass()) | {"transform": {"keyframes": frames}},
        "lamp": lamp(0.02, 4.5),
    }
    camera = {"fov": 0.2, "transform": look, "shutter": [0.999, 1.0]}
    np.testing.assert_allclose(seen(nodes, spp=4, camera=camera), COLOR**0.48, **TOLERANCE)
