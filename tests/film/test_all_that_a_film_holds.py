"""What copies, files and tiles must not lose, whatever a film comes to hold."""

import numpy as np
import pytest

from alight.core.errors import FilmError, OptionError
from alight.films import Film, PartialFilm, merging
from alight.films.coverage import Coverage, SurfaceSums
from alight.films.fixed_point import to_limbs
from alight.films.ledger import Bias
from alight.films.storage import pack_films

NAMES = [(f"thing {i}", f"stuff {i % 2}") for i in range(4)]
#: What is no part of the film itself: found again from it, or of one process.
OF_THE_PROCESS = {"lock", "_judged", "_mean_of", "stats"}
#: What `empty_like` leaves out.
OF_SAMPLES = {"sums", "counts", "aov_sums", "cells", "coverage", "invalid", "saturated"}
WINDOW = (8, 16, 16, 16)


def partial_of(x0, y0, w, h, seed=0):
    """A tile of one sample of three replicates, with a layer and a table of coverage."""
    rng = np.random.default_rng([seed, x0, y0])
    sums = to_limbs(rng.random((h, w, 3, 3), np.float32))[0]
    layer = to_limbs(rng.random((h, w, 1), np.float32))[0]
    pixels, things = np.arange(h * w), rng.integers(0, len(NAMES), h * w)
    table = SurfaceSums.gathered(pixels, things, to_limbs(np.full(h * w, 3.0, np.float32))[0])
    counts = np.ones((h, w, 3), np.int64)
    return PartialFilm(x0, y0, sums, counts, 2, 1, (0, 3), {"depth": layer}, table), things


def full():
    """A film of which nothing is as in a new one."""
    film = Film(
        40, 48, crop=WINDOW, replicates=3, aovs={"depth": ("Z",), "cryptomatte_object": ()},
        surfaces=NAMES, scene_hash="a", seed=5, options={"type": "path"}, fingerprint="f",
        version="1", channels=("R", "G", "B"),
    )  # fmt: skip
    film.add_tile(partial_of(*WINDOW)[0])
    film.recorded, film.largest_sample = (Bias("clamp", "said", 0.25, 0.125),), 3.5
    film.scene_warnings = ("the lamp is black",)
    film.shares_paths = film.by_chance = True
    film.rare_light = np.arange(12.0).reshape(2, 6)
    return film


def plain(value):
    """A value of a film as something that can be compared."""
    if isinstance(value, Coverage):
        return value.names, [column.tolist() for column in value.sums]
    if isinstance(value, dict):
        return {key: plain(part) for key, part in value.items()}
    return value.tolist() if isinstance(value, np.ndarray) else value


def held(film, left_out=frozenset()):
    return {n: plain(v) for n, v in vars(film).items() if n not in OF_THE_PROCESS | set(left_out)}


def test_the_film_of_these_tests_differs_from_a_new_one_in_everything():
    """So a new attribute has to be given a value here, and is compared below."""
    new, film = held(Film(8, 8)), held(full())
    assert [name for name in film if film[name] == new[name]] == ["channels"]


@pytest.mark.parametrize("copied", ["file", "snapshot", "merged"])
def test_nothing_is_lost(copied, tmp_path):
    film = full()
    if copied == "file":
        other = Film.load(film.save(tmp_path / "a.alight"))
    else:
        other = film.snapshot() if copied == "snapshot" else merging.merge([film])
    assert held(other) == held(film)


def test_films_of_earlier_versions_are_read_whole(tmp_path, monkeypatch):
    """Two of their parts had other names."""

    def earlier(films):
        described, arrays = pack_films(films)
        for one in described:
            one["suspicions"] = one.pop("scene_warnings")
        return described, {n.replace("rare_light", "behind_glass"): a for n, a in arrays.items()}

    film = full()
    monkeypatch.setattr("alight.films.storage.pack_films", earlier)
    assert held(Film.load(film.save(tmp_path / "a.alight"))) == held(film)


def test_merged_films_warn_of_what_any_warns_of():
    films = [Film(8, 8) for _ in range(3)]
    for film, told in zip(films, (("a", "b"), (), ("b", "c")), strict=True):
        film.scene_warnings = told
    assert Film.merge(*films).warnings == ["a", "b", "c"]


def test_an_empty_film_differs_in_its_samples_only():
    film = full()
    assert held(film.empty_like(), OF_SAMPLES) == held(film, OF_SAMPLES)
    assert not film.empty_like().counts.any()


def test_tables_of_tiles_go_where_their_pixels_are():
    film = Film(
        40, 48, crop=WINDOW, replicates=3, aovs={"depth": ("Z",), "cryptomatte_object": ()},
        surfaces=NAMES,
    )  # fmt: skip
    x, y, w, h = WINDOW
    expected = np.zeros((h, w), int)
    for x0, y0, tw, th in ((8, 16, 8, 16), (16, 24, 8, 8), (16, 16, 8, 8)):
        tile, things = partial_of(x0, y0, tw, th)
        film.add_tile(tile)
        expected[y0 - y : y0 - y + th, x0 - x : x0 - x + tw] = things.reshape(th, tw)
    for number, (name, _) in enumerate(NAMES):
        np.testing.assert_array_equal(film.mask(name), expected == number)


def test_the_error_of_alpha_is_that_of_a_mean_of_hits():
    rng = np.random.default_rng(3)
    hits = rng.random((6, 8, 8)) < 0.4
    film = Film(8, 8, replicates=2, aovs={"alpha": ("A",)}, options={"hide_emitters": True})
    sums = np.zeros((8, 8, 2, 3, 2), np.int64)
    layer = to_limbs(hits.sum(axis=0)[..., None].astype(np.float32))[0]
    film.add_tile(PartialFilm(0, 0, sums, np.full((8, 8, 2), 3), 0, 0, (0, 6), {"alpha": layer}))
    expected = hits.std(axis=0, ddof=1) / np.sqrt(6)
    np.testing.assert_allclose(film.alpha_error, expected, rtol=1e-5, atol=1e-7)


def test_layers_that_name_things_hold_the_first_sample_whole():
    names = np.random.default_rng(4).integers(0, 1 << 20, (8, 8, 1))
    film = Film(8, 8, replicates=3, aovs={"id": ("I",), "depth": ("Z",)})
    tile = partial_of(0, 0, 8, 8)[0]
    layer = to_limbs(names.astype(np.float32))[0]
    film.add_tile(tile._replace(aovs={"id": layer, "depth": layer.copy()}, coverage=None))
    np.testing.assert_array_equal(film.aov("id"), names)
    np.testing.assert_allclose(film.aov("depth"), names / 3.0, rtol=1e-6)


@pytest.mark.parametrize("film_has", [False, True])
@pytest.mark.parametrize("tile_has", [False, True])
def test_a_tile_has_a_table_of_coverage_where_its_film_has_one(film_has, tile_has):
    film = Film(8, 8, replicates=3, aovs={"depth": ("Z",)}, surfaces=NAMES if film_has else None)
    tile, _ = partial_of(0, 0, 8, 8)
    tile = tile if tile_has else tile._replace(coverage=None)
    if film_has == tile_has:
        film.add_tile(tile)
        assert film.spp == 3.0
        return
    with pytest.raises(FilmError, match="a table of coverage if, and only if, the film has one"):
        film.add_tile(tile)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"channels": ([1, 2, 3],)}, "channels: must be names of channels"),
        ({"channels": (1, 2, 3)}, "channels: must be names of channels"),
        ({"aovs": {"depth": [1]}}, "aovs: must be channels by layers"),
        ({"aovs": {"depth": "Z"}}, "aovs: must be channels by layers"),
    ],
)
def test_channels_are_names(arguments, message):
    with pytest.raises(OptionError, match=message):
        Film(8, 8, **arguments)


def test_formats_without_layers_ask_for_none(tmp_path, monkeypatch):
    film = Film(8, 8)
    film.save(tmp_path / "before.png")
    for name in ("standard_error", "unsure"):
        monkeypatch.setattr(Film, name, property(lambda film: pytest.fail("nobody asked")))
    film.save(tmp_path / "after.png")
    assert (tmp_path / "after.png").read_bytes() == (tmp_path / "before.png").read_bytes()
