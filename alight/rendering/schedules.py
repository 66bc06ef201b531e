"""The schedules, by the names that checkpoints call them."""

from __future__ import annotations

from typing import Any

from alight.core.errors import FilmError, unknown_name
from alight.rendering.cycles import Cycles
from alight.rendering.schedule import Schedule, Uniform
from alight.rendering.steering import Steered

SCHEDULES: tuple[type[Schedule], ...] = (Uniform, Steered, Cycles)


def restored_schedule(name: str, state: dict[str, Any]) -> Schedule:
    """Make the schedule of a checkpoint again.

    Raises
    ------
    FilmError
        If this version of alight has no such schedule.
    """
    known = {schedule.name: schedule for schedule in SCHEDULES}
    if name not in known:
        raise FilmError(unknown_name("schedule", name, known))
    return known[name].restored(state)
