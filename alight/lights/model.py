"""What the renderer takes from the file of a light."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from alight.core.constants import PI
from alight.core.field_types import Triple
from alight.core.registry import Kernel, Record, Records
from alight.core.spec import Light, Texture
from alight.lights.bright_disk import Disk
from alight.lights.environment_map import EnvironmentMap


def no_texture(spec: Any) -> Texture | None:
    """The same radiance everywhere."""
    return None


def no_window(numbers: np.ndarray) -> float:
    """It is not one."""
    return 0.0


def all_around(numbers: np.ndarray) -> float:
    """Its light may come from any direction."""
    return 1.0


def nothing_beside(spec: Any) -> Triple:
    """All of it is in the map."""
    return (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False, kw_only=True)
class LightModel(Record):
    """A light at a point, on a shape, or around the scene, as its `placement` says.

    Attributes
    ----------
    DELTA : bool
        Rays cannot hit it: only light sampling finds it.
    INFINITELY_FAR : bool
        Of a light that is DELTA: it has a direction and no place.
    place : (spec, (4, 4) float64) -> (triple, (n,) float64)
        Colour, and up to twelve numbers for its kernels, from the matrix object to world. Those of
        a light that is DELTA begin with the point where it is, or if it is infinitely far, with the
        unit direction to it.
    power : (luminance, area, radius) -> float
        Emitted power in W, where the mean colour has that luminance, its shape has that area in m^2
        and the scene that radius in m.
    sample : kernel ``(scene, index, p, u, u2) -> LightSample``
        See `alight.lights.area.sample`. Lights around the scene get their number from the end in
        the place of the index.
    pdf : kernel
        Density of `sample` per solid angle. On a shape: ``(scene, index, p, hit)`` of a
        `ShapeHit`; around the scene: ``(scene, back, p, d)``.
    emitted : kernel ``(scene, index, surface, wo)``
        On a shape: radiance on the outer side along the unit vector wo.
    radiance : kernel ``(scene, back, d)``
        Around the scene: what arrives from the unit direction d, without the light's colour. If it
        has none, the light cannot be seen.
    mean_color : (spec) -> triple
        Of all that is emitted, where that is not the colour.
    cone : (spec) -> (float, float)
        Half angle of the directions that it faces, and how far beyond them it is dark, radians: at
        a point, around +z of its node; on a shape, around its normals. Without it a light at a
        point has no place in a light tree.
    table : (spec) -> (n,) float32
        Further numbers, in `LightTables.cdf`.
    emit : kernel ``(scene, index, u2, v2) -> Emission``
        At a point: a ray of its light, its flux over the light's colour; u2 and v2 are uniform
        pairs. Without it no light path starts there.
    emit_pdf : kernel ``(scene, index, d)``
        At a point: density of `emit` for the unit direction d, per steradian; 1 if there is one.
    emission_table : (spec) -> (n,) float32
        At a point: numbers for both, in `EmittingLights.emission`.
    texture : (spec) -> Texture or None
        On a shape: of its radiance, in the place of the colour.
    IS_MAPPED : bool
        On a shape: its points are chosen by that texture, see `alight.lights.area_map`; numbers 0
        and 1 of its own are those of the map.
    map_of : (spec, (4, 4) float64, bool) -> EnvironmentMap
        Around the scene: its picture; the last argument leaves light to BSDF sampling.
    beside_the_map : (spec) -> triple
        Mean over all directions of what is not in it.
    disk_of : (spec, (4, 4) float64) -> Disk or None
        Around the scene: a part that is so small and bright that paths may aim at it.
    left_out : kernel ``(scene, back)``
        Around the scene: share of its light that `sample` leaves to BSDF sampling; none by default.
    window : (numbers) -> float
        Area in m^2 of an opening through which the other lights around the scene are sampled.
    window_point : kernel ``(scene, back, u2)``
        A point of that opening, uniform by area.
    window_pdf : kernel ``(scene, back, o, d)``
        How densely lines along the unit vector d go through such points, per square metre across d:
        that of the line through o.
    share_all_around : (numbers) -> float
        Share of its samples that such windows may take over.
    """

    DELTA: bool
    place: Callable[[Any, np.ndarray], tuple[Triple, np.ndarray]]
    power: Callable[[float, float, float], float]
    sample: Kernel
    INFINITELY_FAR: bool = False
    pdf: Kernel | None = None
    emitted: Kernel | None = None
    radiance: Kernel | None = None
    mean_color: Callable[[Any], Triple] | None = None
    cone: Callable[[Any], tuple[float, float]] | None = None
    table: Callable[[Any], np.ndarray] | None = None
    emit: Kernel | None = None
    emit_pdf: Kernel | None = None
    emission_table: Callable[[Any], np.ndarray] | None = None
    texture: Callable[[Any], Texture | None] = no_texture
    IS_MAPPED: bool = False
    map_of: Callable[[Any, np.ndarray, bool], EnvironmentMap] | None = None
    beside_the_map: Callable[[Any], Triple] = nothing_beside
    disk_of: Callable[[Any, np.ndarray], Disk | None] | None = None
    left_out: Kernel | None = None
    window: Callable[[np.ndarray], float] = no_window
    window_point: Kernel | None = None
    window_pdf: Kernel | None = None
    share_all_around: Callable[[np.ndarray], float] = all_around

    @property
    def is_around(self) -> bool:
        """Whether it is at infinity."""
        return self.spec.placement == "environment"

    @property
    def is_on_shape(self) -> bool:
        """Whether a shape shines."""
        return self.spec.placement == "shape"

    def mean(self, spec: Light) -> Triple:
        """Mean colour of all that is emitted."""
        return self.mean_color(spec) if self.mean_color else self.place(spec, np.eye(4))[0]

    def dark_beyond(self, spec: Light) -> float:
        """On a shape: the angle from the normal at which it is dark, radians."""
        return sum(self.cone(spec)) if self.cone else 0.5 * PI


#: All lights, by name.
LIGHTS = Records("lights", LightModel)
