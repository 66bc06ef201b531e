"""Do two renderers make the same picture? A test over blocks of pixels and many seeds.

Per-pixel tests at a fixed number of sigmas are wrong for the skewed noise of path tracing. Here
each side is rendered with many seeds, 32 or more; the mean luminance of small blocks (2x2 pixels)
is nearly normal over them. Where it is not, because one side's noise is more skewed than the
other's, four blocks can become one until it is (`alight.metrics.block_sums`). Student's t of each
block is mapped through its own distribution to a z. Six hypotheses share one family level by
Holm's test: that

* the sum of z^2 is neither too large nor too small: neither bias nor misstated variance;
* the largest abs(z) is no larger than chance allows;
* the means of the three channels are the same, by the spread of whole pictures over the seeds;
* the mean luminance is the same, by the noise of all blocks: also for few seeds a sharp test.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from alight.metrics.block_sums import LARGEST_SKEWNESS, BlockSums, Measured
from alight.metrics.statistics import holm, student_t_tail, sum_of_squares_tails, welch

#: Degrees of freedom that the variance of a block must have at least where blocks may be joined:
#: with fewer, noise that differs between the sides gives far too large z.
_FREEDOM_WANTED = 7

#: Rounded as in the statistics of references that are already stored.
STORED_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


@dataclass(frozen=True)
class PictureStatistics:
    """What the comparison needs of one side.

    Attributes
    ----------
    count : float
        Seeds; infinity for an exact picture.
    block : int
        Width and height of a block in pixels.
    block_mean, block_variance : ndarray of float64, shape (h / block, w / block)
        Luminance of the blocks: mean over seeds, and unbiased variance of one seed.
    channel_mean, channel_variance : ndarray of float64, shape (3,)
        Mean over the picture: mean over seeds, and unbiased variance of one seed.
    mean : ndarray of float32, shape (h, w, 3)
        The mean picture, to be looked at.
    """

    count: float
    block: int
    block_mean: np.ndarray
    block_variance: np.ndarray
    channel_mean: np.ndarray
    channel_variance: np.ndarray
    mean: np.ndarray

    @classmethod
    def of(cls, pictures: np.ndarray, block: int = 2) -> PictureStatistics:
        """Statistics of pictures rendered with different seeds.

        Parameters
        ----------
        pictures : ndarray, shape (S, h, w, 3)
            S >= 2; h and w multiples of `block`.

        Raises
        ------
        ValueError
            For another shape, or pictures that are not finite.
        """
        pictures = np.asarray(pictures, np.float64)
        if pictures.ndim != 4 or pictures.shape[3] != 3 or pictures.shape[0] < 2:
            raise ValueError(f"need pictures of shape (S >= 2, h, w, 3), got {pictures.shape}")
        if not np.isfinite(pictures).all():
            raise ValueError("the pictures hold NaN or infinity")
        s, h, w, _ = pictures.shape
        if h % block or w % block:
            raise ValueError(f"{w}x{h} pixels do not divide into blocks of {block}")
        luminance = (pictures @ STORED_LUMINANCE).reshape(s, h // block, block, w // block, block)
        blocks, channels = luminance.mean(axis=(2, 4)), pictures.mean(axis=(1, 2))
        return cls(
            s, block, blocks.mean(axis=0), blocks.var(axis=0, ddof=1),
            channels.mean(axis=0), channels.var(axis=0, ddof=1),
            pictures.mean(axis=0).astype(np.float32),
        )  # fmt: skip

    def save(self, path: str | Path) -> None:
        """Store as ``.npz``."""
        np.savez_compressed(path, **vars(self))

    @classmethod
    def load(cls, path: str | Path) -> PictureStatistics:
        """Load what `save` stored."""
        with np.load(path, allow_pickle=False) as stored:
            values = {name: stored[name] for name in stored.files}
        count, block = float(values.pop("count")), int(values.pop("block"))
        return cls(count=count, block=block, **values)


@dataclass(frozen=True)
class Comparison:
    """Result of `compare_pictures`.

    Attributes
    ----------
    z : ndarray of float64, shape (rows, columns)
        NaN in blocks that vary on neither side and agree (black ones).
    block : int
        Pixels on the side of a block.
    rms, rms_low, rms_high : float
        Root mean square of z, and where it lies with three standard deviations of normal noise.
    largest : float
        The largest abs(z).
    p_values : dict of str to float
        Of the rms, of the largest abs(z) (times the number of blocks), of the channel means and of
        the mean luminance.
    reasons : list of str
        What failed, in words; empty if all passed.
    """

    z: np.ndarray
    block: int
    rms: float
    rms_low: float
    rms_high: float
    largest: float
    p_values: dict[str, float]
    reasons: list[str]
    a: PictureStatistics = field(repr=False)
    b: PictureStatistics = field(repr=False)

    @property
    def passed(self) -> bool:
        """True if the two sides may be the same picture."""
        return not self.reasons

    def __bool__(self) -> bool:
        """Tell whether the test passed."""
        return self.passed

    def report(self) -> str:
        """Write the figures and the reasons, a line each."""
        blocks = int(np.isfinite(self.z).sum())
        bounds = f"[{self.rms_low:.4f}, {self.rms_high:.4f}]"
        size = f"{blocks} blocks of {self.block}x{self.block} pixels"
        lines = [f"{size}: rms(z) {self.rms:.4f} in {bounds}, largest {self.largest:.2f}"]
        lines += [f"p({name}) = {p:.3g}" for name, p in self.p_values.items()]
        for i, name in enumerate("RGB"):
            a, b = self.a.channel_mean[i], self.b.channel_mean[i]
            lines.append(f"mean {name}: {a:.6g} and {b:.6g}")
        return "\n".join([*lines, *self.reasons])

    def dump(self, folder: str | Path) -> Path:
        """Write both mean pictures, z and the report, to see where they differ."""
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        for name, array in (("a", self.a.mean), ("b", self.b.mean), ("z", self.z)):
            np.save(folder / f"{name}.npy", array)
        (folder / "report.txt").write_text(self.report() + "\n")
        return folder


def blocks_of(a: PictureStatistics, b: PictureStatistics, join: bool) -> BlockSums:
    """Sums over the sides' blocks, if wanted joined until they are hardly skewed and well known."""
    sums = BlockSums.of(_luminance(a), _luminance(b), 1)
    freedom = min(a.count, b.count) - 1.0
    while (
        join
        and max(sums.count) > 1
        and (sums.block**2 * freedom < _FREEDOM_WANTED or sums.skewness > LARGEST_SKEWNESS)
    ):
        sums = sums.joined()
    return sums


def _luminance(side: PictureStatistics) -> Measured:
    """The block means as a picture of one channel; infinitely many seeds make an exact one."""
    mean = side.block_mean[..., None]
    if math.isinf(side.count):
        return Measured(mean)
    error = np.sqrt(side.block_variance / side.count)[..., None]
    return Measured(mean, error, round(side.count))


def compare_pictures(
    a: PictureStatistics | np.ndarray,
    b: PictureStatistics | np.ndarray,
    *,
    block: int = 2,
    level: float = 0.01,
    join: bool = True,
) -> Comparison:
    """Test whether two sides are the same picture.

    Parameters
    ----------
    a, b : PictureStatistics, or ndarray of shape (S, h, w, 3)
        Pictures of S seeds each, independent pixels and seeds.
    block : int, default 2
        For sides given as arrays.
    level : float, default 0.01
        Probability that equal pictures fail any of the tests.
    join : bool, default True
        Join blocks until their differences are hardly skewed and their variances well known. Where
        both sides have the same noise and 8 seeds or more, there is nothing to join.

    Raises
    ------
    ValueError
        If the sides have different blocks or sizes.
    """
    a = a if isinstance(a, PictureStatistics) else PictureStatistics.of(a, block)
    b = b if isinstance(b, PictureStatistics) else PictureStatistics.of(b, block)
    if a.block_mean.shape != b.block_mean.shape or a.block != b.block:
        raise ValueError(
            f"the sides have {a.block_mean.shape} blocks of {a.block} pixels "
            f"and {b.block_mean.shape} of {b.block}"
        )
    sums = blocks_of(a, b, join)
    z = sums.z()[..., 0]
    judged = z[np.isfinite(z)]
    if len(judged) == 0:
        raise ValueError("no block varies: there is nothing to judge")
    largest, rms = float(np.abs(judged).max()), float(np.sqrt(np.mean(judged**2)))
    # Bonferroni over the blocks first, so that the channel means keep their power.
    names = {
        "rms(z)": min(1.0, 2.0 * min(sum_of_squares_tails(judged))),
        "largest |z|": min(1.0, len(judged) * math.erfc(largest / math.sqrt(2.0))),
    }
    t, dof = welch(
        a.channel_mean, a.channel_variance, a.count, b.channel_mean, b.channel_variance, b.count
    )
    # Welch's degrees of freedom are those of the finer side where the noisier one looks calm by
    # chance; the fewer of both are on the safe side always, and of three seeds no use.
    tails = student_t_tail(t, np.minimum(dof, min(a.count, b.count) - 1.0))
    names |= {f"mean {name}": float(tails[i]) for i, name in enumerate("RGB")}
    whole = float(sums.whole.z()[0, 0, 0])
    names["mean luminance"] = 1.0 if math.isnan(whole) else math.erfc(abs(whole) / math.sqrt(2.0))
    margin = 3.0 / math.sqrt(2.0 * len(judged))
    reasons = [
        f"{name} differs: p = {p:.3g}, family level {level:g}"
        for (name, p), bad in zip(names.items(), holm(list(names.values()), level), strict=True)
        if bad
    ]
    return Comparison(
        z, a.block * sums.block, rms, 1.0 - margin, 1.0 + margin, largest, names, reasons, a, b
    )
