"""Scale does not change the picture: threads, tile order, passes, crops and parts, bit for bit."""

from __future__ import annotations

import numpy as np
import pytest

import alight
from alight.films import Film
from alight.rendering import job


def cornell(size=(40, 28), crop=None, sampler="sobol"):
    changes = [f"film.size={list(size)}", f"sampler.type={sampler}"]
    if crop:
        changes.append(f"film.crop={list(crop)}")
    return alight.load("cornell-box", changes)


@pytest.fixture(scope="module")
def reference():
    return alight.render(cornell(), spp=16, threads=1)


@pytest.mark.parametrize("threads", [2, 8])
def test_threads(reference, threads):
    film = alight.render(cornell(), spp=16, threads=threads)
    np.testing.assert_array_equal(film.sums, reference.sums)
    np.testing.assert_array_equal(film.counts, reference.counts)


def test_tile_order_and_size(reference, monkeypatch):
    tiles = job.tiles_of
    monkeypatch.setattr(job, "tiles_of", lambda window: tiles(window, 8)[::-1])
    film = alight.render(cornell(), spp=16)
    np.testing.assert_array_equal(film.sums, reference.sums)


@pytest.mark.parametrize("per_pass", [1, 5, 16])
def test_passes(reference, per_pass):
    film = alight.render(cornell(), spp=16, spp_per_pass=per_pass)
    np.testing.assert_array_equal(film.sums, reference.sums)


def test_two_halves_are_the_whole(reference):
    first = alight.render(cornell(), spp=7)
    second = alight.render(cornell(), spp=9, first_sample=7)
    for order in ((first, second), (second, first)):
        film = Film.merge(*order)
        np.testing.assert_array_equal(film.sums, reference.sums)
        np.testing.assert_array_equal(film.counts, reference.counts)


def test_crop_equals_the_cut_out(reference):
    film = alight.render(cornell(crop=(5, 3, 21, 17)), spp=16)
    np.testing.assert_array_equal(film.sums, reference.sums[3:20, 5:26])


def test_another_seed_is_another_picture(reference):
    film = alight.render(cornell(), spp=16, seed=1)
    lit = reference.image > 0
    assert np.mean(film.image[lit] == reference.image[lit]) < 0.05


def test_direct_and_indirect_add_up_to_the_picture(reference):
    film = alight.render(cornell(), spp=16, aovs=("direct", "indirect"))
    np.testing.assert_array_equal(film.sums, reference.sums)
    total = film.aov_sums["direct"] + film.aov_sums["indirect"]
    beauty = film.sums.sum(axis=2)
    value = total[..., 0] * 2**40 + total[..., 1]
    np.testing.assert_array_equal(value, beauty[..., 0] * 2**40 + beauty[..., 1])


def test_layers_never_change_the_picture(reference):
    film = alight.render(cornell(), spp=16, aovs=("id", "normal", "depth", "uv"))
    np.testing.assert_array_equal(film.sums, reference.sums)
