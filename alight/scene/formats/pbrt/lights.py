"""``LightSource`` and ``AreaLightSource`` -> lights of the native format.

Amounts are multiplied by the exposure of the film, so that pictures have pbrt's values.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from alight.core.errors import Issue, SceneError
from alight.scene.formats.pbrt.context import Context, Data
from alight.scene.formats.pbrt.octahedral import to_latitude_longitude, to_sphere
from alight.scene.formats.pbrt.parameters import Parameters
from alight.scene.formats.pbrt.pictured_lights import (
    LUMINANCE,
    goniometric,
    projection,
    shining_picture,
    shown,
    with_power,
)
from alight.scene.formats.pbrt.transforms import keeps_angles, steps, turned_to
from alight.scene.formats.reach import OutOfReachError
from alight.scene.images import read_image
from alight.textures.images import Image

Matrix = np.ndarray
MOST_SIDE = 2**13

# From the map of pbrt 3 to its light: our +y is its +z. The mirror turns the columns around.
_MAP_OF_3 = np.array(
    [[0.0, 0.0, -1.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
)
_MAP_OF_4 = np.array(
    [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
)
_UNUSED = ("nsamples", "samples", "visibleinreflections")


def light_node(context: Context, p: Parameters, matrix: Matrix) -> Data | None:
    """Convert a ``LightSource`` to a node with a light; None after a problem."""
    kind = p.directive.type
    if kind not in COVERED:
        p.report.unknown(p.directive, "light", kind, (*COVERED, "infinite"), "left out")
        p.forget()
        return None
    p.ignore("lights are chosen by their power", *_UNUSED)
    return COVERED[kind](context, p, matrix)


def amount(context: Context, p: Parameters, name: str) -> list[float]:
    """Ask for the light's colour, with ``scale`` and the film's exposure."""
    found = p.find(name)
    color = None if found is None else context.colors.read(found, "light")
    scale = p.find("scale")
    factor = [1.0] * 3
    if scale is not None:
        factor = context.colors.read(scale, "light") or factor
    color = color or [1.0] * 3
    found_amount = [c * f * context.exposure for c, f in zip(color, factor, strict=True)]
    if min(found_amount) < 0.0:
        p.report.error(p.directive, f"must not shine less than 0, got {min(found_amount):g}")
        return [0.0] * 3
    return found_amount


def _point(context: Context, p: Parameters, matrix: Matrix) -> Data:
    color = with_power(p, amount(context, p, "I"), "power", 4.0 * math.pi)
    place = _moved(matrix, p.triple("from", (0.0, 0.0, 0.0)))
    return _node({"type": "point", "intensity": color}, _at(place))


def _spot(context: Context, p: Parameters, matrix: Matrix) -> Data | None:
    cone = p.number("coneangle", 30.0)
    delta = p.number("conedeltaangle", p.number("conedelta", 5.0))
    if not 0.0 < cone <= 180.0 or not 0.0 <= delta <= cone:
        text = "coneangle must be in (0, 180] and conedeltaangle in [0, coneangle]"
        p.report.error(p.directive, f"{text}, got {cone:g} and {delta:g}")
        return None
    inner, outer = (math.cos(math.radians(a)) for a in (cone - delta, cone))
    whole = 2.0 * math.pi * ((1.0 - inner) + 0.5 * (inner - outer))
    color = with_power(p, amount(context, p, "I"), "power", whole)
    start, target = p.triple("from", (0.0, 0.0, 0.0)), p.triple("to", (0.0, 0.0, 1.0))
    turn = _towards(p, matrix, target - start)
    if turn is None:
        return None
    if not keeps_angles(matrix):
        p.report.approximated(p.directive, "is stretched by its transformation: it stays round")
    light = {
        "type": "spot",
        "intensity": color,
        "cutoff_angle": max(cone, 0.001),
        "beam_width": cone - delta,
        "falloff": "quartic" if context.old else "smooth",
    }
    return _node(light, _at(_moved(matrix, start)) @ turn)


def _distant(context: Context, p: Parameters, matrix: Matrix) -> Data | None:
    color = with_power(p, amount(context, p, "L"), "illuminance", 1.0)
    start, target = p.triple("from", (0.0, 0.0, 0.0)), p.triple("to", (0.0, 0.0, 1.0))
    turn = _towards(p, matrix, target - start)
    return None if turn is None else _node({"type": "directional", "irradiance": color}, turn)


def _goniometric(context: Context, p: Parameters, matrix: Matrix) -> Data | None:
    light = goniometric(context, p, amount(context, p, "I"))
    return None if light is None else _node(light, matrix)


def _projection(context: Context, p: Parameters, matrix: Matrix) -> Data | None:
    found = projection(context, p, amount(context, p, "I"))
    return None if found is None else _node(found[0], matrix @ found[1])


def _towards(p: Parameters, matrix: Matrix, direction: np.ndarray) -> Matrix | None:
    with np.errstate(over="ignore", invalid="ignore"):
        moved = matrix[:3, :3] @ direction
        length = float(np.linalg.norm(moved))
    if not 0.0 < length < math.inf:
        p.report.error(p.directive, "from and to must differ: there is no direction")
        return None
    return turned_to(moved)


def _moved(matrix: Matrix, point: np.ndarray) -> np.ndarray:
    return matrix[:3, :3] @ point + matrix[:3, 3]


def _at(point: np.ndarray) -> Matrix:
    result = np.eye(4)
    result[:3, 3] = point
    return result


def _node(light: Data, matrix: Matrix) -> Data:
    step = steps(matrix)
    return {"light": light} if step is None else {"transform": step, "light": light}


def area_light(context: Context, p: Parameters, area: Callable[[], float]) -> Data:
    """Convert an ``AreaLightSource``, except for what the size of its shape decides.

    Parameters
    ----------
    area : callable
        Gives that of all sides that shine, m^2; asked for where the light is given as power.
    """
    p.ignore("lights are chosen by their power", *_UNUSED)
    radiance = amount(context, p, "L")
    picture, luminance = shining_picture(context, p) or (None, 1.0)
    power = p.number("power", -1.0) * context.exposure
    if power > 0.0:
        whole = math.pi * area() * luminance
        radiance = [channel * power / whole if whole else channel for channel in radiance]
    shining = radiance if picture is None else shown(context, p, picture, radiance)
    return {"type": "area", "radiance": shining}


def surroundings(
    context: Context, p: Parameters, matrix: Matrix
) -> tuple[list[float], Data | None]:
    """Convert an infinite light.

    Returns
    -------
    constant : list of 3 floats
        Radiance that is the same from everywhere.
    node : dict or None
        With the light of a picture.
    """
    p.ignore("lights are chosen by their power", *_UNUSED)
    color = amount(context, p, "L")
    name = "mapname" if p.has("mapname") else "filename"
    found = p.values(name, "string", count=1)
    if found is None:
        return with_power(p, color, "illuminance", math.pi), None
    node: Data = {}
    try:
        path = context.reach.find(found.values[0])
        if context.old:
            file = context.reach.name_of(path)
            light: Data = {"type": "environment", "file": file, "scale": color}
            node = _node(light, matrix @ _MAP_OF_3)
        else:
            square = _square(read_image(path, found.values[0], p.report.approximate))
            color = with_power(p, color, "illuminance", _illuminance(square))
            pixels = Image(to_latitude_longitude(square))
            light = {"type": "environment", "pixels": pixels, "scale": color}
            node = _node(light, matrix @ _MAP_OF_4)
    except OutOfReachError as error:
        p.report.error(found, str(error))
    except SceneError as error:
        p.report.errors_of(found, error)
    return [0.0] * 3, node or None


def _square(image: Image) -> np.ndarray:
    texels = image.linear()
    if image.width != image.height or image.width > MOST_SIDE:
        text = f"must be a square of at most {MOST_SIDE} texels a side, which folds to a sphere"
        raise SceneError([Issue("", f"{text}, got {image.width}x{image.height}")])
    return np.broadcast_to(texels, (*texels.shape[:2], 3))


def _illuminance(square: np.ndarray) -> float:
    """Luminance from above, weighted by the cosine, as pbrt sums it up over the upper half."""
    n = len(square)
    middle = (np.arange(n) + 0.5) / n
    z = to_sphere(np.stack(np.meshgrid(middle, middle), axis=-1))[..., 2]
    return float((np.maximum(z, 0.0) * (square @ LUMINANCE)).sum()) * 2.0 * math.pi / (n * n)


#: Lights of pbrt with a place of their own.
COVERED: dict[str, Callable[[Context, Parameters, Matrix], Data | None]] = {
    "distant": _distant,
    "goniometric": _goniometric,
    "point": _point,
    "projection": _projection,
    "spot": _spot,
}
