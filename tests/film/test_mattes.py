"""Tables of coverage: ranks once more with dictionaries, and files that hold none in order."""

import collections

import numpy as np

from alight.core.errors import FilmError
from alight.films import Film, fixed_point, storage
from alight.films.archive import write_archive
from alight.films.coverage import SurfaceSums
from alight.films.mattes import MATTES, ranks_of
from alight.outputs import cryptomatte


def coverage_of(rows):
    """A table from (pixel, surface, weight)."""
    pixels, surfaces, weights = (np.array(column) for column in zip(*rows, strict=True))
    return SurfaceSums.gathered(pixels, surfaces, fixed_point.to_limbs(weights)[0])


def test_ranks_are_those_of_the_sums_of_each_name():
    """Once more with dictionaries: several surfaces of a name, weights of 0 and below, ties."""
    rng = np.random.default_rng(69)
    names = [(f"thing {number % 9}", f"{'ab'[number % 2]}/b") for number in range(20)]
    film = Film(4, 3, aovs=dict.fromkeys(MATTES, ()), surfaces=names)
    rows = [
        (pixel, int(surface), float(rng.choice([-1.0, 0.0, 0.0, 0.25, 0.5, 1.0])))
        for pixel in range(12)
        for surface in rng.permutation(20)[: rng.integers(1, 20)]
    ]
    film.coverage.add(coverage_of(rows))
    for number, layer in enumerate(MATTES):
        ids, shares = ranks_of(film, layer)
        for pixel in range(12):
            sums = collections.Counter()
            for own, surface, weight in rows:
                if own == pixel:
                    sums[cryptomatte.id_of(names[surface][number])] += weight
            best = sorted((-w, name) for name, w in sums.items() if w > 0.0)[: cryptomatte.RANKS]
            best += [(0.0, 0)] * (cryptomatte.RANKS - len(best))
            y, x = divmod(pixel, 4)
            assert list(ids[y, x]) == [name for _, name in best]
            assert list(shares[y, x]) == [-weight for weight, _ in best]


def test_names_of_materials_are_no_branches():
    film = Film(2, 1, surfaces=[("house/door", "wood"), ("house/wall", "wood/oak")])
    film.coverage.add(coverage_of([(0, 0, 1.0), (1, 1, 1.0)]))
    assert list(film.mask("house")[0]) == [1.0, 1.0]
    assert list(film.mask("wood", "cryptomatte_material")[0]) == [1.0, 0.0]


def is_readable(film, folder, **columns):
    """Whether a film is read from a file in which columns of its table are others."""
    described, arrays = storage.pack_films([film])
    arrays |= {f"0.coverage.{name}": column for name, column in columns.items()}
    write_archive(folder / "odd.alight", {"films": described}, arrays)
    try:
        Film.load(folder / "odd.alight")
    except FilmError as error:
        assert "holds no readable film" in str(error)
        return False
    return True


def test_a_film_file_with_numbers_of_nothing_is_refused(tmp_path):
    film = Film(2, 1, surfaces=[("a", "a"), ("b", "b"), ("c", "c")])
    film.coverage.add(coverage_of([(0, 0, 1.0), (0, 1, 1.0), (1, 0, 1.0)]))
    pixels, surfaces, _ = film.coverage.sums
    ends = {"pixels": 2, "surfaces": 3}
    assert is_readable(film, tmp_path)
    for name, column in (("pixels", pixels), ("surfaces", surfaces)):
        for place, number in ((-1, ends[name]), (0, -1)):
            odd = column.copy()
            odd[place] = number
            assert not is_readable(film, tmp_path, **{name: odd}), (name, number)


def test_a_film_file_whose_rows_are_out_of_order_is_refused(tmp_path):
    """Each pair stands once, pixels first; sums of pairs that stand twice would be lost."""
    film = Film(2, 1, surfaces=[("a", "a"), ("b", "b")])
    film.coverage.add(coverage_of([(0, 0, 1.0), (0, 1, 1.0), (1, 0, 1.0)]))
    for pixels, surfaces, right in (
        ((0, 0, 1), (0, 1, 0), True), ((0, 0, 1), (1, 0, 0), False), ((0, 0, 1), (0, 0, 0), False),
        ((0, 1, 0), (0, 0, 1), False),
    ):  # fmt: skip
        columns = {"pixels": np.array(pixels), "surfaces": np.array(surfaces)}
        assert is_readable(film, tmp_path, **columns) == right, (pixels, surfaces)


def test_rows_that_are_joined_are_canonical():
    """As many as an int64 holds fit only where what one limb cannot hold goes to the next."""
    limbs = fixed_point.to_limbs(np.array([0.3, 0.3, -0.7, 0.9]))[0]
    pixels, surfaces = np.array([1, 0, 1, 1]), np.array([0, 2, 0, 0])
    made = SurfaceSums.gathered(pixels, surfaces, limbs)
    again = SurfaceSums.gathered(made.pixels, made.surfaces, made.sums)
    np.testing.assert_array_equal(made.sums, again.sums)
    np.testing.assert_array_equal(made.sums[:, 0] >> 40, 0)
    np.testing.assert_allclose(fixed_point.to_float(made.sums), [0.3, 0.5], rtol=1e-6)
