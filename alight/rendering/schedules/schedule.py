"""What to render next: the protocol between the main loop and the rules that stop or steer it.

The loop asks a schedule for a `Goal`: which samples every 8x8 cell shall hold before it is asked
again. How a goal is cut into passes depends on the clock; what a schedule decides may depend only
on what it is given: its own state, and films that hold whole goals. So a render that was stopped,
saved and resumed makes the same decisions and ends with the same bits.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Self

import numpy as np

from alight.core.errors import OptionError
from alight.films import Film
from alight.films.fixed_point import MAX_SAMPLES
from alight.films.ledger import Bias


@dataclass(frozen=True)
class Goal:
    """Samples that a film shall hold before the schedule is asked again.

    Attributes
    ----------
    first, count : ndarray of int64, shape (cells_y, cells_x)
        Of each 8x8 cell of the full film: samples first to first + count - 1. Those that the film
        holds already are not rendered again.
    round : int
        Index of the film; a new one is made when it is first used.
    """

    first: np.ndarray
    count: np.ndarray
    round: int = 0

    @classmethod
    def uniform(cls, film: Film, first: int, count: int, round: int = 0) -> Goal:
        """The same samples in every cell."""
        shape = film.cells.shape
        return cls(np.full(shape, first, np.int64), np.full(shape, count, np.int64), round)


@dataclass(frozen=True)
class Verdict:
    """How a render ended.

    Attributes
    ----------
    word : str
        "done", "time", "cancelled", or a rule's own: "met", "not met", "not certifiable".
    line : str
        One line for people; empty where there is nothing to say.
    figures : dict
        For ``--stats``: plain JSON.
    """

    word: str
    line: str = ""
    figures: dict[str, Any] = field(default_factory=dict)


class Schedule(ABC):
    """Decides what is rendered, and when it is enough."""

    #: In checkpoints; `alight.rendering.schedules.selection` finds the class by it.
    name: ClassVar[str]

    @abstractmethod
    def next(self, rounds: Sequence[Film]) -> Goal | Verdict:
        """Give the next goal, or the end.

        Parameters
        ----------
        rounds : sequence of Film
            At least one; earlier goals are in them, whole.
        """

    def cut_short(self, rounds: Sequence[Film], word: str) -> Verdict:
        """Say how the render ended when "time" or "cancelled" ended it, perhaps inside a goal."""
        return Verdict(word)

    def picture(self, rounds: Sequence[Film]) -> Film:
        """Give the film that is shown and returned."""
        return rounds[0]

    def biases(self, rounds: Sequence[Film]) -> tuple[Bias, ...]:
        """What of the picture is biased by the schedule's decisions."""
        return ()

    def extended(self, spp: int) -> Schedule:
        """Make the schedule that continues to `spp` samples per pixel in all.

        Raises
        ------
        OptionError
            If that has no meaning for it.
        """
        raise OptionError(f"a render by the schedule {self.name} has no fixed number", "spp")

    @property
    def promises(self) -> bool:
        """Whether it ends at an error that is promised."""
        return False

    @property
    def total_spp(self) -> float | None:
        """Samples per pixel at the end, as far as they are known: for the progress bar."""
        return None

    @abstractmethod
    def state(self) -> dict[str, Any]:
        """Copy everything that decisions depend on: plain JSON and, at the top level, arrays."""

    @classmethod
    @abstractmethod
    def restored(cls, state: dict[str, Any]) -> Self:
        """Make the schedule that `state` describes."""


@dataclass
class Uniform(Schedule):
    """The same number of samples for every pixel; without a number, until something else ends it.

    Parameters
    ----------
    first : int
        Index of the first sample.
    spp : int or None
        Samples per pixel.
    asked : bool
        Whether the goal has been given out.
    """

    first: int
    spp: int | None
    asked: bool = False
    name: ClassVar[str] = "uniform"

    def next(self, rounds: Sequence[Film]) -> Goal | Verdict:
        """All samples at once, then the end."""
        if self.asked:
            return Verdict("done")
        self.asked = True
        # What the film has room for.
        most = MAX_SAMPLES * (1 if rounds[0].aov_channels else rounds[0].replicates)
        return Goal.uniform(rounds[0], self.first, self.spp or most)

    def extended(self, spp: int) -> Uniform:
        """More or fewer samples from the same first one on."""
        return Uniform(self.first, spp)

    @property
    def total_spp(self) -> float | None:
        """What was asked for."""
        return self.spp

    def state(self) -> dict[str, Any]:
        """The fields."""
        return {"first": self.first, "spp": self.spp, "asked": self.asked}

    @classmethod
    def restored(cls, state: dict[str, Any]) -> Self:
        """From the fields."""
        return cls(int(state["first"]), state["spp"], bool(state["asked"]))
