"""All figures of one picture against another, and the test whether they are the same."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from alight.core.constants import LUMINANCE
from alight.core.errors import OptionError, quote, unknown_name
from alight.core.srgb import encode_srgb
from alight.lab.compare.inputs import Input
from alight.metrics import flip as flip_metric
from alight.metrics.agreement import Agreement, Measured, compare_measured
from alight.metrics.mse import mse
from alight.metrics.relmse import LITERATURE_EPSILON, default_epsilon, relmse
from alight.metrics.smape import smape
from alight.metrics.ssim import ssim

#: What the command line can set a limit to.
LIMITED = ("mse", "rmse", "relmse", "relmse_literature", "smape", "dssim", "flip")

#: Verdicts.
EQUAL, SAME, DIFFERENT, UNTESTED = "identical", "same within noise", "different", "not tested"

#: Verdict where the pictures differ by their own errors, but not if they were made the same way.
UNSURE = "cannot tell"

#: Verdict where only one picture's noise is known.
DIFFERENT_IF_EXACT = "different, if the other is exact"

#: Why FLIP is missing where it was not requested.
NOT_ASKED = "FLIP was not asked for"


@dataclass(frozen=True)
class PictureComparison:
    """One picture against another, which is the reference of the relative figures.

    Attributes
    ----------
    a, b : Input
    mse, relmse, relmse_literature, smape : float
        relMSE with epsilon = (0.1 mean of b)^2 and with 0.01; NaN where b is black.
    epsilon : float
    ssim : float
        Of the display's luminance; NaN below 11x11 pixels.
    flip : Flip or None
    flip_range : str
        "ldr" or "hdr".
    flip_note : str
        Why there is none.
    noise_a, noise_b : float
        What the pictures' own noise adds to `mse`; NaN where unknown.
    agreement : Agreement or None
    verdict : str
        `EQUAL`, `SAME`, `UNSURE`, `DIFFERENT`, `DIFFERENT_IF_EXACT` or `UNTESTED`.
    notes : list of str
        What the verdict rests on, and what is odd.
    """

    a: Input
    b: Input
    mse: float
    relmse: float
    relmse_literature: float
    smape: float
    epsilon: float
    ssim: float
    flip: flip_metric.Flip | None
    flip_range: str
    flip_note: str
    noise_a: float
    noise_b: float
    agreement: Agreement | None
    verdict: str
    notes: list[str]

    def figure(self, name: str) -> float:
        """Give a figure by its name in `LIMITED`; NaN where it is unknown."""
        if name == "flip":
            return self.flip.mean if self.flip else math.nan
        if name == "dssim":
            return (1.0 - self.ssim) / 2.0
        return math.sqrt(self.mse) if name == "rmse" else float(getattr(self, name))

    def to_dict(self) -> dict[str, Any]:
        """All numbers, ready for JSON; unknown ones are None."""
        found: dict[str, Any] = {
            "a": self.a.name, "b": self.b.name, "width": self.a.size[0], "height": self.a.size[1],
            "mean_a": _means(self.a), "mean_b": _means(self.b),
            **{name: _known(self.figure(name)) for name in LIMITED},
            "ssim": _known(self.ssim), "epsilon": self.epsilon,
            "flip_range": self.flip_range if self.flip else None,
            "flip_note": self.flip_note or None,
            "noise_mse_a": _known(self.noise_a), "noise_mse_b": _known(self.noise_b),
            "verdict": self.verdict, "notes": self.notes,
        }  # fmt: skip
        if self.agreement is not None:
            test = self.agreement
            found["test"] = {
                "block": test.block, "rms_z": [_known(v) for v in test.rms],
                "largest_z": test.largest, "level": test.level,
                "p_values": test.p_values, "reasons": test.reasons, "doubts": test.doubts,
            }  # fmt: skip
        return found


def compare_inputs(
    a: Input, b: Input, *, exposure: float = 0.0, with_flip: bool = True
) -> PictureComparison:
    """Compare two pictures of one size.

    Parameters
    ----------
    a, b : Input
        Finite, of one size; b is the reference of the relative figures.
    exposure : float, default 0
        Stops, for the figures of what a display shows: SSIM, and FLIP of display files.
    with_flip : bool, default True
    """
    flip_range = "ldr" if a.is_display or b.is_display else "hdr"
    found, note = None, NOT_ASKED
    if with_flip:
        found, note = _flip(a.image, b.image, flip_range, exposure)
    agreement, verdict, notes = _judge(a, b)
    return PictureComparison(
        a, b, mse(a.image, b.image), _relmse(a, b, None), _relmse(a, b, LITERATURE_EPSILON),
        smape(a.image, b.image), default_epsilon(b.image), _ssim(a.image, b.image, exposure),
        found, flip_range, note, _noise(a), _noise(b), agreement, verdict,
        [*a.remarks, *b.remarks, *notes],
    )  # fmt: skip


def _means(one: Input) -> list[float]:
    return [float(v) for v in one.image.mean(axis=(0, 1), dtype=np.float64)]


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _relmse(a: Input, b: Input, epsilon: float | None) -> float:
    if epsilon is None and default_epsilon(b.image) == 0.0:
        return math.nan
    return relmse(a.image, b.image, epsilon=epsilon)


def _noise(one: Input) -> float:
    if one.error is None:
        return math.nan
    return float(np.nanmean(np.asarray(one.error, np.float64) ** 2))


def _shown(image: np.ndarray, exposure: float) -> np.ndarray:
    return np.clip(np.asarray(image, np.float64) * 2.0**exposure, 0.0, 1.0)


def _ssim(a: np.ndarray, b: np.ndarray, exposure: float) -> float:
    if min(a.shape[:2]) < 11:
        return math.nan
    return ssim(*(encode_srgb(_shown(v, exposure) @ LUMINANCE) for v in (a, b)))


def _flip(
    a: np.ndarray, b: np.ndarray, kind: str, exposure: float
) -> tuple[flip_metric.Flip | None, str]:
    if kind == "ldr":
        a, b = _shown(a, exposure), _shown(b, exposure)
    try:
        return flip_metric.flip(a, b, kind), ""
    except OptionError as error:
        return None, str(error)


def _judge(a: Input, b: Input) -> tuple[Agreement | None, str, list[str]]:
    """Test whether the pictures are the same, as far as their errors are known."""
    if np.array_equal(a.image, b.image):
        return None, EQUAL, ["every pixel is the same"]
    known = [one for one in (a, b) if one.error is not None]
    if not known:
        return (
            None,
            UNTESTED,
            ["no standard errors are known (linear EXR files of alight hold them)"],
        )
    notes = [f"{one.name} is taken as exact: its noise counts as difference"
             for one in (a, b) if one.error is None]  # fmt: skip
    sides = [Measured(one.image, one.error, one.replicates, one.samples) for one in (a, b)]
    try:
        agreement = compare_measured(*sides)
    except ValueError as error:
        return None, UNTESTED, [*notes, str(error)]
    notes += [f"{text}: skewed noise, errors too large, or shared random numbers"
              for text in agreement.remarks]  # fmt: skip
    told = f"{len(agreement.p_values)} tests at a family level of {100.0 * agreement.level:g} %"
    if agreement.passed and not agreement.doubts:
        return agreement, SAME, [*notes, f"{told}: none fails"]
    if agreement.doubts:
        doubt = (
            "by the pictures' own errors these fail, but those are too small if bright samples "
            "were missed and the pictures were made in the same way"
        )
        return agreement, UNSURE, [*notes, f"{told}: {doubt}", *agreement.doubts]
    verdict = DIFFERENT if len(known) == 2 else DIFFERENT_IF_EXACT
    return agreement, verdict, [*notes, f"{told}: these fail", *agreement.reasons]


# ------------------------------------------------------------------------------------- limits


def parse_limits(texts: list[str]) -> dict[str, float]:
    """Read ``relmse=0.01`` and the like.

    Raises
    ------
    OptionError
        For an unknown figure or a limit that is no number.
    """
    limits = {}
    for text in texts:
        name, _, value = text.partition("=")
        name = name.strip().replace("-", "_")
        if name not in LIMITED:
            raise OptionError(unknown_name("figure", name, LIMITED), "fail_above")
        try:
            limits[name] = float(value)
        except ValueError:
            limits[name] = math.nan
        if not limits[name] >= 0.0:
            problem = f"must be FIGURE=NUMBER such as relmse=0.01, got {quote(text)}"
            raise OptionError(problem, "fail_above")
    return limits


def exceeded(comparison: PictureComparison, limits: dict[str, float]) -> list[str]:
    """What lies above its limit, in words.

    Raises
    ------
    OptionError
        If a figure with a limit is unknown.
    """
    found = []
    for name, limit in limits.items():
        value = comparison.figure(name)
        if math.isnan(value):
            why = comparison.flip_note if name == "flip" else "it is not defined for these pictures"
            raise OptionError(f"{name} is unknown: {why}", "fail_above")
        if value > limit:
            found.append(f"{name} is {value:.4g}, above {limit:g}")
    return found
