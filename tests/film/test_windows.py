"""Windows of a film: which there are, and what their cells say of their pixels."""

import itertools

import numpy as np
import pytest

from alight.core.errors import FilmError
from alight.films import Film, PartialFilm, SampleRanges
from alight.films.sample_ranges import CELL_SIZE


def is_recorded(film):
    """Whether merging finds the samples in each pixel that its cell says."""
    try:
        Film.merge(film)
    except FilmError as error:
        assert "not recorded" in str(error)
        return False
    return True


@pytest.mark.parametrize("seed", range(3))
def test_every_pixel_of_a_window_holds_what_its_cell_says(seed):
    """Cells are counted from the corner of the film; windows begin and end anywhere in them."""
    rng = np.random.default_rng(seed)
    x, y, w, h = rng.integers(1, 20), rng.integers(9, 20), 21, 25
    film = Film(50, 50, crop=(int(x), int(y), w, h))
    cells = rng.integers(0, 6, film.cells.shape)
    for place in np.ndindex(film.cells.shape):
        film.cells[place] = SampleRanges([(0, int(cells[place]))] if cells[place] else [])
    for i, j in np.ndindex(h, w):
        count = cells[(y + i) // CELL_SIZE, (x + j) // CELL_SIZE]
        film.counts[i, j] = np.bincount(
            np.arange(count) % film.replicates, minlength=film.replicates
        )
    assert is_recorded(film)
    # One sample more, anywhere, was not recorded.
    for _ in range(20):
        i, j = rng.integers(0, h), rng.integers(0, w)
        film.counts[i, j, 0] += 1
        assert not is_recorded(film)
        film.counts[i, j, 0] -= 1


def test_windows_are_those_within_the_film_and_no_others():
    """All windows of a small film, and all around it."""
    for x, y, w, h in itertools.product(range(-1, 4), repeat=4):
        pixels = {(a, b) for a in range(x, x + w) for b in range(y, y + h)}
        if pixels and pixels <= {(a, b) for a in range(3) for b in range(2)}:
            assert Film(3, 2, crop=(x, y, w, h)).counts.shape[:2] == (h, w)
        else:
            with pytest.raises(FilmError, match="inside"):
                Film(3, 2, crop=(x, y, w, h))


def test_tiles_are_those_within_the_window_and_go_where_they_belong():
    """All tiles of whole cells, of a window that leaves a margin on every side."""
    x, y, w, h = 8, 16, 16, 24
    for x0, y0, tw, th in itertools.product(range(0, 40, 8), range(0, 56, 8), (8, 16), (8, 24)):
        film = Film(40, 56, crop=(x, y, w, h), replicates=1)
        sums, counts = np.ones((th, tw, 1, 3, 2), np.int64), np.ones((th, tw, 1), np.int64)
        tile = PartialFilm(x0, y0, sums, counts, 0, 0, (0, 1))
        if x <= x0 and y <= y0 and x0 + tw <= x + w and y0 + th <= y + h:
            film.add_tile(tile)
            expected = np.zeros((56, 40), bool)
            expected[y0 : y0 + th, x0 : x0 + tw] = True
            np.testing.assert_array_equal(film.counts[..., 0], expected[y : y + h, x : x + w])
            assert is_recorded(film)
        else:
            with pytest.raises(FilmError, match="leaves the film's window"):
                film.add_tile(tile)
            assert not film.counts.any()
