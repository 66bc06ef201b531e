r"""Lights of pbrt with a picture: ``projection`` throws it, ``goniometric`` shines through it.

A projection's picture is as wide as `fov` along its shorter side and even in intensity. Its upper
edge is towards +y of the light (in pbrt 3 towards -y), its left edge towards -x.

The picture of a goniometric light is a map of all directions: of pbrt 4 the square of
`octahedral`, of pbrt 3 latitude and longitude; y of the light is up. It becomes a lamp with a
measured profile, which is grey.

Source: pbrt-v4, documentation of the file format, "Lights"; PBR4 sections 12.2.2 and 12.2.3.
"""

from __future__ import annotations

import math

import numpy as np

from alight.core.constants import LUMINANCE
from alight.core.errors import Issue, SceneError
from alight.formats.pbrt.amounts import amount, placed, with_power
from alight.formats.pbrt.context import Context, Data
from alight.formats.pbrt.octahedral import texel, to_square
from alight.formats.pbrt.parameters import Parameters
from alight.formats.reading.reach import OutOfReachError
from alight.formats.scenes.lamps import point
from alight.lights.ies import LUMENS, Ies, mean_color
from alight.scene import images
from alight.textures.images import Image

#: Steps of a profile in degrees, from the light's +z and around it.
_DOWN, _AROUND = 2.5, 5.0


def projection(context: Context, p: Parameters, matrix: np.ndarray) -> Data | None:
    """Convert a ``projection``."""
    color = amount(context, p, "I")
    fov = p.number("fov", 45.0 if context.old else 90.0)
    texels = _picture(context, p)
    if texels is None:
        return None
    if not 0.0 < fov < 180.0:
        p.report.error(p.named["fov"], f"must be in (0, 180) degrees, got {fov:g}")
        return None
    height, width = texels.shape[:2]
    half = math.tan(math.radians(0.5 * fov))
    wide, high = half * max(1.0, width / height), half * max(1.0, height / width)
    color = with_power(p, color, "power", _thrown(texels, wide, high))
    across = math.degrees(2.0 * math.atan(wide))
    taken = min(max(across, 0.1), 179.0)
    if taken != across:
        place = p.named.get("fov", p.directive)
        p.report.warn(place, f"makes a picture {across:.4g} degrees wide: became {taken:g}")
    pixels = texels[:, ::-1] if not context.old else texels[::-1, ::-1]
    light: Data = {
        "type": "projector",
        "pixels": Image(np.ascontiguousarray(pixels)),
        "scale": color,
        "fov": taken,
        "evenness": "intensity",
    }
    return placed(light, matrix)


def _thrown(texels: np.ndarray, wide: float, high: float) -> float:
    """Luminance integrated over the directions of a picture with these half sides."""
    rows, columns = texels.shape[:2]
    x = wide * ((np.arange(columns) + 0.5) * 2.0 / columns - 1.0)
    y = high * ((np.arange(rows) + 0.5) * 2.0 / rows - 1.0)
    cosine = 1.0 / np.sqrt(1.0 + x[None, :] ** 2 + y[:, None] ** 2)
    return float(((texels @ LUMINANCE) * cosine**3).sum()) * 4.0 * wide * high / (rows * columns)


def goniometric(context: Context, p: Parameters, matrix: np.ndarray) -> Data | None:
    """Convert a ``goniometric``; a point light without a picture."""
    color = amount(context, p, "I")
    if not (p.has("filename") or p.has("mapname")):
        color = with_power(p, color, "power", 4.0 * math.pi)
        return placed(point(color), matrix)
    texels = _picture(context, p)
    if texels is None:
        return None
    height, width = texels.shape[:2]
    if not context.old and width != height:
        text = f"must be a square, which folds to a sphere, got {width}x{height}"
        p.report.error(p.directive, text)
        return None
    map_ = texels.mean(axis=2, dtype=np.float64)
    if np.ptp(texels, axis=2).max() > 1e-3 * map_.max():
        p.report.warn(p.directive, "shines in one colour: that of its picture is left out")
    vertical = np.arange(0.0, 180.0 + _DOWN, _DOWN)
    horizontal = np.arange(0.0, 360.0 + _AROUND, _AROUND)
    theta, phi = np.radians(vertical)[None, :], np.radians(horizontal)[:, None]
    x, y = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi)
    # The map's z is the light's y.
    z, up = y, np.broadcast_to(np.cos(theta), y.shape)
    values = _looked_up(map_, np.stack([x, up, z], axis=-1), context.old)
    profile = {
        "vertical_angles": vertical.tolist(),
        "horizontal_angles": horizontal.tolist(),
        "candela": (LUMENS * values).tolist(),
    }
    color = with_power(p, color, "power", 4.0 * math.pi * mean_color(Ies(**profile))[0])
    return placed({"type": "ies", **profile, "scale": color}, matrix)


def _looked_up(map_: np.ndarray, directions: np.ndarray, old: bool) -> np.ndarray:
    """Values of a map of directions, which have its z up: bilinear between texels."""
    rows, columns = map_.shape
    if old:
        theta = np.arccos(np.clip(directions[..., 2], -1.0, 1.0))
        phi = np.arctan2(directions[..., 1], directions[..., 0]) % (2.0 * np.pi)
        s, t = phi / (2.0 * np.pi) * columns - 0.5, theta / np.pi * rows - 0.5
    else:
        square = to_square(directions)
        s, t = square[..., 0] * columns - 0.5, square[..., 1] * rows - 0.5
    i, j = np.floor(s).astype(int), np.floor(t).astype(int)
    a, b = s - i, t - j

    def at(column: np.ndarray, row: np.ndarray) -> np.ndarray:
        if not old:
            return texel(map_, column, row)
        return map_[np.clip(row, 0, rows - 1), column % columns]

    top = (1.0 - a) * at(i, j) + a * at(i + 1, j)
    return (1.0 - b) * top + b * ((1.0 - a) * at(i, j + 1) + a * at(i + 1, j + 1))


def _picture(context: Context, p: Parameters) -> np.ndarray | None:
    """The texels of the light's picture, linear, top row first; None after a problem."""
    name = "mapname" if p.has("mapname") else "filename"
    found = p.values(name, "string", count=1)
    if found is None:
        if not p.has(name):
            p.report.error(p.directive, 'needs "string filename"')
        return None
    try:
        path = context.reach.find(found.values[0])
        texels = images.picture(
            found.values[0], context.reach.files, p.report.approximate, path
        ).linear()
        return np.broadcast_to(texels, (*texels.shape[:2], 3)).astype(np.float32)
    except OutOfReachError as error:
        p.report.error(found, str(error))
    except SceneError as error:
        p.report.errors_of(found, SceneError([Issue("", i.message) for i in error.issues]))
    return None
