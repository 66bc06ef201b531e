"""FLIP: the difference that an eye sees when it flips between two pictures, 0 to 1.

Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild 2020, "FLIP: A difference
evaluator for alternating images"; for high dynamic range Andersson, Nilsson, Shirley and
Akenine-Möller 2021, "Visualizing errors in rendered high dynamic range images": the largest FLIP
over all exposures that show something. Computed by the authors' package `flip-evaluator`, at 67
pixels a degree (their default: a 4K display of 0.7 m width, seen from 0.7 m).
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from alight.core.errors import OptionError
from alight.core.extras import install_command
from alight.core.srgb import encode_srgb
from alight.metrics.model import Metric, Pair

#: Dynamic ranges: values on a display, cut at 1, or the scene's own.
RANGES = ("ldr", "hdr")


class Flip(NamedTuple):
    """A mean FLIP and its map.

    Attributes
    ----------
    mean : float
        0 (nothing is seen) to 1.
    error : ndarray of float32, shape (h, w)
    """

    mean: float
    error: np.ndarray


class FlipMetric(Metric):
    """FLIP: the difference that an eye sees, from 0 to 1."""

    type: Literal["flip"] = "flip"


EXAMPLES = (FlipMetric(),)

LABEL, BOUNDED, SLOW = "FLIP", True, True


def missing() -> str:
    """The package that computes it, if it is not installed."""
    import importlib.util

    if importlib.util.find_spec("flip_evaluator") is not None:
        return ""
    return f"FLIP needs the package flip-evaluator: {install_command('lab', 'flip-evaluator')}"


def error_map(spec, pair: Pair) -> np.ndarray:
    """Of a display at its exposure, or of all exposures that show something."""
    return _of(pair).error


def evaluate(spec, pair: Pair) -> float:
    """The mean."""
    return _of(pair).mean


def label(spec, pair: Pair) -> str:
    """It depends on the range."""
    return f"FLIP ({_range(pair).upper()})"


def _range(pair: Pair) -> str:
    return "ldr" if pair.on_display else "hdr"


def _of(pair: Pair) -> Flip:
    seen = pair.shown() if pair.on_display else pair
    return flip(seen.image, seen.reference, _range(pair))


def flip(image: np.ndarray, reference: np.ndarray, dynamic_range: str = "hdr") -> Flip:
    """FLIP of two linear pictures.

    Parameters
    ----------
    image, reference : ndarray, shape (h, w, 3)
        Linear sRGB; values below 0 count as 0.
    dynamic_range : str, default "hdr"
        ``"ldr"`` shows both at exposure 0, cut at 1; ``"hdr"`` at every exposure that matters.

    Raises
    ------
    OptionError
        If the package `flip-evaluator` is not installed.
    ValueError
        If the shapes differ, or for another dynamic range.
    """
    if dynamic_range not in RANGES:
        raise ValueError(f"dynamic range must be one of {RANGES}, got {dynamic_range!r}")
    x, ref = np.asarray(image, np.float32), np.asarray(reference, np.float32)
    if x.shape != ref.shape:
        raise ValueError(f"pictures must have one shape, got {x.shape} and {ref.shape}")
    if problem := missing():
        raise OptionError(problem)
    import flip_evaluator

    x, ref = np.maximum(x, 0.0), np.maximum(ref, 0.0)
    if not ref.any() or not x.any():
        # The range of exposures is that of the reference's brightness: black has none.
        dynamic_range = "ldr"
    if dynamic_range == "ldr":
        x, ref = (encode_srgb(np.minimum(v, 1.0)).astype(np.float32) for v in (x, ref))
    error, mean, _ = flip_evaluator.evaluate(ref, x, dynamic_range.upper(), applyMagma=False)
    return Flip(float(mean), np.asarray(error, np.float32).reshape(x.shape[:2]))
