"""Are two pictures the same within their noise? The test for pictures that carry their errors.

A picture of a film comes with a standard error for every pixel and channel, from R replicates:
R - 1 degrees of freedom each. A pixel's own error is far too uncertain to judge by, so pixels are
pooled: the mean of a block of n pixels has the variance V = sum of v_i / n^2, and by Welch and
Satterthwaite, in the form that is exact for one pixel and nearly unbiased for estimated v_i,

    nu = V^2 / sum (v_i^2 / n^4 / (R + 1)) - 2

degrees of freedom (Welch 1947, "The generalization of Student's problem when several different
population variances are involved", section 6). Student's t of the difference of two blocks is
mapped through its distribution to a z. The pictures agree if the rms of z over B blocks is at most
1 + 3 / sqrt(2 B), and the largest abs(z) and the channel means pass Holm's test. An rms below
1 - 3 / sqrt(2 B) is no difference but worth a remark: skewed noise of few samples (measured on
glass: 0.93 to 0.97), overstated errors, or random numbers that both pictures share. Channels are
judged each on its own: how their errors go together is not in a file.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from alight.metrics.statistics import holm, student_t_tail, t_to_z

#: Stored means are float32, and renderers add in different orders: relative rounding of a mean.
_ROUNDING = 1e-6

#: Blocks are as large as leaves this many, for nearly normal means.
_BLOCKS_WANTED = 1000

#: Degrees of freedom that the errors of a block must have at least, if its pixels are alike. With
#: fewer, noise that differs by e between the pixels gives far too large z (measured: 6 with 16).
_FREEDOM_WANTED = 48


@dataclass(frozen=True)
class Measured:
    """A picture with what is known of its error.

    Parameters
    ----------
    mean : ndarray, shape (h, w, 3)
        Finite.
    error : ndarray, shape (h, w, 3), optional
        Standard errors, NaN where unknown; by default the picture is exact.
    replicates : int, default 0
        R of the standard errors, at least 2 with `error`.
    """

    mean: np.ndarray
    error: np.ndarray | None = None
    replicates: int = 0


@dataclass(frozen=True)
class Agreement:
    """Result of `compare_measured`.

    Attributes
    ----------
    z : ndarray of float64, shape (h / block, w / block, 3)
        NaN in blocks of unknown error, and where nothing varies and both sides agree.
    block : int
        Width and height of a block in pixels.
    rms : tuple of 3 float
        Root mean square of z for each channel.
    rms_low, rms_high : float
        Where it lies if the pictures are the same; only the upper bound is a test.
    largest : float
        The largest abs(z).
    mean_a, mean_b : tuple of 3 float
        Means of the channels over the pixels of known error.
    p_values : dict of str to float
        Of the largest abs(z) (times the number of blocks and channels) and of the channel means.
    reasons : list of str
        What failed, in words; empty if all passed.
    remarks : list of str
        What is odd but no difference.
    """

    z: np.ndarray
    block: int
    rms: tuple[float, ...]
    rms_low: float
    rms_high: float
    largest: float
    mean_a: tuple[float, ...]
    mean_b: tuple[float, ...]
    p_values: dict[str, float]
    reasons: list[str]
    remarks: list[str]

    @property
    def passed(self) -> bool:
        """True if the two may be the same picture."""
        return not self.reasons


def compare_measured(
    a: Measured, b: Measured, *, block: int | None = None, level: float = 0.01
) -> Agreement:
    """Test whether two pictures are the same within their errors.

    Parameters
    ----------
    a, b : Measured
        Of one shape; at least one with standard errors.
    block : int, optional
        By default the largest of 8, 4, 2, 1 that leaves 1 000 blocks, but large enough for the
        number of replicates.
    level : float, default 0.01
        Probability that equal pictures fail one of Holm's tests.

    Raises
    ------
    ValueError
        If the shapes differ, no error is known, or nothing varies.
    """
    if a.mean.shape != b.mean.shape:
        raise ValueError(f"pictures must have one shape, got {a.mean.shape} and {b.mean.shape}")
    h, w, _ = a.mean.shape
    block = block or _block_size(h * w, [s.replicates for s in (a, b) if s.error is not None])
    t, dof = _block_t(a, b, block)
    judged = np.isfinite(t)
    z = np.full(t.shape, np.nan)
    z[judged] = t_to_z(t[judged], dof[judged])
    if not judged.any():
        raise ValueError("no block has a known error above 0: there is nothing to judge")
    blocks = int(judged.any(axis=2).sum())
    rms = tuple(_rms(z[..., c]) for c in range(3))
    largest = float(np.abs(z[judged]).max())
    p_values, mean_a, mean_b = _channel_means(a, b)
    # Bonferroni over the blocks first, so that the channel means keep their power.
    tail = math.erfc(largest / math.sqrt(2.0))
    tests = {"largest |z|": min(1.0, int(judged.sum()) * tail), **p_values}
    margin = 3.0 / math.sqrt(2.0 * blocks)
    low, high = 1.0 - margin, 1.0 + margin
    rejected = holm(list(tests.values()), level)
    named = list(zip("RGB", rms, strict=True))
    reasons = [f"rms(z) of {c} is {x:.3f}, above {high:.3f}" for c, x in named if x > high]
    reasons += [f"{name}: p {_shown(tests[name])}" for name, no in zip(tests, rejected, strict=True)
                if no]  # fmt: skip
    remarks = [f"rms(z) of {c} is {x:.3f}, below {low:.3f}" for c, x in named if x < low]
    return Agreement(z, block, rms, low, high, largest, mean_a, mean_b, tests, reasons, remarks)


def _shown(p: float) -> str:
    return "< 0.0001" if p < 1e-4 else f"= {p:.4f}"


def _rms(z: np.ndarray) -> float:
    judged = z[np.isfinite(z)]
    return math.sqrt(float(np.mean(judged**2))) if judged.size else math.nan


def _block_size(pixels: int, replicates: list[int]) -> int:
    freedom = min([r - 1 for r in replicates], default=1)
    allowed = [n for n in (8, 4, 2, 1) if n * n * freedom >= _FREEDOM_WANTED or n == 8]
    return next((n for n in allowed if pixels >= _BLOCKS_WANTED * n * n), allowed[-1])


def _block_t(a: Measured, b: Measured, block: int) -> tuple[np.ndarray, np.ndarray]:
    """Student's t and its degrees of freedom for every block and channel, NaN if not judged."""
    count = _sum_blocks(np.ones(a.mean.shape), block)
    difference = (_sum_blocks(a.mean, block) - _sum_blocks(b.mean, block)) / count
    variance = np.zeros_like(count)
    spread = np.zeros_like(count)
    for side in (a, b):
        if side.error is None:
            continue
        v = np.asarray(side.error, np.float64) ** 2
        variance += _sum_blocks(v, block) / count**2
        spread += _sum_blocks(v * v, block) / count**4 / (side.replicates + 1)
    size = _sum_blocks(np.abs(a.mean), block) + _sum_blocks(np.abs(b.mean), block)
    floor = (_ROUNDING * size / count) ** 2
    still = variance == 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        dof = np.where(still, np.inf, np.maximum(variance**2 / spread - 2.0, 1.0))
        t = difference / np.sqrt(variance + floor)
    t = np.where(floor + variance == 0.0, 0.0, t)
    return np.where(still & (np.abs(t) < 1.0), np.nan, t), dof


def _channel_means(
    a: Measured, b: Measured
) -> tuple[dict[str, float], tuple[float, ...], tuple[float, ...]]:
    """Tail probabilities of the differences of the channel means, and the means."""
    known = np.ones(a.mean.shape[:2], bool)
    for side in (a, b):
        if side.error is not None:
            known &= np.isfinite(side.error).all(axis=2)
    means = [np.asarray(side.mean, np.float64)[known].mean(axis=0) for side in (a, b)]
    p_values: dict[str, float] = {}
    variance, spread = np.zeros(3), np.zeros(3)
    for side in (a, b):
        if side.error is not None:
            v = np.asarray(side.error, np.float64)[known] ** 2
            variance += v.sum(axis=0) / len(v) ** 2
            spread += (v * v).sum(axis=0) / len(v) ** 4 / (side.replicates + 1)
    difference = means[0] - means[1]
    variance += (_ROUNDING * (np.abs(means[0]) + np.abs(means[1]))) ** 2
    for c, name in enumerate("RGB"):
        dof = max(variance[c] ** 2 / spread[c] - 2.0, 1.0) if spread[c] > 0.0 else math.inf
        t = difference[c] / math.sqrt(variance[c]) if variance[c] > 0.0 else 0.0
        p_values[f"mean {name}"] = float(student_t_tail(t, dof))
    return p_values, tuple(map(float, means[0])), tuple(map(float, means[1]))


def _sum_blocks(planes: np.ndarray, block: int) -> np.ndarray:
    """Sum over blocks of pixels; the last ones may be smaller."""
    h, w = planes.shape[:2]
    rows = np.add.reduceat(np.asarray(planes, np.float64), np.arange(0, h, block), axis=0)
    return np.add.reduceat(rows, np.arange(0, w, block), axis=1)
