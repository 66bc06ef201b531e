"""Laws of what the estimates of a picture's error share, and of doing it in one go."""

from __future__ import annotations

import numpy as np
import pytest

from alight.films import Film
from alight.films.fixed_point import to_limbs
from alight.metrics import noisy_pixels
from alight.metrics.own_error import estimate_relmse, relmse_of
from alight.metrics.pixel_bars import pixel_bars, unsure_pixels
from alight.metrics.surroundings import CELL, around, by_cells, pixels_of_cells, spread_out
from alight.metrics.survey import survey


def noisy_film(seed, size=(16, 96), replicates=4, samples=4):
    """A film of skewed noise, one bright sample in a few pixels."""
    film = Film(size[1], size[0], replicates=replicates)
    rng = np.random.default_rng(seed)
    shape = (*size, replicates, 3)
    sums = samples * rng.gamma(0.5, 2.0, shape) * np.exp(rng.normal(0, 1, (*size, 1, 1)))
    sums[5, 5, 0] *= 500.0
    film.sums[...], _, _ = to_limbs(sums.astype(np.float32))
    film.counts[...] = samples
    return film


@pytest.mark.parametrize("size", [(1, 1), (7, 9), (8, 16), (40, 17), (33, 3)])
def test_cells_are_the_sums_of_their_pixels(size):
    planes = np.random.default_rng(1).random((2, *size))
    cells = by_cells(planes)
    for y, x in np.ndindex(cells.shape[1:]):
        own = planes[:, CELL * y : CELL * (y + 1), CELL * x : CELL * (x + 1)]
        np.testing.assert_allclose(cells[:, y, x], own.sum(axis=(1, 2)))
    np.testing.assert_array_equal(pixels_of_cells(*size), by_cells(np.ones((1, *size))))
    y, x = np.indices(size) // CELL
    np.testing.assert_array_equal(spread_out(cells, *size), cells[:, y, x])


def test_classes_worked_out_together_say_what_they_say_alone():
    rng = np.random.default_rng(2)
    shape = (noisy_pixels.CLASSES, noisy_pixels.GROUPS)
    sums = rng.gamma(2.0, 1.0, (9, *shape))
    # Of r^2 and of r^(3/2) as of pixels with one r; some bright samples seen, and none.
    sums[4:6] = sums[0] * np.array([0.3, 0.3**0.5])[:, None, None] * rng.uniform(0.5, 1.0, shape)
    sums[1:3, ::2] = 0.0
    together = noisy_pixels.believe(sums, 3, 2, 2, 4)
    values = []
    for c in range(noisy_pixels.CLASSES):
        one = np.zeros_like(sums)
        one[:, c] = sums[:, c]
        alone = noisy_pixels.believe(one, 3, 2, 2, 4)
        assert together.weights[c] == pytest.approx(alone.weights[c], rel=1e-12)
        assert np.count_nonzero(alone.weights) == 1
        values.append((alone.value, alone.lowest))
    assert (together.value, together.lowest) == pytest.approx(np.sum(values, axis=0))


def test_a_group_that_is_all_of_its_class_is_not_left_out_of_it():
    sums = noisy_pixels.no_sums()
    sums[:, 3, 5] = [2.0, 2.0, 2.5, 0.1, 0.5, 1.0, 0.3, 0.2, 0.0]
    found = noisy_pixels.believe(sums, 3, 2, 2, 4)
    spread = sums.copy()
    spread[:, 3] = sums[:, 3].sum(axis=1, keepdims=True) / noisy_pixels.GROUPS
    alike = noisy_pixels.believe(spread, 3, 2, 2, 4)
    assert (found.value, found.lowest) == pytest.approx((alike.value, alike.lowest), rel=1e-9)
    # Sixteen groups alike say that B knows itself well. One says nothing, and samples are counted.
    assert found.variance > 1.5 * alike.variance


@pytest.mark.parametrize("part", [1e-16, 1e-13, 2e-9, 1e-6])
def test_a_part_that_vanishes_has_no_say(part):
    """A class that is in one group, or evenly in two, and a trace of other pixels in another."""
    one = np.array([2.0, 2.0, 2.5, 0.1, 0.5, 1.0, 0.3, 0.2, 0.0])
    trace = part * np.array([1.0, 9.0, 90.0, 0.5, 2.0, 1.5, 2.0, 5.0, 0.0])
    for groups in ([5], [5, 6]):
        sums = noisy_pixels.no_sums()
        sums[:, 3, groups] = one[:, None] / len(groups)
        without = noisy_pixels.believe(sums, 3, 2, 2, 4)
        sums[:, 3, 9] = trace
        found = noisy_pixels.believe(sums, 3, 2, 2, 4)
        np.testing.assert_allclose(found[1:], without[1:], rtol=max(1e3 * part, 1e-9))


@pytest.mark.parametrize("replicates", [1, 2, 3, 4, 8])
def test_one_survey_gives_what_each_question_gives_by_itself(replicates):
    means, counts = noisy_film(3, replicates=replicates).replicate_means()
    seen = survey(means, counts)
    np.testing.assert_equal(relmse_of(seen), estimate_relmse(means, counts))
    np.testing.assert_array_equal(unsure_pixels(seen), pixel_bars(means, counts).unsure)
    assert seen.known.all() == (replicates > 1)


@pytest.mark.parametrize("literature", [False, True])
def test_a_film_says_together_what_it_says_one_by_one(literature):
    film = noisy_film(4)
    error, unsure = film.judged(literature)
    np.testing.assert_equal(error, film.relmse_estimate(literature))
    np.testing.assert_array_equal(unsure, film.interval().unsure)
    assert 0 < unsure.sum() < unsure.size


def test_a_film_answers_anew_once_it_has_other_samples(monkeypatch):
    film, more = noisy_film(5), noisy_film(6)
    first = film.judged(literature=False)[0]
    before = film.unsure
    calls = []
    read = film.replicate_means
    monkeypatch.setattr(film, "replicate_means", lambda: (calls.append(1), read())[1])
    assert film.unsure is before
    assert film.judged(literature=False)[0] is first
    assert not calls
    # The figure of the literature was not asked for yet.
    assert film.judged()[0].figure == first.figure
    assert film.judged(literature=False)[0].figure == first.figure
    assert len(calls) == 1
    film.sums += more.sums
    film.counts += more.counts
    assert film.judged(literature=False)[0].figure != first.figure
    np.testing.assert_array_equal(film.unsure, film.interval().unsure)
    film.sums += more.sums
    film.counts += more.counts
    np.testing.assert_array_equal(film.unsure, film.interval().unsure)
    assert film.unsure is not before


def test_what_is_around_a_pixel_is_the_mean_of_its_cell_without_it():
    """Noise for which nine pixels are too few and a cell is enough."""
    rng = np.random.default_rng(3)
    picture = rng.uniform(0.95, 1.05, (3, 24, 24)).astype(np.float32)
    epsilon = 0.01
    # Needed are 20 pixels: their variance over a quarter of the brightness squared.
    variance = np.full_like(picture, 20.0 * 0.25 * (1.0 + epsilon))
    found = around(picture, variance, epsilon)
    cells = picture.reshape(3, 3, 8, 3, 8).sum(axis=(2, 4))
    expected = (np.repeat(np.repeat(cells, 8, 1), 8, 2) - picture) / 63.0
    np.testing.assert_allclose(found, expected, rtol=1e-5)
