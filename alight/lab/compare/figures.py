"""All figures of one picture against another, and the test whether they are the same."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from alight.core.errors import OptionError, quote, unknown_name
from alight.lab.compare.inputs import Input
from alight.metrics.agreement import Agreement, Measured, compare_measured
from alight.metrics.epsilon import default_epsilon
from alight.metrics.model import METRICS, Pair, label_of, shown_of

#: Verdicts.
EQUAL, SAME, DIFFERENT, UNTESTED = "identical", "same within noise", "different", "not tested"

#: Verdict where the pictures differ by their own errors, but not if they were made the same way.
UNSURE = "cannot tell"

#: Verdict where only one picture's noise is known.
DIFFERENT_IF_EXACT = "different, if the other is exact"

#: Why a slow metric is missing where it was not requested.
NOT_ASKED = "slow metrics were not asked for (--no-flip)"


@dataclass(frozen=True)
class PictureComparison:
    """One picture against another, which is the reference of the relative figures.

    Attributes
    ----------
    a, b : Input
    exposure : float
        Stops, for metrics of what a display shows.
    errors : dict of str to float
        By the metric's name; NaN where it is unknown or not defined.
    maps : dict of str to ndarray, shape (h, w)
        Of metrics that have one.
    missing : dict of str to str
        Metrics that were not worked out, and why.
    epsilon : float
        Of relMSE: (0.1 mean of b)^2.
    noise_a, noise_b : float
        What the pictures' own noise adds to the MSE; NaN where unknown.
    agreement : Agreement or None
    verdict : str
        `EQUAL`, `SAME`, `UNSURE`, `DIFFERENT`, `DIFFERENT_IF_EXACT` or `UNTESTED`.
    notes : list of str
        What the verdict rests on, and what is odd.
    """

    a: Input
    b: Input
    exposure: float
    errors: dict[str, float]
    maps: dict[str, np.ndarray]
    missing: dict[str, str]
    epsilon: float
    noise_a: float
    noise_b: float
    agreement: Agreement | None
    verdict: str
    notes: list[str]

    @property
    def pair(self) -> Pair:
        """What metrics are given."""
        return _pair(self.a, self.b, self.exposure)

    def shown(self) -> dict[str, dict[str, Any]]:
        """What tables tell: label and value, by the metric's name."""
        return {
            name: {"label": label_of(name, self.pair), "value": _known(shown_of(name, value))}
            for name, value in self.errors.items()
        }

    def to_dict(self) -> dict[str, Any]:
        """All numbers, ready for JSON; unknown ones are None."""
        found: dict[str, Any] = {
            "a": self.a.name, "b": self.b.name, "width": self.a.size[0], "height": self.a.size[1],
            "mean_a": _means(self.a), "mean_b": _means(self.b),
            **{name: _known(value) for name, value in self.errors.items()},
            "shown": self.shown(),
            "missing": self.missing, "epsilon": self.epsilon,
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
    a: Input, b: Input, *, exposure: float = 0.0, slow: bool = True
) -> PictureComparison:
    """Compare two pictures of one size.

    Parameters
    ----------
    a, b : Input
        Finite, of one size; b is the reference of the relative figures.
    exposure : float, default 0
        Stops, for metrics of what a display shows.
    slow : bool, default True
        Slow metrics too.
    """
    pair = _pair(a, b, exposure)
    errors, maps, missing = {}, {}, {}
    for name, metric in METRICS.items():
        errors[name] = math.nan
        if why := NOT_ASKED if metric.SLOW and not slow else metric.missing():
            missing[name] = why
            continue
        if metric.error_map is not None:
            maps[name] = metric.error_map(metric.example, pair)
        # What is slow is worked out once.
        found = maps.get(name) if metric.SLOW else None
        errors[name] = float(
            metric.evaluate(metric.example, pair) if found is None else found.mean(dtype=float)
        )
    agreement, verdict, notes = _judge(a, b)
    return PictureComparison(
        a, b, exposure, errors, maps, missing, default_epsilon(b.image), _noise(a), _noise(b),
        agreement, verdict, [*a.remarks, *b.remarks, *notes],
    )  # fmt: skip


def _pair(a: Input, b: Input, exposure: float) -> Pair:
    return Pair(a.image, b.image, exposure, a.is_display or b.is_display)


def _means(one: Input) -> list[float]:
    return [float(v) for v in one.image.mean(axis=(0, 1), dtype=np.float64)]


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _noise(one: Input) -> float:
    if one.error is None:
        return math.nan
    return float(np.nanmean(np.asarray(one.error, np.float64) ** 2))


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
        if name not in METRICS:
            raise OptionError(unknown_name("figure", name, METRICS), "fail_above")
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
        value = comparison.errors[name]
        if math.isnan(value):
            why = comparison.missing.get(name, "it is not defined for these pictures")
            raise OptionError(f"{name} is unknown: {why}", "fail_above")
        if value > limit:
            found.append(f"{name} is {value:.4g}, above {limit:g}")
    return found
