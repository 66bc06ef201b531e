"""From scene light to a display: white balance, exposure, tone curve, sRGB transfer function.

Only display formats (PNG, JPEG) are changed so; EXR, HDR, PFM and NPY keep the scene's own values.
Tone curves are imported at first use: a family of models takes a tenth of a second.
"""

from __future__ import annotations

import math
import numbers
from dataclasses import dataclass

import numpy as np

from alight.core.constants import LUMINANCE
from alight.core.errors import OptionError, show_value, unknown_name
from alight.core.srgb import encode_srgb
from alight.outputs.white_balance import adaptation, grey_world, parse_white

#: Linear value that automatic exposure gives to the middle of the picture: a grey card.
MIDDLE_GREY = 0.18

#: Pixels per inch of the finest prints.
MOST_DPI = 10_000


@dataclass(frozen=True)
class Display:
    """How linear values become display values.

    Parameters
    ----------
    exposure : float or "auto", default 0
        Stops: values are multiplied by 2^exposure before the tone curve. In [-100, 100]. ``auto``
        brings the geometric mean of the luminances to 0.18 (Reinhard et al. 2002, equation 1).
    tone_map : str, default "none"
        A tone curve of `alight.tone_curves`, or one that is registered.
    bits : int, default 8
        8, or 16 in PNG.
    white_balance : str, default "none"
        Which light looks white: ``none`` (that of D65), ``auto`` (the mean of the picture), a
        temperature as ``3200K``, or the light's colour in linear sRGB as ``1,0.8,0.6``.
    dpi : float, optional
        Pixels per inch, for print.

    Raises
    ------
    OptionError
        For an unknown tone map, an exposure out of range, another number of bits or no white.
    """

    exposure: float | str = 0.0
    tone_map: str = "none"
    bits: int = 8
    white_balance: str = "none"
    dpi: float | None = None

    def __post_init__(self) -> None:
        """Check the values."""
        from alight.tone_curves.model import TONE_CURVES

        if not isinstance(self.tone_map, str) or self.tone_map not in TONE_CURVES:
            raise OptionError(unknown_name("tone map", str(self.tone_map), TONE_CURVES))
        if self.exposure != "auto":
            object.__setattr__(self, "exposure", _stops(self.exposure))
        if self.bits not in (8, 16):
            raise OptionError(f"bits per channel must be 8 or 16, got {self.bits}")
        if self.dpi is not None and not (_is_number(self.dpi) and 1.0 <= self.dpi <= MOST_DPI):
            text = f"must be a number in [1, {MOST_DPI}], got {show_value(self.dpi)}"
            raise OptionError(text, "dpi")
        parse_white(self.white_balance)

    def developed(self, linear: np.ndarray) -> Development:
        """Settle what depends on the whole picture.

        Parameters
        ----------
        linear : ndarray, shape (h, w, 3)
        """
        white, matrix = parse_white(self.white_balance), np.eye(3)
        if isinstance(white, str):
            white = grey_world(_bounded(linear))
        if white is not None:
            matrix = adaptation(white)
        exposure = self.exposure
        if isinstance(exposure, str):
            exposure = _automatic_exposure(_bounded(linear))
        return Development(exposure, matrix, self.tone_map, self.bits, self.dpi)

    def apply(self, linear: np.ndarray) -> np.ndarray:
        """Encode a whole picture as sRGB in [0, 1]: see `Development.apply`."""
        return self.developed(linear).apply(linear)


@dataclass(frozen=True)
class Development:
    """A `Display` for one picture: numbers only.

    Parameters
    ----------
    exposure : float
        Stops.
    matrix : ndarray of float64, shape (3, 3)
        White balance, for column vectors of linear sRGB.
    tone_map : str
    bits : int
    dpi : float or None
    """

    exposure: float
    matrix: np.ndarray
    tone_map: str
    bits: int
    dpi: float | None = None

    def apply(self, linear: np.ndarray) -> np.ndarray:
        """Encode as sRGB in [0, 1].

        Parameters
        ----------
        linear : ndarray, shape (h, w, 3)
            A part of the picture. Negative values and NaN become black, infinity white.

        Returns
        -------
        ndarray of float64, shape (h, w, 3)
        """
        from alight.tone_curves.model import TONE_CURVES

        rgb = _bounded(linear)
        if not np.array_equal(self.matrix, np.eye(3)):
            rgb = rgb @ self.matrix.T
        rgb = np.clip(rgb * 2.0**self.exposure, 0.0, 1e30)
        curve = TONE_CURVES[self.tone_map]
        return encode_srgb(np.clip(curve.apply(curve.spec(), rgb), 0.0, 1.0))


def _bounded(linear: np.ndarray) -> np.ndarray:
    """Finite values >= 0. The bound keeps squares inside the curves finite; all are flat before."""
    return np.clip(
        np.nan_to_num(linear.astype(np.float64), nan=0.0, posinf=1e30, neginf=0.0), 0.0, 1e30
    )


def _is_number(value: object) -> bool:
    return isinstance(value, numbers.Real) and not isinstance(value, bool)


def _stops(value: object) -> float:
    try:
        stops = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        stops = math.nan
    if not (math.isfinite(stops) and abs(stops) <= 100.0):
        raise OptionError(
            f"exposure must be auto or lie in [-100, 100] stops, got {show_value(value)}"
        )
    return stops


def _automatic_exposure(linear: np.ndarray) -> float:
    """Stops that bring the geometric mean of all pixels with light to middle grey."""
    luminance = linear @ LUMINANCE
    lit = luminance[luminance > 0.0]
    if not lit.size:
        return 0.0
    stops = math.log2(MIDDLE_GREY) - float(np.log2(lit).mean())
    return min(max(stops, -100.0), 100.0)
