r"""Surfaces of metal, plastic and glass, as OBJ, glTF and USD describe them -> ours.

A file's material is read into one `Surface`, which becomes a material of the native format here:
the core, normally `principled`; around it what bends its normals; both sides of what does not
refract; and what is cut out of it.

Source: Born and Wolf, Principles of Optics, section 1.5, for the reflectance straight on,
:math:`((n - 1)^2 + k^2) / ((n + 1)^2 + k^2)`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from alight.formats.geometry.displacement import Heights
from alight.formats.materials.textures import by_vertices

Data = dict[str, Any]
#: The largest index of refraction of `principled`, and its reflectance straight on.
LARGEST_IOR = 5.0
BRIGHTEST = 4.0 / 9.0
#: Indices of glass differ from 1 by this at least, and the largest Abbe number of a material.
LEAST_PART, LARGEST_ABBE = 1e-3, 1e3
#: What reflects less is taken for this dark, so that a tint can be divided by it.
_DARKEST = 1e-4


def reflectance(eta: float, k: float = 0.0) -> float:
    """What a surface with an index of refraction reflects of light that meets it straight on."""
    return min(1.0, ((eta - 1.0) ** 2 + k * k) / ((eta + 1.0) ** 2 + k * k))


def index_of(reflected: float) -> float:
    """The index of refraction, at least 1, that reflects a part of the light straight on."""
    root = math.sqrt(reflected)
    return (1.0 + root) / (1.0 - root) if root < 1.0 else math.inf


def abbe_number(number: float, ior: float) -> float:
    """The nearest Abbe number with which `principled` is given an index of refraction; 0 if none.

    Parameters
    ----------
    number : float
        What a file asks for; 0 or infinity: no dispersion.
    ior : float
        Index at the line d.
    """
    if number <= 0.0 or not math.isfinite(number) or ior - 1.0 < 2.0 * LEAST_PART:
        return 0.0
    # The index at 380 nm is larger by that many times (ior - 1) / V.
    least = max(1.0, 2.12 * (ior - 1.0) / max(LARGEST_IOR - ior, LEAST_PART))
    return min(max(number, least), LARGEST_ABBE) if least <= LARGEST_ABBE else 0.0


@dataclass(frozen=True)
class Reflection:
    """A coloured reflection straight on, as an index of refraction and a tint.

    Attributes
    ----------
    strength : float
        What the index reflects; at most `BRIGHTEST`.
    ior : float
    tint : list of float
    is_weaker : bool
        Whether a part of the reflection is lost because no such index is known.
    """

    strength: float
    ior: float
    tint: list[float]
    is_weaker: bool


def reflection(color: Sequence[float]) -> Reflection:
    """Take a colour of what is reflected straight on apart."""
    strength = min(max(*color, _DARKEST), BRIGHTEST)
    tint = [channel / strength for channel in color]
    return Reflection(strength, index_of(strength), tint, max(color) > strength)


def is_metal(diffuse: Any, specular: Sequence[float]) -> bool:
    """Whether a matte and a shiny colour are a metal's: black, and too strong for any index.

    `metallic` then has the shiny colour exactly, as its own.
    """
    is_black = isinstance(diffuse, list) and max(diffuse) == 0.0
    return is_black and max(specular) > BRIGHTEST


def two_sided(bsdf: Data) -> Data:
    """Make a material look the same from both sides."""
    return {"type": "two_sided", "bsdf": bsdf}


@dataclass(frozen=True)
class Surface:
    """What a material of a file says.

    Attributes
    ----------
    core : dict
        Description of the material itself, without wrappers.
    bent : dict or None
        Normal or bump map around it, without what it wraps.
    opacity : number or texture
    emission : color, texture or None
        Radiance of the surfaces that have it, W/(m^2 sr).
    is_unlit : bool
        Whether it shows its colour without light.
    sets : tuple
        Sets of texture coordinates that its textures use, by their numbers or names; the first is
        the mesh's own, by which normals are bent.
    place : str
        Where the file defines it.
    inside : dict or None
        Description in the place of `core` on closed shapes, which light enters to be scattered.
    heights : Heights or None
        How far it lifts the surface.
    """

    core: Data
    bent: Data | None = None
    opacity: Any = 1.0
    emission: Any = None
    is_unlit: bool = False
    sets: tuple[Any, ...] = ()
    place: str = ""
    inside: Data | None = None
    heights: Heights | None = None

    def on(self, closed: bool) -> Surface:
        """What it is on a shape that is closed, or on one that is not."""
        if self.inside is None:
            return self
        return replace(self, core=self.inside if closed else self.core, inside=None)

    @property
    def bsdf(self) -> Data:
        """Description of the native format."""
        bsdf = self.core if self.bent is None else {**self.bent, "bsdf": self.core}
        has_sides = "transmission" in self.core or "radius" in self.core
        if not self.is_unlit and not has_sides:
            bsdf = two_sided(bsdf)
        if self.opacity != 1.0:
            bsdf = {"type": "mask", "opacity": self.opacity, "bsdf": bsdf}
        return bsdf

    @property
    def light(self) -> Data:
        """What a node of it has beside shape and material: its light, if it shines."""
        if self.emission is None:
            return {}
        return {"light": {"type": "area", "radiance": self.emission}}


def tinted(surface: Surface) -> Surface:
    """The surface with the colours of its vertices over its own."""
    color = by_vertices(surface.core["base_color"])
    return replace(surface, core={**surface.core, "base_color": color})


def plain_surface(has_colors: bool) -> Surface:
    """What a mesh without a material has: the colours of its vertices, or grey."""
    color = {"type": "vertex_color", "fallback": 0.6} if has_colors else 0.6
    return Surface({"type": "principled", "base_color": color, "roughness": 0.6})
