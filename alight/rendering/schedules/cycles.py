r"""The adaptive rule of Blender's Cycles, for comparison: its pictures are biased.

With I the mean of a pixel's samples and A that of every second one, the pixel's error is

.. math:: \frac{|I_r - A_r| + |I_g - A_g| + |I_b - A_b|}{10^{-4} + s}, \qquad
    s = \begin{cases} \sqrt{I_r + I_g + I_b} & \text{below 1} \\
    I_r + I_g + I_b & \text{above} \end{cases}

and it is finished where that is below 5 times the noise threshold. A noisy pixel lets the eight
around it continue, too. Decisions come every 16 samples, the first after ceil(16 / threshold^0.3)
samples: 80 at the threshold 0.01.

All that is Cycles'. But Cycles decides for pixels, and here samples go to 8x8 cells: a cell
continues as long as one of its pixels does, and its finished pixels with it. Such a cell sees 64
times as much before it stops, so what is lost by stopping early is less than Cycles loses.

Source: Blender, intern/cycles: kernel/film/adaptive_sampling.h (error, and the filter in x and y),
integrator/adaptive_sampling.cpp (when), scene/integrator.cpp (threshold, first decision); the
error after Dammertz, Hanika, Keller and Lensch 2010, "A hierarchical automatic stopping condition
for Monte Carlo global illumination".
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, ClassVar, Self

import numpy as np

from alight.core.errors import OptionError
from alight.films import CELL_SIZE, Film
from alight.films.ledger import Bias
from alight.films.sample_ranges import cells_of
from alight.metrics.planes import box
from alight.rendering.schedules.adaptive import over_cells
from alight.rendering.schedules.schedule import Goal, Schedule, Verdict

#: Noise threshold by default, samples between two decisions, and the most samples by default.
THRESHOLD, STEP, MOST = 0.01, 16, 4096

#: Factor of the threshold, and the least number of samples before the first decision.
_SCALE, _LEAST = 5.0, 4


def first_decision(threshold: float) -> int:
    """Samples per pixel at the first decision."""
    least = max(_LEAST, math.ceil(16.0 / threshold**0.3))
    # The last of the samples has an index above `least` and is the last of its 16.
    return STEP * ((least + 1) // STEP + 1)


def cycles_error(means: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Error of each pixel, shape (h, w), from means (h, w, R, 3) and counts (h, w, R).

    Every second sample belongs to every second replicate, R being even.
    """
    half = slice(0, None, 2)
    whole, part = (
        (means[:, :, rows] * counts[:, :, rows, None]).sum(axis=2)
        / np.maximum(counts[:, :, rows].sum(axis=2), 1)[..., None]
        for rows in (slice(None), half)
    )
    brightness = np.maximum(whole.sum(axis=2), 0.0)
    scale = np.where(brightness < 1.0, np.sqrt(brightness), brightness)
    return np.abs(whole - part).sum(axis=2) / (1e-4 + scale)


def in_noise(error: np.ndarray, threshold: float, active: np.ndarray) -> np.ndarray:
    """Which pixels continue: noisy ones among those that were active, and the eight around each."""
    return box((active & (error >= _SCALE * threshold)).astype(np.float64)) > 0.0


class Cycles(Schedule):
    """Cycles' rule, cell by cell.

    Parameters
    ----------
    first, spp : int
        First sample, and the largest number of them per pixel.
    threshold : float
        Cycles' noise threshold.
    """

    name: ClassVar[str] = "cycles"

    def __init__(self, first: int, spp: int, threshold: float) -> None:
        if not threshold > 0.0:
            raise OptionError(f"the threshold of cycles must be > 0, got {threshold:.6g}")
        self.first, self.spp, self.threshold = first, spp, threshold
        self.now = 0
        self.counts, self.active = np.zeros((0, 0), np.int64), np.zeros((0, 0), bool)
        # Sums over each cell at the first decision, by replicate: what no decision has touched.
        self.before = np.zeros((0, 0, 0))

    def next(self, rounds: Sequence[Film]) -> Goal | Verdict:
        """Go on with the cells that are active."""
        film = rounds[0]
        if not self.counts.size:
            if film.replicates % 2:
                raise OptionError(
                    "the rule of cycles compares every second sample with all: it needs an even "
                    f"number of replicates, got {film.replicates}"
                )
            self.active = np.zeros(film.cells.shape, bool)
            self.active[cells_of(*film.crop)] = True
            self.counts = np.zeros(self.active.shape, np.int64)
            return self._goal(min(first_decision(self.threshold), self.spp))
        if self.now >= self.spp:
            return self._end(film)
        means, counts = film.replicate_means()
        if not self.before.size:
            self.before = _cell_means(film, means)
        self._decide(film, cycles_error(means, counts))
        if not self.active.any():
            return self._end(film)
        return self._goal(min(STEP, self.spp - self.now))

    def _goal(self, more: int) -> Goal:
        # Cells that start again do not catch up: as in Cycles, all pause and end together.
        self.now += more
        self.counts = self.counts + np.where(self.active, more, 0)
        return Goal(np.full(self.counts.shape, self.first, np.int64), self.counts)

    def _decide(self, film: Film, error: np.ndarray) -> None:
        x, y, w, h = film.crop
        rows, columns = np.arange(y, y + h) // CELL_SIZE, np.arange(x, x + w) // CELL_SIZE
        pixels = in_noise(error, self.threshold, self.active[rows][:, columns])
        self.active = np.zeros(self.active.shape, bool)
        self.active[cells_of(*film.crop)] = over_cells(film, pixels, np.maximum)

    def _end(self, film: Film) -> Verdict:
        rule = f"Cycles' rule (threshold {self.threshold:g})"
        if not self.before.size:
            first = first_decision(self.threshold)
            return Verdict("done", f"{rule} decides after {first} spp first; nothing was decided")
        stopped = float(np.mean(self.counts[cells_of(*film.crop)] < self.spp))
        return Verdict("done", f"{rule} stopped {100 * stopped:.3g} % of the cells early")

    def biases(self, rounds: Sequence[Film]) -> tuple[Bias, ...]:
        """The mean against that of the samples before the first decision, which has no bias."""
        if not self.before.size:
            return ()
        film = rounds[0]
        after = _cell_means(film, film.replicate_means()[0])
        change = after - self.before
        # Replicates and cells are independent of each other.
        variance = float(change.var(axis=2, ddof=1).sum()) * film.replicates
        pixels = film.replicates * film.crop[2] * film.crop[3]
        effect, error = float(change.sum()) / pixels, math.sqrt(variance) / pixels
        text = f"Cycles' rule decides by the samples that it keeps (threshold {self.threshold:g})"
        return (Bias("adaptive criterion", text, effect, error),)

    @property
    def total_spp(self) -> float | None:
        """At most."""
        return self.spp

    def state(self) -> dict[str, Any]:
        """The fields."""
        return {
            "first": self.first, "spp": self.spp, "threshold": self.threshold,
            "now": self.now, "counts": self.counts, "active": self.active.astype(np.int64),
            "before": self.before,
        }  # fmt: skip

    @classmethod
    def restored(cls, state: dict[str, Any]) -> Self:
        """From the fields."""
        self = cls(int(state["first"]), int(state["spp"]), float(state["threshold"]))
        self.now, self.counts = int(state["now"]), np.asarray(state["counts"], np.int64)
        self.active = np.asarray(state["active"], np.int64) > 0
        self.before = np.asarray(state["before"], np.float64)
        return self


def _cell_means(film: Film, means: np.ndarray) -> np.ndarray:
    """Sums over the pixels of each cell of the window, by replicate, float64."""
    return over_cells(film, means.mean(axis=3, dtype=np.float64), np.add)
