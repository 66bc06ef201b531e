"""A picture's own error as a value with its interval: what `alight.metrics.own_error` finds."""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist
from typing import NamedTuple

from alight.metrics.estimate import Estimate
from alight.metrics.statistics import f_quantile

_NORMAL = NormalDist()

#: Replicates that an interval takes: two halves, each with a spread of its own.
LEAST_FOR_INTERVAL = 4

#: An error beyond this is reported as "more than".
LARGEST_TOLD = 10.0


class Figure(NamedTuple):
    """An estimated relMSE and how sure it is.

    Attributes
    ----------
    value : float
    freedom : float
        Were the brightness known, the true relMSE over `value` had the distribution
        F(freedom, (R - 1) freedom). NaN if unknown.
    replicates : int
    brightness : float, default 0
        Variance of log(relMSE) that comes from the brightness of noisy pixels.
    lowest : float, default 1
        What part of `value` is left if pixels of whose brightness there is no evidence are as
        bright as their brightest samples say.
    rise : float, default 0
        Variance of log(relMSE), upwards only, because noisy pixels may differ by more than their
        samples can tell, and be black where samples have both signs.
    """

    value: float
    freedom: float
    replicates: int
    brightness: float = 0.0
    lowest: float = 1.0
    rise: float = 0.0

    def quantile(self, p: float) -> float:
        """Find the relMSE below which the true one lies with probability p; NaN if unknown."""
        if math.isnan(self.value) or self.replicates < LEAST_FOR_INTERVAL:
            return math.nan
        if self.value == 0.0:
            return 0.0
        errors = f_quantile(p, self.freedom, (self.replicates - 1) * self.freedom)
        upper = p >= 0.5
        brightness = self.brightness + (self.rise if upper else 0.0)
        # All parts are independent; their logarithms add up as deviations do.
        doubt = math.hypot(
            math.log(max(errors, 1e-300)), _NORMAL.inv_cdf(p) * math.sqrt(brightness)
        )
        if upper:
            return self.value * math.exp(min(doubt, 600.0))
        return self.value * self.lowest * math.exp(-doubt)

    @property
    def deviation(self) -> float:
        """Standard deviation of log(relRMSE), by the quantiles that lie one from the middle."""
        if not self.value > 0.0:
            return 0.0
        low, high = (self.quantile(_NORMAL.cdf(z)) for z in (-1.0, 1.0))
        return 0.25 * math.log(high / max(low, 1e-300))

    def interval(self, confidence: float = 0.95) -> Estimate:
        """Give the value with its two-sided interval."""
        tail = 0.5 * (1.0 - confidence)
        return Estimate(self.value, self.quantile(tail), self.quantile(1.0 - tail))


@dataclass(frozen=True)
class ErrorEstimate:
    """A picture's own error, estimated without a reference.

    Attributes
    ----------
    figure, figure_literature : Figure
        relMSE with the exposure-free `epsilon`, and with epsilon = 0.01.
    epsilon : float
        (0.1 times the mean of the picture) squared.
    known : float
        Share of the pixels whose standard error is known; the others are left out.
    shares_paths : bool, default False
        Whether one path adds to several pixels: intervals may then hold less often than they say.
    """

    figure: Figure
    figure_literature: Figure
    epsilon: float
    known: float
    shares_paths: bool = False

    @property
    def promised(self) -> bool:
        """Whether there is an interval, and it holds as often as it says."""
        return not self.shares_paths and not math.isnan(self.relmse.high)

    @property
    def relmse(self) -> Estimate:
        """With the exposure-free `epsilon`, and its 95 % interval."""
        return self.figure.interval()

    @property
    def relmse_literature(self) -> Estimate:
        """With epsilon = 0.01, and its 95 % interval."""
        return self.figure_literature.interval()

    @property
    def relrmse(self) -> Estimate:
        """Square root of `relmse`."""
        return Estimate(*(math.sqrt(v) for v in self.relmse))

    @property
    def line(self) -> str:
        """How wrong the picture is, and what is promised of that."""
        relative = self.relrmse
        if math.isnan(relative.value):
            return "unknown (too few samples, or a black picture)"
        told = f"{relative.value:.2%} relRMSE"
        relmse = f"relMSE {self.relmse.value:.3g}"
        if math.isnan(relative.high):
            return (
                f"{told} or more (an interval takes {LEAST_FOR_INTERVAL} replicates, there are "
                f"{self.figure.replicates}), {relmse}"
            )
        high = relative.high
        between = f"{relative.low:.2%} to " + (
            f"{high:.2%}" if high <= LARGEST_TOLD else f"more than {100 * LARGEST_TOLD:.0f} %"
        )
        if self.shares_paths:
            return f"{told} ({between}, not promised: pixels share paths), {relmse}"
        return f"{told} (95 %: {between}), {relmse}"

    def relrmse_below(self, confidence: float) -> float:
        """Find the relRMSE that the true one does not exceed, with this confidence."""
        return math.sqrt(self.figure.quantile(confidence))
