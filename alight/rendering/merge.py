"""`alight.merge`: films, film files and checkpoints; `films.merging` adds their sums."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence

from alight.core.arguments import known_words
from alight.core.errors import FilmError, show_value
from alight.films import Film, merging
from alight.rendering.checkpoints.checkpoint import Stored, read_stored
from alight.rendering.checkpoints.resume import listed
from alight.rendering.schedules.schedule import Schedule
from alight.scene.content import differences

#: What holds a film.
Source = Film | str | os.PathLike[str]


@known_words("films and paths are all it takes; film.save(path) writes what it gives")
def merge(*sources: Source | Iterable[Source]) -> Film:
    """Make one film of the samples of all.

    Parameters
    ----------
    *sources : Film, path, or list of these
        Films, film files and checkpoints of one picture, with different samples
        (``first_sample``). The order does not matter.

    Returns
    -------
    Film
        Of rounds of adaptive renders, round k with round k, the picture that their schedule makes.

    Raises
    ------
    AlightError
        If a file cannot be read, two films hold the same samples, or they differ in scene,
        options, seed, replicates, size, crop, channels or kernel fingerprint: the message names
        the films and what differs.
    """
    parts = [_stored(source, number) for number, source in enumerate(_each(sources), start=1)]
    if not parts:
        raise FilmError("nothing to merge: give at least one film")
    first = parts[0]
    for part in parts[1:]:
        _check_scene(first, part)
        if part.kind != first.kind:
            raise FilmError(
                f"cannot merge {part.name} with {first.name}: {part.kind}, not {first.kind}"
            )
    names = [part.name for part in parts]
    rounds = [
        merging.merge(same, names) for same in zip(*(part.films for part in parts), strict=True)
    ]
    return _picture(first.schedule, rounds)


def _each(sources: Iterable[Source | Iterable[Source]]) -> Iterator[Source]:
    """The films and paths, those in lists too."""
    for number, source in enumerate(sources, start=1):
        if isinstance(source, Film | str | os.PathLike):
            yield source
            continue
        if not isinstance(source, Iterable):
            text = f"must be a film, a path or a list of these, got {show_value(source)}"
            raise FilmError(f"source {number} to merge {text}")
        yield from _each(source)


def _stored(source: Source, number: int) -> Stored:
    if isinstance(source, Film):
        return Stored(f"film {number}", [source], None, {})
    return read_stored(source)


def _check_scene(first: Stored, part: Stored) -> None:
    """Name the keys that differ, where both files know their scenes."""
    if first.films[0].scene_hash == part.films[0].scene_hash:
        return
    changed = differences(first.content, part.content) if first.content and part.content else []
    if changed:
        raise FilmError(
            f"cannot merge {part.name} with {first.name}: their scenes differ\n{listed(changed)}"
        )


def _picture(schedule: Schedule | None, rounds: Sequence[Film]) -> Film:
    return rounds[0] if schedule is None else schedule.picture(rounds)
