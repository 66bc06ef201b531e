"""One truth about what is promised of a picture's error: of its film, and in its file."""

import numpy as np
import pytest

import alight
from alight.films import Film
from alight.films.fixed_point import to_limbs
from alight.outputs import exr


def noisy_film(replicates):
    film = Film(16, 16, replicates=replicates)
    values = np.random.default_rng(1).gamma(8.0, size=(16, 16, replicates, 3))
    film.sums[...] = to_limbs(4 * values)[0]
    film.counts[:] = 4
    return film


@pytest.mark.parametrize("replicates", [2, 3, 4, 8])
def test_a_promise_takes_an_interval(replicates, tmp_path):
    film = noisy_film(replicates)
    error = film.relmse_estimate()
    assert error.promised == (replicates >= 4) == np.isfinite(error.relmse.high)
    # What `alight info` says of the film and of its picture.
    film.save(tmp_path / "a.exr")
    film.save(tmp_path / "a.alight")
    of_file = dict(alight.info(tmp_path / "a.exr").facts)["error"]
    assert of_file == dict(alight.info(tmp_path / "a.alight").facts)["error"] == error.line
    assert ("or more" in of_file) == (replicates < 4)


def test_pixels_that_share_paths_have_an_interval_and_no_promise(tmp_path):
    film = noisy_film(4)
    film.shares_paths = True
    error = film.relmse_estimate()
    assert np.isfinite(error.relmse.high) and not error.promised
    film.save(tmp_path / "a.exr")
    assert "not promised" in exr.read_layers(tmp_path / "a.exr")[1]["error"]
