"""Shaders of which all is scattered below the surface -> `subsurface`, on closed shapes.

Source: the documentation of MaterialX for ``subsurface_bsdf``, whose radius is a mean free path.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from alight.formats.materials.surfaces import index_of, reflectance
from alight.formats.materialx.shading import Data, Shading, is_one, is_zero
from alight.formats.materialx.values import Plain, Value, Varying

#: The least and the largest radius, metres.
LEAST_RADIUS, MOST_RADIUS = 1e-12, 1e9
DIFFUSE = "subsurface: no light wanders below the surface; its colour is diffuse"


@dataclass(frozen=True)
class Below:
    """What a shader says of what is below its surface.

    Attributes
    ----------
    weight, color, radius : Value
    scale : Value
        Of the radius.
    anisotropy, roughness, specular, specular_color : Value
    ior : float
    others : tuple of Value
        Weights of what a body cannot have.
    """

    weight: Value
    color: Value
    radius: Value
    scale: Value
    anisotropy: Value
    roughness: Value
    specular: Value
    specular_color: Value
    ior: float
    others: tuple[Value, ...]


def body_of(s: Shading, below: Below, opacity: Any, thin: bool) -> Data | None:
    """A body, where the shader is one and nothing else; None, with a remark, where it is not."""
    if is_zero(below.weight):
        return None
    radius, scale = below.radius, below.scale
    alone = is_one(below.weight) and all(map(is_zero, below.others)) and opacity == 1.0 and not thin
    if not alone or isinstance(radius, Varying) or isinstance(scale, Varying):
        s.say(DIFFUSE)
        return None
    free = [
        min(max(s.meters * a * b, LEAST_RADIUS), MOST_RADIUS)
        for a, b in zip(_three(radius), _three(scale), strict=True)
    ]
    ior = below.ior
    if isinstance(below.specular, Varying):
        s.say("the reflection of a body has one strength: that of its index is taken")
    elif below.specular.numbers[0] != 1.0:
        ior = index_of(min(max(below.specular.numbers[0], 0.0), 1.0) * reflectance(ior))
    if not is_one(below.specular_color):
        s.say("the colour of a body's reflection is left out")
    if not is_zero(below.anisotropy):
        s.say("light is scattered alike to all sides in a body")
    roughness = 0.5
    if isinstance(below.roughness, Varying):
        s.say(f"the roughness of a body must not vary: {roughness} is taken")
    else:
        roughness = min(max(below.roughness.numbers[0], 0.0), 1.0)
    return {
        "type": "subsurface",
        "color": s.color("subsurface_color", below.color),
        "radius": free,
        "ior": ior,
        "roughness": roughness,
    }


def _three(value: Plain) -> tuple[float, ...]:
    return value.numbers * 3 if value.width == 1 else value.numbers
