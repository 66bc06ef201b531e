"""Schedules that render until an error is reached, or where samples are worth most."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, ClassVar, Self

import numpy as np

from alight.core.errors import OptionError
from alight.films import Film
from alight.films.fixed_point import MAX_SAMPLES
from alight.films.ledger import Bias
from alight.films.sample_ranges import cells_of
from alight.metrics.error_estimate import LEAST_FOR_INTERVAL
from alight.rendering.schedules.adaptive import PILOT_SPP, counts_at, shares_of
from alight.rendering.schedules.schedule import Goal, Schedule, Uniform, Verdict
from alight.rendering.schedules.stopping import (
    Judgement,
    Promise,
    early_line,
    first_look,
    judge,
    line_of,
    next_look,
    word_of,
)

#: What the ledger says of a render that its own error ended.
_STOPPED = (
    "the samples themselves decided how many there are (measured on the scenes of "
    "docs/known-error.md: less than 0.2 % of the light)"
)


class Steered(Schedule):
    """Samples until a promise is kept, or up to a number; evenly, or where they are worth most.

    Parameters
    ----------
    first : int
        Index of the first sample.
    spp : int or None
        Largest number of samples per pixel (on average); None is what the film has room for.
    promise : Promise, optional
        Ends the render when it is kept.
    adaptive : bool
        Whether a pilot says which cells get how much.
    """

    name: ClassVar[str] = "steered"

    def __init__(
        self, first: int, spp: int | None, promise: Promise | None = None, adaptive: bool = False
    ) -> None:
        if promise is None and spp is None:
            raise OptionError("adaptive: give spp or an error, or it would never end")
        self.first, self.spp, self.promise, self.adaptive = first, spp, promise, adaptive
        self.shares, self.piloted = np.zeros(0), False
        # Samples per pixel of the look, and whether they have been asked for.
        self.now, self.asked = 0, False

    def next(self, rounds: Sequence[Film]) -> Goal | Verdict:
        """First the pilot, then look after look."""
        film = rounds[0]
        if self.promise is not None:
            check_replicates(film)
        if self.adaptive and not self.shares.size:
            if not self.piloted:
                # What a render before this one has of the pilot is not rendered again.
                self.piloted = True
                pilot = film.replicates * max(math.ceil(PILOT_SPP / film.replicates), 2)
                return Goal.uniform(film, self.first, pilot, round=1)
            self.shares = shares_of(rounds[1])
        most = self._most(film)
        if self.asked:
            verdict = self._verdict(film, most)
            if verdict is not None:
                return verdict
            self.now = min(next_look(self.now, film.replicates), most)
        elif not self.now:
            self.now = most if self.promise is None else min(first_look(film.replicates), most)
        self.asked = True
        counts = self._counts_at(film, self.now)
        return Goal(np.full(counts.shape, self.first, np.int64), counts)

    def _most(self, film: Film) -> int:
        room = MAX_SAMPLES * (1 if film.aov_channels else film.replicates)
        if self.shares.size:
            # The cell with the most samples must fit into the film.
            room = int((room - film.replicates) / max(float(self.shares.max()), 1.0))
        return min(self.spp or room, room)

    def _counts_at(self, film: Film, spp: int) -> np.ndarray:
        if not self.adaptive:
            return np.full(film.cells.shape, spp, np.int64)
        return counts_at(self.shares, spp, film.replicates)

    def _verdict(self, film: Film, most: int) -> Verdict | None:
        if self.promise is None:
            return Verdict("done")
        judgement = judge(film, self.promise)
        if not judgement.met and self.now < most:
            return None
        return self._say(film, judgement)

    def _say(self, film: Film, judgement: Judgement) -> Verdict:
        assert self.promise is not None
        word = word_of(judgement)
        figures = {
            "promise": self.promise.state(),
            **{k: _number(v) for k, v in judgement._asdict().items()},
        }
        return Verdict(word, line_of(word, judgement, self.promise, film.spp), figures)

    def cut_short(self, rounds: Sequence[Film], word: str) -> Verdict:
        """Say what has been reached when the time is over; inside a look nothing can be met."""
        film = rounds[0]
        if self.promise is None or word != "time" or not film.sample_count.all():
            return Verdict(word)
        judgement = judge(film, self.promise)
        if not judgement.met:
            return self._say(film, judgement)
        # Only looks that were planned may say so: their places know nothing of the film.
        early = judgement._replace(met=False, factor=self.now / film.spp)
        line = early_line(early, self.promise, self.now)
        return replace(self._say(film, early), word="not met", line=line)

    def biases(self, rounds: Sequence[Film]) -> tuple[Bias, ...]:
        """An error that ends the render makes the number of samples depend on them, a little."""
        return () if self.promise is None else (Bias("stopped at an error", _STOPPED),)

    def after(self, film: Film) -> Steered:
        """Leave out the looks at which a film had less than this one; they were in vain.

        Raises
        ------
        OptionError
            If the film holds more than is allowed.
        """
        if not film.sample_count.any() or (self.adaptive and not self.shares.size):
            return self
        window = cells_of(*film.crop)
        held = np.array([[cell.count for cell in row] for row in film.cells[window]], np.int64)
        self.now, most = first_look(film.replicates), self._most(film)
        while (self._counts_at(film, min(self.now, most))[window] < held).any():
            if self.now >= most:
                raise OptionError(f"{most} is less than the render holds already", "max_spp")
            self.now = next_look(self.now, film.replicates)
        self.now = min(self.now, most)
        return self

    def extended(self, spp: int) -> Steered:
        """Go on to more samples, by the same pilot."""
        longer = Steered(self.first, spp, None, self.adaptive)
        longer.shares = self.shares
        return longer

    @property
    def promises(self) -> bool:
        """If an error is asked for."""
        return self.promise is not None

    @property
    def total_spp(self) -> float | None:
        """Known where no error ends the render."""
        return self.spp if self.promise is None else None

    def state(self) -> dict[str, Any]:
        """The fields."""
        return {
            "first": self.first,
            "spp": self.spp,
            "promise": self.promise.state() if self.promise else None,
            "adaptive": self.adaptive,
            "now": self.now,
            "asked": self.asked,
            "piloted": self.piloted,
            "shares": self.shares,
        }

    @classmethod
    def restored(cls, state: dict[str, Any]) -> Self:
        """From the fields."""
        promise = Promise(**state["promise"]) if state["promise"] else None
        self = cls(int(state["first"]), state["spp"], promise, bool(state["adaptive"]))
        self.now = int(state["now"])
        self.asked, self.piloted = bool(state["asked"]), bool(state["piloted"])
        self.shares = np.asarray(state["shares"], np.float64)
        return self


def check_replicates(film: Film) -> None:
    """Refuse to promise an error of too few replicates.

    Raises
    ------
    OptionError
    """
    if film.replicates < LEAST_FOR_INTERVAL:
        raise OptionError(
            f"an error can be promised from {LEAST_FOR_INTERVAL} replicates on, "
            f"got {film.replicates}", "replicates",
        )  # fmt: skip


def towards(schedule: Schedule, promise: Promise, film: Film, spp: int | None) -> Steered:
    """Make the schedule that continues from a film until a promise is kept.

    Parameters
    ----------
    schedule : Schedule
        Of the render so far.
    promise : Promise
    film : Film
        What there is; it may hold a part of a goal.
    spp : int or None
        Largest number of samples per pixel.

    Raises
    ------
    OptionError
        If that has no meaning for it.
    """
    if isinstance(schedule, Uniform):
        return Steered(schedule.first, spp, promise).after(film)
    if not isinstance(schedule, Steered):
        name = schedule.name
        raise OptionError(f"a render by the schedule {name} cannot continue to an error", "error")
    longer = Steered(schedule.first, spp, promise, schedule.adaptive)
    longer.shares = schedule.shares
    return longer.after(film)


def _number(value: Any) -> Any:
    """Plain JSON knows no NaN and no infinity."""
    return None if isinstance(value, float) and not math.isfinite(value) else value
