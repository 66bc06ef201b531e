"""Lights of pbrt that shine a picture: projectors, lamps with a profile, shapes, and portals.

Pictures are linear light times ``scale``; with ``power``, as bright as gives that much light.
"""

from __future__ import annotations

import math

import numpy as np

from alight.core.errors import SceneError
from alight.lights import ies, projector
from alight.lights.ies import LUMENS
from alight.scene.formats.pbrt.context import Context, Data
from alight.scene.formats.pbrt.octahedral import to_square
from alight.scene.formats.pbrt.parameters import Parameters
from alight.scene.formats.pbrt.textures import Source, Value, entry, product
from alight.scene.formats.pbrt.transforms import Matrix, steps
from alight.scene.formats.reach import OutOfReachError
from alight.scene.images import read_image
from alight.textures.images import Image

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
#: Degrees between the directions at which profiles are looked up, and how many those are.
STEP = 2.0
_POLAR, _AZIMUTHS = 91, 181
#: How far the corners of a portal may be from a rectangle's, of its size.
SKEW = 1e-3


def picture_of(context: Context, p: Parameters, *names: str) -> tuple[Image, str] | None:
    """The picture of a light and the name of its file; None if there is none."""
    name = next((name for name in names if p.has(name)), names[0])
    found = p.values(name, "string", count=1)
    if found is None:
        return None
    try:
        path = context.reach.find(found.values[0])
        image = read_image(path, found.values[0], p.report.approximate)
        return image, context.reach.name_of(path)
    except OutOfReachError as error:
        p.report.error(found, str(error))
    except SceneError as error:
        p.report.errors_of(found, error)
    return None


def with_power(p: Parameters, color: list[float], name: str, whole: float) -> list[float]:
    """Scale a light whose colour has the luminance 1 so that all of it is what the file asks."""
    power = p.number(name, -1.0)
    if power <= 0.0 or whole <= 0.0:
        return color
    return [channel * power / whole for channel in color]


def _luminance(texels: np.ndarray) -> float:
    """Mean luminance of a picture's texels."""
    return float((np.broadcast_to(texels, (*texels.shape[:2], 3)) @ LUMINANCE).mean())


def projection(context: Context, p: Parameters, color: list[float]) -> tuple[Data, Matrix] | None:
    """A ``projection`` light, and the matrix from our projector to it.

    In both the picture's top is towards +y; pbrt's left edge is towards -x, ours towards +x. In
    pbrt 3 it stands upside down.
    """
    fov = p.number("fov", 45.0 if context.old else 90.0)
    if not 0.0 < fov < 180.0:
        p.report.error(p.named["fov"], f"must be in (0, 180) degrees, got {fov:g}")
        return None
    found = picture_of(context, p, "filename", "mapname")
    if found is None:
        if not p.has("filename") and not p.has("mapname"):
            p.report.error(p.directive, 'needs "string filename"')
        return None
    image, file = found
    height, width = image.texels.shape[:2]
    # Given across the shorter side.
    across = math.tan(math.radians(0.5 * fov)) * max(width / height, 1.0)
    light: Data = {
        "type": "projector",
        "fov": math.degrees(2.0 * math.atan(across)),
        "evenness": "intensity",
    }
    if p.has("power"):
        shape = {key: light[key] for key in ("fov", "evenness")}
        mean = projector.mean_color(projector.Projector(pixels=image, **shape))
        color = with_power(p, color, "power", 4.0 * math.pi * float(mean @ LUMINANCE))
    if not context.old:
        p.report.approximated(p.directive, "interpolates between the texels of its picture")
    return (
        {**light, "file": file, "scale": color},
        np.diag([-1.0, -1.0 if context.old else 1.0, 1.0, 1.0]),
    )


def goniometric(context: Context, p: Parameters, color: list[float]) -> Data | None:
    """A ``goniometric`` light: a point, whose picture says how bright it is to which side."""
    if not p.has("filename") and not p.has("mapname"):
        color = with_power(p, color, "power", 4.0 * math.pi)
        return {"type": "point", "intensity": color}
    found = picture_of(context, p, "filename", "mapname")
    if found is None:
        return None
    texels = found[0].linear()
    if not context.old and texels.shape[0] != texels.shape[1]:
        size = f"{texels.shape[1]}x{texels.shape[0]}"
        p.report.error(p.directive, f"needs a square picture, which folds to a sphere, got {size}")
        return None
    if texels.shape[2] == 3 and np.ptp(texels, axis=2).max() > 1e-3 * max(texels.max(), 1e-30):
        p.report.approximated(p.directive, "has a picture with colours: their mean is taken")
    texels = texels.mean(axis=2).astype(np.float64)
    polar = np.radians(STEP * np.arange(_POLAR))
    azimuth = np.radians(STEP * np.arange(_AZIMUTHS))[:, None]
    across = np.sin(polar)
    x, y = across * np.cos(azimuth), across * np.sin(azimuth)
    z = np.broadcast_to(np.cos(polar), x.shape)
    shown = _on_map_of_3(texels, x, y, z) if context.old else _on_square(texels, x, y, z)
    p.report.approximated(p.directive, f"is looked up every {STEP:g} degrees")
    light: Data = {
        "vertical_angles": [STEP * i for i in range(_POLAR)],
        "horizontal_angles": [STEP * i for i in range(_AZIMUTHS)],
        "candela": (LUMENS * shown).tolist(),
    }
    mean = ies.mean_color(ies.Ies(**light))[0]
    color = with_power(p, color, "power", 4.0 * math.pi * mean)
    return {"type": "ies", **light, "scale": color}


def _on_square(texels: np.ndarray, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """The texels of pbrt 4's picture, whose pole is the light's +y."""
    n = len(texels)
    at = np.clip((to_square(np.stack([x, z, y], axis=-1)) * n).astype(int), 0, n - 1)
    return texels[at[..., 1], at[..., 0]]


def _on_map_of_3(texels: np.ndarray, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """The texels of pbrt 3's map of latitude and longitude around +y."""
    height, width = texels.shape
    column = np.arctan2(z, x) % (2.0 * np.pi) * (width / (2.0 * np.pi))
    row = np.arccos(np.clip(y, -1.0, 1.0)) * (height / np.pi)
    return texels[
        np.minimum(row.astype(int), height - 1), np.minimum(column.astype(int), width - 1)
    ]


def shining_picture(context: Context, p: Parameters) -> tuple[str, float] | None:
    """The bitmap that an area light shows, as a texture's name, and its mean luminance."""
    if not p.has("filename"):
        return None
    key = "shining picture", *map(str, p.named["filename"].values)
    if key in context.loaded:
        p.find("filename")
        return context.loaded[key]
    found = picture_of(context, p, "filename")
    if found is None:
        return None
    image, file = found
    data = {"type": "bitmap", "file": file, "wrap": "clamp"}
    context.loaded[key] = entry(Source(context, p, {}), data), _luminance(image.linear())
    return context.loaded[key]


def shown(context: Context, p: Parameters, picture: str, factor: list[float]) -> Value:
    """A texture for the radiance: a picture times a colour."""
    return product(Source(context, p, {}), picture, factor)


def portal(p: Parameters, matrix: Matrix) -> Data | None:
    """The node of an infinite light's portal: four corners, one after another."""
    corners = p.table("portal", "point")
    if corners is None:
        return None
    if corners.shape[0] != 4:
        p.report.error(p.named["portal"], f"must have 4 corners, got {corners.shape[0]}")
        return None
    a, b, c, d = corners @ matrix[:3, :3].T + matrix[:3, 3]
    x, y = 0.5 * (b - a), 0.5 * (d - a)
    size = max(float(np.linalg.norm(x)), float(np.linalg.norm(y)))
    flat = np.linalg.norm(a + c - b - d) <= SKEW * size and abs(x @ y) <= SKEW * size * size
    normal = np.cross(x, y)
    if not flat or not np.linalg.norm(normal) > 0.0:
        p.report.error(p.named["portal"], "must be a rectangle, corner after corner")
        return None
    made = np.eye(4)
    made[:3, 0], made[:3, 1], made[:3, 2] = x, y, normal / np.linalg.norm(normal) * size
    made[:3, 3] = 0.25 * (a + b + c + d)
    text = "light that does not come through its portal counts, too"
    p.report.approximated(p.directive, text)
    return {"light": {"type": "portal"}, "transform": steps(made)}
