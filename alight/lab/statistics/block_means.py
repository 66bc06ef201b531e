"""Block means of pictures, and the test whether an arm's mean picture is the reference's.

The test is that of `alight.metrics.comparison`: Welch's t of each block over the seeds, mapped to
a z. Blocks are far larger than there, about 64 to a picture: over 16 seeds a small block that a few
fireflies visit is nowhere near normal, and would be called biased for it. Where even these are
skewed, as under a small sun that only chance finds, they are joined to larger ones: a block that
no seed's firefly hit has a mean that is too dark and knows nothing of the spread it should have.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from alight.core.constants import LUMINANCE
from alight.lab.results import BIASED, DIFFERENT, UNBIASED, BiasTest
from alight.lab.statistics.decomposition import Moments
from alight.lab.statistics.intervals import holm_adjusted, quantile
from alight.metrics.comparison import PictureStatistics, compare_pictures
from alight.metrics.estimate import Estimate
from alight.metrics.statistics import sum_of_squares_tails, welch

#: Blocks of a picture, about.
_BLOCKS = 64

#: Family level at which an arm is called biased, over all arms of a scene.
LEVEL = 0.01

#: Largest skewness of a block's mean over the seeds: above, four blocks become one. Noise of rare
#: spikes, one to 1000 in a block, is then called biased in 1 to 3 % of the cases at the level of
#: 1 % (without: up to 100 %), and noise that is nearly normal keeps its 64 blocks.
_LARGEST_SKEWNESS = 0.2

#: Seeds that represent an exactly known variance.
_MANY = 1e6


@dataclass
class BlockMoments:
    """Statistics of block luminances and channel means over pictures, one picture at a time.

    Attributes
    ----------
    block : int
        Pixels on the side.
    blocks, channels : Moments
    """

    block: int
    blocks: Moments
    channels: Moments

    @classmethod
    def of(cls, rows: Iterable[np.ndarray], size: tuple[int, int]) -> BlockMoments:
        """From what `block_row` gave for each picture."""
        block = block_size(size)
        moments = cls(block, Moments(), Moments())
        for row in rows:
            moments.channels.add(row[:3])
            moments.blocks.add(row[3:].reshape(size[1] // block, size[0] // block))
        return moments

    @classmethod
    def calm(cls, rows: Iterable[np.ndarray], size: tuple[int, int]) -> BlockMoments:
        """The same with blocks joined, two by two, until their means are nearly normal."""
        kept = list(rows)
        moments = cls.of(kept, size)
        luminances = np.stack([row[3:].reshape(moments.blocks.mean.shape) for row in kept])
        factor = 1
        while min(moments.blocks.mean.shape) > 1 and abs(_skewness(luminances)) > _LARGEST_SKEWNESS:
            luminances = _joined(luminances, 2)
            factor *= 2
            moments.blocks = Moments()
            for one in luminances:
                moments.blocks.add(one)
        moments.block *= factor
        return moments

    @property
    def statistics(self) -> PictureStatistics:
        """The same for `compare_pictures`."""
        return PictureStatistics(
            self.blocks.count, self.block, self.blocks.mean, self.blocks.variance,
            self.channels.mean, self.channels.variance, np.zeros((0, 0, 3), np.float32),
        )  # fmt: skip


def _joined(blocks: np.ndarray, factor: int) -> np.ndarray:
    """Means of `factor` times `factor` neighbours; shape (..., h, w)."""
    *rest, height, width = blocks.shape
    rows, columns = height // factor, width // factor
    # What is left over at the right and lower edge belongs to no block, as in `block_row`.
    inner = blocks[..., : rows * factor, : columns * factor]
    return inner.reshape(*rest, rows, factor, columns, factor).mean(axis=(-3, -1))


def _skewness(blocks: np.ndarray) -> float:
    """Skewness of the blocks' means over the seeds; blocks of shape (S, h, w), S >= 3.

    Pooled over the blocks: those that a rare event visited speak for those that it did not, and
    each has the scale of its own noise.
    """
    count = len(blocks)
    if count < 3:
        return 0.0
    around = blocks - blocks.mean(axis=0)
    scale = float((((around**2).sum(axis=0) / (count - 1)) ** 1.5).mean())
    third = float((around**3).sum(axis=0).mean()) * count / ((count - 1) * (count - 2))
    return third / scale / math.sqrt(count) if scale > 0.0 else 0.0


def joined_statistics(statistics: PictureStatistics, block: int) -> PictureStatistics:
    """The same over larger blocks, whose parts are taken as independent.

    Parameters
    ----------
    statistics : PictureStatistics
    block : int
        A multiple of its own.
    """
    factor = block // statistics.block
    if factor == 1:
        return statistics
    return replace(
        statistics,
        block=block,
        block_mean=_joined(statistics.block_mean, factor),
        block_variance=_joined(statistics.block_variance, factor) / factor**2,
    )


def block_size(size: tuple[int, int]) -> int:
    """Pixels on the side of a block: 2 at least, the whole picture at most."""
    width, height = size
    wanted = max(2, round(math.sqrt(width * height / _BLOCKS)))
    return max(1, min(wanted, width, height))


def block_row(picture: np.ndarray) -> np.ndarray:
    """Channel means (3), then the block luminances of a picture, as float64."""
    height, width = picture.shape[:2]
    block = block_size((width, height))
    rows, columns = height // block, width // block
    # What is left over at the right and lower edge belongs to no block.
    inner = picture[: rows * block, : columns * block].astype(np.float64)
    sums = inner.reshape(rows, block, columns, block, 3).mean(axis=(1, 3))
    channels = picture.mean(axis=(0, 1), dtype=np.float64)
    return np.concatenate([channels, (sums @ LUMINANCE).ravel()])


def exact_statistics(picture: np.ndarray, variance: np.ndarray | None) -> PictureStatistics:
    """Statistics of a picture whose pixels' variance is known (or 0)."""
    height, width = picture.shape[:2]
    block = block_size((width, height))
    row = block_row(picture)
    noise = np.zeros_like(picture) if variance is None else variance
    # Channels of a pixel share their paths: their errors add up as they are, not as squares.
    luminance = (np.sqrt(np.maximum(noise, 0.0)) @ LUMINANCE) ** 2
    shape = (height // block, width // block)
    inner = luminance[: shape[0] * block, : shape[1] * block]
    sums = inner.reshape(shape[0], block, shape[1], block).sum(axis=(1, 3)) / block**4
    channels = noise.sum(axis=(0, 1), dtype=np.float64) / (height * width) ** 2
    return PictureStatistics(
        _MANY, block, row[3:].reshape(shape), sums * _MANY, row[:3], channels * _MANY,
        np.zeros((0, 0, 3), np.float32),
    )  # fmt: skip


@dataclass(frozen=True)
class RawTest:
    """What one arm's comparison says before it is corrected over the arms."""

    test: BiasTest
    p_value: float


def compare_with_reference(arm: PictureStatistics, reference: PictureStatistics) -> RawTest:
    """Block t-tests of an arm against the reference, and one p-value for all of them.

    The p-value is the smallest of six (root mean square and largest of the blocks' z, three
    channel means, mean luminance), times six (Bonferroni). The smaller blocks of either side are
    joined.
    """
    block = max(arm.block, reference.block)
    sides = joined_statistics(arm, block), joined_statistics(reference, block)
    found = compare_pictures(*sides)
    judged = found.z[np.isfinite(found.z)]
    blocks = len(judged)
    # Blocks that agree too well are no bias.
    p_values = found.p_values | {"rms(z)": sum_of_squares_tails(judged)[1]}
    p = min(1.0, len(p_values) * min(p_values.values()))
    test = BiasTest(
        found.block, blocks, found.rms, max(found.rms_low, 0.0), found.rms_high, found.largest,
        _relative_differences(arm, reference), p, UNBIASED,
    )  # fmt: skip
    return RawTest(test, p)


def _relative_differences(arm: PictureStatistics, ref: PictureStatistics) -> list[Estimate]:
    result = []
    for i in range(3):
        a, b = float(arm.channel_mean[i]), float(ref.channel_mean[i])
        variance = arm.channel_variance[i] / arm.count + ref.channel_variance[i] / ref.count
        _, dof = welch(
            arm.channel_mean[i], arm.channel_variance[i], arm.count,
            ref.channel_mean[i], ref.channel_variance[i], ref.count,
        )  # fmt: skip
        if b == 0.0:
            result.append(Estimate(math.nan, math.nan, math.nan))
            continue
        width = quantile(float(dof)) * math.sqrt(float(variance)) / abs(b)
        result.append(Estimate(a / b - 1.0, a / b - 1.0 - width, a / b - 1.0 + width))
    return result


def judge(raw: list[RawTest], declared: list[bool], level: float = LEVEL) -> list[BiasTest]:
    """Correct the p-values over the arms of a scene (Holm) and say what each arm is."""
    result = []
    adjusted = holm_adjusted([one.p_value for one in raw])
    for one, p, different in zip(raw, adjusted, declared, strict=True):
        verdict = BIASED if p < level else UNBIASED
        if different and p < level:
            verdict = DIFFERENT
        values = {**vars(one.test), "p_value": p, "verdict": verdict}
        result.append(BiasTest(**values))
    return result
