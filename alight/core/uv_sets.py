"""Further sets of texture coordinates, in addition to a mesh's own.

Textures name a set by its number: 0 is the mesh's own, ``uvs``; `alight.shapes.mesh.Mesh.more_uvs`
holds the others. Where a shape has no such set (formulas have one only), its own is taken.

Programs in which a texture names another set than 0 have `UV_SETS` among their textures. Their
surfaces carry a `Chart`; in all others that field is empty, and the machine code knows no sets.

In tables, `ShapeTables.uv_shifts` holds `MOST_SETS` words a shape: what must be added to a vertex
to find its row in `ShapeTables.uvs`, or `NO_SET`.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Annotated

from alight.core.fields import Interval
from lanewise.jit import kernel, specialised
from lanewise.simd import any_lane, gather, gather_row, to_uint, where

#: What programs call it that a texture names another set than 0.
UV_SETS = "uv_sets"
MOST_SETS = 8
#: In the place of a shift: the shape has no set of this number but its own.
NO_SET = 0xFFFFFFFF

UvSet = Annotated[int, Interval(0, MOST_SETS - 1, integer=True)]

#: Vertices of a triangle, u32.
Corners = namedtuple("Corners", "i0 i1 i2")

#: Where on a triangle a surface point lies: barycentrics b1, b2; its `Corners`; set: the set of
#: coordinates, u32, by which derivatives are taken (`alight.shapes.derivatives`).
Chart = namedtuple("Chart", "b1 b2 corners set")

#: Coordinates of the three vertices of a triangle; further: mask of the lanes that have them, the
#: others hold those of some row.
TriangleUvs = namedtuple("TriangleUvs", "further u0 v0 u1 v1 u2 v2")


def set_features(uv_set: int) -> tuple[str, ...]:
    """What kernels must be written for, of a texture that names a set."""
    return (UV_SETS,) if uv_set else ()


@kernel
def triangle_uvs(tables, surface, number):
    """Coordinates of set `number` (u32) at the vertices below the `Chart` of a surface.

    Parameters
    ----------
    tables : ShapeTables
    """
    corners = surface.chart.corners
    shift = gather(tables.uv_shifts, surface.shape * MOST_SETS + number)
    further = shift != NO_SET
    i0 = 2 * where(further, corners.i0 + shift, 0)
    i1 = 2 * where(further, corners.i1 + shift, 0)
    i2 = 2 * where(further, corners.i2 + shift, 0)
    u0, v0 = gather_row(tables.uvs, i0, 2)
    u1, v1 = gather_row(tables.uvs, i1, 2)
    u2, v2 = gather_row(tables.uvs, i2, 2)
    return TriangleUvs(further=further, u0=u0, v0=v0, u1=u1, v1=v1, u2=u2, v2=v2)


@specialised
def uv_of_texture(program):
    """``uv_of_texture(scene, slot, surface) -> (u, v)``.

    The number of the set is at `slot` of `texture_data`.
    """
    if UV_SETS not in program.textures:
        return _own_uv

    @kernel
    def found(scene, slot, surface):
        number = gather(scene.materials.texture_data, slot)
        u, v = surface.u, surface.v
        wanted = number > 0.0
        if any_lane(wanted):
            c = triangle_uvs(scene.shapes, surface, to_uint(where(wanted, number, 0.0)))
            b1, b2 = surface.chart.b1, surface.chart.b2
            wanted = wanted & c.further
            u = where(wanted, c.u0 + b1 * (c.u1 - c.u0) + b2 * (c.u2 - c.u0), u)
            v = where(wanted, c.v0 + b1 * (c.v1 - c.v0) + b2 * (c.v2 - c.v0), v)
        return u, v

    return found


@kernel
def _own_uv(scene, slot, surface):
    return surface.u, surface.v
