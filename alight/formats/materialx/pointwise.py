"""What nodes compute of numbers, point by point.

Each function takes arrays of shape (n, 1) or (n, c) and gives one. Constants are folded by it, and
pictures are computed anew where no texture of alight does the same.

Source: MaterialX 1.39, the standard library's implementations (stdlib, genglsl).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Rows = NDArray[np.float64]
#: Weights of the channels in a luminance, as the library's default has them (ACEScg).
LUMA = (0.2722287, 0.6740818, 0.0536895)
_SMALL = 1e-12


def _power(base: Rows, exponent: Rows) -> Rows:
    return np.power(np.maximum(base, 0.0), exponent)


def _divide(a: Rows, b: Rows) -> Rows:
    return a / np.where(np.abs(b) < _SMALL, _SMALL, b)


def _burn(fg: Rows, bg: Rows, share: Rows) -> Rows:
    found = share * (1.0 - _divide(1.0 - bg, fg)) + (1.0 - share) * bg
    return np.where(np.abs(fg) < 1e-8, 0.0, found)


def _dodge(fg: Rows, bg: Rows, share: Rows) -> Rows:
    found = share * _divide(bg, 1.0 - fg) + (1.0 - share) * bg
    return np.where(np.abs(1.0 - fg) < 1e-8, 0.0, found)


def remap(x: Rows, in_low: Rows, in_high: Rows, low: Rows, high: Rows) -> Rows:
    """From one interval to another."""
    return low + _divide((x - in_low) * (high - low), in_high - in_low)


def _smoothstep(x: Rows, low: Rows, high: Rows) -> Rows:
    t = np.clip(_divide(x - low, high - low), 0.0, 1.0)
    return np.where(x >= high, 1.0, np.where(x <= low, 0.0, t * t * (3.0 - 2.0 * t)))


def _range(
    x: Rows, in_low: Rows, in_high: Rows, gamma: Rows, low: Rows, high: Rows, clamped: Rows
) -> Rows:
    t = _divide(x - in_low, in_high - in_low)
    t = np.sign(t) * np.abs(t) ** _divide(np.ones_like(gamma), gamma)
    found = low + t * (high - low)
    return np.where(clamped != 0.0, np.clip(found, np.minimum(low, high), high), found)


def luminance(x: Rows, weights: Rows) -> Rows:
    """Weighted sum of red, green and blue, in all three."""
    grey = (x[:, :3] * weights[:, :3]).sum(axis=1, keepdims=True)
    return np.concatenate([np.repeat(grey, 3, axis=1), x[:, 3:]], axis=1)


def _saturate(x: Rows, amount: Rows, weights: Rows) -> Rows:
    grey = luminance(x, weights)
    return np.concatenate([(grey + amount * (x - grey))[:, :3], x[:, 3:]], axis=1)


def _to_hsv(x: Rows) -> Rows:
    rgb = x[:, :3]
    high, low = rgb.max(axis=1), rgb.min(axis=1)
    span = high - low
    safe = np.where(span > 0.0, span, 1.0)
    r, g, b = rgb.T
    hue = np.where(
        high == r, (g - b) / safe, np.where(high == g, 2.0 + (b - r) / safe, 4.0 + (r - g) / safe)
    )
    hue = np.where(span > 0.0, hue / 6.0 % 1.0, 0.0)
    saturation = np.where(high > 0.0, span / np.where(high > 0.0, high, 1.0), 0.0)
    return np.concatenate([np.stack([hue, saturation, high], 1), x[:, 3:]], axis=1)


def _to_rgb(x: Rows) -> Rows:
    hue, saturation, value = x[:, 0] % 1.0 * 6.0, x[:, 1], x[:, 2]
    pure = [
        np.clip(sign * np.abs(hue - center) + shift, 0.0, 1.0)
        for center, sign, shift in ((3.0, 1.0, -1.0), (2.0, -1.0, 2.0), (4.0, -1.0, 2.0))
    ]
    parts = [value * (1.0 - saturation * (1.0 - share)) for share in pure]
    return np.concatenate([np.stack(parts, 1), x[:, 3:]], axis=1)


def _hsv_adjust(x: Rows, amount: Rows) -> Rows:
    hsv = _to_hsv(x)
    hsv[:, 0] += amount[:, 0]
    hsv[:, 1:3] *= amount[:, 1:3]
    return _to_rgb(hsv)


def _color_correct(
    x: Rows, hue: Rows, saturation: Rows, gamma: Rows, lift: Rows, gain: Rows, contrast: Rows,
    pivot: Rows, exposure: Rows,
) -> Rows:  # fmt: skip
    ones = np.ones_like(hue)
    turned = _hsv_adjust(x, np.concatenate([hue, ones, ones], axis=1))[:, :3]
    rgb = _saturate(turned, saturation, np.broadcast_to(LUMA, turned.shape))
    rgb = np.sign(rgb) * np.abs(rgb) ** _divide(ones, gamma)
    rgb = (rgb * (1.0 - lift) + lift) * gain
    rgb = ((rgb - pivot) * contrast + pivot) * 2.0**exposure
    return np.concatenate([rgb, x[:, 3:]], axis=1)


def _angle(function: Callable[[Rows], Rows]) -> Callable[[Rows], Rows]:
    return lambda x: function(np.clip(x, -1.0, 1.0))


def _length(x: Rows) -> Rows:
    return np.linalg.norm(x, axis=1, keepdims=True)


def _normalized(x: Rows) -> Rows:
    return _divide(x, _length(x))


Argument = tuple[str, Any]
#: Node -> what it computes, and its inputs with the library's defaults.
POINTWISE: dict[str, tuple[Callable[..., Rows], tuple[Argument, ...]]] = {
    "absval": (np.abs, (("in", 0.0),)),
    "acos": (_angle(np.arccos), (("in", 0.0),)),
    "add": (np.add, (("in1", 0.0), ("in2", 0.0))),
    "asin": (_angle(np.arcsin), (("in", 0.0),)),
    "atan2": (np.arctan2, (("iny", 0.0), ("inx", 1.0))),
    "burn": (_burn, (("fg", 0.0), ("bg", 0.0), ("mix", 1.0))),
    "ceil": (np.ceil, (("in", 0.0),)),
    "clamp": (lambda x, low, high: np.minimum(np.maximum(x, low), high),
              (("in", 0.0), ("low", 0.0), ("high", 1.0))),
    "colorcorrect": (_color_correct, (
        ("in", 1.0), ("hue", 0.0), ("saturation", 1.0), ("gamma", 1.0), ("lift", 0.0),
        ("gain", 1.0), ("contrast", 1.0), ("contrastpivot", 0.5), ("exposure", 0.0))),
    "contrast": (lambda x, amount, pivot: (x - pivot) * amount + pivot,
                 (("in", 0.0), ("amount", 1.0), ("pivot", 0.5))),
    "cos": (np.cos, (("in", 0.0),)),
    "difference": (lambda fg, bg, m: m * np.abs(bg - fg) + (1.0 - m) * bg,
                   (("fg", 0.0), ("bg", 0.0), ("mix", 1.0))),
    "divide": (_divide, (("in1", 0.0), ("in2", 1.0))),
    "dodge": (_dodge, (("fg", 0.0), ("bg", 0.0), ("mix", 1.0))),
    "dotproduct": (lambda a, b: (a * b).sum(axis=1, keepdims=True), (("in1", 0.0), ("in2", 0.0))),
    "exp": (lambda x: np.exp(np.minimum(x, 80.0)), (("in", 0.0),)),
    "floor": (np.floor, (("in", 0.0),)),
    "fract": (lambda x: x - np.floor(x), (("in", 0.0),)),
    "hsvadjust": (_hsv_adjust, (("in", 0.0), ("amount", (0.0, 1.0, 1.0)))),
    "hsvtorgb": (_to_rgb, (("in", 0.0),)),
    "ifequal": (lambda a, b, x, y: np.where(a == b, x, y),
                (("value1", 0.0), ("value2", 0.0), ("in1", 0.0), ("in2", 0.0))),
    "ifgreater": (lambda a, b, x, y: np.where(a > b, x, y),
                  (("value1", 1.0), ("value2", 0.0), ("in1", 0.0), ("in2", 0.0))),
    "ifgreatereq": (lambda a, b, x, y: np.where(a >= b, x, y),
                    (("value1", 1.0), ("value2", 0.0), ("in1", 0.0), ("in2", 0.0))),
    "invert": (np.subtract, (("amount", 1.0), ("in", 0.0))),
    "ln": (lambda x: np.log(np.maximum(x, _SMALL)), (("in", 1.0),)),
    "luminance": (luminance, (("in", 0.0), ("lumacoeffs", LUMA))),
    "magnitude": (_length, (("in", 0.0),)),
    "max": (np.maximum, (("in1", 0.0), ("in2", 0.0))),
    "min": (np.minimum, (("in1", 0.0), ("in2", 0.0))),
    "minus": (lambda fg, bg, m: bg - m * fg, (("fg", 0.0), ("bg", 0.0), ("mix", 1.0))),
    "mix": (lambda fg, bg, m: bg + (fg - bg) * m, (("fg", 0.0), ("bg", 0.0), ("mix", 0.0))),
    "modulo": (lambda a, b: a - b * np.floor(_divide(a, b)), (("in1", 0.0), ("in2", 1.0))),
    "multiply": (np.multiply, (("in1", 0.0), ("in2", 1.0))),
    "normalize": (_normalized, (("in", 0.0),)),
    "overlay": (lambda fg, bg, m: m * np.where(
        bg >= 0.5, 1.0 - 2.0 * (1.0 - fg) * (1.0 - bg), 2.0 * fg * bg) + (1.0 - m) * bg,
        (("fg", 0.0), ("bg", 0.0), ("mix", 1.0))),
    "plus": (lambda fg, bg, m: bg + m * fg, (("fg", 0.0), ("bg", 0.0), ("mix", 1.0))),
    "power": (_power, (("in1", 0.0), ("in2", 1.0))),
    "range": (_range, (("in", 0.0), ("inlow", 0.0), ("inhigh", 1.0), ("gamma", 1.0),
                       ("outlow", 0.0), ("outhigh", 1.0), ("doclamp", 0.0))),
    "remap": (remap, (("in", 0.0), ("inlow", 0.0), ("inhigh", 1.0), ("outlow", 0.0),
                      ("outhigh", 1.0))),
    "rgbtohsv": (_to_hsv, (("in", 0.0),)),
    "round": (lambda x: np.floor(x + 0.5), (("in", 0.0),)),
    "safepower": (lambda a, b: np.sign(a) * np.abs(a) ** b, (("in1", 0.0), ("in2", 1.0))),
    "saturate": (_saturate, (("in", 0.0), ("amount", 1.0), ("lumacoeffs", LUMA))),
    "screen": (lambda fg, bg, m: m * (1.0 - (1.0 - fg) * (1.0 - bg)) + (1.0 - m) * bg,
               (("fg", 0.0), ("bg", 0.0), ("mix", 1.0))),
    "sign": (np.sign, (("in", 0.0),)),
    "sin": (np.sin, (("in", 0.0),)),
    "smoothstep": (_smoothstep, (("in", 0.0), ("low", 0.0), ("high", 1.0))),
    "sqrt": (lambda x: np.sqrt(np.maximum(x, 0.0)), (("in", 0.0),)),
    "subtract": (np.subtract, (("in1", 0.0), ("in2", 0.0))),
    "tan": (np.tan, (("in", 0.0),)),
    "trianglewave": (lambda x: 0.5 - np.abs(np.abs(x) % 1.0 - 0.5), (("in", 0.0),)),
}  # fmt: skip


def folded(function: Callable[..., Rows], values: list[tuple[float, ...]]) -> tuple[float, ...]:
    """What a node makes of numbers; 0 where that is none."""
    arrays = [np.array([numbers], np.float64) for numbers in values]
    with np.errstate(all="ignore"):
        found = np.asarray(function(*arrays), np.float64)[0]
    return tuple(float(x) if math.isfinite(x) else 0.0 for x in found)
