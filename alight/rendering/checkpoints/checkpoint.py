"""What a checkpoint holds: the job's state, and where its scene came from.

A checkpoint is a film file (`alight.films.archive`) that also has

========  ===========================================================================
recipe    how to load the scene again
scene     its content by key, to name what changed
machine   versions, processor and lanes: what decides the bits of a picture
job       schedule with its state, goal, rays, samples, seconds
notes     plain JSON of whoever rendered, as the names of the pictures to be written
========  ===========================================================================
"""

from __future__ import annotations

import json
import os
import shlex
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from alight.core.errors import FilmError, OutputError
from alight.films import Film
from alight.films.archive import Archive, read_archive, write_archive
from alight.films.storage import as_tuples, pack_films, unpack_films
from alight.rendering.job import JobState
from alight.rendering.schedules.passes import Work
from alight.rendering.schedules.schedule import Goal, Schedule, Verdict
from alight.rendering.schedules.selection import restored_schedule
from alight.scene import Scene
from alight.scene.content import describe_content
from alight.scene.source import Recipe


@dataclass(frozen=True)
class Origin:
    """Of what a checkpoint is one.

    Attributes
    ----------
    recipe : Recipe or None
        How the scene was loaded; None for one that was made in Python.
    content : mapping of str to str
        What the scene says, key by key, and digests of the files that it names.
    machine : mapping of str to str
        Who renders; see `Executor.machine`.
    notes : mapping of str to plain JSON
    """

    recipe: Recipe | None
    content: Mapping[str, str]
    machine: Mapping[str, str]
    notes: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, scene: Scene, notes: Mapping[str, Any], machine: Mapping[str, str]) -> Origin:
        """Describe a scene on a machine."""
        return cls(scene.source.recipe, describe_content(scene), machine, dict(notes))


@dataclass(frozen=True)
class Checkpoint:
    """A checkpoint that was read."""

    path: str
    state: JobState
    origin: Origin


def write_checkpoint(path: str | os.PathLike[str], state: JobState, origin: Origin) -> int:
    """Write a checkpoint, whole or not at all; gives its size in bytes.

    Raises
    ------
    OutputError
        If it cannot be written; the one that was there before is then untouched.
    """
    films, arrays = pack_films(state.rounds)
    plain, own = {}, {}
    for name, value in state.schedule_state.items():
        (own if isinstance(value, np.ndarray) else plain)[name] = value
    arrays |= {f"schedule.{name}": array for name, array in own.items()}
    if state.goal is not None:
        arrays |= {"goal.first": state.goal.first, "goal.count": state.goal.count}
    job = {
        "schedule": state.schedule,
        "state": plain,
        "goal": None if state.goal is None else state.goal.round,
        "rays": state.rays,
        "samples": state.samples,
        "seconds": state.seconds,
        "time_limit": state.time_limit,
    }
    recipe = None if origin.recipe is None else asdict(origin.recipe)
    # As an array, because only these are deflated.
    arrays["scene"] = np.frombuffer(json.dumps(dict(origin.content)).encode(), np.uint8)
    content = {
        "films": films,
        "recipe": recipe,
        "machine": dict(origin.machine),
        "job": job,
        "notes": dict(origin.notes),
    }
    return write_archive(path, content, arrays)


class Stored(NamedTuple):
    """What a film file or checkpoint says about its films.

    Attributes
    ----------
    name : str
        For messages.
    films : list of Film
        The rounds of one render.
    schedule : Schedule or None
        Makes the picture of the rounds; None for a film file.
    content : mapping of str to str
        Of the scene, key by key; empty where it is not known.
    """

    name: str
    films: list[Film]
    schedule: Schedule | None
    content: Mapping[str, str]

    @property
    def kind(self) -> str:
        """What can be added only to its like."""
        if self.schedule is None or len(self.films) == 1:
            return "one film"
        return f"{len(self.films)} rounds of the schedule {self.schedule.name}"


def read_stored(path: str | os.PathLike[str]) -> Stored:
    """Read the films of a film file or checkpoint.

    Raises
    ------
    OutputError, FilmError
        If it cannot be read or is damaged.
    """
    archive = read_archive(path)
    films = unpack_films(Film, path, archive)
    if "job" not in archive.content:
        return Stored(os.fspath(path), films, None, {})
    job = archive.content["job"]
    schedule = restored_schedule(job["schedule"], _schedule_state(archive))
    return Stored(os.fspath(path), films, schedule, _content(archive))


def read_checkpoint(path: str | os.PathLike[str]) -> Checkpoint:
    """Read a checkpoint.

    Raises
    ------
    OutputError, FilmError
        If it cannot be read, is damaged, or is a film without a job.
    """
    archive = read_archive(path)
    content, arrays = archive
    films = unpack_films(Film, path, archive)
    if "job" not in content:
        raise FilmError(
            f"{os.fspath(path)} is a film, not a checkpoint: it does not record how to continue; "
            "alight merge, in Python alight.merge, adds other samples to it"
        )
    job, recipe = content["job"], content["recipe"]
    goal = None
    if job["goal"] is not None:
        goal = Goal(arrays["goal.first"], arrays["goal.count"], job["goal"])
    state = JobState(
        rounds=films,
        schedule=job["schedule"],
        schedule_state=_schedule_state(archive),
        goal=goal,
        rays=job["rays"],
        samples=job["samples"],
        seconds=job["seconds"],
        time_limit=job["time_limit"],
    )
    origin = Origin(
        None if recipe is None else Recipe(**as_tuples(recipe)),
        _content(archive),
        content["machine"],
        content["notes"],
    )
    return Checkpoint(os.fspath(path), state, origin)


def check_nothing_is_lost(path: str | os.PathLike[str]) -> None:
    """Refuse to begin a render over a file whose samples would be lost.

    Who runs the same command again after a stop means to go on, and would lose all samples with the
    first checkpoint. The checkpoint of a render that has ended is written over, as its pictures
    are. What is no checkpoint, or cannot be read as one, is kept: a film, a file of a newer alight.

    Raises
    ------
    OutputError
        With the command that goes on, or what the file is.
    """
    name = os.fspath(path)
    try:
        state = read_checkpoint(path).state
    except FilmError as error:
        if not Path(path).stat().st_size:
            return
        text = f"cannot write a checkpoint: {error}; remove it first, or choose another name"
        raise OutputError(text) from None
    except OutputError:
        # There is none; what cannot be read at all is reported when it is written.
        return
    if _is_over(state):
        return
    spp = state.rounds[0].spp
    raise OutputError(
        f"cannot write {name}: it holds {spp:.4g} samples per pixel of a render that was stopped; "
        f"to go on: alight resume {shlex.quote(name)}, in Python alight.resume({name!r}); "
        "to begin anew, remove it first"
    )


def _is_over(state: JobState) -> bool:
    """Whether nothing is lost with a job: it has ended, or has no sample."""
    out_of_time = state.time_limit is not None and state.seconds >= state.time_limit
    if state.goal is None or not state.samples or out_of_time:
        return True
    begun = state.rounds[state.goal.round :]
    if not begun or Work(state.goal, begun[0]).left:
        return False
    # A goal that is reached may be a look of many.
    schedule = restored_schedule(state.schedule, state.schedule_state)
    return isinstance(schedule.next(state.rounds), Verdict)


def _schedule_state(archive: Archive) -> dict[str, Any]:
    arrays = {
        name.removeprefix("schedule."): array
        for name, array in archive.arrays.items()
        if name.startswith("schedule.")
    }
    return {**archive.content["job"]["state"], **arrays}


def _content(archive: Archive) -> dict[str, str]:
    return json.loads(archive.arrays["scene"].tobytes())
