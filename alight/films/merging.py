"""Adding films: exact, in any order, and refused by name where the pictures are not the same."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from alight.core.errors import FilmError
from alight.films import fixed_point, ledger
from alight.films.coverage import check_same_names
from alight.films.sample_ranges import CELL_SIZE, cells_of, union_of_cells
from alight.films.tiles import check_room, names_of

if TYPE_CHECKING:
    from alight.films.film import Film

#: What two films must share, and how a message calls it.
_IDENTITY: tuple[tuple[str, Callable[[Any], Any]], ...] = (
    ("size", lambda film: (film.width, film.height)),
    ("crop", lambda film: film.crop),
    ("number of replicates", lambda film: film.replicates),
    ("channels", lambda film: film.channels),
    ("set of layers", lambda film: film.aov_channels),
    ("scene hash", lambda film: film.scene_hash),
    ("seed", lambda film: film.seed),
    ("kernel fingerprint", lambda film: film.fingerprint),
)


def merge(films: Sequence[Film], names: Sequence[str] | None = None) -> Film:
    """Make the film of all samples of `films` (see `Film.merge`).

    `names` are what messages call them; "film 1", "film 2" by default.
    """
    if not films:
        raise FilmError("nothing to merge: give at least one film")
    names = names or [f"film {number}" for number in range(1, len(films) + 1)]
    parts = [film.snapshot() for film in films]
    for name, part in zip(names, parts, strict=True):
        _check_recorded(part, name)
        _check_same(parts[0], part, names[0], name)
    result = parts[0].empty_like()
    result.recorded = ledger.joined(part.recorded for part in parts)
    told = dict.fromkeys(text for part in parts for text in part.scene_warnings)
    result.scene_warnings = tuple(told)
    index = cells_of(*result.crop)
    for number, (name, part) in enumerate(zip(names, parts, strict=True)):
        _check_disjoint(parts[:number], part, index, names, name)
        result.cells[index] = union_of_cells(result.cells[index], part.cells[index])
        result.counts += part.counts
        check_room(result, result.counts)
        for target, added in _planes(result, part):
            target += added
            fixed_point.carry(target)
        if result.coverage and part.coverage:
            result.coverage.add(part.coverage.sums)
        result.invalid += part.invalid
        result.saturated += part.saturated
    return result


def add(film: Film, other: Film) -> None:
    """Add what `other` holds to a film without layers, as `merge` does, but in place."""
    with film.lock:
        merged = merge((film, other))
        film.sums, film.counts, film.cells = merged.sums, merged.counts, merged.cells
        film.invalid, film.saturated = merged.invalid, merged.saturated


def check_samples(film: Film, spp: int) -> None:
    """Refuse a film with another number of samples in any pixel: a part is missing.

    Raises
    ------
    FilmError
        It says which samples there are.
    """
    count = film.sample_count
    if (count == spp).all():
        return
    cells = film.cells[cells_of(*film.crop)]
    held = next(cell for cell in cells.flat if cell.count != spp)
    least, most = count.min(), count.max()
    counted = f"{least} to {most}" if least < most else f"{most}"
    raise FilmError(
        f"each pixel has {counted} {'sample' if most == 1 else 'samples'}, not {spp}; "
        f"a cell holds those numbered {held}"
    )


def _planes(result: Film, part: Film) -> list[tuple[np.ndarray, np.ndarray]]:
    named = [(plane, part.aov_sums[name]) for name, plane in result.aov_sums.items()]
    return [(result.sums, part.sums), *named]


def _check_same(first: Film, other: Film, first_name: str, name: str) -> None:
    for what, of in _IDENTITY:
        if of(first) != of(other):
            raise FilmError(
                f"cannot merge {name} with {first_name}: the {what} differs "
                f"({_shown(of(other))}, not {_shown(of(first))})"
            )
    check_same_names(first.coverage, other.coverage, f"cannot merge {name} with {first_name}")
    for key in sorted(first.options.keys() | other.options.keys()):
        a, b = first.options.get(key), other.options.get(key)
        if a != b:
            raise FilmError(
                f'cannot merge {name} with {first_name}: the option "{key}" differs '
                f"({_shown(b)}, not {_shown(a)})"
            )


def _shown(value: Any) -> str:
    if isinstance(value, Mapping):
        return names_of(value)
    return "x".join(map(str, value)) if isinstance(value, tuple) else repr(value)


def _check_disjoint(
    before: Sequence[Film], part: Film, index: Any, names: Sequence[str], name: str
) -> None:
    for earlier, film in zip(names, before, strict=False):
        # Films of uniform pictures have few different cells.
        pairs = set(zip(film.cells[index].flat, part.cells[index].flat, strict=True))
        for mine, theirs in pairs:
            common = mine.overlap(theirs)
            if common.count:
                raise FilmError(
                    f"cannot merge {name}: samples {common} are in {earlier} too and would be "
                    "counted twice; render it with another first sample"
                )


def _check_recorded(film: Film, name: str) -> None:
    """Every pixel must hold the samples that its cell's ranges say."""
    size = CELL_SIZE
    x, y, w, h = film.crop
    per_cell = np.array([[cell.count for cell in row] for row in film.cells], np.int64)
    expected = per_cell[(y + np.arange(h))[:, None] // size, (x + np.arange(w))[None, :] // size]
    if (film.counts.sum(axis=2) != expected).any():
        raise FilmError(f"cannot merge {name}: it holds samples whose indices were not recorded")
