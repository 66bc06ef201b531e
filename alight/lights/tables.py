"""What lights look like to kernels: tables and samples."""

from __future__ import annotations

from collections import namedtuple

#: info, data: a row a light; cdf: the choice of the light, then one table a mesh light (see
#: `alight.core.distributions`). The environment, where there is one, is the last light.
LightTables = namedtuple("LightTables", "info data cdf")

#: Words of `LightTables.info` a light: kind, shape, offset in data, start of a mesh's table in cdf.
INFO = 4

#: Numbers of `LightTables.data` a light: red, green and blue, probability of being chosen, and
#: three for the position, or the direction to the light.
STRIDE = 8

#: Light arriving at a point from one chosen direction.
#: wi: unit direction to the light; distance: m, infinity for lights without a place; radiance: RGB
#: (for a delta light the irradiance on a surface that faces it); pdf: per solid angle, times the
#: probability of choosing this light, 0 if nothing can arrive; delta: mask, all light comes from
#: this one direction; cosine, error: at the light, for `alight.shapes.hit.shadow_length`.
LightSample = namedtuple("LightSample", "wi distance radiance pdf delta cosine error")
