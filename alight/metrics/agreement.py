"""Are two pictures the same within their noise? The test for pictures that carry their errors.

A picture of a film comes with a standard error for every pixel and channel, from R replicates:
R - 1 degrees of freedom each. A pixel's own error is far too uncertain to judge by, so pixels are
pooled to blocks, large enough for sums that are nearly normal, and Student's t of the difference of
two blocks is mapped to a z (`alight.metrics.block_sums` says how skewed noise is dealt with).

Seven hypotheses share one family level by Holm's test: the means of the three channels, the largest
abs(z) of all blocks and channels, and the root mean square of z of each channel.

Where the test fails by the pictures' own errors alone, but not if one picture has the noise that
the other foretells, nothing can be said: either bright samples were missed, or the pictures were
made in different ways and are different. An rms below 1 - 3 / sqrt(2 B) is no difference but
worth a remark: skewed noise of few samples (measured on glass: 0.93 to 0.97), overstated errors, or
random numbers that both pictures share. Channels are judged each on its own: how their errors go
together is not in a file.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from alight.metrics.block_sums import LARGEST_SKEWNESS, BlockSums, Measured
from alight.metrics.statistics import holm, sum_of_squares_tails

#: Most blocks.
_MOST_BLOCKS = 1024

#: Degrees of freedom that the errors of a block must have at least, if its pixels are alike. With
#: fewer, noise that differs by e between the pixels gives far too large z (measured: 6 with 16).
_FREEDOM_WANTED = 48


@dataclass(frozen=True)
class Agreement:
    """Result of `compare_measured`.

    Attributes
    ----------
    z : ndarray of float64, shape (rows, columns, 3)
        NaN in blocks of unknown error, and where nothing varies and both sides agree.
    block : int
        Width and height of a block in pixels.
    rms : tuple of 3 float
        Root mean square of z for each channel.
    largest : float
        The largest abs(z).
    mean_a, mean_b : tuple of 3 float
        Means of the channels over the pixels of known error.
    level : float
        Probability that equal pictures fail any of the tests.
    p_values : dict of str to float
        Of the channel means, of the largest abs(z) (times the number of blocks and channels), and
        of the channels' rms; of the means alone where the whole picture is one block.
    reasons : list of str
        What failed, in words; empty if all passed.
    doubts : list of str
        What fails by the pictures' own errors, and not by what each says about the other's.
    remarks : list of str
        What is odd but no difference.
    """

    z: np.ndarray
    block: int
    rms: tuple[float, ...]
    largest: float
    mean_a: tuple[float, ...]
    mean_b: tuple[float, ...]
    level: float
    p_values: dict[str, float]
    reasons: list[str]
    doubts: list[str]
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
        Of one shape (h, w, 3); at least one with standard errors.
    block : int, optional
        By default the smallest power of two that the number of replicates allows, that leaves at
        most 1 024 blocks, and whose differences are hardly skewed.
    level : float, default 0.01
        Probability that equal pictures fail any of the tests.

    Raises
    ------
    ValueError
        If the shapes differ, no error is known, or nothing varies.
    """
    if a.mean.shape != b.mean.shape:
        raise ValueError(f"pictures must have one shape, got {a.mean.shape} and {b.mean.shape}")
    sums = _blocks_of(a, b) if block is None else BlockSums.of(a, b, block)
    whole = sums.whole
    z = sums.z()
    judged = np.isfinite(z)
    if not judged.any():
        raise ValueError("no block has a known error above 0: there is nothing to judge")
    tests = _p_values(z, whole.z())
    own = sums.z(own=True)
    reasons = _failed(tests, level)
    doubts = [] if reasons else _failed(_p_values(own, whole.z(own=True)), level)
    low = 1.0 - 3.0 / math.sqrt(2.0 * int(judged.any(axis=2).sum()))
    remarks = [
        f"rms(z) of {c} is {x:.3f}, below {low:.3f}"
        for c, x in zip("RGB", _rms(own), strict=True)
        if x < low
    ]
    mean_a, mean_b = _means(a, b)
    return Agreement(
        z, sums.block, _rms(z), float(np.abs(z[judged]).max()), mean_a, mean_b, level, tests,
        reasons, doubts, remarks,
    )  # fmt: skip


def _blocks_of(a: Measured, b: Measured) -> BlockSums:
    """Blocks of the size that the pictures' replicates and noise ask for."""
    freedom = min((s.replicates - 1 for s in (a, b) if s.error is not None), default=1)
    size = next((n for n in (1, 2, 4) if n * n * freedom >= _FREEDOM_WANTED), 8)
    sums = BlockSums.of(a, b, size)
    while max(sums.count) > 1 and (
        math.prod(sums.count) > _MOST_BLOCKS or sums.skewness > LARGEST_SKEWNESS
    ):
        sums = sums.joined()
    return sums


def _p_values(z: np.ndarray, whole: np.ndarray) -> dict[str, float]:
    """Tail probabilities of the whole picture's z, and of those of its blocks."""
    tests = {f"mean {c}": _tail(v) for c, v in zip("RGB", whole[0, 0], strict=True)}
    judged = np.isfinite(z)
    if z.shape[:2] == (1, 1):
        return tests
    # Bonferroni over the blocks first, so that the channel means keep their power.
    largest = _tail(float(np.abs(z[judged]).max()))
    tests["largest |z|"] = min(1.0, int(judged.sum()) * largest)
    for i, c in enumerate("RGB"):
        if judged[..., i].any():
            tests[f"rms z {c}"] = sum_of_squares_tails(z[..., i][judged[..., i]])[1]
    return tests


def _failed(tests: dict[str, float], level: float) -> list[str]:
    rejected = holm(list(tests.values()), level)
    return [f"{name}: p {_shown(tests[name])}"
            for name, no in zip(tests, rejected, strict=True) if no]  # fmt: skip


def _tail(z: float) -> float:
    """Both tails; 1 where nothing is known."""
    return 1.0 if math.isnan(z) else math.erfc(abs(z) / math.sqrt(2.0))


def _shown(p: float) -> str:
    return "< 0.0001" if p < 1e-4 else f"= {p:.4f}"


def _rms(z: np.ndarray) -> tuple[float, ...]:
    """Of each channel; NaN where no block is judged."""
    kept = [plane[np.isfinite(plane)] for plane in np.moveaxis(z, 2, 0)]
    return tuple(math.sqrt(float(np.mean(v**2))) if v.size else math.nan for v in kept)


def _means(a: Measured, b: Measured) -> list[tuple[float, ...]]:
    """Means of the channels over the pixels of known error."""
    known = np.ones(a.mean.shape[:2], bool)
    for side in (a, b):
        if side.error is not None:
            known &= np.isfinite(side.error).all(axis=2)
    return [
        tuple(map(float, np.asarray(side.mean, np.float64)[known].mean(axis=0))) for side in (a, b)
    ]
