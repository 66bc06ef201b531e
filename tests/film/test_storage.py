"""Film files: what was written comes back to the bit, and no damaged file is taken for whole."""

import copy
import errno
import hashlib
import json
import os
import pickle
import threading

import numpy as np
import pytest

import alight
from alight.core.errors import AlightError, FilmError, OutputError
from alight.films import Film, PartialFilm, archive
from alight.films.archive import read_archive, write_archive
from alight.films.fixed_point import to_limbs
from alight.rendering import merge


def film_of(first=0, count=6, seed=0, **identity):
    """A film of a few samples, negative and tiny ones among them, in a crop of ragged cells."""
    film = Film(
        27, 19, crop=(3, 2, 20, 15), replicates=3, aovs={"depth": ("Z",)}, scene_hash="a",
        seed=5, options={"type": "path", "max_depth": 8, "pair": (1, 2)}, fingerprint="f",
        version="1", **identity,
    )  # fmt: skip
    rng = np.random.default_rng([first, seed])
    values = rng.lognormal(-3, 4, (15, 20, 3, 3)) * rng.choice([-1, 1], (15, 20, 3, 3))
    sums, _, _ = to_limbs(values.astype(np.float32))
    counts = np.zeros((15, 20, 3), np.int64)
    for sample in range(first, first + count):
        counts[..., sample % 3] += 1
    depth, _, _ = to_limbs(rng.random((15, 20, 1)).astype(np.float32))
    film.add_tile(PartialFilm(3, 2, sums, counts, 2, 1, (first, count), {"depth": depth}))
    return film


def assert_same(film, other):
    np.testing.assert_array_equal(film.sums, other.sums)
    np.testing.assert_array_equal(film.counts, other.counts)
    np.testing.assert_array_equal(film.aov_sums["depth"], other.aov_sums["depth"])
    assert (film.cells == other.cells).all()
    assert film.provenance == other.provenance
    assert film.aov_channels == other.aov_channels
    assert film.channels == other.channels


def test_a_film_comes_back_to_the_bit(tmp_path):
    film = film_of()
    path = film.save(tmp_path / "a.alight")
    assert_same(Film.load(path), film)


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda film: pickle.loads(pickle.dumps(film))])
def test_copies_of_a_film_are_films_of_their_own(copied):
    film = film_of()
    other = copied(film)
    assert_same(film, other)
    with film.lock:
        # Nobody waits for the lock of the first.
        taken = threading.Thread(target=lambda: other.mean)
        taken.start()
        taken.join(10.0)
        assert not taken.is_alive()
    other.sums += 1
    assert_same(film, film_of())


def test_saved_films_merge_as_films_do(tmp_path):
    first, second = film_of(0, 6), film_of(6, 3)
    first.save(tmp_path / "a.alight")
    loaded = Film.load(tmp_path / "a.alight")
    assert_same(Film.merge(loaded, second), Film.merge(second, first))
    with pytest.raises(FilmError, match="samples 0 to 5 are in film 1 too"):
        Film.merge(first, loaded)


def test_a_list_of_films_and_files_merges_as_its_items_do(tmp_path):
    first, second, third = film_of(0, 6), film_of(6, 3), film_of(9, 3)
    path = first.save(tmp_path / "a.alight")
    whole = alight.merge(first, second, third)
    assert_same(alight.merge([path, second, third]), whole)
    assert_same(alight.merge(second, (one for one in (str(path), third))), whole)
    for wrong in (3, None, [path, 3]):
        with pytest.raises(FilmError, match="must be a film, a path or a list of these, got"):
            alight.merge(wrong)
    with pytest.raises(FilmError, match="nothing to merge"):
        alight.merge([])


def test_arrays_of_every_type_and_shape_come_back(tmp_path):
    rng = np.random.default_rng(1)
    arrays = {
        "noise": rng.integers(-(2**62), 2**62, (70, 50)),
        "equal": np.full((100, 3), -7, np.int32),
        "nothing": np.zeros((0, 4), np.float64),
        "one": np.array(2.5),
        "early": np.arange(100_000) // 10 == 3,
        "early number": np.where(np.arange(100_000) == 7, 1 << 40, 5),
        "yes": rng.random(1000) < 0.01,
        "big endian": rng.random((4, 4)).astype(">f4"),
        "strided": np.arange(100, dtype=np.uint32).reshape(10, 10)[::2, ::-3],
    }
    write_archive(tmp_path / "a", {"x": [1, None]}, arrays)
    content, found = read_archive(tmp_path / "a")
    assert content == {"x": [1, None]}
    assert found.keys() == arrays.keys()
    for name, array in arrays.items():
        np.testing.assert_array_equal(found[name], array)
        assert found[name].dtype == array.dtype.newbyteorder("=")


def test_few_bytes_are_written_for_what_says_little(tmp_path):
    size = write_archive(tmp_path / "a", {}, {"a": np.full((512, 512), 64)})
    assert size < 1000


def mutated(data, rng):
    """Damage a file as disks, transfers and crashes do."""
    kind, at = rng.integers(6), int(rng.integers(len(data)))
    length = int(rng.integers(1, 200))
    out = bytearray(data)
    if kind == 0:
        out[at] ^= 1 << int(rng.integers(8))
    elif kind == 1:
        del out[at:]
    elif kind == 2:
        out += bytes(rng.integers(0, 256, length, np.uint8))
    elif kind == 3:
        out[at : at + length] = bytes(len(out[at : at + length]))
    elif kind == 4:
        out[at:at] = bytes(rng.integers(0, 256, length, np.uint8))
    else:
        other = int(rng.integers(len(data)))
        out[at : at + length], out[other : other + length] = (
            out[other : other + length],
            out[at : at + length],
        )
    return bytes(out)


def test_every_mutated_film_is_refused_or_read_right(tmp_path):
    film, rng = film_of(), np.random.default_rng(3)
    path = film.save(tmp_path / "a.alight")
    good, refused = path.read_bytes(), 0
    for _ in range(1000):
        path.write_bytes(mutated(good, rng))
        try:
            found = Film.load(path)
        except FilmError as error:
            assert str(path) in str(error)
            refused += 1
        else:
            assert_same(found, film)
    assert refused > 950


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "is damaged or truncated"),
        (archive.MAGIC[:7], "is damaged or truncated"),
        (archive.MAGIC, "is damaged or truncated"),
        (b"PK\x03\x04 a zip file", "is not a film or checkpoint of alight"),
    ],
)
def test_what_is_no_film_is_said_to_be_none(tmp_path, data, message):
    (tmp_path / "a.alight").write_bytes(data)
    with pytest.raises(FilmError, match=message):
        Film.load(tmp_path / "a.alight")


def test_newer_formats_and_other_archives_are_refused(tmp_path, monkeypatch):
    write_archive(tmp_path / "other", {"x": 1}, {})
    with pytest.raises(FilmError, match="holds no readable film"):
        Film.load(tmp_path / "other")
    monkeypatch.setattr(archive, "VERSION", 2)
    film_of().save(tmp_path / "newer.alight")
    monkeypatch.undo()
    newer = r"^\S+ has format 2, and this version of alight knows format 1"
    with pytest.raises(FilmError, match=newer):
        Film.load(tmp_path / "newer.alight")


@pytest.mark.parametrize("wrong", [None, 3, b"a.alight", [film_of()]])
def test_what_is_no_path_of_a_film_is_refused(wrong):
    with pytest.raises(FilmError, match="must be a film or its path, each by itself; got "):
        Film.load(wrong)


@pytest.mark.parametrize("wrong", [None, 3, b"a.alight", [film_of(), [3]]])
def test_what_holds_no_film_is_not_merged(wrong):
    with pytest.raises(FilmError, match="must be a film, a path or a list of these, got "):
        merge(wrong)


def test_a_missing_file_and_a_folder_are_said(tmp_path):
    with pytest.raises(OutputError, match="there is no such file"):
        Film.load(tmp_path / "none.alight")
    with pytest.raises(AlightError, match="cannot read"):
        Film.load(tmp_path)


@pytest.mark.parametrize("call", ["fsync", "replace"])
def test_the_film_before_is_kept_until_the_new_one_is_safe(tmp_path, monkeypatch, call):
    path = film_of().save(tmp_path / "a.alight")

    def fail(*arguments):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, call, fail)
    with pytest.raises(OutputError, match="the disk is full"):
        film_of(seed=1).save(path)
    monkeypatch.undo()
    assert_same(Film.load(path), film_of())
    assert [p.name for p in tmp_path.iterdir()] == ["a.alight"]


@pytest.mark.parametrize("header", [
    {}, [], {"arrays": 5, "content": {}}, {"arrays": [{}], "content": {}},
    {"arrays": [{"name": "a", "shape": [2**43], "type": "int64", "planes": [["raw", 1]] * 8}]},
    {"arrays": [{"name": "a", "shape": [-1], "type": "int64", "planes": [["raw", 1]] * 8}]},
    {"arrays": [{"name": "a", "shape": [4], "type": "object", "planes": [["raw", 1]] * 8}]},
    {"arrays": [{"name": "a", "shape": [4], "type": "int64", "planes": [["deflated", 4]] * 8}]},
])  # fmt: skip
def test_a_file_that_somebody_made_is_refused_too(tmp_path, header):
    """Its checksum is right, and what it says is not what alight would write."""
    text = json.dumps(header).encode()
    data = archive._HEAD.pack(archive.VERSION, len(text)) + text + bytes(64)
    path = tmp_path / "a.alight"
    path.write_bytes(archive.MAGIC + hashlib.sha256(data).digest() + data)
    with pytest.raises(FilmError, match="readable film"):
        Film.load(path)


def test_a_film_knows_whether_pixels_share_paths(tmp_path):
    film = film_of()
    film.shares_paths = True
    assert Film.load(film.save(tmp_path / "a.alight")).shares_paths
    assert Film.merge(film, film_of(6, 3)).shares_paths
    assert not Film.load(film_of().save(tmp_path / "b.alight")).shares_paths
