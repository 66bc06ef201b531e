"""Light that mirrors throw is known before a sample meets it."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

import alight
from alight.compiled.scene import compile_scene
from alight.rendering.arriving_light import NEAREST, Arrived, _nearest
from alight.rendering.light_behind_glass import light_behind_glass
from alight.rendering.pilot_rays import POINTS
from alight.rendering.schedules.stopping import Promise, judge_means
from alight.rendering.sight import Sight
from alight.scene import flatten

#: The lamp is below a mirror that makes an image of it: metres, W/(m^2 sr).
RADIUS, LAMP, MIRROR, SIDE = 0.01, 1.0, 1.5, 1.0
IMAGE = 2 * MIRROR - LAMP
RADIANCE, ALBEDO = 1e4, 0.4

#: Height of the camera, metres.
EYE = 1.4

#: Its reflecting side is below.
STILL = {
    "scale": 9.0,
    "rotate": {"axis": [1, 0, 0], "angle": 180},
    "translate": [0, 0, MIRROR],
}
STEPS = [{name: value} for name, value in STILL.items()]


def room(
    *, mirror="mirror", place=None, lamp=None, integrator=None, below=(), more=None, medium=None
):
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
    nodes |= more or {}
    # Below the mirror, so that the floor is seen directly.
    look = {"origin": [0, 0, EYE], "target": [0, 0, 0], "up": [0, 1, 0]}
    return alight.load({
        "alight": 1, "film": {"size": [32, 32]}, "integrator": integrator or {"type": "path"},
        "nodes": nodes,
        "camera": {"type": "orthographic", "height": 2 * SIDE, "transform": {"look_at": look}},
    } | ({"medium": medium} if medium else {}))  # fmt: skip


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


def test_a_mirror_shows_a_texel_as_it_shows_a_lamp_of_its_size():
    """A dark screen below the mirror, one texel in its middle; a small lamp on a board."""
    n, half = 65, 0.2
    pixels = [[0.0] * n for _ in range(n)]
    pixels[n // 2][n // 2] = 1e6
    picture = {"type": "bitmap", "pixels": pixels, "interpolation": "nearest"}
    black = {"type": "diffuse", "reflectance": 0}
    found = []
    for radiance, size in ((picture | {"color_space": "linear"}, half), (1e6, half / n)):
        screen = {
            "shape": "rectangle", "bsdf": black, "light": {"type": "area", "radiance": radiance},
            "transform": [{"scale": size}, {"translate": [0, 0, LAMP]}],
        }  # fmt: skip
        board = {"shape": "rectangle", "bsdf": black}
        board["transform"] = [{"scale": half}, {"translate": [0, 0, LAMP - 1e-4]}]
        table = found_in(room(more={"lamp": screen, "board": board}))
        assert table is not None
        found.append(table[:, 2].sum() / POINTS)
    assert found[0] == pytest.approx(found[1], rel=0.1)


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
def test_the_nearest_light_paths_are_those_of_a_list_of_all(count):
    rng = np.random.default_rng(count)
    # Rounded, so that many are at one distance and some at the point itself.
    places, points = (rng.normal(size=(n, 3)).round(1) for n in (count, 40))
    normals, own = (np.eye(3)[rng.integers(3, size=n)] for n in (count, 40))
    # A surface may be nowhere: what it sees is nothing, and ends no render.
    places[0], points[0] = np.nan, np.nan
    arrived = Arrived(places, normals, normals, normals, np.ones(count))
    near, reach = _nearest(arrived, points, own)
    squares = ((places - points[:, None]) ** 2).sum(2)
    squares[np.abs(own @ normals.T) < 0.5] = np.inf
    assert_allclose(np.sort(reach)[1:], np.sort(squares)[1:, :NEAREST], rtol=1e-12)
    assert_allclose(np.take_along_axis(squares, near, 1)[1:], reach[1:], rtol=1e-12)
    # In the order of the light paths, in which they are added up.
    assert (np.diff(near[1:]) > 0).all()


def test_a_picture_that_no_such_light_has_met_is_not_promised():
    means, counts = np.ones((32, 32, 4, 3), np.float32), np.full((32, 32, 4), 4)
    behind, asked = found_in(room()), Promise(0.05)
    means = means * of_image()[0]
    assert judge_means(means, counts, asked).met
    assert not judge_means(means, counts, asked, behind=behind).met
    # The same light is a small part of a bright picture.
    assert judge_means(means * 100.0, counts, asked, behind=behind).met
