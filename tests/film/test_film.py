"""The film: exact in any order, honest about its error, and strict about what it adds."""

import itertools
import threading
from fractions import Fraction

import numpy as np
import pytest

from alight.core.errors import FilmError
from alight.films import Film, PartialFilm, SampleRanges, fixed_point, readout
from alight.films.fixed_point import to_limbs
from alight.rendering.tiles.tile import compiled_add_rows

REPLICATES = 4


def samples_of(width, height, first, count, seed=0):
    """Values of samples that depend on pixel and index alone, shape (count, h, w, 3)."""
    return np.stack([
        np.random.default_rng([seed, i]).lognormal(-2, 2, (height, width, 3))
        for i in range(first, first + count)
    ]).astype(np.float32)  # fmt: skip


def partial_of(values, x0, y0, first, replicates=REPLICATES, aovs=None):
    """A tile's film of `values`, shape (count, h, w, 3), of the samples from `first` on."""
    count, h, w, _ = values.shape
    sums = np.zeros((h, w, replicates, 3, 2), np.int64)
    counts = np.zeros((h, w, replicates), np.int64)
    limbs, invalid, saturated = to_limbs(values)
    for i in range(count):
        sums[:, :, (first + i) % replicates] += limbs[i]
        counts[:, :, (first + i) % replicates] += 1
    bad = int(invalid.any(axis=-1).sum())
    return PartialFilm(x0, y0, sums, counts, bad, int(saturated.sum()), (first, count), aovs)


def film_of(values, first=0, **options):
    height, width = values.shape[1:3]
    film = Film(width, height, **options)
    film.add_tile(partial_of(values, 0, 0, first, film.replicates))
    return film


def same_bits(a, b):
    return (
        (a.sums == b.sums).all()
        and (a.counts == b.counts).all()
        and (a.cells == b.cells).all()
        and (a.invalid, a.saturated) == (b.invalid, b.saturated)
    )


# ---------------------------------------------------------------------------- exactness


def test_tiles_in_any_order_and_passes_of_any_length_give_the_same_bits():
    values = samples_of(24, 20, 0, 16)
    values[3, 1, 2], values[9, 17, 20], values[9, 0, 0] = np.nan, np.inf, 1e30
    whole = film_of(values)
    assert (whole.invalid, whole.saturated) == (2, 3)
    rng = np.random.default_rng(5)
    for cuts in ([0, 16], [0, 1, 7, 16], [0, 5, 10, 11, 16]):
        pieces = [
            partial_of(values[a:b, y : y + 8, x : x + 8], x, y, a)
            for a, b in itertools.pairwise(cuts)
            for y in range(0, 20, 8)
            for x in range(0, 24, 8)
        ]
        film = Film(24, 20)
        for i in rng.permutation(len(pieces)):
            film.add_tile(pieces[i])
        assert same_bits(film, whole)


def test_merged_parts_give_the_bits_of_the_whole():
    values = samples_of(16, 8, 0, 64)
    whole = film_of(values)
    a, b, c = (film_of(values[s : s + n], first=s) for s, n in ((0, 32), (32, 3), (35, 29)))
    assert same_bits(Film.merge(a, b, c), whole)
    assert same_bits(Film.merge(c, a, b), whole)
    assert same_bits(Film.merge(a, Film.merge(c, b)), whole)
    assert (Film.merge(b, c, a).image == whole.image).all()


def test_the_image_is_the_exact_mean_rounded_once():
    values = samples_of(3, 2, 0, 37) * np.float32(1e3)
    film = film_of(values)
    for y, x, c in np.ndindex(2, 3, 3):
        mean = sum(Fraction(float(v)) for v in values[:, y, x, c]) / 37
        assert abs(Fraction(float(film.mean[y, x, c])) - mean) <= mean * Fraction(
            4, 2**53
        ) + Fraction(1, 2**48)
        assert film.image[y, x, c] == np.float32(float(mean))


def test_threads_add_without_losing_samples():
    values = samples_of(32, 32, 0, 32)
    pieces = [
        partial_of(values[i : i + 1, y : y + 8], 0, y, i)
        for i in range(32)
        for y in range(0, 32, 8)
    ]
    film = Film(32, 32)

    def work(k):
        for piece in pieces[k::4]:
            film.add_tile(piece)
            film.image  # noqa: B018 (reading while others add must be safe)

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert same_bits(film, film_of(values))


def test_sums_that_are_not_canonical_become_so():
    values = samples_of(8, 8, 0, 4)
    tile = partial_of(values, 0, 0, 0)
    moved = tile.sums.copy()
    moved[..., 0] -= 3
    moved[..., 1] += 3 << 40
    film = Film(8, 8)
    film.add_tile(tile._replace(sums=moved))
    assert same_bits(film, film_of(values))


# ---------------------------------------------------------------------------- statistics


def test_standard_error_is_the_formula_of_the_replicates():
    values = samples_of(5, 4, 0, 14)
    film = film_of(values)
    n = np.array([4, 4, 3, 3])
    means = np.stack([values[r::4].astype(np.float64).mean(axis=0) for r in range(4)])
    mean = values.astype(np.float64).mean(axis=0)
    squared = (n[:, None, None, None] ** 2 * (means - mean) ** 2).sum(axis=0) / (14**2 - sum(n**2))
    np.testing.assert_allclose(film.standard_error, np.sqrt(squared), rtol=1e-6)


def test_standard_error_matches_the_true_spread_of_the_mean():
    rng = np.random.default_rng(3)
    values = rng.normal(5.0, 2.0, (64, 64, 64, 3)).astype(np.float32)
    squared = film_of(values).standard_error.astype(np.float64) ** 2
    # Mean of 64 * 64 * 3 chi-squared variables of 3 degrees of freedom: relative spread 0.74 %.
    assert squared.mean() == pytest.approx(2.0**2 / 64, rel=0.03)


def test_error_is_unknown_while_a_replicate_is_empty_and_never_zero():
    film = Film(8, 8)
    assert np.isnan(film.standard_error).all()
    for i in range(3):
        film.add_tile(partial_of(samples_of(8, 8, i, 1), 0, 0, i))
        assert np.isnan(film.standard_error).all()
        assert np.isnan(film.relmse_estimate().relmse.value)
    film.add_tile(partial_of(samples_of(8, 8, 3, 1), 0, 0, 3))
    assert (film.standard_error > 0).all()
    assert film.relmse_estimate().known == 1.0


def test_error_is_unknown_with_one_replicate():
    film = film_of(samples_of(8, 8, 0, 8), replicates=1)
    assert np.isnan(film.standard_error).all()


def test_pixels_without_samples_are_black_and_uncounted():
    film = Film(16, 8)
    film.add_tile(partial_of(samples_of(8, 8, 0, 4), 8, 0, 0))
    assert (film.image[:, :8] == 0).all()
    assert (film.sample_count[:, :8] == 0).all()
    assert (film.sample_count[:, 8:] == 4).all()
    assert np.isnan(film.standard_error[:, :8]).all()
    assert film.relmse_estimate().known == 0.5


def test_invalid_samples_count_one_and_add_nothing():
    values = np.ones((4, 8, 8, 3), np.float32)
    values[1, 2, 3] = np.nan
    values[2, 2, 3, 0] = 1e30
    film = film_of(values)
    assert (film.invalid, film.saturated) == (1, 1)
    assert film.sample_count[2, 3] == 4
    assert film.image[2, 3, 1] == 0.75
    assert film.image[2, 3, 0] == np.float32((2.0**36 + 2) / 4)


# ---------------------------------------------------------------------------- crop, AOVs


def test_a_crop_holds_the_cut_out_of_the_full_film():
    values = samples_of(24, 24, 0, 8)
    whole = film_of(values)
    crop = Film(24, 24, crop=(5, 8, 13, 11))
    crop.add_tile(partial_of(values[:, 8:19, 5:18], 5, 8, 0))
    assert (crop.image == whole.image[8:19, 5:18]).all()
    assert crop.cells[1, 0] == SampleRanges([(0, 8)])
    assert crop.cells[0, 0] == SampleRanges()


def test_aovs_are_exact_means_over_all_samples_and_leave_beauty_alone():
    values = samples_of(8, 8, 0, 6)
    limbs, _, _ = to_limbs(values)
    depth = limbs.sum(axis=0)[:, :, :1]
    film = Film(8, 8, aovs={"depth": ("Z",)})
    film.add_tile(partial_of(values, 0, 0, 0, aovs={"depth": depth}))
    assert (film.sums == film_of(values).sums).all()
    np.testing.assert_allclose(film.aov("depth"), values.mean(axis=0)[:, :, :1], rtol=1e-6)
    with pytest.raises(FilmError, match="depth"):
        film.aov("normal")
    with pytest.raises(FilmError, match="has the AOVs depth, got none"):
        film.add_tile(partial_of(values, 0, 0, 6))


def test_ranges_may_differ_from_cell_to_cell():
    values = samples_of(16, 8, 0, 4)
    tile = partial_of(values, 0, 0, 0)
    ranges = np.array([[[0, 4], [4, 4]]])
    film = Film(16, 8)
    film.add_tile(tile._replace(ranges=ranges))
    assert film.cells.tolist() == [[SampleRanges([(0, 4)]), SampleRanges([(4, 8)])]]


# ---------------------------------------------------------------------------- refusals


def test_a_sample_is_never_added_twice():
    values = samples_of(8, 8, 0, 4)
    film = film_of(values)
    before = film.snapshot()
    with pytest.raises(FilmError, match="samples 2 to 3 would be counted twice"):
        film.add_tile(partial_of(values, 0, 0, 2))
    assert same_bits(film, before)


IDENTITIES = {
    "scene hash": {"scene_hash": "b"},
    "seed": {"seed": 7},
    "kernel fingerprint": {"fingerprint": "x"},
    "number of replicates": {"replicates": 2},
    'option "max_depth"': {"options": {"max_depth": 3}},
    "channels": {"channels": ("X", "Y", "Z")},
}


@pytest.mark.parametrize(("name", "changed"), IDENTITIES.items(), ids=IDENTITIES.keys())
def test_merging_another_picture_is_refused_by_name(name, changed):
    a = film_of(samples_of(8, 8, 0, 4), scene_hash="a")
    b = film_of(samples_of(8, 8, 4, 4), first=4, **{"scene_hash": "a", **changed})
    with pytest.raises(FilmError, match=f"cannot merge film 2 with film 1: the {name} differs"):
        Film.merge(a, b)


def test_merging_another_size_or_crop_is_refused():
    a = film_of(samples_of(8, 8, 0, 4))
    with pytest.raises(FilmError, match=r"the size differs \(16x8, not 8x8\)"):
        Film.merge(a, film_of(samples_of(16, 8, 4, 4), first=4))
    with pytest.raises(FilmError, match="the crop differs"):
        Film.merge(a, Film(8, 8, crop=(0, 0, 4, 4)))


def test_merging_overlapping_samples_is_refused():
    a, b = film_of(samples_of(8, 8, 0, 8)), film_of(samples_of(8, 8, 6, 8), first=6)
    with pytest.raises(FilmError, match="samples 6 to 7 are in film 1 too"):
        Film.merge(a, b)


def test_merging_samples_of_unknown_index_is_refused():
    values = samples_of(8, 8, 0, 4)
    film = Film(8, 8)
    film.add_tile(partial_of(values, 0, 0, 0)._replace(ranges=None))
    with pytest.raises(FilmError, match="not recorded"):
        Film.merge(film)
    film.mark_samples(0, 4)
    assert same_bits(Film.merge(film), film_of(values))


def test_merging_nothing_is_refused():
    with pytest.raises(FilmError, match="at least one film"):
        Film.merge()


def test_more_samples_than_fit_are_refused_before_they_overflow():
    film = Film(8, 8)
    tile = partial_of(samples_of(8, 8, 0, 4), 0, 0, 0)
    film.add_tile(tile._replace(counts=np.full((8, 8, 4), fixed_point.MAX_SAMPLES)))
    with pytest.raises(FilmError, match="at most 524287 samples per pixel and replicate"):
        film.add_tile(tile._replace(ranges=(4, 4)))


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"x0": 4}, "leaves the film's window"),
        ({"x0": -8}, "leaves the film's window"),
        ({"counts": np.zeros((8, 8, 3), np.int64)}, "counts of shape"),
    ],
)
def test_tiles_that_do_not_fit_are_refused(changed, message):
    film = Film(8, 8)
    with pytest.raises(FilmError, match=message):
        film.add_tile(partial_of(samples_of(8, 8, 0, 1), 0, 0, 0)._replace(**changed))


def test_half_a_cell_is_refused():
    film = Film(16, 16)
    with pytest.raises(FilmError, match="8x8 cells, got x from 0 to 4"):
        film.add_tile(partial_of(samples_of(4, 8, 0, 1), 0, 0, 0))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"width": 0}, "at least 1x1"),
        ({"replicates": 0}, "replicates"),
        ({"crop": (0, 0, 9, 8)}, "crop 0,0,9,8"),
        ({"crop": (-1, 0, 4, 4)}, "crop"),
        ({"crop": (0, 0, 0, 4)}, "crop"),
        ({"crop": (0, 0, 4, 0)}, "crop"),
        ({"channels": ("Y",)}, "channels"),
    ],
)
def test_impossible_films_are_refused(arguments, message):
    with pytest.raises(FilmError, match=message):
        Film(**{"width": 8, "height": 8, **arguments})


# ---------------------------------------------------------------------------- output


def test_a_snapshot_does_not_change_any_more():
    film = film_of(samples_of(8, 8, 0, 4))
    snapshot = film.snapshot()
    film.add_tile(partial_of(samples_of(8, 8, 4, 4), 0, 0, 4))
    assert same_bits(snapshot, film_of(samples_of(8, 8, 0, 4)))


def test_provenance_says_what_and_how():
    film = film_of(
        samples_of(8, 8, 0, 6), scene_hash="abc", seed=9, options={"max_depth": 8},
        fingerprint="f", version="1.2",
    )  # fmt: skip
    assert film.provenance == {
        "version": "1.2", "scene_hash": "abc", "seed": 9, "spp": 6.0, "replicates": 4,
        "size": (8, 8), "crop": (0, 0, 8, 8), "options": {"max_depth": 8}, "fingerprint": "f",
        "invalid": 0, "saturated": 0, "biases": "none",
    }  # fmt: skip


def test_notebooks_show_the_picture_and_its_error():
    film = film_of(samples_of(8, 8, 0, 16))
    assert film._repr_png_().startswith(b"\x89PNG")
    page = film._repr_html_()
    assert "8 × 8 pixels, 16 samples per pixel, relative error" in page
    assert "data:image/png;base64," in page
    assert repr(film) == "<Film 8x8, 16 spp, 4 replicates>"


def test_machine_code_adds_tiles_as_numpy_does():
    rng = np.random.default_rng(3)
    films = [Film(19, 21, crop=(2, 3, 16, 17), replicates=2) for _ in range(2)]
    for x0, y0, width, height in ((8, 8, 8, 8), (2, 3, 6, 5), (8, 8, 8, 8), (16, 16, 2, 4)):
        shape = (height, width, 2)
        # Both limbs of any sign, with carries in both directions.
        sums = rng.integers(-(2**52), 2**52, (*shape, 3, 2))
        for film, add_rows in zip(films, (None, compiled_add_rows()), strict=True):
            tile = PartialFilm(x0, y0, sums.copy(), np.ones(shape, np.int64), 0, 0)
            film.add_tile(tile, add_rows)
    np.testing.assert_array_equal(films[1].sums, films[0].sums)


@pytest.mark.parametrize("channels", [("R", "G", "B"), ("R", "G", "B", "A")])
def test_machine_code_reads_films_as_numpy_does(monkeypatch, channels):
    """More rows than a band, a cut band at the end, negative sums, and empty replicates."""
    rng = np.random.default_rng(4)
    film = Film(21, 37, replicates=3, channels=channels)
    # Of all sizes: in large sums alone no float32 would show the lower halves.
    film.sums[...] = rng.integers(-(2**50), 2**50, film.sums.shape)
    film.sums[..., 0] >>= rng.integers(0, 60, film.sums.shape[:-1])
    fixed_point.carry(film.sums)
    film.counts[...] = rng.integers(0, 5, film.counts.shape)
    image, (means, counts) = film.image, film.replicate_means()
    monkeypatch.setattr(readout, "_LARGE", 0)
    np.testing.assert_array_equal(film.image, image)
    again, held = film.replicate_means()
    np.testing.assert_array_equal(again, means)
    np.testing.assert_array_equal(held, counts)
    # So many samples that their sum could overflow are left to NumPy.
    film.counts[0, 0], film.sums[0, 0, ..., 0] = fixed_point.MAX_SAMPLES, 2**62
    full = film.image
    monkeypatch.setattr(readout, "_LARGE", 2**40)
    np.testing.assert_array_equal(film.image, full)
