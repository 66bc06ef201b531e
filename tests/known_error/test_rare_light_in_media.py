"""Light that smoke scatters, or small bright surfaces throw through fog, is known beforehand."""

import math

import numpy as np
import pytest

from alight.rendering.pilot_rays import POINTS
from tests.known_error import test_light_off_mirrors as mirrors
from tests.known_error.test_light_off_surfaces import (
    ALBEDO,
    CARD,
    CLOSE,
    HEIGHT,
    POINT,
    RADIANCE,
    RADIUS,
    SIDE,
    WHITE,
    found_in,
    lamp_of,
    of_card,
    room,
)

#: Of a medium that takes up light, per metre; height of the camera.
TAKEN, EYE = 0.8, 0.6

#: A ball around the lamp, metres; its medium loses nothing.
BALL, DEPTHS = 0.05, 2.0


def through_fog(n=16):
    """Of the card's light in a medium that takes up light: mean, and mean square of a sample."""
    r = (np.arange(40) + 0.5) / 40 * CARD
    first = np.sqrt(r**2 + CLOSE**2)
    lit = RADIANCE * math.pi * RADIUS**2 * CLOSE / first**3 * np.exp(-TAKEN * first)
    radiance, area = WHITE / math.pi * lit, 2 * math.pi * r * CARD / 40
    x, y = np.meshgrid(*2 * [(np.arange(n) + 0.5) / n * 2 * SIDE - SIDE])
    square = x**2 + y**2 + HEIGHT**2
    left = np.exp(-TAKEN * (np.sqrt(square) + EYE))
    form = (left * HEIGHT**2 / (math.pi * square**2)).mean()
    return ALBEDO * form * (area * radiance).sum(), ALBEDO**2 * form * (area * radiance**2).sum()


def test_fog_takes_its_part_of_light_and_of_the_paths_that_meet_it():
    fog = {"type": "homogeneous", "sigma_a": TAKEN}
    table = found_in(room(None, {"type": "volpath", "max_depth": 3}, fog, lamp=lamp_of()))
    light, square = through_fog()
    assert table[:, 2].sum() / POINTS == pytest.approx(light, rel=0.08)
    assert (table[:, 2] ** 2 / table[:, 6]).sum() / POINTS == pytest.approx(square, rel=0.1)


#: The same smoke, its distances found by delta tracking, its transmittance by ratio tracking.
GRID = {
    "type": "grid",
    "values": [[[0.5, 0.5], [0.5, 0.5]], [[0.5, 0.5], [0.5, 0.5]]],
    "low": [-1, -1, 0],
    "high": [1, 1, 2],
    "scale": 2.0,
}


@pytest.mark.parametrize("kind", [{"type": "homogeneous"}, GRID], ids=["homogeneous", "grid"])
def test_smoke_around_a_lamp_keeps_its_power(kind):
    """A ball of a medium that loses red light nowhere, seen through like air."""
    ball = {
        "shape": {"type": "sphere", "radius": BALL},
        "bsdf": {"type": "null"},
        "interior": {
            **kind,
            "sigma_t": DEPTHS / BALL,
            "albedo": [1.0, 0.5, 0.5],
        },
        "transform": {"translate": [0, 0, 0.9]},
    }
    table = found_in(room(ball, {"type": "volpath", "max_depth": 60}, lamp=lamp_of(z=0.9)))
    x, y = np.meshgrid(*2 * [(np.arange(32) + 0.5) / 16 * SIDE - SIDE])
    light = ALBEDO * RADIANCE * RADIUS**2 * (0.9 / (x**2 + y**2 + 0.9**2) ** 1.5).mean()
    # Light sampling finds what passes.
    scattered = light * (1.0 - math.exp(-DEPTHS))
    assert table[:, 2].sum() / POINTS == pytest.approx(scattered, rel=0.1)
    # Green light ends where it collides, half of it at a time.
    assert table[:, 3].sum() < 0.5 * table[:, 2].sum()


@pytest.mark.parametrize("lamp", [lamp_of(), POINT], ids=["a ball", "a point"])
def test_a_hole_on_the_way_to_a_lit_card_changes_nothing(lamp):
    pane = {
        "shape": "disk",
        "bsdf": {"type": "null"},
        "transform": [{"scale": 3 * CARD}, {"translate": [0, 0, HEIGHT - 0.2 * CLOSE]}],
    }
    table = found_in(room(lamp=lamp, pane=pane))
    light, radiance, met = of_card()
    square = ALBEDO**2 * (met * radiance**2).sum()
    assert table[:, 2].sum() / POINTS == pytest.approx(light, rel=0.08)
    assert (table[:, 2] ** 2 / table[:, 6]).sum() / POINTS == pytest.approx(square, rel=0.1)


#: Fog under a mirror that makes an image of a lamp: of what reaches it, fog scatters all.
FOG = 0.5


def in_fog(n=16, steps=40):
    """Of fog that the camera sees in the light of the image: radiance, and how often it is met."""
    x, y = np.meshgrid(*2 * [(np.arange(n) + 0.5) / n * 2 * mirrors.SIDE - mirrors.SIDE])
    s = (np.arange(steps) + 0.5)[:, None, None] / steps * mirrors.EYE
    z = mirrors.EYE - s
    square = x**2 + y**2 + (mirrors.IMAGE - z) ** 2
    last = np.sqrt(square) * (mirrors.MIRROR - z) / (mirrors.IMAGE - z)
    met = FOG * np.exp(-FOG * (s + last)) / 4 * mirrors.RADIUS**2 / square
    met = met.mean() * mirrors.EYE
    return met * mirrors.RADIANCE, met


def test_light_that_fog_scatters_into_the_camera_is_known():
    medium = {"type": "homogeneous", "sigma_t": FOG, "albedo": 1}
    dark = {"shape": "plane", "bsdf": {"type": "diffuse", "reflectance": 0}}
    scene = mirrors.room(integrator="volpath", medium=medium, more={"floor": dark})
    table = mirrors.found_in(scene)
    light, met = in_fog()
    assert table[:, 2].sum() / POINTS == pytest.approx(light, rel=0.1)
    assert table[:, 5].sum() / POINTS == pytest.approx(met, rel=0.1)


def test_light_of_a_frosted_bulb_that_only_fog_shows_is_looked_for():
    medium = {"type": "homogeneous", "sigma_t": FOG, "albedo": 1}
    dark = {"shape": "plane", "bsdf": {"type": "diffuse", "reflectance": 0}}
    table = found_in(room(None, {"type": "volpath"}, medium, lamp=lamp_of(), floor=dark))
    assert table is not None and table[:, 2].sum() > 0.0
