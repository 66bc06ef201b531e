"""Lights as kernels see them: tables and samples."""

from __future__ import annotations

from collections import namedtuple

from alight.core.constants import INFINITY
from lanewise.jit import kernel
from lanewise.simd import lanes, lanes_mask

#: info, data: a row a light; cdf: the choice of the light (a distribution, or a tree: see
#: `alight.lights.tree`), then one table a mesh light, the tables of lamps that have one, and that
#: of the environments' maps (see `alight.core.distributions`); map: the environments', see
#: `alight.lights.environment_map`.
#: Environments are the last lights.
LightTables = namedtuple("LightTables", "info data cdf map")

#: Words of `LightTables.info` a light: kind, shape (of an environment: start of its map), texture
#: of the radiance + 1 (0: none), start of its table in cdf.
INFO = 4

#: Name in `Program.lights` next to the models: the radiance of an area light has a texture.
TEXTURED = "textured"

#: Numbers of `LightTables.data` a light: red, green and blue, probability of being chosen, and up
#: to twelve of its own, as `place` gave them.
STRIDE = 16

#: Light arriving at a point from one chosen direction.
#: wi: unit direction to the light; distance: m, infinity for lights without a place; radiance: RGB
#: (for a delta light the irradiance on a surface that faces it); pdf: per solid angle, times the
#: probability of choosing this light, 0 if nothing can arrive; delta: mask, all light comes from
#: this one direction; cosine, error: at the light, for `alight.shapes.hit.shadow_length`.
LightSample = namedtuple("LightSample", "wi distance radiance pdf delta cosine error")


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
