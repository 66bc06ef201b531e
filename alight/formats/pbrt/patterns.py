r"""Textures of pbrt that are computed, not read: gradients become small bitmaps, waves our noise.

pbrt's waves are sums :math:`\sum_k r^k n(1.99^k x)`, ours the same with 2 and another n, divided by
:math:`S = \sum_k r^k` and shifted to [0, 1]. So theirs are :math:`S (2 w - 1)` for "fbm" and
:math:`S w` for "wrinkled", with our w: a relief of the same steepness.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from alight.formats.pbrt.context import Data
from alight.formats.pbrt.textures import GREY, Source, Value, entry, mapping, part, product
from alight.formats.pbrt.transforms import inverse
from alight.textures.images import Image

_BLACK, _WHITE = [0.0] * 3, [1.0] * 3
_LARGEST_OCTAVES = 16
#: Steps of a ramp that begins again and again.
_SAWTEETH = 256
#: Darkest and brightest colour of pbrt's marble.
_VEIN, _STONE = [0.3, 0.3, 0.495], [0.87, 0.87, 0.9]
#: From the unit square to the middles of the texels of a picture of 2 x 2.
_TO_MIDDLES: list[Data] = [{"scale": [0.5, 0.5]}, {"translate": [0.25, 0.25]}]


def _approximated(source: Source, text: str) -> None:
    source.p.report.warn(source.p.directive, text)


def _gradient(source: Source, corners: list[list[float]], steps: Data) -> Value:
    """The bilinear mixture of colours at (0, 0), (1, 0), (0, 1) and (1, 1)."""
    rows = [[corners[2], corners[3]], [corners[0], corners[1]]]
    to_uv = [*steps.get("to_uv", []), *_TO_MIDDLES]
    data: Data = {"type": "bitmap", "pixels": rows, "wrap": "clamp", "to_uv": to_uv}
    return entry(source, {**data, "color_space": "linear"})


def _bilerp(source: Source) -> Value:
    names, defaults = ("v00", "v10", "v01", "v11"), (_BLACK, _BLACK, _WHITE, _WHITE)
    found = [part(source, name, value) for name, value in zip(names, defaults, strict=True)]
    steps = mapping(source)
    colors = [value for value in found if isinstance(value, list)]
    if len(colors) == len(names):
        if steps:
            text = "beyond its corners it goes on as at its edges, and does not grow"
            _approximated(source, text)
        return _gradient(source, colors, steps)
    _approximated(source, "mixes textures bilinearly: the first one is taken")
    return next(value for value in found if isinstance(value, str))


def _uv(source: Source) -> Value:
    corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]]
    steps = mapping(source)
    if not steps:
        return _gradient(source, corners, steps)
    # The part after the point, again in each square.
    ramp = (np.arange(_SAWTEETH) + 0.5) / _SAWTEETH
    red, green = np.meshgrid(ramp, ramp[::-1])
    pixels = np.stack([red, green, 0.0 * red], axis=2).astype(np.float32)
    data: Data = {"type": "bitmap", "pixels": Image(pixels), "interpolation": "nearest", **steps}
    return entry(source, {**data, "color_space": "linear"})


def _dots(source: Source) -> Value:
    value = part(source, "outside", _BLACK)
    inside = part(source, "inside", _WHITE)
    mapping(source)
    if value != inside:
        _approximated(source, "is not covered: its colour outside of the dots is taken")
    return value


def _asked_waves(source: Source, size: float = 1.0) -> tuple[Data, float]:
    """`_waves` with the octaves and the roughness that a file says."""
    p = source.p
    wanted = p.integer("octaves", 8), p.number("roughness", 0.5)
    octaves = min(max(wanted[0], 1), _LARGEST_OCTAVES)
    gain = min(max(wanted[1], 0.0), 1.0)
    for name, value, taken in zip(("octaves", "roughness"), wanted, (octaves, gain), strict=True):
        if value != taken:
            p.report.warn(p.named[name], f"became {taken:g}")
    return _waves(source, octaves, gain, size)


def _waves(source: Source, octaves: int, gain: float, size: float = 1.0) -> tuple[Data, float]:
    """Noise between 0 and 1 in the texture's space, and the largest sum of its waves."""
    scale, offset = _space(source, size)
    data: Data = {"type": "noise", "octaves": octaves, "gain": gain, "scale": scale}
    if any(offset):
        data["offset"] = offset
    return data, float(sum(gain**k for k in range(octaves)))


def _space(source: Source, size: float) -> tuple[list[float], list[float]]:
    """Scale and shift along the axes of the world that come nearest to the texture's space."""
    matrix = inverse(source.matrix)
    if matrix is None:
        return [size] * 3, [0.0] * 3
    linear = matrix[:3, :3]
    if np.array_equal(linear, np.diag(np.diag(linear))):
        return (size * np.diag(linear)).tolist(), (size * matrix[:3, 3]).tolist()
    return [size * float(np.cbrt(abs(np.linalg.det(linear))))] * 3, [0.0] * 3


def _fbm(source: Source) -> Value:
    data, most = _asked_waves(source)
    _approximated(source, "becomes noise of the same steepness, but with no values below 0")
    return product(source, entry(source, data), [2.0 * most] * 3)


def _wrinkled(source: Source) -> Value:
    data, most = _asked_waves(source)
    _approximated(source, "becomes noise: other wrinkles of the same size")
    return product(source, entry(source, {**data, "pattern": "turbulence"}), [most] * 3)


def _windy(source: Source) -> Value:
    wind, wind_most = _waves(source, 3, 0.5, 0.1)
    waves, most = _waves(source, 6, 0.5)
    wind["pattern"] = "turbulence"
    _approximated(source, "becomes noise: other waves of about the same size")
    both = product(source, entry(source, wind), entry(source, waves))
    return product(source, both, [2.0 * most * wind_most] * 3)


def _marble(source: Source) -> Value:
    p = source.p
    size = p.number("scale", 1.0)
    p.number("variation", 0.2)
    data, _ = _asked_waves(source, size)
    _approximated(source, "becomes noise between its colours: other veins")
    return entry(source, {**data, "color0": _VEIN, "color1": _STONE})


def _ptex(source: Source) -> Value:
    p = source.p
    p.leave_out("such files are not covered", "filename", "encoding", "scale")
    shown = ", ".join(f"{channel:g}" for channel in GREY)
    _approximated(source, f"is not covered: grey [{shown}] is taken")
    return list(GREY)


#: By pbrt's name.
PATTERNS: dict[str, Callable[[Source], Value]] = {
    "bilerp": _bilerp,
    "dots": _dots,
    "fbm": _fbm,
    "marble": _marble,
    "ptex": _ptex,
    "uv": _uv,
    "windy": _windy,
    "wrinkled": _wrinkled,
}
