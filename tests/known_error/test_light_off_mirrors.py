"""Light that mirrors throw is known before a sample meets it."""

import math

import numpy as np
import pytest

import alight
from alight.compiled.scene import compile_scene
from alight.rendering.arriving_light import NEAREST, _least
from alight.rendering.light_behind_glass import light_behind_glass
from alight.rendering.pilot_rays import POINTS
from alight.rendering.schedules.stopping import Promise, judge_means
from alight.rendering.sight import Sight
from alight.scene import flatten

#: The lamp is below a mirror that makes an image of it: metres, W/(m^2 sr).
RADIUS, LAMP, MIRROR, SIDE = 0.01, 1.0, 1.5, 1.0
IMAGE = 2 * MIRROR - LAMP
RADIANCE, ALBEDO = 1e4, 0.4

#: Its reflecting side is below.
STILL = {
    "scale": 9.0,
    "rotate": {"axis": [1, 0, 0], "angle": 180},
    "translate": [0, 0, MIRROR],
}
STEPS = [{name: value} for name, value in STILL.items()]


def room(*, mirror="mirror", place=None, lamp=None, integrator=None, below=()):
    """A matt floor seen from above, under a horizontal mirror; `below` it are stronger lamps."""
    at = lamp or {"translate": [0, 0, LAMP]}
    nodes = {
        "floor": {"shape": "plane", "bsdf": {"type": "diffuse", "reflectance": ALBEDO}},
        "lamp": {
            "shape": {"type": "sphere", "radius": RADIUS},
            "transform": at,
            "light": {"type": "area", "radiance": RADIANCE},
        },
        "mirror": {"shape": "rectangle", "bsdf": {"type": mirror}, "transform": place or STEPS},
    }
    for i in below:
        nodes[f"below {i}"] = nodes["lamp"] | {
            "shape": {"type": "sphere", "radius": 30 * RADIUS},
            "transform": {"translate": [3.0 * i, 0, -50.0]},
        }
    # Below the mirror, so that the floor is seen directly.
    look = {"origin": [0, 0, 1.4], "target": [0, 0, 0], "up": [0, 1, 0]}
    return alight.load({
        "alight": 1, "film": {"size": [32, 32]}, "integrator": integrator or {"type": "path"},
        "nodes": nodes,
        "camera": {"type": "orthographic", "height": 2 * SIDE, "transform": {"look_at": look}},
    })  # fmt: skip


def found_in(scene):
    flat = flatten(scene)
    return light_behind_glass(Sight(flat, compile_scene(flat)))


def of_image():
    """Mean radiance of the floor by the lamp's image, and the mean probability to meet it."""
    x, y = np.meshgrid(*2 * [(np.arange(64) + 0.5) / 64 * 2 * SIDE - SIDE])
    square = x * x + y * y + IMAGE**2
    cosine, angle = IMAGE / np.sqrt(square), math.pi * RADIUS**2 / square
    light = ALBEDO / math.pi * RADIANCE * angle * cosine
    return light.mean(), (angle * cosine / math.pi).mean()


def once(table):
    """Light that has met the floor once: what it brings is the lamp's radiance times the albedo."""
    return table[table[:, 2] > 0.8 * ALBEDO * RADIANCE * table[:, 5]]


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"place": {"keyframes": [{"time": 0} | STILL, {"time": 1} | STILL | {"scale": 12.0}]}},
        {"lamp": {"keyframes": [
            {"time": 0, "translate": [-0.2, 0, LAMP]}, {"time": 1, "translate": [0.2, 0, LAMP]}
        ]}},
        {"below": range(1)},
    ],
    ids=["at rest", "the mirror grows", "the lamp moves", "another outshines it from afar"],
)  # fmt: skip
def test_a_mirror_is_a_window_to_an_image_of_the_lamp(changes):
    table = once(found_in(room(**changes)))
    light, q = of_image()
    assert table[:, 2].sum() / POINTS == pytest.approx(light, rel=0.08)
    assert table[:, 5].sum() / POINTS == pytest.approx(q, rel=0.08)


@pytest.mark.parametrize(
    "changes",
    [
        {"mirror": "diffuse"},
        {"integrator": {"type": "path", "light_sampling": "bsdf"}},
        {"integrator": {"type": "path", "caustics": "manifold"}},
        {"integrator": {"type": "bidirectional"}},
    ],
    ids=str,
)
def test_nothing_is_found_without_a_mirror_or_where_paths_are_led_to_it(changes):
    assert found_in(room(**changes)) is None


@pytest.mark.parametrize("count", [NEAREST, 255, 256, 4000])
def test_the_least_of_many_values_are_found(count):
    values = np.random.default_rng(count).permutation(count).astype(float)
    values[count // 2 :] = np.inf
    assert set(values[_least(values)]) >= set(np.sort(values)[:NEAREST])
    # A surface may be nowhere: what it sees is nothing, and ends no render.
    assert len(_least(np.full(count, np.nan))) == NEAREST


def test_a_picture_that_no_such_light_has_met_is_not_promised():
    means, counts = np.ones((32, 32, 4, 3), np.float32), np.full((32, 32, 4), 4)
    behind, asked = found_in(room()), Promise(0.05)
    means = means * of_image()[0]
    assert judge_means(means, counts, asked).met
    assert not judge_means(means, counts, asked, behind=behind).met
    # The same light is a small part of a bright picture.
    assert judge_means(means * 100.0, counts, asked, behind=behind).met
