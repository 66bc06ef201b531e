"""Light that small bright surfaces throw is known before a sample meets them."""

import math

import numpy as np
import pytest

import alight
from alight.compiled.scene import compile_scene
from alight.rendering import sight as sight_module
from alight.rendering.light_off_mirrors import light_off_mirrors
from alight.rendering.light_off_surfaces import light_off_surfaces
from alight.rendering.main_loop import job_of
from alight.rendering.pilot_rays import POINTS
from alight.rendering.schedules.schedule import Uniform
from alight.rendering.schedules.steering import Steered
from alight.rendering.schedules.stopping import Promise, judge_means
from alight.rendering.sight import Sight
from alight.scene import flatten

#: A lamp just below a small card: metres, W/(m^2 sr).
RADIUS, CLOSE, CARD, HEIGHT, SIDE = 0.002, 0.05, 0.1, 1.0, 1.0
RADIANCE, ALBEDO, WHITE = 1e5, 0.4, 0.8

#: The card faces the floor.
UNDER = [{"rotate": {"axis": [1, 0, 0], "angle": 180}}, {"translate": [0, 0, HEIGHT]}]


def lamp_of(radius=RADIUS, radiance=RADIANCE, z=HEIGHT - CLOSE):
    return {
        "shape": {"type": "sphere", "radius": radius},
        "bsdf": {"type": "diffuse", "reflectance": 0},
        "transform": {"translate": [0, 0, z]},
        "light": {"type": "area", "radiance": radiance},
    }


def room(card=None, integrator=None, medium=None, **more):
    """A matte floor seen from above, the camera below the card."""
    bsdf = {"type": "diffuse", "reflectance": WHITE}
    disk = {"shape": "disk", "bsdf": bsdf, "transform": [{"scale": CARD}, *UNDER]}
    nodes = {
        "floor": {"shape": "plane", "bsdf": {"type": "diffuse", "reflectance": ALBEDO}},
        "lamp": lamp_of(),
        "card": card or disk,
    }
    look = {"origin": [0, 0, 0.6], "target": [0, 0, 0], "up": [0, 1, 0]}
    return alight.load({
        "alight": 1, "film": {"size": [32, 32]}, "nodes": nodes | more,
        "integrator": integrator or {"type": "path", "max_depth": 3},
        "camera": {"type": "orthographic", "height": 2 * SIDE, "transform": {"look_at": look}},
    } | ({"medium": medium} if medium else {}))  # fmt: skip


def found_in(scene):
    flat = flatten(scene)
    return light_off_surfaces(Sight(flat, compile_scene(flat)))


def of_card(n=16):
    """Mean radiance of the floor by the lit card; radiance of parts of it, and how often paths from
    the floor meet these.
    """
    r = (np.arange(40) + 0.5) / 40 * CARD
    area = 2 * math.pi * r * CARD / 40
    square = r**2 + CLOSE**2
    lit = RADIANCE * math.pi * RADIUS**2 * CLOSE / square**1.5
    x, y = np.meshgrid(*2 * [(np.arange(n) + 0.5) / n * 2 * SIDE - SIDE])
    # Far away, it does not matter where on the card.
    form = (HEIGHT**2 / (math.pi * (x**2 + y**2 + HEIGHT**2) ** 2)).mean()
    radiance = WHITE / math.pi * lit
    return ALBEDO * form * float((area * radiance).sum()), radiance, form * area


#: As bright, and without a size.
POINT = {
    "light": {"type": "point", "intensity": RADIANCE * math.pi * RADIUS**2},
    "transform": {"translate": [0, 0, HEIGHT - CLOSE]},
}


@pytest.mark.parametrize("lamp", [lamp_of(), POINT], ids=["a ball", "a point"])
def test_a_lit_card_gives_the_light_that_it_throws_and_is_met_as_often_as_it_is_large(lamp):
    table = found_in(room(lamp=lamp))
    light, radiance, met = of_card()
    assert table[:, 2].sum() / POINTS == pytest.approx(light, rel=0.08)
    # What a sample brings is the radiance that it meets, times the albedo.
    square = (table[:, 2] ** 2 / table[:, 6]).sum() / POINTS
    assert square == pytest.approx(ALBEDO**2 * (met * radiance**2).sum(), rel=0.1)


def test_a_texel_throws_as_much_as_a_lamp_of_its_size():
    """A dark screen below the card, one texel at its rim; a small lamp at the rim of a board."""
    n, half = 64, 0.06
    pixels = [[0.0] * n for _ in range(n)]
    pixels[n // 2][n - 1] = 1e6
    picture = {"type": "bitmap", "pixels": pixels, "interpolation": "nearest"}
    black = {"type": "diffuse", "reflectance": 0}
    found = []
    for shining, x, y, size in (
        (picture | {"color_space": "linear"}, 0.0, 0.0, half),
        (1e6, half - half / n, -half / n, half / n),
    ):
        place = [{"scale": size}, {"translate": [x, y, HEIGHT - CLOSE]}]
        light = {"type": "area", "radiance": shining}
        lamp = {"shape": "rectangle", "bsdf": black, "light": light, "transform": place}
        below = [{"scale": half}, {"translate": [0, 0, HEIGHT - CLOSE - 1e-4]}]
        board = {"shape": "rectangle", "bsdf": black, "transform": below}
        table = found_in(room(lamp=lamp, board=board))
        assert table is not None
        found.append(table[:, 2].sum() / POINTS)
    assert found[0] == pytest.approx(found[1], rel=0.1)


@pytest.mark.parametrize("choice", ["tree", "uniform"])
def test_lamps_at_a_point_are_as_likely_as_light_sampling_has_them(choice):
    """Far and dark lamps below the floor, which a tree hardly asks from the card."""
    below = {
        f"below {x} {y}": {
            "light": {"type": "point", "intensity": 0.1 * POINT["light"]["intensity"]},
            "transform": {"translate": [3.0 * x, 3.0 * y, -50.0]},
        }
        for x in range(-2, 3)
        for y in range(-2, 2)
    }
    integrator = {"type": "path", "max_depth": 3, "light_choice": choice}
    table = found_in(room(integrator=integrator, lamp=POINT, **below))
    _, radiance, met = of_card()
    # A sample that has reached the card asks this lamp, or one of 21.
    times = 1.0 if choice == "tree" else 21.0
    square = (table[:, 2] ** 2 / table[:, 6]).sum() / POINTS
    assert square == pytest.approx(times * ALBEDO**2 * (met * radiance**2).sum(), rel=0.2)


@pytest.mark.parametrize("count", [1, 20])
def test_lamps_that_outshine_it_from_afar_do_not_hide_it(count):
    """Below the floor, each a thousand times as strong."""
    ball = lamp_of(0.5, 1e3 * RADIANCE * (RADIUS / 0.5) ** 2)
    below = {
        f"below {i}": ball | {"transform": {"translate": [3.0 * i, 0, -50.0]}} for i in range(count)
    }
    table = found_in(room(**below))
    assert table is not None
    assert table[:, 2].sum() / POINTS == pytest.approx(of_card()[0], rel=0.08)


def test_a_satin_bulb_keeps_the_power_of_its_lamp():
    """The lamp is in glass: étendue shrinks on the way out, and flux does not."""
    bulb = {
        "shape": {"type": "sphere", "radius": 0.05},
        "bsdf": {"type": "rough_dielectric", "alpha": 0.2},
        "transform": {"translate": [0, 0, 0.9]},
    }
    found = found_in(room(bulb, {"type": "path", "max_depth": 4}, lamp=lamp_of(z=0.9)))
    x, y = np.meshgrid(*2 * [(np.arange(32) + 0.5) / 16 * SIDE - SIDE])
    square = x**2 + y**2 + 0.9**2
    light = ALBEDO * RADIANCE * RADIUS**2 * (0.9 / square**1.5).mean()
    # A few per cent are turned back more often than paths of four edges are long.
    assert 0.8 * light < found[:, 2].sum() / POINTS < 1.05 * light


def test_what_clear_glass_turns_first_is_left_to_the_other_pilot_and_keeps_its_power():
    """Radiance falls where light leaves glass, and its étendue grows."""
    ball = {
        "shape": {"type": "sphere", "radius": 0.02},
        "bsdf": {"type": "dielectric"},
        "transform": {"translate": [0, 0, HEIGHT - CLOSE]},
    }
    # What the ball mirrors inside meets the black lamp again, or this, and not the floor.
    shade = {
        "shape": {"type": "sphere", "radius": 0.015, "center": [0, 0, HEIGHT - 1.8 * CLOSE]},
        "bsdf": {"type": "diffuse", "reflectance": 0},
    }
    flat = flatten(room(ball=ball, shade=shade))
    sight = Sight(flat, compile_scene(flat))
    assert light_off_surfaces(sight) is None
    table = light_off_mirrors(sight, sight.random())
    assert 0.8 < table[:, 2].sum() / POINTS / of_card()[0] < 1.1


@pytest.mark.parametrize(
    "changes",
    [
        {"integrator": {"type": "path", "max_depth": 2}},
        {"integrator": {"type": "direct"}},
        {"integrator": {"type": "path", "light_sampling": "bsdf"}},
        {"integrator": {"type": "bidirectional"}},
        {"card": {"shape": {"type": "sphere", "radius": 0.01}, "bsdf": {"type": "mirror"}}},
    ],
    ids=str,
)
def test_nothing_is_found_where_no_path_is_long_enough_or_all_are_led_to_it(changes):
    assert found_in(room(**changes)) is None


def test_a_picture_that_no_such_light_has_met_is_not_promised():
    means, counts = np.ones((32, 32, 4, 3), np.float32), np.full((32, 32, 4), 1)
    behind, asked = found_in(room()), Promise(0.05)
    means = means * of_card()[0]
    assert judge_means(means, counts, asked).met
    assert not judge_means(means, counts, asked, behind=behind).met
    # The same light is a small part of a bright picture.
    assert judge_means(means * 100.0, counts, asked, behind=behind).met


class Clock:
    def lap(self, name):
        pass


def test_pilots_share_what_they_begin_with(monkeypatch):
    """Points seen and lamps are found once; both pilots draw the same numbers behind the points."""
    calls = []
    for name in ("seen_points", "emitting_lights"):
        make = getattr(sight_module, name)
        monkeypatch.setattr(
            sight_module, name, lambda *a, name=name, make=make: calls.append(name) or make(*a)
        )
    flat = flatten(room())
    sight = Sight(flat, compile_scene(flat))
    mirrored, again = light_off_mirrors(sight, sight.random()), sight.random()
    assert len(mirrored) == 0
    assert light_off_surfaces(sight) is not None
    assert again.random() == sight.random().random()
    assert sorted(calls) == ["emitting_lights", "seen_points"]


def test_only_a_promise_looks_for_it():
    flat = flatten(room())
    scene = compile_scene(flat)
    options = {"seed": 3, "threads": 1, "replicates": 4}
    promised = job_of(flat, scene, Steered(16, 64, Promise(0.1)), Clock(), **options)
    assert np.array_equal(promised.rounds[0].rare_light, light_off_surfaces(Sight(flat, scene)))
    # A cap's pilot has samples of its own.
    assert promised.rare_light.behind_glass is None
    assert job_of(flat, scene, Uniform(4, 4), Clock(), **options).rounds[0].rare_light is None
