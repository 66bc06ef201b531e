"""The schedules: by the options of a render, and by the names that checkpoints call them."""

from __future__ import annotations

from typing import Any

from alight.core.errors import FilmError, OptionError, unknown_name
from alight.options.render import PromiseOptions, RenderOptions
from alight.rendering.schedules.cycles import MOST, THRESHOLD, Cycles
from alight.rendering.schedules.schedule import Schedule, Uniform
from alight.rendering.schedules.steering import Steered
from alight.rendering.schedules.stopping import Promise

SCHEDULES: tuple[type[Schedule], ...] = (Uniform, Steered, Cycles)

#: Samples per pixel where nothing says how many.
SPP = 64


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


def promise_of(options: PromiseOptions) -> Promise | None:
    """The promise that the options ask for; None where no error is given."""
    if options.error is None:
        return None
    return Promise(options.error, options.confidence, options.metric, options.share)


def time_limit_of(options: RenderOptions) -> float | None:
    """Seconds after which no pass starts, if there is such a limit."""
    limit = options.time_limit if options.max_time is None else options.max_time
    return None if limit is None else float(limit)


def schedule_of(options: RenderOptions, own_spp: int | None) -> Schedule:
    """The schedule that the options ask for.

    Parameters
    ----------
    options : RenderOptions
    own_spp : int or None
        Samples per pixel that the scene's file asks for.
    """
    first, spp = options.first_sample, options.spp
    if options.schedule is not None:
        return options.schedule
    if options.criterion == "cycles":
        threshold = THRESHOLD if options.error is None else options.error
        return Cycles(first, options.max_spp or spp or MOST, threshold)
    promise = promise_of(options)
    if promise is not None:
        return Steered(first, options.max_spp, promise, options.adaptive)
    if options.adaptive:
        return Steered(first, spp or own_spp or SPP, None, True)
    whole = Uniform(first, spp or (None if time_limit_of(options) else own_spp or SPP))
    return whole if options.part is None else part_of(whole, *options.part)


def planned_spp(options: RenderOptions, own_spp: int | None) -> tuple[int | None, bool]:
    """Samples per pixel that the options ask for, in all parts.

    Parameters
    ----------
    options : RenderOptions
    own_spp : int or None
        Samples per pixel that the scene's file asks for.

    Returns
    -------
    int or None
        None if something else decides.
    bool
        Whether that is a limit only, and the render may end before.
    """
    if options.schedule is not None:
        return None, False
    if options.criterion == "cycles" or options.error is not None:
        return options.max_spp or options.spp, True
    if time_limit_of(options):
        return options.spp, True
    return options.spp or own_spp or SPP, False


def part_of(whole: Uniform, number: int, parts: int) -> Uniform:
    """One of the equal ranges that the samples of a render are cut into.

    Parameters
    ----------
    whole : Uniform
        With a number of samples.
    number, parts : int
        Which range, counted from 1, and of how many.

    Raises
    ------
    OptionError
        If there are more parts than samples per pixel.
    """
    assert whole.spp is not None
    if parts > whole.spp:
        text = f"there are only {whole.spp} samples per pixel for {parts} parts"
        raise OptionError(text, "part")
    begin, end = (whole.spp * n // parts for n in (number - 1, number))
    return Uniform(whole.first + begin, end - begin)
