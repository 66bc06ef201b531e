"""Whatever is biased stands in the picture's ledger, with the effect that it has."""

from __future__ import annotations

import json
import threading

import numpy as np
import pytest

import alight
from alight.films import Film, readout
from alight.films.ledger import Bias, joined
from alight.outputs import exr
from alight.rendering.depth_cap import _series
from alight.rendering.schedules.cycles import Cycles
from alight.rendering.schedules.stopping import Promise
from tests.rendering.interrupted import cancelled_after

# A closed white box that shines: depth d brings Le rho^(d - 1), so a cap D loses rho^D of it.
BOX = """
alight: 1
camera: {type: pinhole, fov: 60, transform: [{look_at: {origin: [0.2, 0.1, 0.3], target: [1,
    0.5, -1]}}]}
film: {size: [48, 40]}
integrator: INTEGRATOR
nodes:
  box:
    shape: {type: cube, flip_normals: true}
    bsdf: {type: diffuse, reflectance: 0.5}
    light: {type: area, radiance: [1, 2, 3]}
"""


@pytest.fixture
def box(tmp_path):
    def make(integrator):
        path = tmp_path / "box.yaml"
        path.write_text(BOX.replace("INTEGRATOR", integrator))
        return alight.load(path)

    return make


@pytest.mark.parametrize(
    "integrator",
    [
        "{type: path, max_depth: 3, rr_depth: 2}",
        "{type: path, max_depth: 3, russian_roulette: none}",
        "{type: random_walk, max_depth: 3}",
    ],
)
def test_a_depth_cap_says_what_it_cuts_off(box, integrator):
    film = alight.render(box(integrator), spp=64)
    (bias,) = film.biases
    assert bias.cause == "depth cap"
    assert bias.error < 0.02
    # A random walk's own depths are noisy, but what they lack is 1/8 all the same.
    assert bias.effect == pytest.approx(-0.125, abs=max(3.0 * bias.error, 0.002))
    assert film.stats["biases"] == [bias.state()]


@pytest.mark.parametrize(
    ("size", "replicates"), [((48, 40), 64), ((8, 8), 4), ((8, 8), 64), ((1, 1), 4)]
)
def test_what_a_cap_cuts_off_has_an_error_however_few_cells_are_looked_at(box, size, replicates):
    scene = alight.changed(box("{type: path, max_depth: 3, rr_depth: 2}"), {"film.size": size})
    (bias,) = alight.render(scene, spp=1, replicates=replicates).biases
    assert 0.0 < bias.error < 0.2
    assert bias.effect == pytest.approx(-0.125, abs=4.0 * bias.error)


def test_a_picture_without_a_bias_has_an_empty_ledger(box):
    film = alight.render(box("{type: path}"), spp=8)
    assert film.biases == ()
    assert film.provenance["biases"] == "none"


def test_a_series_that_does_not_end_is_no_number():
    assert _series(np.array([0.5, 0.5]))[0] == np.inf
    value, slope = _series(np.array([0.5, 0.25]))
    assert value == 1.0
    step = 1e-6
    for i in range(2):
        moved = np.array([0.5, 0.25]) + step * np.eye(2)[i]
        assert (_series(moved)[0] - value) / step == pytest.approx(slope[i], abs=1e-4)


def test_the_ledger_is_in_every_file(box, tmp_path):
    film = alight.render(box("{type: path, max_depth: 3}"), spp=8, checkpoint=tmp_path / "c.alight")
    film.save(tmp_path / "a.exr")
    film.save(tmp_path / "a.alight")
    assert "paths end at depth 3: −1" in exr.read_layers(tmp_path / "a.exr")[1]["biases"]
    assert Film.load(tmp_path / "a.alight").biases == film.biases
    assert Film.load(tmp_path / "c.alight").biases == film.biases
    other = alight.render(box("{type: path, max_depth: 3}"), spp=8, first_sample=8)
    assert [bias.cause for bias in alight.merge(film, other).biases] == ["depth cap"]


def test_a_render_that_was_cut_short_is_not_silent(box, tmp_path):
    cancel = threading.Event()
    cancel.set()
    film = alight.render(box("{type: path, max_depth: 3}"), spp=8, cancel=cancel)
    assert film.biases == (Bias("depth cap", "paths end at depth 3"),)


def test_a_cancelled_render_knows_its_effect_too(box, monkeypatch):
    scene = box("{type: path, max_depth: 3}")
    whole = alight.render(scene, spp=64)
    with cancelled_after(2, monkeypatch) as cancel:
        film = alight.render(scene, spp=64, cancel=cancel, threads=1, spp_per_pass=8)
    assert film.spp < 64
    (bias,) = film.biases
    # The ledger's pilot does not depend on how far the picture came.
    assert film.recorded == whole.recorded
    assert bias.effect < -0.05


def test_a_random_walk_owns_that_it_may_have_missed_the_light(tmp_path):
    """A lamp that few paths find: what the cap cuts off lies within the doubt, all the same."""
    path = tmp_path / "lamp.yaml"
    lamp = "{type: sphere, center: [0.5, 0.6, 0.5], radius: 0.05}"
    dark = BOX.replace("    light: {type: area, radiance: [1, 2, 3]}\n", "")
    dark = dark.replace("integrator: INTEGRATOR\n", "")
    path.write_text(
        dark
        + f"  lamp: {{shape: {lamp}, bsdf: {{type: diffuse, reflectance: 0}}, "
        + "light: {type: area, radiance: 400}}\n"
    )
    changes = ["film.size=[32,32]", "integrator.max_depth=4"]
    known, found = (
        [
            alight.render(
                alight.load(path, [*changes, f"integrator.type={kind}"]), spp=spp, seed=seed
            ).biases[0]
            for seed in range(3)
        ]
        for kind, spp in (("path", 64), ("random_walk", 256))
    )
    truth = np.mean([bias.effect for bias in known])
    assert truth < -0.03
    for bias in found:
        assert bias.effect == pytest.approx(truth, abs=2.0 * bias.error)
        # The brightest sample alone is worth so much.
        assert bias.error > 3 / 1.96 / 2**14


def test_the_picture_can_be_added_to_while_its_ledger_is_read(box, monkeypatch):
    """The mean of a large picture takes long; tiles must not wait for it."""
    film = alight.render(box("{type: path, max_depth: 3}"), spp=8)
    film._mean_of = -1, 0.0
    free = []

    def slow(film):
        def try_lock():
            free.append(film.lock.acquire(blocking=False))
            if free[-1]:
                film.lock.release()

        thread = threading.Thread(target=try_lock)
        thread.start()
        thread.join()
        return np.ones((2, 2, 3))

    monkeypatch.setattr(readout, "image_of", slow)
    assert film.biases[0].effect < 0.0
    assert free == [True]


def test_the_surest_effect_is_kept():
    unknown, rough = Bias("depth cap", "x"), Bias("depth cap", "x", -0.1, 0.05)
    sure, else_ = Bias("depth cap", "x", -0.12, 0.01), Bias("adaptive criterion", "y")
    assert joined([[unknown, else_], [rough], [sure]]) == (sure, else_)


def test_an_error_that_ends_a_render_is_recorded(box):
    from alight.rendering.schedules.steering import Steered

    schedule = Steered(0, None, Promise(0.5))
    film = alight.render(box("{type: path}"), schedule=schedule)
    assert [bias.cause for bias in film.biases] == ["stopped at an error"]


def test_cycles_rule_is_recorded_with_its_effect():
    """A cell that is dark until a late sample: the rule leaves half of the cells too dark."""

    class Pixels:
        def __init__(self, means, counts):
            from alight.films.sample_ranges import empty_cells

            h, w = counts.shape[:2]
            self.crop, self.cells, self.replicates = (0, 0, w, h), empty_cells(w, h), 4
            self.means, self.counts = means, counts

        def replicate_means(self):
            return self.means, self.counts

    rng = np.random.default_rng(1)
    schedule = Cycles(0, 96, 0.01)
    counts = np.full((32, 32, 4), 20)
    before = rng.normal(1.0, 0.2, (32, 32, 4, 1)) * np.ones(3)
    film = Pixels(before, counts)
    schedule.next([film])
    schedule.next([film])
    film.means = before * 0.9
    (bias,) = schedule.biases([film])
    assert bias.cause == "adaptive criterion"
    assert bias.effect == pytest.approx(-0.1 * before.mean(), rel=1e-6)
    assert bias.relative(0.9 * before.mean()).effect == pytest.approx(-0.1, rel=1e-6)
    # 10 % of the standard error of a mean of 1024 pixels.
    assert bias.error == pytest.approx(0.1 * 0.2 / np.sqrt(4 * 1024), rel=0.2)
    json.dumps(bias.state())


def test_a_bias_that_was_not_seen_has_no_sign():
    assert Bias("depth cap", "x", -0.0, 0.0).line == "x: no effect seen"
    assert Bias("depth cap", "x", 0.0, 0.01).line == "x: 0.0 ± 1.0 % of the light"
    assert Bias("depth cap", "x", -1e-6, 0.01).line == "x: 0.0 ± 1.0 % of the light"


@pytest.mark.parametrize(
    ("effect", "error", "said"),
    [
        (-0.01, 0.0011, "−1.00 ± 0.11"),
        (0.1234, 0.02, "+12.3 ± 2.0"),
        (-0.5, 0.25, "−50 ± 25"),
        (-0.5, 3.0, "−50 ± 300"),
        (0.02, None, "+2"),
        (-0.02, 0.0, "−2 ± 0"),
    ],
)
def test_a_bias_and_its_error_have_the_same_decimals(effect, error, said):
    assert Bias("depth cap", "x", effect, error).line == f"x: {said} % of the light"
