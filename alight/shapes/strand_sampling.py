"""Points of strands that shine: any primitive, then uniform in its parameters.

As many samples go to each primitive, whatever its size: strands that shine differ little.
"""

from __future__ import annotations

from alight.core.constants import INFINITY, TWO_PI
from alight.core.maths import sincos_2pi
from alight.core.vec import cross, dot, gather_vec3, length_squared
from alight.shapes.hit import INFO, AreaSample, ShapeSample, area_to_solid_angle
from alight.shapes.strand_places import center_of, error_of, is_seen, place_at, row_of
from alight.shapes.strand_rows import IS_BALL
from alight.shapes.tube import BEYOND, PIECES
from lanewise.jit import kernel
from lanewise.simd import (
    as_float,
    floor,
    gather,
    lanes,
    lanes_u32,
    maximum,
    minimum,
    sqrt,
    to_float,
    to_uint,
    where,
)

#: Steps of Newton's method from the nearest of some points of a curve.
NEWTON = 4


@kernel
def choose_place(tables, shape, u2):
    """(prim, u, `Place`, density per area): any primitive, then uniform in u and phi."""
    data = tables.data
    k = gather(tables.info, shape * INFO + 3)
    _, count = row_of(tables, k, shape, lanes_u32(0))
    number = u2[0] * to_float(count)
    whole = minimum(floor(number), to_float(count) - 1.0)
    prim, u = to_uint(whole), minimum(number - whole, 1.0)
    row, _ = row_of(tables, k, shape, prim)
    sine, cosine = sincos_2pi(u2[1])
    # A point beside the circle, in that direction; of a ball at uniform heights.
    at = place_at(data, row, u, gather_vec3(data, row))
    ball = gather(data, row + IS_BALL) > 0.0
    e = cosine * at.f1 + sine * at.f2
    height = 2.0 * u - 1.0
    t = cross(at.f1, at.f2)
    out = height * t + sqrt(maximum(1.0 - height * height, 0.0)) * e
    center = center_of(data, row, where(ball, 0.0, u))
    place = place_at(data, row, u, center + where(ball, out, e))
    spread = place.stretch * to_float(count) * where(ball, 2.0 * TWO_PI, TWO_PI)
    # What lies within a tube is not drawn, rather than drawn again: most joints bend little.
    drawn = (spread > 0.0) & is_seen(data, row, place.n)
    return prim, u, place, where(drawn, 1.0 / where(spread > 0.0, spread, 1.0), 0.0)


@kernel
def sample(tables, cdf, start, shape, p, u, u2):
    """Choose a point; see `alight.shapes.rectangle.sample`."""
    data = tables.data
    prim, _, place, density = choose_place(tables, shape, u2)
    row, _ = row_of(tables, gather(tables.info, shape * INFO + 3), shape, prim)
    to_light = place.p - p
    distance = sqrt(length_squared(to_light))
    wi = to_light * (1.0 / maximum(distance, 1e-30))
    cosine = -dot(wi, place.n)
    density = area_to_solid_angle(density, distance, cosine)
    return ShapeSample(wi, distance, cosine, error_of(data, row, place.n), density)


@kernel
def pdf(tables, cdf, start, shape, p, hit):
    """Density of `sample` per solid angle at a `ShapeHit` seen from p."""
    data, q = tables.data, p + hit.distance * hit.wi
    row, count = row_of(tables, gather(tables.info, shape * INFO + 3), shape, hit.prim)
    place = place_at(data, row, nearest_of_row(data, row, q), q)
    ball = gather(data, row + IS_BALL) > 0.0
    spread = place.stretch * to_float(count) * where(ball, 2.0 * TWO_PI, TWO_PI)
    density = where(spread > 0.0, 1.0 / where(spread > 0.0, spread, 1.0), 0.0)
    return area_to_solid_angle(density, hit.distance, hit.cosine)


@kernel
def nearest_of_row(data, row, q):
    """The u at which the curve of a row is nearest to a point."""
    best, u = lanes(INFINITY), lanes(0.0)
    for i in range(PIECES + 1):
        at = lanes(as_float(i) / PIECES)
        away = length_squared(center_of(data, row, at) - q)
        u, best = where(away < best, at, u), minimum(away, best)
    c1, c2 = gather_vec3(data, row + 4), gather_vec3(data, row + 8)
    c3 = gather_vec3(data, row + 12)
    for _ in range(NEWTON):
        dc, ddc = c1 + u * (2.0 * c2 + (3.0 * u) * c3), 2.0 * c2 + (6.0 * u) * c3
        f = q - center_of(data, row, u)
        slope = length_squared(dc) - dot(f, ddc)
        step = dot(f, dc) / maximum(slope, 0.25 * length_squared(dc) + 1e-37)
        u = minimum(maximum(u + step, -BEYOND), 1.0 + BEYOND)
    return u


@kernel
def sample_area(tables, cdf, start, shape, u, u2):
    """Choose a point; see `alight.shapes.rectangle.sample_area`. Not uniform by area."""
    prim, place_u, place, density = choose_place(tables, shape, u2)
    return AreaSample(place.p, place_u, lanes(0.0), prim, density)


@kernel
def coordinates(tables, cdf, start, shape, q, u, u2):
    """u, 0 and the primitive of a sampled point: the same numbers choose the same again."""
    prim, place_u, _, _ = choose_place(tables, shape, u2)
    return place_u, lanes(0.0), prim
