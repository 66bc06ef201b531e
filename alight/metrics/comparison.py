"""Do two renderers make the same picture? A test over blocks of pixels and many seeds.

Per-pixel tests at a fixed number of sigmas are wrong for the skewed noise of path tracing. Here
each side is rendered with at least 32 seeds; the mean luminance of small blocks (2x2 pixels) is
nearly normal over them, Welch's t of each block is mapped through its own distribution to a z, and
the picture passes if

* rms(z) lies within 1 +- 3 / sqrt(2 B) for B blocks: neither bias nor misstated variance, and
* the largest abs(z) and the three channel means pass Holm's test at one family level.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from alight.metrics.statistics import holm, student_t_tail, t_to_z, welch

_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


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
        luminance = (pictures @ _LUMINANCE).reshape(s, h // block, block, w // block, block)
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
    z : ndarray of float64, shape (h / block, w / block)
        NaN in blocks that vary on neither side and agree (black ones).
    rms, rms_low, rms_high : float
        Root mean square of z and the bounds that it must keep.
    largest : float
        The largest abs(z).
    p_values : dict of str to float
        Of the largest abs(z) (times the number of blocks) and of the channel means.
    reasons : list of str
        What failed, in words; empty if all passed.
    """

    z: np.ndarray
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
        lines = [f"{blocks} blocks: rms(z) {self.rms:.4f} in {bounds}, largest {self.largest:.2f}"]
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


def block_z(a: PictureStatistics, b: PictureStatistics) -> np.ndarray:
    """Give one z per block, standard normal if the pictures agree; NaN where nothing varies."""
    t, dof = welch(a.block_mean, a.block_variance, a.count, b.block_mean, b.block_variance, b.count)
    return np.where(np.isinf(dof) & (t == 0.0), np.nan, t_to_z(t, dof))


def compare_pictures(
    a: PictureStatistics | np.ndarray,
    b: PictureStatistics | np.ndarray,
    *,
    block: int = 2,
    level: float = 0.01,
) -> Comparison:
    """Test whether two sides are the same picture.

    Parameters
    ----------
    a, b : PictureStatistics, or ndarray of shape (S, h, w, 3)
        Pictures of S seeds each, independent pixels and seeds.
    block : int, default 2
        For sides given as arrays.
    level : float, default 0.01
        Probability that equal pictures fail one of Holm's tests.

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
    z = block_z(a, b)
    judged = z[np.isfinite(z)]
    if len(judged) == 0:
        raise ValueError("no block varies: there is nothing to judge")
    largest = float(np.abs(judged).max())
    # Bonferroni over the blocks first, so that the channel means keep their power.
    names = {"largest |z|": min(1.0, len(judged) * math.erfc(largest / math.sqrt(2.0)))}
    t, dof = welch(
        a.channel_mean, a.channel_variance, a.count, b.channel_mean, b.channel_variance, b.count
    )
    tails = student_t_tail(t, dof)
    names |= {f"mean {name}": float(tails[i]) for i, name in enumerate("RGB")}
    rms, margin = float(np.sqrt(np.mean(judged**2))), 3.0 / math.sqrt(2.0 * len(judged))
    low, high = 1.0 - margin, 1.0 + margin
    reasons = []
    if not low <= rms <= high:
        reasons.append(f"rms(z) = {rms:.4f} lies outside [{low:.4f}, {high:.4f}]")
    for (name, p), bad in zip(names.items(), holm(list(names.values()), level), strict=True):
        if bad:
            reasons.append(f"{name} differs: p = {p:.3g}, family level {level:g}")
    return Comparison(z, rms, low, high, largest, names, reasons, a, b)
