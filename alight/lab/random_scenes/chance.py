"""A source of random choices that is named, so that one choice does not change another."""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from alight.core.field_types import Triple

T = TypeVar("T")


class Chance:
    """Random choices that are a pure function of its names.

    Parameters
    ----------
    *names : object
        Whatever tells it apart, for instance a seed; their texts count.

    Notes
    -----
    Everything is made from `random.Random.random`, whose sequence does not change between versions
    of Python.
    """

    def __init__(self, *names: object) -> None:
        self._names = names
        self._random = random.Random("/".join(map(str, names)))

    def named(self, name: object) -> Chance:
        """An independent source that depends on this one's names and on its own."""
        return Chance(*self._names, name)

    def number(self) -> float:
        """A number in [0, 1)."""
        return self._random.random()

    def happens(self, probability: float) -> bool:
        """Whether something of this probability is the case."""
        return self.number() < probability

    def within(self, low: float, high: float) -> float:
        """A number in [low, high], evenly, of four digits."""
        return _short(low + (high - low) * self.number(), low, high)

    def scaled(self, low: float, high: float) -> float:
        """A number in [low, high], 0 < low, evenly in its logarithm, of four digits."""
        return _short(low * (high / low) ** self.number(), low, high)

    def whole(self, low: int, high: int) -> int:
        """A whole number from low to high, both included."""
        return low + int((high - low + 1) * self.number())

    def choose(self, items: Sequence[T]) -> T:
        """One of some things, all alike."""
        return items[int(len(items) * self.number())]

    def among(self, items: Sequence[T], count: int) -> list[T]:
        """So many different ones of some things, in any order."""
        left = list(items)
        return [left.pop(int(len(left) * self.number())) for _ in range(min(count, len(left)))]

    def numbers(self, *shape: int) -> np.ndarray:
        """An array of numbers in [0, 1), of three digits."""
        count = int(np.prod(shape))
        return np.array([int(1000 * self.number()) / 1000 for _ in range(count)]).reshape(shape)

    def color(self, low: float = 0.0, high: float = 1.0) -> Triple:
        """A colour with its channels in [low, high]: grey, pale or strong."""
        saturation = self.choose((0.0, 0.3, 1.0))
        grey = self.number()
        red, green, blue = (
            _short(low + (high - low) * (grey + saturation * (self.number() - grey)), low, high)
            for _ in range(3)
        )
        return red, green, blue


def _short(value: float, low: float, high: float) -> float:
    return min(max(float(f"{value:.4g}"), low), high)
