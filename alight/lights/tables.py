"""Lights as kernels see them: tables and samples."""

from __future__ import annotations

from collections import namedtuple

from alight.core.constants import INFINITY
from lanewise.jit import kernel
from lanewise.simd import lanes, lanes_mask, lanes_u32, lanes_vec3

#: info, data: a row a light; cdf: the choice of the light (a distribution, or a tree: see
#: `alight.lights.tree.traversal`), then one table a mesh light, the tables of lamps that have one,
#: and that of the environments' maps (see `alight.core.distributions`); map: the environments', see
#: `alight.lights.environment_map`; targets: see `alight.lights.targets`, empty where nobody aims.
#: Environments are the last lights.
LightTables = namedtuple("LightTables", "info data cdf map targets")

#: The same of scenes whose lights emit paths. emission: middle and radius of the scene's ball, the
#: choice of a light by its power, then tables of single lights; starts: where those begin, one word
#: a light; per_area: of each light on a shape, one over its area in m^2.
EmittingLights = namedtuple(
    "EmittingLights", (*LightTables._fields, "emission", "starts", "per_area")
)

#: Numbers of `EmittingLights.emission`.
MIDDLE, RADIUS, CHOICE = 0, 3, 4

#: Words of `LightTables.info` a light: kind, shape (of an environment: start of its map), texture
#: of the radiance + 1 (0: none), start of its table in cdf.
INFO = 4

#: Name in `Program.lights` next to the models: the radiance of an area light has a texture.
TEXTURED = "textured"

#: The same: points of an area light are chosen by its texture.
MAPPED = "mapped"

#: Numbers of `LightTables.data` a light: red, green and blue, probability of being chosen, and up
#: to twelve of its own, as `place` gave them.
STRIDE = 16

#: Of these, of a mapped area light: the word of `LightTables.cdf` at which its map begins, as bits,
#: and 1 where a list of such words begins there, one a triangle (`alight.lights.area_map`).
MAP_START, IS_LIST = 4, 5

#: Light arriving at a point from one chosen direction.
#: wi: unit direction to the light; distance: m, infinity for lights without a place; radiance: RGB
#: (for a delta light the irradiance on a surface that faces it); pdf: per solid angle, times the
#: probability of choosing this light, 0 if nothing can arrive; delta: mask, all light comes from
#: this one direction; cosine, error: at the light, for `alight.shapes.hit.shadow_length`.
LightSample = namedtuple("LightSample", "wi distance radiance pdf delta cosine error")

#: A ray of light on its way from a light into the scene. p: where it starts, on light from infinity
#: behind the whole scene; n: unit outer normal there, d where there is no surface; o: p moved off
#: the surface; d: unit direction; flux: W, RGB, the light that it carries: radiance times cosine
#: over all probabilities; light: row of the light; prim: triangle of its mesh; choice: probability
#: of that light, or of all that is around the scene; pdf_position: per square metre (across d, for
#: light from infinity); pdf_direction: per steradian; both are 1 where the masks delta_position and
#: delta_direction say that nothing was chosen.
Emission = namedtuple(
    "Emission",
    "p n o d flux light prim choice pdf_position pdf_direction delta_position delta_direction",
)


@kernel
def from_point(p, d, flux, pdf_direction):
    """The `Emission` of a light at the point p, before the choice of the light."""
    one, here = lanes(1.0), lanes_vec3(0.0) + p
    return Emission(
        p=here,
        n=d,
        o=here,
        d=d,
        flux=flux,
        light=lanes_u32(0),
        prim=lanes_u32(0),
        choice=one,
        pdf_position=one,
        pdf_direction=pdf_direction,
        delta_position=lanes_mask(True),
        delta_direction=lanes_mask(False),
    )


@kernel
def row_of(scene, back):
    """Offset in `LightTables.data` of an environment, the light number `back` from the end."""
    return scene.lights.data.size - STRIDE * back


@kernel
def from_infinity(wi, radiance, pdf):
    """The `LightSample` of an environment that can be hit."""
    one = lanes(1.0)
    return LightSample(
        wi=wi,
        distance=INFINITY * one,
        radiance=radiance,
        pdf=pdf,
        delta=lanes_mask(False),
        cosine=one,
        error=lanes(0.0),
    )
