"""`resume --error`, adaptive renders and cut windows: the same bits, whatever happened before."""

from __future__ import annotations

import numpy as np
import pytest

import alight
from alight.core.errors import OptionError
from alight.rendering.schedules.cycles import Cycles
from alight.rendering.schedules.steering import Steered
from alight.rendering.schedules.stopping import Promise
from tests.rendering.interrupted import assert_same, cancelled_after

#: No edge of the window lies on the 8-pixel grid.
CHANGES = ("film.size=[64, 48]", "film.crop=[3, 5, 50, 39]", "integrator.max_depth=4")


def scene():
    return alight.load("cornell-box", CHANGES)


def stopped_after(tiles, path, monkeypatch, schedule):
    """Render with a checkpoint until so many tiles are in the films."""
    with cancelled_after(tiles, monkeypatch) as cancel:
        return alight.render(
            scene(), schedule=schedule, checkpoint=path, cancel=cancel, threads=1, spp_per_pass=5
        )


SCHEDULES = {
    "error": lambda: Steered(0, None, Promise(0.15)),
    "adaptive": lambda: Steered(0, 40, None, adaptive=True),
    "adaptive to an error": lambda: Steered(0, None, Promise(0.15), adaptive=True),
    "cycles": lambda: Cycles(0, 96, 0.03),
}


@pytest.mark.parametrize("name", SCHEDULES)
def test_a_steered_render_goes_on_to_the_same_bits_inside_a_window(tmp_path, monkeypatch, name):
    whole = alight.render(scene(), schedule=SCHEDULES[name]())
    path = tmp_path / "a.alight"
    # In the pilot, in the first look, and later.
    for tiles in (1, 3, 9, 14):
        stopped_after(tiles, path, monkeypatch, SCHEDULES[name]())
        film = alight.resume(path)
        assert_same(film, whole)
        assert film.stats["verdict"] == whole.stats["verdict"]
        assert film.biases == whole.biases
    # Every pixel of a cell has the samples of its cell, also where the window cuts it.
    per_cell = np.array([[cell.count for cell in row] for row in whole.cells])
    y, x = np.mgrid[5:44, 3:53] // 8
    np.testing.assert_array_equal(whole.sample_count, per_cell[y, x])
    if name != "error":
        assert len(np.unique(whole.sample_count)) > 1


@pytest.mark.parametrize("adaptive", [False, True])
def test_going_on_to_a_smaller_error_is_the_render_that_asked_for_it_first(
    tmp_path, monkeypatch, adaptive
):
    path = tmp_path / "a.alight"
    whole = alight.render(scene(), schedule=Steered(0, None, Promise(0.12), adaptive))
    alight.render(scene(), schedule=Steered(0, None, Promise(0.2), adaptive), checkpoint=path)
    film = alight.resume(path, promise=Promise(0.12))
    assert_same(film, whole)
    assert film.stats["verdict"] == whole.stats["verdict"]
    assert film.stats["verdict"]["word"] == "met"
    # From inside a look, or of the pilot, as well.
    for tiles in (1, 5):
        stopped_after(tiles, path, monkeypatch, Steered(0, None, Promise(0.2), adaptive))
        assert_same(alight.resume(path, promise=Promise(0.12)), whole)


def test_a_fixed_number_of_samples_goes_on_to_an_error(tmp_path):
    path = tmp_path / "a.alight"
    whole = alight.render(scene(), schedule=Steered(0, None, Promise(0.12)))
    alight.render(scene(), spp=19, checkpoint=path)
    assert_same(alight.resume(path, promise=Promise(0.12)), whole)
    alight.render(scene(), spp=19, checkpoint=path)
    short = alight.resume(path, promise=Promise(0.12), spp=24)
    assert (short.sample_count == 24).all()
    assert short.stats["verdict"]["word"] == "not met"
    with pytest.raises(OptionError, match="max_spp: 20 is less than the render holds"):
        alight.resume(path, promise=Promise(0.12), spp=20)


def test_a_pilot_that_was_cut_off_is_finished_before_more_samples_follow(tmp_path, monkeypatch):
    path = tmp_path / "a.alight"
    whole = alight.render(scene(), schedule=Steered(0, 64, None, adaptive=True))
    stopped_after(1, path, monkeypatch, Steered(0, 24, None, adaptive=True))
    assert_same(alight.resume(path, spp=64), whole)


def test_cycles_does_not_go_on_to_an_error(tmp_path):
    path = tmp_path / "a.alight"
    alight.render(scene(), schedule=Cycles(0, 80, 0.2), checkpoint=path)
    with pytest.raises(OptionError, match="the schedule cycles cannot continue to an error"):
        alight.resume(path, promise=Promise(0.1))


def test_adaptive_films_of_other_samples_merge_exactly_and_in_any_order(tmp_path):
    files = []
    for first in (0, 4096):
        files.append(tmp_path / f"{first}.alight")
        schedule = Steered(first, 24, None, adaptive=True)
        alight.render(scene(), schedule=schedule, checkpoint=files[-1])
    film = alight.merge(*files)
    assert_same(film, alight.merge(*reversed(files)))
    parts = [alight.merge(file) for file in files]
    np.testing.assert_array_equal(film.counts, parts[0].counts + parts[1].counts)
    # Two pilots: the halves have their samples in different cells.
    assert (parts[0].counts != parts[1].counts).any()
    n = film.sample_count[..., None]
    mean = sum(part.image * part.sample_count[..., None] for part in parts) / n
    np.testing.assert_allclose(film.image, mean, rtol=1e-5)


def test_a_time_limit_does_not_change_what_follows(tmp_path):
    path = tmp_path / "a.alight"
    whole = alight.render(scene(), schedule=Steered(0, None, Promise(0.15)))
    short = alight.render(
        scene(), schedule=Steered(0, None, Promise(0.15)), checkpoint=path, time_limit=1e-6,
        spp_per_pass=4, threads=1,
    )  # fmt: skip
    assert short.spp < whole.spp
    film = alight.resume(path, time_limit=60.0)
    assert_same(film, whole)
    assert film.stats["verdict"] == whole.stats["verdict"]
