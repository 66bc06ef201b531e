"""How much a light of pbrt shines, and where it stands."""

from __future__ import annotations

import numpy as np

from alight.formats.pbrt.context import Context, Data
from alight.formats.pbrt.parameters import Parameters
from alight.formats.pbrt.transforms import steps


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


def with_power(p: Parameters, color: list[float], name: str, whole: float) -> list[float]:
    """Scale a light whose colour has the luminance 1 so that all of it is what the file asks."""
    power = p.number(name, -1.0)
    if power <= 0.0 or whole <= 0.0:
        return color
    return [channel * power / whole for channel in color]


def placed(light: Data, matrix: np.ndarray) -> Data:
    """A node with a light."""
    step = steps(matrix)
    return {"light": light} if step is None else {"transform": step, "light": light}
