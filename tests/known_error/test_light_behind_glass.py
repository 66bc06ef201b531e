"""Light behind clear glass is known before a sample meets it."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

import alight
from alight.compiled.scene import compile_scene
from alight.core.vec import Vec3
from alight.films import CELL_SIZE, Film
from alight.laws.statistics import LARGEST_Z
from alight.rendering import depth_cap, pilot_rays
from alight.rendering.depth_cap import light_beyond
from alight.rendering.light_behind_glass import DIRECTIONS, _through, light_behind_glass
from alight.rendering.main_loop import job_of
from alight.rendering.pilot_rays import POINTS, SHARP
from alight.rendering.plan import PilotSchedule
from alight.rendering.schedules.schedule import Uniform
from alight.rendering.schedules.steering import Steered
from alight.rendering.schedules.stopping import Promise, judge, judge_means
from alight.rendering.schedules.unseen import unseen_error
from alight.rendering.sight import Sight
from alight.scene import flatten

#: Radius and height of the lamp, half of the side that is seen of the floor, metres.
RADIUS, HEIGHT, SIDE = 0.01, 2.0, 1.0
RADIANCE, ALBEDO = 1e4, 0.4


class Clock:
    def lap(self, name):
        pass


def room(*, size=(32, 24), crop=None, pane="thin_dielectric", integrator=None, lamps=1, more=None):
    """A matt floor seen from above, and small lamps above a horizontal pane."""
    nodes = {
        "floor": {
            "shape": "plane",
            "bsdf": {"type": "diffuse", "reflectance": ALBEDO},
        },
        "lamp": {
            "shape": {"type": "sphere", "radius": RADIUS},
            "transform": {"translate": [0, 0, HEIGHT]},
            "light": {"type": "area", "radiance": RADIANCE / lamps},
        },
    }
    for i in range(1, lamps):
        nodes[f"lamp{i}"] = dict(nodes["lamp"])
    if pane:
        nodes["pane"] = {
            "shape": "rectangle",
            "bsdf": pane if isinstance(pane, dict) else {"type": pane},
            "transform": [{"scale": 9.0}, {"translate": [0, 0, 1.5]}],
        }
    nodes |= more or {}
    # Below the pane, so that the floor is seen directly.
    look = {"origin": [0, 0, 1.4], "target": [0, 0, 0], "up": [0, 1, 0]}
    film = {"size": list(size)} | ({"crop": list(crop)} if crop else {})
    return alight.load({
        "alight": 1, "film": film, "integrator": integrator or {"type": "path"}, "nodes": nodes,
        "camera": {"type": "orthographic", "height": 2 * SIDE, "transform": {"look_at": look}},
    })  # fmt: skip


def found_in(scene):
    flat = flatten(scene)
    return light_behind_glass(Sight(flat, compile_scene(flat)))


def of_floor(x, y):
    """Radiance of the floor, and the probability of a cosine-distributed path to meet the lamp."""
    square = x * x + y * y + HEIGHT**2
    cosine, angle = HEIGHT / np.sqrt(square), math.pi * RADIUS**2 / square
    return ALBEDO / math.pi * RADIANCE * angle * cosine, angle * cosine / math.pi


@pytest.mark.parametrize("lamps", [1, 3])
def test_the_pilot_sees_what_the_lamp_would_give_without_the_pane(lamps):
    size = (32, 24)
    # What the pane mirrors comes before.
    table = found_in(room(lamps=lamps))[-POINTS * DIRECTIONS :]
    assert table.shape == (POINTS * DIRECTIONS, 7)
    # Where in a cell a point lies is not told.
    across = size[0] // CELL_SIZE
    cells = table[:, 1].astype(int)
    pixel = 2 * SIDE / size[1]
    x = (np.arange(size[0]) + 0.5 - size[0] / 2) * pixel
    y = (np.arange(size[1]) + 0.5 - size[1] / 2) * pixel
    light, q = of_floor(*np.meshgrid(x, y))
    for cell in range(across * size[1] // CELL_SIZE):
        rows = slice(cell // across * CELL_SIZE, (cell // across + 1) * CELL_SIZE)
        columns = slice(cell % across * CELL_SIZE, (cell % across + 1) * CELL_SIZE)
        for values, wanted in ((table[:, 2] * DIRECTIONS, light), (table[:, 5], q)):
            inside = wanted[rows, columns]
            mine = values[cells == cell]
            assert inside.min() * 0.98 < mine.min() and mine.max() < inside.max() * 1.02
    total = np.bincount(table[:, 0].astype(int), table[:, 3], POINTS)
    error = total.std() / math.sqrt(POINTS)
    assert abs(total.mean() - light.mean()) < LARGEST_Z * error
    # A path that meets a lamp brings its radiance times the albedo.
    np.testing.assert_allclose(table[:, 3] / table[:, 6], ALBEDO * RADIANCE / lamps, rtol=1e-3)


#: No path meets it, whatever chance does.
BULB = {"light": {"type": "point", "intensity": 9}, "transform": {"translate": [0, 0, HEIGHT]}}


@pytest.mark.parametrize(
    "changes",
    [
        {"pane": None},
        {"pane": "diffuse"},
        {"pane": {"type": "rough_dielectric", "alpha": 0.3}},
        {"pane": "mirror"},
        {"integrator": {"type": "path", "light_sampling": "bsdf"}},
        {"integrator": {"type": "random_walk"}},
        {"integrator": {"type": "path", "caustics": "manifold"}},
        {"integrator": {"type": "bidirectional"}},
        {"more": {"lamp": BULB}},
    ],
    ids=str,
)
def test_nothing_is_found_where_light_is_not_behind_clear_glass_or_paths_are_led_to_it(changes):
    assert found_in(room(**changes)) is None


SHEET = {"shape": "rectangle", "transform": [{"scale": 9.0}, {"translate": [0, 0, 1.45]}]}
BOX = {"shape": "cube", "transform": [{"scale": 8.0}]}


@pytest.mark.parametrize(
    ("more", "share"),
    [
        ({"box": BOX | {"bsdf": {"type": "null"}}}, 1.0),
        ({"sheet": SHEET | {"bsdf": {"type": "null"}}}, 1.0),
        ({"sheet": SHEET | {"bsdf": {"type": "mask", "opacity": 0.2}}}, 0.8),
    ],
    ids=["camera in a box", "a null sheet", "leaves"],
)
def test_holes_let_light_on(more, share):
    plain = found_in(room())[:, 3].sum()
    found = found_in(room(more=more))
    assert found is not None
    assert found[:, 3].sum() == pytest.approx(share * plain, rel=0.1)


@pytest.mark.parametrize("pane", ["principled", "rough_dielectric"])
def test_glass_that_is_hardly_rough_is_glass_that_spreads_light(pane):
    of = {
        "principled": {"type": "principled", "transmission": 1, "roughness": 0, "ior": 1.01},
        "rough_dielectric": {"type": "rough_dielectric", "alpha": 0.001, "int_ior": 1.01},
    }
    smooth, rough = found_in(room()), found_in(room(pane=of[pane]))
    assert rough[:, 3].sum() == pytest.approx(smooth[:, 3].sum(), rel=0.1)
    assert np.median(rough[:, 5]) > np.median(smooth[:, 5])


def test_what_moves_is_looked_at_too():
    """A pane that slides in its own plane, and one that leaves the way half of the time."""
    plain = found_in(room())[-POINTS * DIRECTIONS :, 3].sum()
    for away, share in ((1.0, 1.0), (200.0, 0.0)):
        moves = {"keyframes": [
            {"time": 0, "scale": 9.0, "translate": [0, 0, 1.5]},
            {"time": 1, "scale": 9.0, "translate": [away, 0, 1.5]},
        ]}  # fmt: skip
        sheet = {"shape": "rectangle", "bsdf": {"type": "thin_dielectric"}, "transform": moves}
        found = found_in(room(pane=None, more={"pane": sheet}))
        found = found[-POINTS * DIRECTIONS :, 3].sum() if found is not None else 0.0
        assert found == pytest.approx(share * plain, rel=0.1, abs=0.2 * plain), away


def test_cells_are_those_of_the_window():
    table = found_in(room(crop=(5, 9, 17, 10)))
    assert set(table[:, 1].astype(int)) == set(range(3 * 2))


def unseen(behind, *, spp=16, brightness=1.0, error=0.01, largest=None):
    means = np.full((8, 16, 4, 3), brightness, np.float32)
    return unseen_error(means, np.full((8, 16, 4), spp // 4), error, largest, behind=behind)


def test_what_is_missing_by_its_formula():
    """Two points in the second cell, of 64 * 16 samples; one sees two lights."""
    q = np.array([1e-3, 3e-3, 2e-3])
    light = np.array([[0.1, 0.2, 0.3], [0.4, 0.1, 0.2], [0.2, 0.2, 0.2]])
    rows = np.column_stack([[7, 9, 9], [1, 1, 1], light, q])
    unmet = light * np.exp(-512 * q)[:, None]
    points = np.stack([unmet[0], unmet[1] + unmet[2]])
    epsilon = 0.1**2
    relmse = (points**2 / ((1.0 + points) ** 2 + epsilon)).mean(axis=1).sum() / POINTS
    found = unseen(rows)
    assert found.indicator == pytest.approx(math.sqrt(relmse), rel=1e-5)
    assert found.figure == found.indicator
    # A bound that is known counts if it is smaller.
    assert unseen(rows, largest=1e-3).figure < 1e-4
    assert unseen(rows, error=1e-9).factor > 1.0 == unseen(rows, error=1e-3, largest=1e-3).factor
    # Two points of all, the second with a little less.
    for error, share in ((1e-3, 2), (0.111, 1), (0.2, 0)):
        assert unseen(rows, error=error).doubtful == share / POINTS, points
    assert unseen(rows, spp=64).indicator < found.indicator


def test_what_is_missing_is_the_mean_square_of_what_cells_lack():
    """A cell of 1 024 samples lacks the whole light, or has met some of it."""
    rate, light, rng = 1.2e-3, 0.2, np.random.default_rng(3)
    lacks = rng.poisson(1024 * rate, 100_000) == 0
    scale = np.where(lacks, light, 0.0).mean() + 1.0
    rows = np.column_stack([np.arange(POINTS), np.zeros(POINTS), np.full((POINTS, 3), light),
                            np.full((POINTS, 2), rate)])  # fmt: skip
    missing = math.sqrt((np.where(lacks, light, 0.0) ** 2).mean()) / scale
    assert unseen(rows).hidden == pytest.approx(missing, rel=0.06)


def test_so_many_more_samples_are_told_that_it_is_met():
    rows = np.column_stack(
        [np.arange(POINTS), np.zeros(POINTS), np.ones((POINTS, 3)), np.full(POINTS, 1e-6)]
    )
    for error in (0.01, 0.2):
        factor = unseen(rows, error=error).factor
        assert unseen(rows, error=error).doubtful == 1.0
        # The missing share m solves m / sqrt((1 + m)^2 + 0.01) = error.
        enough = unseen(rows, spp=4 * math.ceil(4 * factor), error=error)
        assert enough.figure <= error and enough.factor == 1.0
        few = unseen(rows, spp=4 * math.floor(4 * factor / 1.3), error=error)
        assert few.figure > error


def test_a_picture_that_no_such_light_has_met_is_not_promised():
    means, counts = np.ones((24, 32, 4, 3), np.float32), np.full((24, 32, 4), 64)
    behind, asked = found_in(room()), Promise(0.05)
    # As bright as without the lamp: all agree, and all lack it.
    brightness = behind[:, 2].sum() / POINTS
    assert judge_means(means * brightness, counts, asked).met
    found = judge_means(means * brightness, counts, asked, behind=behind)
    assert not found.met and 0.4 < found.unseen < 0.6
    assert found.factor > 10.0
    # The same light is a small part of a bright picture.
    assert judge_means(means * brightness * 100.0, counts, asked, behind=behind).met


def test_noise_and_missing_light_are_held_against_the_error_together():
    means = np.random.default_rng(5).normal(1.0, 0.2, (24, 32, 4, 3)).astype(np.float32)
    counts = np.full((24, 32, 4), 64)
    noise = judge_means(means, counts, Promise(1.0)).achieved
    # What no sample finds: every point lacks a share, in all channels.
    share = 1.1 * noise
    rows = np.column_stack(
        [np.arange(POINTS), np.zeros(POINTS), np.full((POINTS, 3), share), np.zeros(POINTS)]
    )
    missing = share / math.hypot(1.0 + share, 0.1)
    found = judge_means(means, counts, Promise(1.0), behind=rows)
    assert found.achieved == pytest.approx(math.hypot(noise, missing), rel=0.01)
    either = 1.1 * max(noise, missing)
    assert judge_means(means, counts, Promise(either)).met
    found = judge_means(means, counts, Promise(either), behind=rows)
    assert found.unseen <= either
    assert not found.met


def test_the_table_goes_with_the_film(tmp_path):
    film = Film(32, 24)
    film.rare_light = found_in(room())
    film.save(tmp_path / "a.alight")
    assert np.array_equal(Film.load(tmp_path / "a.alight").rare_light, film.rare_light)
    assert film.empty_like().rare_light is film.rare_light


def job(scene, schedule):
    flat = flatten(scene)
    made = compile_scene(flat)
    return job_of(flat, made, schedule, Clock(), seed=3, threads=1, replicates=4)


def test_a_render_looks_for_it_where_something_depends_on_it():
    wanted = found_in(room())
    promised = job(room(), Steered(16, 64, Promise(0.1)))
    assert np.array_equal(promised.rounds[0].rare_light, wanted)
    film = promised.rounds[0]
    film.sums[..., 0] = 1
    film.counts[:] = 16
    assert judge(film, Promise(0.1)).unseen > 0.1
    assert job(room(), Uniform(4, 4)).rounds[0].rare_light is None
    capped = room(integrator={"type": "path", "max_depth": 3})
    assert np.array_equal(job(capped, Uniform(4, 4)).rare_light.behind_glass, wanted)


def test_a_render_that_goes_on_to_an_error_looks_for_it():
    """It was begun without one, and its film holds no table."""
    begun, goes_on = job(room(), Uniform(4, 4)), job(room(), Steered(16, 64, Promise(0.1)))
    goes_on.restore(begun.state(), None)
    assert np.array_equal(goes_on.rounds[0].rare_light, found_in(room()))


def test_plans_look_for_it():
    assert job(room(), PilotSchedule(Promise(0.1))).rounds[0].rare_light is not None
    film = Film(8, 8, replicates=3)
    with pytest.raises(alight.OptionError, match="from 4 replicates on, got 3"):
        PilotSchedule(Promise(0.1)).next([film])


def test_a_caps_pilot_looks_often_enough_or_says_what_it_may_have_missed(monkeypatch):
    """No sample meets any light: the light behind glass may be all that is cut off."""
    asked = []

    def black(kernels, scene, settings, tile, ranges, scratch):
        h, w = tile.y1 - tile.y0, tile.x1 - tile.x0
        asked.append(h * w * int(ranges[0, 0, 1]))
        return SimpleNamespace(sums=np.zeros((h, w, 4, 3, 2), np.int64)), None

    monkeypatch.setattr(depth_cap, "render_tile", black)
    capped = job(room(integrator={"type": "path", "max_depth": 3}), Uniform(4, 4))
    capped.kernels = None
    for q, samples in ((0.05, 2048), (2e-3, 50_000), (1e-9, 2**17)):
        asked.clear()
        capped.rare_light.behind_glass = np.column_stack(
            [np.arange(9), np.zeros(9), np.full((9, 3), 2.0), np.full(9, q)]
        )
        lost = light_beyond(capped, 3, 0)
        done = sum(asked) / 2
        assert samples <= done < 1.2 * samples + 4 * 24 * 32
        assert lost.radiance == 0.0
        # The root of the mean square: all of it is missing, or nothing.
        missing = math.sqrt(math.exp(-done * q))
        assert lost.error == pytest.approx(9 * 2.0 / POINTS * missing)


def test_glass_that_is_hardly_rough_spreads_light_into_one_over_its_density():
    """A pane of the density p per steradian; what is clear spreads nothing."""
    n = 64
    flat = flatten(room(pane={"type": "rough_dielectric", "alpha": 0.003}))
    scene = compile_scene(flat)
    zero, one = np.zeros(n, np.float32), np.ones(n, np.float32)
    pilot = pilot_rays.Pilot(scene, np.random.default_rng(0))
    for clear, most in ((False, 1.0 / SHARP), (True, 0.0)):
        passed, spread = _through(
            pilot, np.full(len(flat.bsdfs), clear), Vec3(zero, zero, 0.5 * one),
            Vec3(zero, zero, one), 1.2 * one, zero,
        )  # fmt: skip
        # Some samples mirror light, and some facets lean too far.
        assert passed.mean() > 0.3
        assert (spread[passed] <= most).all() and ((spread[passed] > 0.0) == (most > 0.0)).all()
