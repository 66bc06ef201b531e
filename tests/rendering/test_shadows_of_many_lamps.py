"""Shadows of many lamps: what each brings to a place by its formula, and what stands between.

The lamps stand above the ground and below it, in front of balls and behind them; a veil may hang
before the camera.
"""

import json

import numpy as np
import pytest

from alight.compiled.scene import compile_scene
from alight.core.constants import LUMINANCE
from alight.films import fixed_point
from alight.formats import loads
from alight.lights.ground import SHADOW
from alight.scene import flatten
from tests.twin import film_of

SPP, SIDE = 64, 4


def shadow_of(nodes, eye, height=0.004, filter="box"):
    """The layer (4, 4), over a window that looks straight down from a place."""
    look = {"look_at": {"origin": eye, "target": [eye[0], eye[1] - 1.0, eye[2]], "up": [0, 0, 1]}}
    camera = {"type": "orthographic", "height": height, "transform": look}
    film = {"size": [SIDE, SIDE], "filter": {"type": filter}}
    # The ground lies below the lowest thing.
    grain = {"shape": {"type": "sphere", "radius": 0.001, "center": [90, 0.001, 0]}}
    data = {"alight": 1, "camera": camera, "film": film, "nodes": {**nodes, "grain": grain}}
    scene = compile_scene(flatten(loads(json.dumps(data))), aovs=(SHADOW,), structure="list")
    layer = film_of(scene, SPP).aovs[SHADOW]
    fixed_point.carry(layer)
    return fixed_point.to_float(layer)[..., 0] / SPP


def lamps_and_balls(rng):
    lamps = [
        (rng.uniform([-2, low, -2], [2, high, 2]), rng.uniform(0.2, 9.0, 3) * rng.random(3) ** 2)
        for low, high in ((1.0, 3.0), (1.0, 3.0), (1.0, 3.0), (0.3, 1.0), (-2.0, -0.3))
    ]
    balls = []
    for number, (place, _) in enumerate(lamps[:3]):
        # Before the first lamp, behind the second one, and anywhere.
        far = rng.uniform([0.4, 1.2, 0.5], [0.7, 1.3, 1.2])[number]
        balls.append((far * place, 0.08 * np.linalg.norm(place)))
    return lamps, balls


def hits(o, d, length, ball):
    """Whether a segment from o along the unit vector d meets a ball."""
    c, r = ball
    along = np.clip((c - o) @ d, 0.0, length)
    return np.linalg.norm(o + along * d - c) < r


@pytest.mark.parametrize("seed", range(4))
def test_the_shadow_is_the_share_of_the_light_that_is_kept_away(seed):
    rng = np.random.default_rng(seed)
    lamps, balls = lamps_and_balls(rng)
    place, total, kept = np.zeros(3), 0.0, 0.0
    for lamp, intensity in lamps:
        distance = np.linalg.norm(lamp)
        light = max(lamp[1], 0.0) / distance**3 * float(intensity @ LUMINANCE)
        total += light
        if any(hits(place, lamp / distance, distance, ball) for ball in balls):
            kept += light
    nodes = {
        f"lamp {i}": {
            "light": {"type": "point", "intensity": colour.tolist()},
            "transform": {"translate": at.tolist()},
        }
        for i, (at, colour) in enumerate(lamps)
    }
    for i, (c, r) in enumerate(balls):
        nodes[f"ball {i}"] = {"shape": {"type": "sphere", "center": c.tolist(), "radius": r}}
    veil = rng.uniform(0.2, 0.8) if seed % 2 else 0.0
    if veil:
        nodes["veil"] = {
            "shape": "disk",
            "bsdf": {"type": "mask", "opacity": veil, "bsdf": {"type": "diffuse"}},
            "transform": [
                {"scale": 0.005},
                {"rotate": {"axis": "x", "angle": 90}},
                {"translate": [0, 0.1, 0]},
            ],
        }
    assert 0.0 < kept < total
    # Shadow rays go through the veil, too, which is not everywhere in their way.
    assert all(abs(lamp[1]) < 20.0 * np.hypot(lamp[0], lamp[2]) for lamp, _ in lamps)
    found = shadow_of(nodes, [0.0, 0.2, 0.0]).mean()
    assert found == pytest.approx((1.0 - veil) * kept / total, abs=0.01)


LAMP = {"light": "point", "transform": {"translate": [0, 2, 0]}}
BALL = {"shape": {"type": "sphere", "center": [0, 1, 0], "radius": 0.3}}


def test_from_below_the_ground_no_shadow_is_seen():
    nodes = {"lamp": LAMP, "ball": BALL}
    np.testing.assert_allclose(shadow_of(nodes, [0.0, 0.5, 0.0]), 1.0, atol=1e-6)
    assert not shadow_of(nodes, [0.0, -0.5, 0.0]).any()


def test_filters_with_negative_parts_overshoot_at_the_edge_of_a_shadow():
    """The ball's shadow has the radius 2 tan(asin(0.3)), and beyond it the filter is negative."""
    edge = 2.0 * np.tan(np.arcsin(0.3))
    found = shadow_of({"lamp": LAMP, "ball": BALL}, [edge, 0.5, 0.0], 0.1, "mitchell")
    assert found.min() < -0.005 and found.max() > 1.02
