"""``LightSource`` and ``AreaLightSource`` -> lights of the native format.

Amounts are multiplied by the exposure of the film, so that pictures have pbrt's values.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from alight.core.constants import LUMINANCE
from alight.core.errors import Issue, SceneError
from alight.formats.materials.textures import DARK, GREY_SKY
from alight.formats.pbrt.amounts import amount, placed, with_power
from alight.formats.pbrt.context import Context, Data
from alight.formats.pbrt.octahedral import to_latitude_longitude, to_sphere
from alight.formats.pbrt.parameters import Parameters
from alight.formats.pbrt.slides import goniometric, projection
from alight.formats.pbrt.textures import Source, bitmap
from alight.formats.pbrt.transforms import keeps_angles, turned_to
from alight.formats.reading.reach import OutOfReachError
from alight.formats.scenes.lamps import parallel, point, spot
from alight.scene import images
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


def _point(context: Context, p: Parameters, matrix: Matrix) -> Data:
    color = with_power(p, amount(context, p, "I"), "power", 4.0 * math.pi)
    place = _moved(matrix, p.triple("from", (0.0, 0.0, 0.0)))
    return placed(point(color), _at(place))


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
        p.report.warn(p.directive, "is stretched by its transformation: it stays round")
    light = spot(color, cone, cone - delta, "quartic" if context.old else "smooth")
    return placed(light, _at(_moved(matrix, start)) @ turn)


def _distant(context: Context, p: Parameters, matrix: Matrix) -> Data | None:
    color = with_power(p, amount(context, p, "L"), "illuminance", 1.0)
    start, target = p.triple("from", (0.0, 0.0, 0.0)), p.triple("to", (0.0, 0.0, 1.0))
    turn = _towards(p, matrix, target - start)
    return None if turn is None else placed(parallel(color), turn)


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


def area_light(context: Context, p: Parameters) -> Data:
    """Convert an ``AreaLightSource``; ``power`` beside the native keys: all that it shines with."""
    p.ignore("lights are chosen by their power", *_UNUSED)
    radiance = amount(context, p, "L")
    power = p.number("power", -1.0) * context.exposure
    if p.has("filename"):
        picture = bitmap(Source(context, p, {}), {"type": "bitmap", "wrap": "clamp"})
        if picture is not None:
            if power > 0.0 and "file" in context.tables["textures"][picture]:
                power /= _mean_luminance(context, context.tables["textures"][picture]["file"])
            return {"type": "area", "radiance": radiance, "power": power, "picture": picture}
    return {"type": "area", "radiance": radiance, "power": power}


def _mean_luminance(context: Context, file: str) -> float:
    """Mean luminance of a picture; 1 for a black one, and where it cannot be read."""
    try:
        texels = images.picture(file, context.reach.files).linear()
    except SceneError:
        # Compiling the scene reports it.
        return 1.0
    return float((np.broadcast_to(texels, (*texels.shape[:2], 3)) @ LUMINANCE).mean()) or 1.0


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
    # Light from far away has directions, and no place.
    linear = np.eye(4)
    linear[:3, :3] = matrix[:3, :3]
    matrix = linear
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
            node = placed(light, matrix @ _MAP_OF_3)
        else:
            image = images.picture(found.values[0], context.reach.files, p.report.approximate, path)
            if image.width == 2 * image.height and not p.has("illuminance"):
                text = (
                    "is not square: it is taken for a map of latitude and longitude, as in pbrt 3"
                )
                p.report.warn(found, text)
                file = context.reach.name_of(path)
                light = {"type": "environment", "file": file, "scale": color}
                return [0.0] * 3, placed(light, matrix @ _MAP_OF_3)
            square = _square(image)
            color = with_power(p, color, "illuminance", _illuminance(square))
            pixels = Image(to_latitude_longitude(square))
            light = {"type": "environment", "pixels": pixels, "scale": color}
            node = placed(light, matrix @ _MAP_OF_4)
    except OutOfReachError as error:
        p.report.lacks(found, error, DARK)
        if p.report.can_do_without(error):
            return GREY_SKY, None
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
    "goniometric": goniometric,
    "point": _point,
    "projection": projection,
    "spot": _spot,
}
