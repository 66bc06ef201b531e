r"""The error of an arm in a given time, from numbers of samples that its sampler is made for.

A sequence is worse, by 10 to 70 %, at 60 or 68 samples than at 64. So no arm is rendered with
whatever number fits a time. It is rendered with the two numbers around it that its sampler is made
for, and between these two the error is interpolated over time, both as logarithms:

.. math::
    \log E(T) = (1 - w) \log E_1 + w \log E_2, \qquad
    w = \frac{\log T - \log t_1}{\log t_2 - \log t_1}

with the slope s = (log E_2 - log E_1) / (log t_2 - log t_1). To first order, what is uncertain in
w and s has no effect but through the times: E(T) varies as the product of powers
E_1^(1 - w) E_2^w (t_1^(1 - w) t_2^w)^(-s) T^s.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from alight.core.spec import Sampler
from alight.lab.statistics.intervals import Statistic, log_mean
from alight.metrics import JUDGED

#: A number is not left for the next larger ones, at twice the cost, if it is this close.
_NEAR = 1.05

#: A time may lie beyond the two that were measured by this factor, and between the two must be
#: this one at least: there is nothing to interpolate over else.
_BEYOND, _GROWTH = 1.5, 1.1

#: Observations of the replicates, and the power to which their mean is taken.
Powers = list[tuple[np.ndarray, float]]


@dataclass(frozen=True)
class Bracket:
    """Where an arm takes a wanted time.

    Attributes
    ----------
    low, high : int
        Samples per pixel around it; equal where there is one number alone.
    shown : int
        The one of them that is nearer.
    """

    low: int
    high: int
    shown: int

    @classmethod
    def at(cls, spp: int) -> Bracket:
        """One number alone."""
        return cls(spp, spp, spp)


def natural_counts(sampler: Sampler, replicates: int) -> Iterator[int]:
    """Numbers of samples per pixel that a sampler is made for, from 1 up.

    Whole blocks of every replicate, doubled and doubled again. Below the first of these no number
    is better than another.

    Parameters
    ----------
    sampler : Sampler
    replicates : int
        R of the film: each has a sequence of its own.
    """
    whole, count = sampler.block * replicates, 1
    while count < whole:
        yield count
        count *= 2
    while True:
        yield whole
        whole *= 2


def powers_of_two(low: int, high: int) -> set[int]:
    """Those in [low, high]."""
    return {1 << k for k in range(high.bit_length()) if low <= 1 << k <= high}


def is_natural(spp: int, sampler: Sampler, replicates: int) -> bool:
    """Whether a sampler is made for a number of samples per pixel."""
    return next(n for n in natural_counts(sampler, replicates) if n >= spp) == spp


def bracket(wanted: float, sampler: Sampler, replicates: int) -> Bracket:
    """The numbers of samples around a wanted one.

    Parameters
    ----------
    wanted : float
        Samples per pixel, any positive number.
    sampler : Sampler
    replicates : int
        R of the film.

    Examples
    --------
    >>> from alight.samplers.sobol import Sobol
    >>> bracket(60.0, Sobol(), 4)
    Bracket(low=32, high=64, shown=64)
    """
    if wanted <= 1.0:
        return Bracket.at(1)
    for low, high in pairwise(natural_counts(sampler, replicates)):
        if wanted <= high * _NEAR:
            near = wanted * wanted > low * high
            return Bracket(low, high, high if near else low)
    raise AssertionError("the numbers never end")


@dataclass(frozen=True)
class AtTime:
    """An arm's errors in the time T.

    Attributes
    ----------
    figures : mapping of int to mapping of str to ndarray of float64, shape (S,)
        By spp, then by name: what the replicates measured.
    bracket : Bracket
    seconds : float
        T; of a single number of samples the time that it takes.
    """

    figures: Mapping[int, Mapping[str, np.ndarray]]
    bracket: Bracket
    seconds: float

    @classmethod
    def of(
        cls, figures: Mapping[int, Mapping[str, np.ndarray]], where: Bracket, seconds: float
    ) -> AtTime:
        """In a time, or at a single number of samples.

        An arm whose time hardly grows with its samples (it may end when it likes), or that takes
        quite another time than its pilot, has the nearer end as its single number.
        """
        low, high = (float(figures[n]["seconds"].mean()) for n in (where.low, where.high))
        grows = where.low != where.high and high >= _GROWTH * low
        if grows and low / _BEYOND <= seconds <= _BEYOND * high:
            return cls(figures, where, seconds)
        near, own = (where.low, low) if seconds < low else (where.high, high)
        return cls(figures, Bracket.at(near), own)

    @property
    def is_single(self) -> bool:
        """Whether there is one number of samples, and nothing between."""
        return self.bracket.low == self.bracket.high

    @property
    def spp(self) -> int:
        """Samples per pixel that take the time, about."""
        low, high = (math.log(n) for n in self._ends)
        return max(1, round(math.exp(low + self.weight * (high - low))))

    @property
    def weight(self) -> float:
        """w: how far T lies from the lower number to the higher one."""
        if self.is_single:
            return 0.0
        low, high = (math.log(self._mean(n, "seconds")) for n in self._ends)
        return (math.log(self.seconds) - low) / (high - low)

    @property
    def slope(self) -> float:
        """s, of the MSE; -1 at a single number: there the product of error and time counts."""
        if self.is_single:
            return -1.0
        errors = [math.log(self._mean(n, JUDGED)) for n in self._ends]
        times = [math.log(self._mean(n, "seconds")) for n in self._ends]
        return (errors[1] - errors[0]) / (times[1] - times[0])

    @property
    def _ends(self) -> tuple[int, int]:
        return self.bracket.low, self.bracket.high

    def _mean(self, spp: int, name: str) -> float:
        return float(self.figures[spp][name].mean())

    def _between(self, name: str, power: float = 1.0) -> Powers:
        """Geometric interpolation of a figure."""
        if self.is_single:
            return [(self.figures[self.bracket.low][name], power)]
        w = self.weight
        shares = zip(self._ends, (1.0 - w, w), strict=True)
        return [(self.figures[n][name], power * share) for n, share in shares]

    def statistic(self, name: str) -> Statistic:
        """Logarithm of a figure in the time T, as if T took no measuring.

        Raises
        ------
        ValueError
            If a mean, with or without any one replicate, is not positive.
        """
        return product(self._between(name))

    def linear(self, name: str) -> np.ndarray:
        """The replicates' figures in the time T, interpolated as they are; shape (S,)."""
        low, high = (self.figures[n][name] for n in self._ends)
        return (1.0 - self.weight) * low + self.weight * high

    @property
    def powers(self) -> Powers:
        """E(T) but for the power of T, with the times at which it was measured."""
        return self._between(JUDGED) + self._between("seconds", -self.slope)

    @property
    def sensitivity(self) -> float:
        """Relative change of E(T) when all squared errors grow by 1."""
        return sum(power / float(values.mean()) for values, power in self._between(JUDGED))


def compared(base: AtTime, clock: np.ndarray, other: AtTime) -> tuple[Powers, Powers]:
    """Both sides of how many times less an arm's error is than the baseline's in the same time.

    Parameters
    ----------
    base, other : AtTime
    clock : ndarray, shape (S,)
        Times of the baseline's replicates whose mean is T.
    """
    # Either error depends on T: what is left is the difference of their slopes.
    own = base.slope if not base.is_single else 0.0
    errors = base.powers if not base.is_single else base._between(JUDGED)
    return [*errors, (clock, own - other.slope)], other.powers


def product(powers: Powers) -> Statistic:
    """Logarithm of a product of powers of means.

    Raises
    ------
    ValueError
        If a mean, with or without any one replicate, is not positive.
    """
    parts = [(log_mean(values), power) for values, power in powers]
    value = sum(power * part.value for part, power in parts)
    return Statistic(value, sum(power * part.pseudo for part, power in parts))
