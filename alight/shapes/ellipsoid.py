"""Uniform points of the unit sphere on their images: how dense they are, and which it was.

Rows of the table are those of `alight.shapes.sphere`.
"""

from __future__ import annotations

from alight.core.constants import INV_FOUR_PI
from alight.core.vec import gather_vec3, length_squared
from alight.core.warps import uniform_sphere_to_square
from alight.shapes.hit import INFO
from alight.shapes.quadric import times, transposed_times
from lanewise.jit import kernel
from lanewise.simd import gather, sqrt

DENSITY, INVERSE = 6, 8


@kernel
def area_density(data, k, q):
    """Density per area of A q for q uniform on the unit sphere: 1 / (4 pi |det A| |A^-T q|)."""
    stretch = sqrt(length_squared(transposed_times(data, k + INVERSE, q)))
    return INV_FOUR_PI * gather(data, k + DENSITY) / stretch


@kernel
def square(tables, cdf, start, shape, prim, q):
    """Where `sample_area` has a point q from; see `alight.shapes.rectangle.square`."""
    data = tables.data
    k = gather(tables.info, shape * INFO + 3)
    w = times(data, k + INVERSE, q - gather_vec3(data, k))
    w = w * (1.0 / sqrt(length_squared(w)))
    x, y = uniform_sphere_to_square(w)
    return x, y, area_density(data, k, w)
