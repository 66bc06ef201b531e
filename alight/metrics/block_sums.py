"""Sums over blocks of two pictures, and Student's t of their differences for noise of any kind.

Pixels are independent, so the difference D of two blocks has the variance V = sum of v_i, with v_i
the sum of both pixels' squared standard errors: each is an estimate from a few replicates, but
without bias. By Welch and Satterthwaite, in the form that is exact for one pixel and nearly
unbiased for estimated v_i,

    nu = V^2 / sum (v_i^2 / (R + 1)) - 2

degrees of freedom (Welch 1947, "The generalization of Student's problem when several different
population variances are involved", section 6). That is enough where the noise is nearly normal. In
pictures it often is not: a few bright samples carry it. A block that they have not met is too dark
*and* says that it knows itself well, and its t is far too large. Three things keep the level:

* **What the other picture knows.** If both were made in the same way, a sample of either has the
  same variance, and sums of n and m samples with the squared errors s^2 and t^2 have together
  s^2 n/m + t^2 m/n. The noisier picture then has at least the error that the finer one foretells,
  also where it has not met what is bright. Variance that falls faster than 1/n (quasi-Monte Carlo)
  only makes this smaller than V.
* **What the pixels know of each other.** If the pictures are the same, every difference d_i has the
  mean 0, so that the spread of the d_i inside a block is a second estimate of V, which does not
  come from replicates: two replicates that met one bright sample each are equal, and say that
  there is no noise. Sums divided by the root of their own squares have tails no heavier than
  normal for *every* symmetric noise (Efron 1969, "Student's t-test under symmetry conditions").
* **Blocks that are large enough.** The third cumulant of a mean over replicates is the covariance
  of the mean and of its squared standard error. So sum of d_i v_i has, for equal pictures, the
  expectation K of the third cumulant of D: no further planes are needed to know how skewed the
  sums are. Blocks are joined until K / sum V^(3/2) is small. Noise that is alike on both sides
  cancels in K, as it does in D: there blocks stay as they are.

V is replaced by the larger estimate only where that is larger than chance allows, so that normal
noise keeps its distribution.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from alight.metrics.statistics import t_to_z

#: Stored means are float32, and renderers add in different orders: relative rounding of a mean.
_ROUNDING = 1e-6

#: One estimate of a variance must exceed the other by this many standard deviations to count.
_BELIEVED = 4.0

#: Largest skewness of a block's difference: above, four blocks become one.
LARGEST_SKEWNESS = 0.2

#: Noise of two pictures is alike if the squared errors of most blocks differ by less than this.
_ALIKE = 2.0

#: What is summed over blocks, in this order.
_SUMMED = (
    "pixels", "size", "difference", "squares", "variance", "exchanged", "fourth", "spread",
)  # fmt: skip

#: Rows of pixels that are worked on at a time: float64 planes of a whole picture would be large.
_STRIP = 256


@dataclass(frozen=True)
class Measured:
    """A picture with what is known of its error.

    Parameters
    ----------
    mean : ndarray, shape (h, w, C)
        Finite.
    error : ndarray, shape (h, w, C), optional
        Standard errors, NaN where unknown; by default the picture is exact.
    replicates : int, default 0
        R of the standard errors, at least 2 with `error`.
    samples : ndarray, shape (h, w), or float, optional
        Samples per pixel; by default unknown.
    """

    mean: np.ndarray
    error: np.ndarray | None = None
    replicates: int = 0
    samples: np.ndarray | float | None = None


@dataclass(frozen=True)
class BlockSums:
    """Sums over blocks of the pixels whose error is known.

    Attributes
    ----------
    block : int
        Pixels on the side of a block; those at the right and lower edge may be smaller.
    pixels, size, difference, squares : ndarray of float64, shape (rows, columns, C)
        1, abs(a) + abs(b), a - b and its square.
    variance, exchanged : ndarray of float64, shape (rows, columns, C)
        Of the difference: by each picture's own errors, and by the other's (0 if unknown).
    fourth, spread : ndarray of float64, shape (rows, columns, C)
        v^2, and what each picture adds to it over its R + 1, for the degrees of freedom.
    third : ndarray of float64, shape (C,)
        Of the whole picture: abs(K) and one standard error of it; 0 where the noise of both
        pictures is alike.
    """

    block: int
    pixels: np.ndarray
    size: np.ndarray
    difference: np.ndarray
    squares: np.ndarray
    variance: np.ndarray
    exchanged: np.ndarray
    fourth: np.ndarray
    spread: np.ndarray
    third: np.ndarray

    @classmethod
    def of(cls, a: Measured, b: Measured, block: int) -> BlockSums:
        """Sum up two pictures of one shape, with standard errors of one at least."""
        rows = max(1, _STRIP // block) * block
        strips, sides, product, square = [], [], 0.0, 0.0
        for top in range(0, a.mean.shape[0], rows):
            planes, squares = _planes(a, b, slice(top, top + rows))
            sides.append([_sum_blocks(one, block) for one in squares])
            strips.append([_sum_blocks(plane, block) for plane in planes])
            third = planes[_SUMMED.index("difference")] * planes[_SUMMED.index("variance")]
            product, square = product + third.sum(axis=(0, 1)), square + (third**2).sum(axis=(0, 1))
        parts = (np.concatenate(part) for part in zip(*strips, strict=True))
        sums = dict(zip(_SUMMED, parts, strict=True))
        pixels, difference, variance = (
            sums[name].sum(axis=(0, 1)) for name in ("pixels", "difference", "variance")
        )
        # About the mean difference: noise that is the same everywhere has no third cumulant.
        centred = product - difference * variance / np.maximum(pixels, 1.0)
        third = np.abs(centred) + np.sqrt(square)
        alike = _alike(*(np.concatenate(side) for side in zip(*sides, strict=True)))
        return cls(block=block, **sums, third=np.where(alike, 0.0, third))

    def joined(self, factor: int = 2) -> BlockSums:
        """The same over blocks of `factor` times `factor` of these."""
        sums = {name: _sum_blocks(getattr(self, name), factor) for name in _SUMMED}
        return replace(self, block=self.block * factor, **sums)

    @property
    def whole(self) -> BlockSums:
        """The same with the whole picture as one block."""
        return self.joined(max(self.count))

    @property
    def count(self) -> tuple[int, int]:
        """Rows and columns of blocks."""
        return self.pixels.shape[0], self.pixels.shape[1]

    @property
    def skewness(self) -> float:
        """Skewness of the difference of a block, typical of this picture; largest channel."""
        scale = (self.variance**1.5).sum(axis=(0, 1))
        known = scale > 0.0
        return float((self.third[known] / scale[known]).max(initial=0.0))

    def z(self, *, own: bool = False) -> np.ndarray:
        """Give one z per block and channel, standard normal if the pictures are the same.

        Parameters
        ----------
        own : bool, default False
            Trust the pictures' own errors and nothing else.

        Returns
        -------
        ndarray of float64, shape (rows, columns, C)
            NaN in blocks of unknown error, and where nothing varies but by rounding.
        """
        floor = (_ROUNDING * self.size) ** 2
        variance = (self.variance if own else self._safe_variance()) + floor
        # Less noise than rounding has is none.
        still = self.variance <= floor
        with np.errstate(divide="ignore", invalid="ignore"):
            dof = np.where(still, np.inf, np.maximum(self.variance**2 / self.spread - 2.0, 1.0))
            t = self.difference / np.sqrt(variance)
        t = np.where(variance == 0.0, 0.0, t)
        judged = (self.pixels > 0.0) & ~(still & (np.abs(t) < 1.0))
        z = np.full(t.shape, np.nan)
        z[judged] = t_to_z(t[judged], dof[judged])
        return z

    def _safe_variance(self) -> np.ndarray:
        """The largest estimate of V, of those that are larger than chance allows."""
        n = np.maximum(self.pixels, 1.0)
        # Of one pixel there is no spread.
        among = (self.squares - self.difference**2 / n) * n / np.maximum(n - 1.0, 1.0)
        chance = self.variance + _BELIEVED * np.sqrt(2.0 * self.fourth)
        safe = np.where(among > chance, among, self.variance)
        least = (1.0 + _BELIEVED * np.sqrt(2.0 / n)) * self.variance
        return np.where(self.exchanged > least, np.maximum(safe, self.exchanged), safe)


def _alike(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Whether the squared errors of most blocks are alike on both sides, for each channel."""
    within = (a <= _ALIKE * b) & (b <= _ALIKE * a)
    varying = (a > 0.0) | (b > 0.0)
    return 2 * (within & varying).sum(axis=(0, 1)) > varying.sum(axis=(0, 1))


def _planes(a: Measured, b: Measured, rows: slice) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Give what is summed over blocks, for some rows: in the order of `_SUMMED`, and by side."""
    means = [np.asarray(side.mean[rows], np.float64) for side in (a, b)]
    squares = [
        np.zeros_like(means[0]) if side.error is None else np.asarray(side.error[rows], float) ** 2
        for side in (a, b)
    ]
    known = np.isfinite(squares[0] + squares[1]).all(axis=2, keepdims=True)
    pixels = np.broadcast_to(known, means[0].shape).astype(np.float64)
    squares = [np.where(known, one, 0.0) for one in squares]
    difference = np.where(known, means[0] - means[1], 0.0)
    variance = squares[0] + squares[1]
    exchanged, spread = np.zeros_like(variance), np.zeros_like(variance)
    if a.samples is not None and b.samples is not None:
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.broadcast_to(np.asarray(_of_rows(a.samples, rows), np.float64)
                                    / _of_rows(b.samples, rows), means[0].shape[:2])  # fmt: skip
        ratio = np.where(np.isfinite(ratio) & (ratio > 0.0), ratio, 1.0)[..., None]
        exchanged = squares[0] * ratio + squares[1] / ratio
    for side, one in zip((a, b), squares, strict=True):
        if side.error is not None:
            spread += one * one / (side.replicates + 1)
    size = np.where(known, np.abs(means[0]) + np.abs(means[1]), 0.0)
    squared = difference**2
    planes = [pixels, size, difference, squared, variance, exchanged, variance**2, spread]
    return planes, squares


def _of_rows(samples: np.ndarray | float, rows: slice) -> np.ndarray | float:
    return samples[rows] if isinstance(samples, np.ndarray) else samples


def _sum_blocks(planes: np.ndarray, block: int) -> np.ndarray:
    """Sum over blocks of pixels; the last ones may be smaller."""
    h, w = planes.shape[:2]
    rows = np.add.reduceat(np.asarray(planes, np.float64), np.arange(0, h, block), axis=0)
    return np.add.reduceat(rows, np.arange(0, w, block), axis=1)
