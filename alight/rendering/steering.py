"""The schedules that steer: until an error is reached, and to where samples are worth most."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, ClassVar, Self

import numpy as np

from alight.core.errors import OptionError
from alight.films import Film
from alight.films.fixed_point import MAX_SAMPLES
from alight.rendering.adaptive import (
    CYCLES_FIRST,
    CYCLES_STEP,
    PILOT_SPP,
    counts_at,
    cycles_active,
    shares_of,
)
from alight.rendering.schedule import Goal, Schedule, Verdict
from alight.rendering.stopping import Promise, first_look, judge, line_of, next_look, word_of


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
        self.look, self.now, self.shares = -1, 0, np.zeros(0)

    def next(self, rounds: Sequence[Film]) -> Goal | Verdict:
        """First the pilot, then look after look."""
        film = rounds[0]
        if self.adaptive and not self.shares.size:
            if len(rounds) == 1:
                pilot = film.replicates * max(math.ceil(PILOT_SPP / film.replicates), 2)
                return Goal.uniform(film, self.first, pilot, round=1)
            self.shares = shares_of(rounds[1])
        most = self._most(film)
        if self.look >= 0:
            verdict = self._verdict(film, most)
            if verdict is not None:
                return verdict
        self.look += 1
        if self.promise is None:
            self.now = most
        elif self.look == 0:
            self.now = min(first_look(film.replicates), most)
        else:
            self.now = min(next_look(self.now, film.replicates), most)
        return self._goal(film)

    def _most(self, film: Film) -> int:
        room = MAX_SAMPLES * (1 if film.aov_sums else film.replicates)
        if self.shares.size:
            # The cell with the most samples must fit into the film.
            room = int((room - film.replicates) / max(float(self.shares.max()), 1.0))
        return min(self.spp or room, room)

    def _goal(self, film: Film) -> Goal:
        if not self.adaptive:
            return Goal.uniform(film, self.first, self.now)
        counts = counts_at(self.shares, self.now, film.replicates)
        return Goal(np.full(counts.shape, self.first, np.int64), counts)

    def _verdict(self, film: Film, most: int) -> Verdict | None:
        if self.promise is None:
            return Verdict("done")
        judgement = judge(film, self.promise, self.look)
        if not judgement.met and self.now < most:
            return None
        return self._say(film, word_of(judgement))

    def _say(self, film: Film, word: str) -> Verdict:
        assert self.promise is not None
        judgement = judge(film, self.promise, self.look)
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
        self.look = max(self.look, 0) + 1
        return self._say(film, word_of(judge(film, self.promise, self.look)))

    def extended(self, spp: int) -> Steered:
        """Go on to more samples, by the same pilot."""
        longer = Steered(self.first, spp, None, self.adaptive)
        longer.shares = self.shares
        return longer

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
            "look": self.look,
            "now": self.now,
            "shares": self.shares,
        }

    @classmethod
    def restored(cls, state: dict[str, Any]) -> Self:
        """From the fields."""
        promise = Promise(**state["promise"]) if state["promise"] else None
        self = cls(int(state["first"]), state["spp"], promise, bool(state["adaptive"]))
        self.look, self.now = int(state["look"]), int(state["now"])
        self.shares = np.asarray(state["shares"], np.float64)
        return self


class Cycles(Schedule):
    """The adaptive rule of Blender's Cycles, to be compared with: its pictures are biased.

    Parameters
    ----------
    first, spp : int
        First sample, and the largest number of them per pixel.
    threshold : float
        Of its error: see `alight.rendering.adaptive.cycles_active`.
    """

    name: ClassVar[str] = "cycles"

    def __init__(self, first: int, spp: int, threshold: float) -> None:
        if not threshold > 0.0:
            raise OptionError(f"the threshold of cycles must be > 0, got {threshold:.6g}")
        self.first, self.spp, self.threshold = first, spp, threshold
        self.counts = np.zeros((0, 0), np.int64)

    def next(self, rounds: Sequence[Film]) -> Goal | Verdict:
        """Go on with the cells that are active."""
        film = rounds[0]
        if not self.counts.size:
            self.counts = np.full(film.cells.shape, min(CYCLES_FIRST, self.spp), np.int64)
        else:
            going = cycles_active(film, self.threshold) & (self.counts == self.counts.max())
            if not going.any() or self.counts.max() >= self.spp:
                line = f"stopped by Cycles' rule (threshold {self.threshold:g}), which is biased"
                return Verdict("done", line)
            more = min(CYCLES_STEP, self.spp - int(self.counts.max()))
            self.counts = self.counts + np.where(going, more, 0)
        return Goal(np.full(self.counts.shape, self.first, np.int64), self.counts)

    @property
    def total_spp(self) -> float | None:
        """At most."""
        return self.spp

    def state(self) -> dict[str, Any]:
        """The fields."""
        return {
            "first": self.first, "spp": self.spp, "threshold": self.threshold,
            "counts": self.counts,
        }  # fmt: skip

    @classmethod
    def restored(cls, state: dict[str, Any]) -> Self:
        """From the fields."""
        self = cls(int(state["first"]), int(state["spp"]), float(state["threshold"]))
        self.counts = np.asarray(state["counts"], np.int64)
        return self


def _number(value: Any) -> Any:
    """Plain JSON knows no NaN and no infinity."""
    return None if isinstance(value, float) and not math.isfinite(value) else value
