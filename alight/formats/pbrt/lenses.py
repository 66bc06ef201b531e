r"""The lenses of pbrt's ``realistic`` camera -> one thin lens, as rays near the axis see them.

At a surface of radius R from index n to n' a ray of height y and slope u goes on with

.. math:: n' u' = n u - y\, (n' - n) / R, \qquad y \leftarrow y + t u'

to the next surface at distance t. A ray that comes in parallel to the axis at height 1 gives the
focal length f = -1 / u', and by its height at the stop the radius a of the lens that the scene
sees. Focused at d, the film stands at v = f d / (d - f), and the light on it is
:math:`\pi a^2 / v^2` of the radiance, by which pbrt 4 multiplies. Distortion, curved fields and the
dark corners of the lens are left out.

Source: Hecht, Optics, section 6.1; PBR4 section 5.4 (online) for the camera's units.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from alight.core.errors import SceneError, quote
from alight.formats.pbrt.context import Context
from alight.formats.pbrt.parameters import Parameters
from alight.formats.reading.packed import content_of
from alight.formats.reading.reach import OutOfReachError
from alight.formats.scenes.cameras import Perspective, angle_of

MOST_BYTES, MOST_SURFACES = 2**20, 1000
_COLUMNS = 4
MILLIMETRE = 1e-3


@dataclass(frozen=True)
class Lens:
    """A thin lens.

    Attributes
    ----------
    focal_length, radius : float, metres
    """

    focal_length: float
    radius: float


def lens_of(surfaces: np.ndarray, stop_diameter: float) -> Lens:
    """The thin lens that a row of surfaces acts as.

    Parameters
    ----------
    surfaces : (n, 4) float64
        From the scene to the film: radius of curvature (0: the stop), distance to the next one,
        index of what follows (0 counts as 1), diameter; lengths in millimetres.
    stop_diameter : float, millimetres
        Of the stop, at most that of the file.

    Raises
    ------
    ValueError
        If they do not bring light together.
    """
    y, u, n = 1.0, 0.0, 1.0
    radius = math.inf
    for curvature, distance, index, diameter in surfaces:
        if curvature == 0.0:
            # Rays through the edge of the stop decide how much of the scene's light comes in.
            edge = 0.5 * min(stop_diameter, diameter or math.inf)
            radius = min(radius, edge / max(abs(y), 1e-9))
        else:
            after = index or 1.0
            u = (n * u - y * (after - n) / curvature) / after
            n = after
        y += distance * u
    if not u < -1e-9:
        raise ValueError("its surfaces do not bring light together")
    if math.isinf(radius):
        radius = 0.5 * min(stop_diameter, float(surfaces[0, 3]) or math.inf)
    return Lens(MILLIMETRE / -u, MILLIMETRE * radius)


def realistic(
    context: Context, p: Parameters, width: int, height: int, diagonal: float
) -> Perspective:
    """Convert the camera's lenses; a field of view of 90 degrees after a problem.

    Parameters
    ----------
    width, height : int
        Of the picture.
    diagonal : float, millimetres
        Of the film.
    """
    usual = Perspective(90.0)
    stop = p.positive("aperturediameter", 1.0)
    distance = p.positive("focusdistance", 10.0)
    p.leave_out("the stop is round", "aperture")
    simple = p.flag("simpleweighting", True)
    p.ignore("rays are even over the lens", "simpleweighting")
    surfaces = _surfaces(context, p)
    if surfaces is None:
        return usual
    try:
        lens = lens_of(surfaces, stop)
    except ValueError as error:
        p.report.error(p.named["lensfile"], str(error))
        return usual
    if distance <= lens.focal_length:
        wanted = f"must be above the focal length, {lens.focal_length:g} m, got {distance:g}"
        p.report.error(p.named.get("focusdistance", p.directive), wanted)
        return usual
    image = lens.focal_length * distance / (distance - lens.focal_length)
    half = 0.5 * MILLIMETRE * diagonal * height / math.hypot(width, height)
    if not (context.old and simple):
        context.exposure *= math.pi * (lens.radius / image) ** 2
    shown = f"one thin lens of {lens.focal_length / MILLIMETRE:.3g} mm is taken"
    text = f"{shown}, without distortion and dark corners"
    context.report.warn(p.directive, f"is made of {len(surfaces)} surfaces: {text}")
    return Perspective(angle_of(2.0 * half, image), "y", lens.radius, distance)


def _surfaces(context: Context, p: Parameters) -> np.ndarray | None:
    """Read the file of the lenses; None after a problem."""
    found = p.values("lensfile", "string", count=1)
    if found is None:
        if not p.has("lensfile"):
            p.report.error(p.directive, 'needs "string lensfile"')
        return None
    name = found.values[0]
    try:
        content = content_of(context.reach.find(name), MOST_BYTES).decode("utf-8", "replace")
        lines = (line.partition("#")[0] for line in content.splitlines())
        numbers = np.array([float(word) for line in lines for word in line.split()])
    except (OutOfReachError, SceneError) as error:
        p.report.error(found, str(error))
        return None
    except ValueError as error:
        p.report.error(found, f"{quote(name)} must hold numbers: {error}")
        return None
    if not numbers.size or numbers.size % _COLUMNS or numbers.size > _COLUMNS * MOST_SURFACES:
        text = f"must hold {_COLUMNS} numbers for each of 1 to {MOST_SURFACES} surfaces"
        p.report.error(found, f"{quote(name)} {text}, got {numbers.size}")
        return None
    if not np.isfinite(numbers).all():
        p.report.error(found, f"{quote(name)} must hold finite numbers")
        return None
    return numbers.reshape(-1, _COLUMNS)
