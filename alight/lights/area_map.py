r"""Points of area lights, chosen by the texture of their radiance.

The unit square that `sample_area` of a shape takes its points from, with the density :math:`p_A`
per square metre, is cut into cells. Each gets the probability :math:`P_c` of its share of the
emitted light. Mixed with the shape's own sampling :math:`p_\omega`, which knows where it is seen
from, the density at the distance d is

.. math::
    p = (1 - a)\, p_\omega + a\, P_c\, n\, p_A\, \frac{d^2}{\cos\theta}

for n cells. The share a depends on nothing but the point that is lit. Let b be the part of the
light that stands out, what exceeds the mean radiance, but one half at most. Rectangles seen
from near, and spheres, have a = b: the even light is left to the shape's own sampling. From afar
all points of a rectangle count alike. At the distance r of its middle, with its points up to R from
there,

.. math:: a = 1 - (1 - b) \min\Bigl(1, \frac{R^2}{r^2}\Bigr)

Shapes whose own sampling does not know where they are seen from have a = 1. On a mesh the triangle
is chosen first, by its light, and the square is that of the triangle.

A map begins with `HEAD` numbers: columns, rows, b, R^2 (infinite where a = b), the middle; then
follow the tables of `alight.core.distributions.cumulative_grid`. `LightTables.data` of the light
holds where it begins in `LightTables.cdf`, as the bits of a whole number, 0 for none; of a mesh,
where a list of such words begins, one a triangle.

Source: PBR4 sections 12.4 and A.5; Veach and Guibas, Optimally combining sampling techniques for
Monte Carlo rendering, SIGGRAPH 1995 (a mixture as one technique).
"""

from __future__ import annotations

from alight.core.constants import ONE_MINUS_EPSILON
from alight.core.distributions import pmf_grid, sample_grid
from alight.core.switch import is_one_of
from alight.core.vec import gather_vec3, length_squared
from alight.lights.model import LIGHTS
from alight.lights.tables import INFO, IS_LIST, MAP_START, STRIDE
from alight.shapes.hit import INFO as SHAPE_INFO
from alight.shapes.hit import area_to_solid_angle
from alight.shapes.model import SHAPES, ShapeModel
from lanewise.jit import kernel, specialised
from lanewise.simd import (
    any_lane,
    float_bits,
    floor,
    gather,
    gather_row,
    lanes,
    lanes_u32,
    maximum,
    minimum,
    minimum_u32,
    to_float,
    to_uint,
    where,
)

#: Numbers before the tables of a map.
HEAD = 7


@specialised
def map_at(program):
    """``map_at(scene, index, prim)``: where the maps of lights begin, 0 where they have none.

    prim: the primitive of their shapes.
    """
    is_mapped = is_one_of(
        model.number for name, model in LIGHTS.items() if name in program.lights and model.IS_MAPPED
    )

    @kernel
    def map_at(scene, index, prim):
        info, index = scene.lights.info, lanes_u32(0) + index
        mine = is_mapped(gather(info, index * INFO)) & (gather(info, index * INFO + 2) != 0)
        k = where(mine, index, 0) * STRIDE
        start = float_bits(gather(scene.lights.data, k + MAP_START))
        listed = mine & (gather(scene.lights.data, k + IS_LIST) > 0.0)
        if any_lane(listed):
            word = gather(scene.lights.cdf, where(listed, start + prim, 0))
            start = where(listed, float_bits(word), start)
        return where(mine, start, 0)

    return map_at


@kernel
def share_of(scene, at, p):
    """The share a of the maps that begin at `at`, for the points p."""
    cdf = scene.lights.cdf
    squared = length_squared(gather_vec3(cdf, at + 4) - p)
    near = minimum(gather(cdf, at + 3) / maximum(squared, 1e-30), 1.0)
    return where(at != 0, 1.0 - (1.0 - gather(cdf, at + 2)) * near, 0.0)


@kernel
def _size_of(scene, at):
    """(columns, rows) of maps, 1 where there is none."""
    columns, rows = gather_row(scene.lights.cdf, at, 2)
    return to_uint(where(at != 0, columns, 1.0)), to_uint(where(at != 0, rows, 1.0))


@kernel
def draw(scene, at, u, u2):
    """A point of the unit square by the map that begins at `at`; u, u2: uniform in [0, 1)."""
    columns, rows = _size_of(scene, at)
    digits = u - floor(u)
    column, row, _, rest = sample_grid(scene.lights.cdf, at + HEAD, rows, columns, digits, u2)
    x = (to_float(column) + rest[0]) / to_float(columns)
    y = (to_float(row) + rest[1]) / to_float(rows)
    return minimum(x, ONE_MINUS_EPSILON), minimum(y, ONE_MINUS_EPSILON)


@kernel
def square_density(scene, at, x, y):
    """Density of `draw` over the square."""
    columns, rows = _size_of(scene, at)
    # Rounding leads out of the square; NaN leads to the first cell.
    column = minimum_u32(to_uint(maximum(x * to_float(columns), 0.0)), columns - 1)
    row = minimum_u32(to_uint(maximum(y * to_float(rows), 0.0)), rows - 1)
    pmf = pmf_grid(scene.lights.cdf, at + HEAD, rows, columns, column, row)
    return pmf * to_float(columns) * to_float(rows)


@kernel
def mixed_pdf(scene, at, square, p, hit, by_shape):
    """The density p at a `ShapeHit`, per solid angle.

    Parameters
    ----------
    scene : namedtuple
    at : uint32
        Where the maps of the lights begin, 0 for none.
    square : (x, y, density)
        The point by `square_of`. Samples give the x and y that were drawn: rounding may lead from
        the point that they become over the edge of a cell, into one a million times as dark.
    p : Vec3
        Where they are seen from.
    hit : ShapeHit
    by_shape : float
        The density of the shape's own sampling there.
    """
    density, mapped = by_shape, at != 0
    if any_lane(mapped):
        x, y, per_area = square
        share = share_of(scene, at, p)
        by_area = where(mapped, per_area * square_density(scene, at, x, y), 0.0)
        by_map = area_to_solid_angle(by_area, hit.distance, hit.cosine)
        density = where(mapped, (1.0 - share) * by_shape + share * by_map, by_shape)
    return density


@specialised
def square_of(program):
    """``square_of(scene, shape, start, prim, q) -> (x, y, density)`` of the program's shapes.

    See `alight.shapes.model.ShapeModel.square`.
    """
    shapes = [SHAPES[name] for name in program.light_shapes if SHAPES[name].square]
    chain = _chain(shapes)

    @kernel
    def by_kind(scene, shape, start, prim, q):
        kind = gather(scene.shapes.info, shape * SHAPE_INFO)
        return chain(scene, kind, shape, start, prim, q)

    return by_kind


@kernel
def _nowhere(scene, kind, shape, start, prim, q):
    return lanes(0.0), lanes(0.0), lanes(0.0)


def _chain(shapes: list[ShapeModel]):
    """The kernel of each kind where lanes need it."""
    if not shapes:
        return _nowhere
    own, number, others = shapes[0].square, shapes[0].number, _chain(shapes[1:])
    assert own is not None

    @kernel
    def choose(scene, kind, shape, start, prim, q):
        x, y, density = others(scene, kind, shape, start, prim, q)
        mine = kind == number
        if any_lane(mine):
            first, face = where(mine, start, 0), where(mine, prim, 0)
            x1, y1, density1 = own(scene.shapes, scene.lights.cdf, first, shape, face, q)
            x, y = where(mine, x1, x), where(mine, y1, y)
            density = where(mine, density1, density)
        return x, y, density

    return choose
