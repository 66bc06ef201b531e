"""Pictures inside a page: one exposure for all, crops where the arms differ most, false colour."""

from __future__ import annotations

import base64
import io
import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from alight.core.constants import LUMINANCE
from alight.outputs.display import Display
from alight.outputs.png import encode_png

#: Share of the display's range that the bright parts of a picture get, and what "bright" is.
_BRIGHT, _PERCENTILE = 0.85, 97.0

#: Maps are averaged down to at most this many pixels a side: more cannot be seen in a report.
_LARGEST_MAP = 320

#: Colours of a map: fewer compress better, and no eye tells these apart.
_LEVELS = 128


def exposure_for(reference: np.ndarray) -> float:
    """Stops that show a picture well: 0 if it is neither dark nor bright, else whole halves.

    Parameters
    ----------
    reference : ndarray, shape (h, w, 3)
        Linear.
    """
    level = float(np.percentile(np.nan_to_num(reference) @ LUMINANCE, _PERCENTILE))
    if not (math.isfinite(level) and level > 0.0):
        return 0.0
    stops = math.log2(_BRIGHT / level)
    return 0.0 if -0.75 < stops < 1.25 else float(np.clip(round(2.0 * stops) / 2.0, -40.0, 40.0))


def data_uri(png: bytes) -> str:
    """Write a PNG file into a page."""
    return "data:image/png;base64," + base64.b64encode(png).decode("ascii")


def picture_uri(linear: np.ndarray, exposure: float) -> str:
    """Encode a linear picture for a display, as part of a page."""
    return data_uri(encode_png(Display(exposure).apply(linear), bits=8))


def reduced(plane: np.ndarray, largest: int = _LARGEST_MAP) -> np.ndarray:
    """Average blocks of pixels until no side is longer than `largest`; NaN are passed over."""
    step = -(-max(plane.shape[:2]) // largest)
    if step == 1:
        return plane
    known = np.isfinite(plane)
    rows, columns = (np.arange(0, n, step) for n in plane.shape[:2])
    sums = [np.add.reduceat(np.add.reduceat(p, rows, axis=0), columns, axis=1)
            for p in (np.where(known, plane, 0.0), known.astype(np.float64))]  # fmt: skip
    return np.where(sums[1] > 0.0, sums[0] / np.maximum(sums[1], 1.0), np.nan)


# ------------------------------------------------------------------------------------ crops


def error_differences(errors: Sequence[np.ndarray], size: int) -> np.ndarray:
    """How much the errors of several arms differ around each pixel.

    Parameters
    ----------
    errors : sequence of ndarray, shape (h, w)
        Expected squared relative error of each arm's picture.
    size : int
        Width and height of a crop.

    Returns
    -------
    ndarray, shape (h - size + 1, w - size + 1)
        Standard deviation over the arms of the crop's relative error; the error itself for one.
    """
    means = np.stack([np.sqrt(np.maximum(_box_mean(error, size), 0.0)) for error in errors])
    return means[0] if len(means) == 1 else means.std(axis=0)


def _box_mean(plane: np.ndarray, size: int) -> np.ndarray:
    total = np.zeros((plane.shape[0] + 1, plane.shape[1] + 1))
    total[1:, 1:] = np.nan_to_num(plane).cumsum(axis=0).cumsum(axis=1)
    corners = total[size:, size:] - total[:-size, size:] - total[size:, :-size]
    return (corners + total[:-size, :-size]) / size**2


def choose_crops(errors: Sequence[np.ndarray], count: int = 3) -> list[tuple[int, int, int, int]]:
    """Choose the parts of a picture where the arms differ most.

    Parameters
    ----------
    errors : sequence of ndarray, shape (h, w)
        Expected squared relative error of each arm's picture.
    count : int, default 3

    Returns
    -------
    list of (x, y, width, height)
        That do not overlap; fewer where there is no room. From the largest difference down.
    """
    h, w = errors[0].shape
    size = max(1, min(h, w, max(24, round(min(h, w) / 5))))
    score = error_differences(errors, size)
    found: list[tuple[int, int, int, int]] = []
    for _ in range(count):
        y, x = np.unravel_index(int(np.argmax(score)), score.shape)
        if not math.isfinite(score[y, x]):
            break
        found.append((int(x), int(y), size, size))
        score[max(y - size + 1, 0) : y + size, max(x - size + 1, 0) : x + size] = -np.inf
    return found


# ------------------------------------------------------------------------------- false colour


class Scale(NamedTuple):
    """How values become colours.

    Attributes
    ----------
    kind : str
        "signed" (around 0), "log" or "linear".
    low, high : float
    """

    kind: str
    low: float
    high: float

    @classmethod
    def of(cls, planes: Sequence[np.ndarray], kind: str) -> Scale:
        """Choose one scale for several maps, so that their colours compare."""
        values = np.concatenate([p[np.isfinite(p)].ravel() for p in planes] or [np.zeros(1)])
        if kind == "signed":
            tops = [float(np.percentile(np.abs(p[np.isfinite(p)]), 99.0)) for p in planes
                    if np.isfinite(p).any()]  # fmt: skip
            # One wild map must not wash out the others: it saturates instead.
            top = min(max(tops), 4.0 * float(np.median(tops)) or max(tops)) if tops else 0.0
            return cls(kind, -(top or 1.0), top or 1.0)
        if kind == "log":
            positive = values[values > 0.0]
            if len(positive) == 0:
                return cls(kind, 0.1, 1.0)
            low, high = (float(v) for v in np.percentile(positive, [2.0, 99.8]))
            return cls(kind, low / 1.05, high * 1.05) if high < 1.2 * low else cls(kind, low, high)
        low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)
        return cls(kind, min(low, 0.0), high if high > 0.0 else 1.0)

    def places(self, values: np.ndarray) -> np.ndarray:
        """Where in [0, 1] of the scale values lie."""
        if self.kind == "log":
            with np.errstate(divide="ignore", invalid="ignore"):
                shown = np.log(np.maximum(values, 1e-300) / self.low)
            return np.clip(shown / math.log(self.high / self.low), 0.0, 1.0)
        return np.clip((values - self.low) / (self.high - self.low), 0.0, 1.0)


#: Perceptually even and safe for colour-blind readers: Nuñez, Anderton and Renslow 2018 (cividis);
#: Brewer's red-blue with a white middle.
_COLOR_MAPS = {"signed": "RdBu_r", "log": "cividis", "linear": "cividis"}

#: Where nothing is known.
_UNKNOWN_COLOR = (214, 214, 214)


def map_uri(plane: np.ndarray, scale: Scale) -> str:
    """Write a plane of numbers as a picture in false colour; unknown ones are grey.

    Parameters
    ----------
    plane : ndarray, shape (h, w)
        NaN where unknown.
    scale : Scale
    """
    from PIL import Image

    plane = reduced(np.asarray(plane, np.float64))
    levels = np.rint(scale.places(np.nan_to_num(plane)) * (_LEVELS - 1)).astype(np.uint8)
    image = Image.fromarray(np.where(np.isfinite(plane), levels, _LEVELS).astype(np.uint8))
    image.putpalette([*_colors(scale.kind).ravel().tolist(), *_UNKNOWN_COLOR])
    buffer = io.BytesIO()
    image.save(buffer, "PNG", optimize=True)
    return data_uri(buffer.getvalue())


def _colors(kind: str) -> np.ndarray:
    """Rows of red, green and blue from the low to the high end."""
    import matplotlib as mpl

    table = mpl.colormaps[_COLOR_MAPS[kind]](np.linspace(0.0, 1.0, _LEVELS))
    return np.rint(np.asarray(table)[:, :3] * 255.0).astype(np.uint8)


class Tick(NamedTuple):
    """A number under a colour bar."""

    percent: float
    text: str


def color_bar(scale: Scale, percent: bool = False) -> dict[str, Any]:
    """Build the bar of a scale: a picture, and ticks with their places.

    Parameters
    ----------
    scale : Scale
    percent : bool, default False
        Whether the values are shares.
    """
    from alight.lab.report.numbers import number, superscript

    bar = data_uri(encode_png(_colors(scale.kind)[None] / 255.0, bits=8))
    if scale.kind == "log":
        first, last = math.ceil(math.log10(scale.low)), math.floor(math.log10(scale.high))
        step = max(1, math.ceil((last - first + 1) / 5))
        values = [10.0**e for e in range(first, last + 1, step)]
        texts = [f"10{superscript(round(math.log10(v)))}" for v in values]
        if len(values) < 2:
            values = [scale.low, math.sqrt(scale.low * scale.high), scale.high]
            texts = [number(v, 2) for v in values]
    else:
        low, high = scale.low, scale.high
        values = [low, 0.5 * (low + high), high]
        texts = [f"{number(100.0 * v, 2)} %" if percent else number(v) for v in values]
        if scale.kind == "signed":
            texts[2] = f"+{texts[2]}"
    places = scale.places(np.array(values))
    ticks = [Tick(100.0 * float(p), t) for p, t in zip(places, texts, strict=True)]
    return {"image": bar, "ticks": ticks}
