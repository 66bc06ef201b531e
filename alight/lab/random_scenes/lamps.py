"""Lights of any registered model, as bright as the picture needs them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from alight.core.registry import Models as Registry
from alight.core.spec import Light, Texture
from alight.lab.random_scenes.chance import Chance
from alight.lab.random_scenes.descriptions import any_texture, of_model
from alight.lab.random_scenes.materials import UNIT
from alight.lab.random_scenes.pictures import surroundings
from alight.lab.random_scenes.views import Point
from alight.lights.ies import LUMENS
from alight.scene.transform import Transform, look_at, rotate
from alight.textures.images import Image

#: Irradiance in W/m^2 at scale 1 on what faces the light of a clear day.
_DAYLIGHT = {"sun": 140.0, "sky": 30.0, "sunsky": 150.0}
#: The sun's place is given by its direction.
_NO_DATE = {"time": None, "latitude": None, "longitude": None}


def models_at(placement: str) -> list[str]:
    """Names of the lights that belong to a node, a shape, or the surroundings."""
    return [
        name
        for name, module in Registry("lights").items()
        if type(module.EXAMPLES[0]).placement == placement and name != "portal"
    ]


def small_lamp(
    chance: Chance, distance: float, irradiance: float, names: list[str] | None = None
) -> Light:
    """A light without a size that gives this many W/m^2 on its axis at some distance."""
    name = chance.choose(names or models_at("node"))
    spec = _lit(chance, of_model(chance, Registry("lights")[name]))
    fields = dict(spec)
    tint = np.array(chance.color(0.6, 1.0))
    if "irradiance" in fields:
        return spec.replaced(irradiance=_short(irradiance * tint))
    if "intensity" in fields:
        if "cutoff_angle" in fields and spec.cutoff_angle < 10.0:
            spec = spec.replaced(cutoff_angle=chance.within(10.0, 60.0), beam_width=None)
        return spec.replaced(intensity=_short(irradiance * distance**2 * tint))
    if "candela" in fields:
        peak = max(map(max, spec.candela)) / LUMENS
        return spec.replaced(scale=_short(irradiance * distance**2 / peak * tint))
    if "pixels" in fields and "scale" in fields:
        mean = _mean(spec.pixels)
        return spec.replaced(scale=_short(irradiance * distance**2 / mean * tint))
    return spec


def glow(chance: Chance, radiance: float, textured: float = 0.1) -> Light:
    """Light of a shape: any area light model, of this many W/(m^2 sr) on average."""
    name = chance.choose(models_at("shape"))
    spec = of_model(chance, Registry("lights")[name])
    if "radiance" not in dict(spec):
        return spec
    texture = any_texture(chance, UNIT, 1) if chance.happens(textured) else None
    if texture is not None and max(texture.mean()) > 0.05:
        return spec.replaced(radiance=_brighter(texture, radiance / max(texture.mean())))
    return spec.replaced(radiance=_short(radiance * np.array(chance.color(0.5, 1.0))))


def surround(
    chance: Chance,
    irradiance: float,
    contrast: float,
    names: list[str] | None = None,
    *,
    turn: float | None = None,
) -> Light:
    """Light from all sides, of some W/m^2 on what faces most of it.

    Parameters
    ----------
    chance : Chance
    irradiance : float, W/m^2
    contrast : float
        Light of the brightest texels of a map over that of all others.
    names : list of str, optional
        Models to choose from.
    turn : float, radians, optional
        About where the brightest part is, from +x towards +z; anywhere by default.
    """
    name = chance.choose(names or models_at("environment"))
    spec = _lit(chance, of_model(chance, Registry("lights")[name]))
    fields = dict(spec)
    if name in _DAYLIGHT:
        spec = spec.replaced(scale=_short(irradiance / _DAYLIGHT[name] * np.ones(3)))
        if turn is not None or fields["sun_direction"] is not None:
            spec = spec.replaced(sun_direction=_to_sun(chance, turn), **_NO_DATE)
        return spec
    if "pixels" in fields:
        # The bright texels are all above: what faces them gets their light from all of the sphere.
        gain = math.pi * (1.0 + 2.0 * contrast) / (1.0 + contrast)
        scale = irradiance / gain * np.array(chance.color(0.7, 1.0))
        pixels = surroundings(chance, contrast, turn)
        rotate = 0.0 if turn is not None else fields.get("rotate", 0.0)
        return spec.replaced(pixels=pixels, scale=_short(scale), rotate=rotate)
    if "radiance" in fields:
        return spec.replaced(
            radiance=_short(irradiance / math.pi * np.array(chance.color(0.5, 1.0)))
        )
    return spec


def _to_sun(chance: Chance, turn: float | None) -> tuple[float, ...]:
    """A direction to the sun, 10 to 70 degrees above the horizon; lower where it looks in."""
    height = chance.within(0.2, 1.2 if turn is None else 0.7)
    around = chance.within(-math.pi, math.pi) if turn is None else turn + chance.within(-0.5, 0.5)
    return _short(np.array([math.cos(around), math.tan(height), math.sin(around)]))


def _lit(chance: Chance, spec: Any) -> Any:
    """The first of the model's examples instead of a black one."""
    if not spec.is_black:
        return spec
    examples = [e for e in Registry("lights")[spec.type_name()].EXAMPLES if not e.is_black]
    return chance.choose(examples) if examples else spec


def _brighter(texture: Texture, factor: float) -> Texture:
    multiply = Registry("textures").get("multiply")
    if multiply is None:
        return texture
    spec: Any = multiply.EXAMPLES[0]
    return spec.replaced(a=texture, b=_short(np.full(3, factor)))


def _mean(pixels: Image) -> float:
    """Mean of a picture; float texels are linear, whole ones are taken as they are."""
    return max(max(pixels.mean("auto")), 1e-3)


def _short(values: np.ndarray) -> tuple[float, ...]:
    return tuple(float(f"{value:.4g}") for value in values)


def aimed(chance: Chance, at: Point, target: Point) -> Transform:
    """Stand somewhere and shine along +z towards another place, turned about that axis."""
    view = look_at(at, target, up=(0.0, 0.0, 1.0) if at[0] == target[0] else (0.0, 1.0, 0.0))
    # Cameras look along -z, lamps shine along +z.
    return view @ rotate("y", 180.0) @ rotate("z", chance.within(-180.0, 180.0))
