"""Films in files: all sums, counts and sample ranges, so that nothing is lost or rounded."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from alight.core.arguments import expect_path
from alight.core.errors import FilmError
from alight.films.archive import Archive, read_archive, write_archive
from alight.films.coverage import pack_sums, unpack_sums
from alight.films.ledger import Bias
from alight.films.sample_ranges import SampleRanges

if TYPE_CHECKING:
    from alight.films.film import Film

#: Of files that hold films; any other name is read as well.
SUFFIX = ".alight"

#: Attributes that make a film again, as its constructor calls them.
_IDENTITY = (
    "width", "height", "crop", "replicates", "channels", "scene_hash", "seed", "options",
    "fingerprint", "version",
)  # fmt: skip


def is_film_file(path: str | os.PathLike[str]) -> bool:
    """Whether a file of this name keeps the film, not only its picture."""
    return Path(expect_path(path)).suffix.lower() == SUFFIX


def save_film(path: str | os.PathLike[str], film: Film) -> Path:
    """Write a film, whole or not at all.

    Raises
    ------
    OutputError
        If it cannot be written; a file that was there before is then untouched.
    """
    described, arrays = pack_films([film.snapshot()])
    write_archive(path, {"films": described}, arrays)
    return Path(path)


def load_film(make: type[Film], path: str | os.PathLike[str]) -> Film:
    """Read the film of a film file or checkpoint; `make` is the class.

    Raises
    ------
    OutputError, FilmError
        If it cannot be read, is damaged, or holds several rounds of an adaptive render.
    """
    films = unpack_films(make, path, read_archive(path))
    if len(films) != 1:
        raise FilmError(
            f"{os.fspath(path)} holds {len(films)} films, the rounds of one render; "
            "alight.merge gives their picture"
        )
    return films[0]


def pack_films(films: Sequence[Film]) -> tuple[list[dict[str, Any]], dict[str, np.ndarray]]:
    """Describe films as plain JSON and arrays; they must not change meanwhile.

    Returns
    -------
    described : list of dict
    arrays : dict of str to ndarray
        Named by the number of the film.
    """
    described, arrays = [], {}
    for number, film in enumerate(films):
        distinct = {cell: index for index, cell in enumerate(dict.fromkeys(film.cells.flat))}
        described.append({
            **{name: getattr(film, name) for name in _IDENTITY},
            "aovs": film.aov_channels,
            "invalid": film.invalid,
            "saturated": film.saturated,
            "largest_sample": film.largest_sample,
            "shares_paths": film.shares_paths,
            "by_chance": film.by_chance,
            "recorded": [bias.state() for bias in film.recorded],
            "scene_warnings": list(film.scene_warnings),
            "ranges": [list(cell) for cell in distinct],
        })  # fmt: skip
        indices = [distinct[cell] for cell in film.cells.flat]
        arrays[f"{number}.cells"] = np.array(indices, np.int32).reshape(film.cells.shape)
        arrays[f"{number}.counts"] = film.counts
        for name, sums in (("sums", film.sums), *film.aov_sums.items()):
            # Limbs apart: their bytes have nothing in common that could be left out.
            arrays[f"{number}.{name}.high"] = sums[..., 0]
            arrays[f"{number}.{name}.low"] = sums[..., 1]
        if film.rare_light is not None:
            arrays[f"{number}.rare_light"] = film.rare_light
        if film.coverage:
            described[-1]["surfaces"] = film.coverage.names
            arrays |= pack_sums(f"{number}.coverage", film.coverage.sums)
    return described, arrays


def unpack_films(make: type[Film], path: str | os.PathLike[str], archive: Archive) -> list[Film]:
    """Make the films of an archive again.

    Raises
    ------
    FilmError
        If it holds none.
    """
    try:
        return [
            _unpack(make, described, number, archive.arrays)
            for number, described in enumerate(archive.content["films"])
        ]
    except (KeyError, TypeError, ValueError) as error:
        raise FilmError(f"{os.fspath(path)} holds no readable film") from error


def _unpack(
    make: type[Film], described: Mapping[str, Any], number: int, arrays: Mapping[str, np.ndarray]
) -> Film:
    identity = {name: as_tuples(described[name]) for name in _IDENTITY}
    surfaces = as_tuples(described.get("surfaces"))
    film = make(aovs=described["aovs"], surfaces=surfaces, **identity)
    film.counts = _shaped(arrays[f"{number}.counts"], film.counts)
    film.sums = _joined(arrays, f"{number}.sums", film.sums)
    film.aov_sums = {
        name: _joined(arrays, f"{number}.{name}", plane) for name, plane in film.aov_sums.items()
    }
    if film.coverage:
        pixels = film.counts[..., 0].size
        film.coverage.add(unpack_sums(f"{number}.coverage", arrays, pixels, len(surfaces)))
    ranges = [SampleRanges(pairs) for pairs in described["ranges"]]
    table = np.zeros(len(ranges), dtype=object)
    table[:] = ranges
    film.cells = table[_shaped(arrays[f"{number}.cells"], film.cells)]
    film.invalid, film.saturated = described["invalid"], described["saturated"]
    film.largest_sample = described.get("largest_sample")
    film.shares_paths = bool(described.get("shares_paths"))
    film.by_chance = bool(described.get("by_chance"))
    # Earlier versions had other words for the last two.
    older = described.get("suspicions", ())
    film.scene_warnings = tuple(described.get("scene_warnings", older))
    film.rare_light = arrays.get(f"{number}.rare_light", arrays.get(f"{number}.behind_glass"))
    film.recorded = tuple(Bias.restored(state) for state in described.get("recorded", ()))
    return film


def _joined(arrays: Mapping[str, np.ndarray], name: str, like: np.ndarray) -> np.ndarray:
    limbs = [arrays[f"{name}.high"], arrays[f"{name}.low"]]
    return _shaped(np.stack(limbs, axis=-1), like)


def _shaped(array: np.ndarray, like: np.ndarray) -> np.ndarray:
    if array.shape != like.shape:
        raise ValueError(f"shape {array.shape} instead of {like.shape}")
    return array


def as_tuples(value: Any) -> Any:
    """Turn the lists of JSON into the tuples that they were."""
    if isinstance(value, list):
        return tuple(as_tuples(item) for item in value)
    if isinstance(value, dict):
        return {key: as_tuples(item) for key, item in value.items()}
    return value
