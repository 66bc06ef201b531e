"""`alight why`: the parts add up, and where the answer is known, it is given."""

from __future__ import annotations

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

import alight
from alight.cli.main import app
from alight.compiled.program import Program
from alight.compiled.scene import compile_scene
from alight.films.fixed_point import carry, to_float
from alight.formats import loads
from alight.integrators import contributions as noted
from alight.integrators.contributions import FIELDS, SEEN, Log, as_found, can_record, write
from alight.integrators.walk import make_settings
from alight.lab.statistics.intervals import holm_adjusted, log_mean, log_ratio
from alight.lab.why import trials
from alight.lab.why.bright_samples import Squares
from alight.lab.why.shares import (
    BATCHES,
    REPLICATES,
    TECHNIQUES,
    Part,
    _coded,
    _Divider,
    _part,
    _within,
    relative_weights,
    shares_of,
)
from alight.lab.why.trials import Trial, alternatives, try_alternatives
from alight.lab.why.words import ranked, share_lines, trial_lines
from alight.laws.scene.pictures import small
from alight.lights.tables import INFO as LIGHT_INFO
from alight.metrics.estimate import Estimate
from alight.rendering.tiles.tile import make_kernels, render_tile
from alight.rendering.tiles.tile_kernel import Tile
from alight.rendering.tracing.contribution_recorder import Contributions, Recorder
from alight.scene import flatten
from lanewise.jit import instantiate
from lanewise.simd import LANES
from lanewise.vec3 import Vec3
from lanewise.view import View
from tests.laws.test_scene_check import SCENE

CAMERA = """alight: 1
camera: {type: pinhole, fov: 40, transform: {look_at: {origin: [0, 4, 4], target: [0, 0, 0]}}}
film: {size: [16, 16]}
"""
FLOOR = """
  floor: {shape: rectangle, transform: [{scale: [9, 9, 1]}, {rotate: {axis: x, angle: -90}}]}
"""
SMALL_LAMP = (
    CAMERA
    + "integrator: {type: path, light_sampling: bsdf, max_depth: 3}\n"
    + "environment: {type: constant, radiance: 0.3}\nnodes:"
    + FLOOR
    + """  lamp:
    shape: disk
    light: {type: area, radiance: 300}
    transform: [{rotate: {axis: x, angle: 90}}, {scale: 0.3}, {translate: [0, 5, 0]}]
"""
)
MANY_LIGHTS = (
    CAMERA
    + "integrator: {type: path, light_choice: uniform, max_depth: 2}\nnodes:"
    + FLOOR
    + "  sun: {light: {type: point, intensity: 100}, transform: {translate: [0, 5, 0]}}\n"
    + "".join(
        f"  star-{i}: {{light: {{type: point, intensity: 1}}, "
        f"transform: {{translate: [{i - 8}, 5, 1]}}}}\n"
        for i in range(16)
    )
)


# ---------------------------------------------------------------- contributions


@pytest.fixture(scope="module")
def recorded():
    scene = small(alight.load(SCENE), size=16)
    compiled = compile_scene(flatten(scene), structure="list")
    return compiled, *Recorder(compiled, 2).run(8, 5, 2)


def test_contributions_add_up_to_the_picture(recorded):
    compiled, found, picture = recorded
    width, height = compiled.size
    place = found.pixel * 2 + found.replicate
    sums = [
        np.bincount(place, found.value[:, c].astype(float), width * height * 2) for c in (0, 1, 2)
    ]
    sums = np.stack(sums, axis=-1).reshape(height, width, 2, 3)
    np.testing.assert_allclose(sums, picture, rtol=2e-5, atol=2e-5)
    assert set(found.how.tolist()) == {SEEN, noted.BY_BSDF, noted.BY_DELTA, noted.BY_LIGHT}
    assert set(found.light.tolist()) == {0, 1, 2}
    assert found.depth.max() == 6
    assert ((found.depth == 1) == (found.how == SEEN)).all()
    assert ((found.bsdf < 0) == (found.how == SEEN)).all()


def test_the_picture_is_the_ordinary_one(recorded):
    compiled, _, picture = recorded
    settings = make_settings(compiled.integrator, seed=5, replicates=2)
    kernels = make_kernels(compiled, compiled=False)
    film, _ = render_tile(
        kernels, compiled, settings, Tile(0, 0, *compiled.size), np.tile([0, 8], (2, 2, 1))
    )
    carry(film.sums)
    # A path whose choice hangs on a rounding error goes another way: very few do.
    close = np.isclose(to_float(film.sums), picture, rtol=1e-3, atol=1e-4)
    assert close.mean() > 0.97


def test_a_log_without_room_is_made_larger(recorded, monkeypatch):
    compiled, found, _ = recorded
    monkeypatch.setattr("alight.rendering.tracing.contribution_recorder._ROOM", 0)
    again, _ = Recorder(compiled, 1).run(8, 5, 2)
    assert len(again.pixel) == len(found.pixel)


def test_words_hold_all_numbers_up_to_their_limits_and_the_longest_path_beyond():
    """The last contribution does not fit: it is counted, and written nowhere."""
    n, rng = int(LANES), np.random.default_rng(7)
    room = n - 1
    x, y, replicate, first = rng.integers(0, 1 << 16, (4, n), np.uint32)
    depth = np.resize(np.array([1, 2, 65535, 65536, 2**31], np.uint32), n)
    how, light = (rng.integers(0, high, n, np.uint32) for high in (4, 2**32 - 1))
    path = SimpleNamespace(sampler=SimpleNamespace(x=x, y=y, scramble=replicate))
    log = Log(
        View(np.zeros((room, FIELDS), np.uint32)), View(np.zeros((room, 3), np.float32)),
        View(np.zeros(1, np.int64)), None, None,
    )  # fmt: skip
    run = instantiate(write, Program(), compiled=False)
    found = SimpleNamespace(light=light, depth=depth, how=how, first=first)
    run(log, path, found, np.ones(n, bool), Vec3(*np.ones((3, n), np.float32)))
    assert log.count.array[0] == n
    place, sample, lamp, what = log.words.shaped.T
    depth = np.minimum(depth, 65535)
    np.testing.assert_array_equal([place >> 16, place & 65535], [y[:room], x[:room]])
    np.testing.assert_array_equal([sample >> 16, sample & 65535], [replicate[:room], depth[:room]])
    np.testing.assert_array_equal(lamp, light[:room])
    np.testing.assert_array_equal([what >> 16, what & 65535], [how[:room], first[:room]])


def test_integrators_that_say_where_their_light_comes_from():
    assert [can_record(name) for name in ("path", "direct", "random_walk")] == [True] * 3
    assert not can_record("ambient_occlusion")


# ---------------------------------------------------------------- shares


def batch(rng, means):
    """One contribution of each kind a sample; its values are exponential with these means."""
    pixels, spp = 64, 2
    kinds, values, where, replicate = [], [], [], []
    for kind, mean in enumerate(means):
        for pixel in range(pixels):
            for r in range(REPLICATES):
                values += (mean * rng.exponential(size=spp)).tolist()
                kinds += [kind] * spp
                where += [pixel] * spp
                replicate += [r] * spp
    value = np.array(values, np.float32)[:, None].repeat(3, axis=1)
    where, replicate, kinds = (np.array(v) for v in (where, replicate, kinds))
    found = Contributions(
        where, replicate, kinds + 2, kinds * 0 + noted.BY_LIGHT, kinds, kinds * 0, value
    )
    sums = np.zeros((pixels, REPLICATES, 3))
    np.add.at(sums, (where, replicate), value.astype(float))
    return found, sums.reshape(8, 8, REPLICATES, 3)


def test_shares_of_independent_parts_are_those_of_their_variances():
    """Exponential parts with means 3 and 1 have variances 9 and 1."""
    rng = np.random.default_rng(1)
    scene = type("Scene", (), {"size": (8, 8)})()
    divider = _Divider(scene, np.ones((8, 8, 3)), 2)
    total = []
    for _ in range(BATCHES):
        found, sums = batch(rng, (3.0, 1.0))
        divider.add(found, sums)
        total.append(2 * (sums / 2).var(axis=2, ddof=1).sum())
    shares = divider.result((["a", "b"], ["m"]))
    assert shares.relative_variance == pytest.approx(np.mean(total), rel=1e-6)
    by_light = {part.light: share for part, share in shares.by("light").items()}
    assert by_light["a"].value + by_light["b"].value == pytest.approx(1.0, abs=1e-9)
    assert 0.002 < by_light["a"].error < 0.03
    assert abs(by_light["a"].value - 0.9) < 3.5 * by_light["a"].error
    assert shares.map_of(Part(light="a")).sum() / shares.variance.sum() == pytest.approx(
        by_light["a"].value
    )
    assert [part.depth for part in shares.by("depth")] == [2, 3]


def test_parts_of_a_scene_add_up_and_map_to_its_pixels():
    shares = shares_of(alight.load(SCENE), size=16, spp=32)
    for fields in (("depth",), ("technique",), ("light",), ("material",), ("light", "depth")):
        assert sum(s.value for s in shares.by(*fields).values()) == pytest.approx(1.0, abs=1e-9)
    np.testing.assert_allclose(shares.variance.sum(), shares.relative_variance, rtol=1e-9)
    assert {part.light for part in shares.parts} == {"lamp", "bulb", "environment"}
    assert {part.material for part in shares.parts} >= {"", "glass", "clay"}
    assert shares.by("technique").keys() <= {Part(technique=t) for t in TECHNIQUES.values()}


def test_a_small_lamp_that_only_bsdf_sampling_finds():
    shares = shares_of(loads(SMALL_LAMP, "lamp"), size=16, spp=64)
    lines = list(share_lines(shares))
    assert "light `lamp` found by BSDF sampling at depth 2" in lines[1]
    [first, *_] = ranked(shares).values()
    assert first.value > 0.9


def test_several_environments_are_one_light():
    """A small sun beside a sky, found by the BSDF only, is nearly all of the noise."""
    sun = "  sun: {light: {type: sun, sun_direction: [1, 2, 1], diameter: 8, scale: 0.01}}\n"
    bulb = "  bulb: {light: {type: point, intensity: 0.1}, transform: {translate: [0, 3, 0]}}\n"
    shares = shares_of(loads(SMALL_LAMP.split("  lamp:")[0] + sun + bulb, "suns"), size=16, spp=64)
    by_light = {part.light: share.value for part, share in shares.by("light").items()}
    assert sum(by_light.values()) == pytest.approx(1.0, abs=1e-9)
    assert set(by_light) == {"environment + sun", "bulb"}
    assert by_light["environment + sun"] > 0.9


@pytest.mark.parametrize(("lights", "environments"), [(1, 1), (3, 1), (4, 3), (5, 0)])
def test_light_sampling_says_the_environments_that_a_ray_would_have_met(lights, environments):
    """All of them are the last one, which they are listed as; lights in front are themselves."""
    program = Program(environments=("sky",) * environments)
    scene = SimpleNamespace(lights=SimpleNamespace(info=SimpleNamespace(size=lights * LIGHT_INFO)))
    index = np.arange(lights, dtype=np.uint32)
    found = instantiate(as_found, program, compiled=False)(scene, index)
    around = index >= lights - environments
    assert found.tolist() == np.where(around, lights - 1, index).tolist()


def test_weights_are_those_of_relmse():
    reference = np.full((2, 2, 3), 3.0)
    np.testing.assert_allclose(relative_weights(reference).sum(), 1.0 / (9.0 + 0.09))
    assert np.isfinite(relative_weights(np.zeros((2, 2, 3)))).all()


# ---------------------------------------------------------------- alternatives


def test_alternatives_are_the_other_choices():
    found = alternatives(alight.load(SCENE))
    assert set(found) == {
        "integrator.light_sampling=bsdf",
        "integrator.light_sampling=emitter",
        "integrator.caustics=manifold",
        "integrator.heuristic=balance",
        "integrator.russian_roulette=none",
        "integrator.light_choice=uniform",
        "integrator.light_choice=tree",
        "integrator.type=bidirectional",
    }
    # Hidden lamps make another picture, which is no advice.
    assert "hide_emitters" in type(alight.load(SCENE).integrator).model_fields
    lit = alternatives(
        alight.load(SCENE), Part(depth=2, technique=TECHNIQUES[noted.BY_LIGHT], light="lamp")
    )
    assert next(iter(lit)) == "integrator.light_choice=uniform"
    # Paths from both ends find direct light as others do.
    assert "integrator.type=bidirectional" not in lit
    # One light: there is nothing to choose.
    assert "integrator.light_choice=uniform" not in alternatives(alight.load("cornell-box"))


def test_advice_is_corrected_over_all_that_was_tried(monkeypatch):
    """Of five changes that do nothing, one looks good by chance every fifth time."""
    rng, raw = np.random.default_rng(2), []

    many = [Squares(np.ones(1), 1e9)]

    def measured(arms, weights, seeds):
        noise = rng.lognormal(0.0, 0.1, (2, 2, BATCHES))
        here, there = [(log_mean(variances), log_mean(times)) for variances, times in noise]
        raw.append(log_ratio(here[0] + here[1], there[0] + there[1], paired=True).p_value)
        return [here, there], [many, many]

    changes = dict.fromkeys("abcde", SimpleNamespace(integrator=None))
    monkeypatch.setattr(trials, "alternatives", lambda scene, cause: changes)
    monkeypatch.setattr(
        trials,
        "_sums_of",
        lambda scene: SimpleNamespace(of=lambda *_: np.ones((1, 1, 1)), scene=None),
    )
    monkeypatch.setattr(trials, "rare_noises", lambda *_: [0.0] * (1 + len(changes)))
    monkeypatch.setattr(trials, "_measured", measured)
    tried, left = try_alternatives(alight.load(SCENE))
    assert not left
    found = {trial.change: trial.p_value for trial in tried}
    assert [found[name] for name in changes] == holm_adjusted(raw)


@pytest.mark.proofs
def test_many_unequal_lights_chosen_alike():
    scene = loads(MANY_LIGHTS, "lights")
    shares = shares_of(scene, size=16, spp=64)
    assert "light `sun` found by light sampling at depth 2" in list(share_lines(shares))[1]
    tried, _ = try_alternatives(scene, cause=next(iter(ranked(shares))), limit=240.0)
    # A tree that could gain little more chooses by intensity, so either may stand first.
    best = {"integrator.light_choice=tree", "integrator.light_choice=power"}
    assert {trial.change for trial in tried[:2]} == best
    (trial,) = [t for t in tried if t.change == "integrator.light_choice=power"]
    assert trial.helps
    # 17 lights alike: E[x^2] = 17 (100^2 + 16); by power 116^2: less their common mean.
    assert trial.variance.value > 50.0


# ---------------------------------------------------------------- the command line


def test_numbers_and_maps_from_the_command_line(tmp_path):
    target = tmp_path / "maps.png"
    words = ["why", str(SCENE), "--size", "16", "--spp", "32", "--no-measure", "-o", str(target)]
    result = CliRunner().invoke(app, [*words, "--json", "-q"])
    assert result.exit_code == 0, result.output
    found = json.loads(result.output)
    assert sum(row["share"] for row in found["parts"]) == pytest.approx(1.0, abs=1e-9)
    assert found["spp"] == 32
    assert target.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--spp", "16"), "--spp: must be a whole number in [32, 2147483647], got 16"),
        (("--size", "4"), "--size: must be a whole number in [8, 1024], got 4"),
        (("--integrator", "ambient_occlusion"), "does not record where its light comes from"),
        (("-o", "maps.exr"), "--output: the maps are a .png file, got maps.exr"),
    ],
)
def test_wrong_options(words, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(app, ["why", "cornell-box", "-q", *words])
    assert result.exit_code == 2
    assert message in result.output
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("size", [(6, 20), (20, 6), (8, 8)])
def test_a_region_counts_the_pixels_that_it_touches(size):
    """Left, right, top and bottom of pictures that are wide or tall; their mean stays."""
    height, width = size
    rng = np.random.default_rng(height)
    for _ in range(40):
        x, y = rng.uniform(0.0, 0.9, 2)
        w, h = rng.uniform(0.0, 1.0, 2) * (1.0 - x, 1.0 - y)
        weights = rng.uniform(1.0, 2.0, (height, width, 3))
        columns, rows = np.arange(width) / width, np.arange(height) / height
        touched = ((rows < y + h) & (rows + 1 / height > y))[:, None]
        touched = touched & (columns < x + w) & (columns + 1 / width > x)
        found = _within(weights, (x, y, w, h))
        assert ((found > 0.0) == touched[..., None]).all()
        assert (found[touched] / weights[touched]).std() < 1e-9
        assert np.mean(found[touched] / weights[touched]) == pytest.approx(
            height * width / touched.sum()
        )


def test_kinds_of_contributions_keep_all_of_their_fields():
    """All depths, techniques, lights and materials; from the deepest on they are one kind."""
    lights, materials = ([f"{what}{i}" for i in range(300)] for what in ("light", "bsdf"))
    rng = np.random.default_rng(5)
    depth, how, light, bsdf = (
        rng.integers(low, high, 500)
        for low, high in ((0, 24), (0, len(TECHNIQUES)), (0, 300), (-1, 300))
    )
    found = SimpleNamespace(depth=depth, how=how, light=light, bsdf=bsdf)
    for row, code in enumerate(_coded(found).tolist()):
        wanted = Part(
            min(int(depth[row]), 16), TECHNIQUES[how[row]], lights[light[row]],
            materials[bsdf[row]] if bsdf[row] >= 0 else "",
        )  # fmt: skip
        assert _part(code, lights, materials) == wanted


def test_each_figure_of_a_trial_stands_behind_its_name():
    variance, time, product = (Estimate(v, v - 0.1, v + 0.1) for v in (2.0, 3.0, 6.0))
    better = Trial("a=b", variance, time, product, 0.01)
    worse = replace(better, change="c=d", efficiency=Estimate(0.5, 0.4, 0.6))
    figures = "variance / 2 [1.9, 2.1], efficiency x {}, corrected p = 0.01"
    assert list(trial_lines([worse, better], ["e=f", "g=h"])) == [
        f"advice: --set a=b  {figures.format('6 [5.9, 6.1]')}",
        f"tried:  --set c=d  {figures.format('0.5 [0.4, 0.6]')}",
        "no time left to try: e=f, g=h",
    ]
    assert next(trial_lines([worse], [])).startswith("no advice: nothing that was tried")
