"""Triangles of meshes in the tables: their corners, and how texture coordinates lie on them."""

from __future__ import annotations

from alight.core.uv_sets import UV_SETS, Chart, Corners, triangle_uvs
from alight.core.vec import Vec3, dot, gather_vec3
from alight.shapes.hit import INFO, INSTANCED, UVS
from lanewise.jit import kernel, specialised
from lanewise.simd import any_lane, gather, gather_row, where


@kernel
def corners_of(tables, shape, prim):
    """`Corners` of a triangle of a mesh; those of triangle 0 for other shapes."""
    _, first, _, count = gather_row(tables.info, shape * INFO + 4, 4)
    face = 3 * where(prim < count, first + prim, 0)
    i0, i1, i2 = gather_row(tables.faces, face, 3)
    return Corners(i0, i1, i2)


@kernel
def rows_if(mask, corners):
    """`Corners` where the mask holds, else 0: the table may have no further rows."""
    i0, i1, i2 = corners.i0, corners.i1, corners.i2
    return Corners(where(mask, i0, 0), where(mask, i1, 0), where(mask, i2, 0))


@kernel(strict=True)
def along_rows(data, k, v):
    """The upper 3 x 3 part of the 3 x 4 matrix at k times v."""
    return Vec3(
        dot(gather_vec3(data, k), v),
        dot(gather_vec3(data, k + 4), v),
        dot(gather_vec3(data, k + 8), v),
    )


@specialised
def uv_edges(program):
    """``(tables, surface, mapped, corners) -> (du1, dv1, du2, dv2)``.

    How far (u, v) of the second and the third corner are from the first one's, in the set that the
    surface's `Chart` names.
    """
    return _edges_of_chart if UV_SETS in program.textures else _own_edges


@kernel
def _own_edges(tables, surface, mapped, corners):
    rows = rows_if(mapped, corners)
    u0, v0 = gather_row(tables.uvs, 2 * rows.i0, 2)
    u1, v1 = gather_row(tables.uvs, 2 * rows.i1, 2)
    u2, v2 = gather_row(tables.uvs, 2 * rows.i2, 2)
    du1, dv1, du2, dv2 = u1 - u0, v1 - v0, u2 - u0, v2 - v0
    return du1, dv1, du2, dv2


@kernel
def _edges_of_chart(tables, surface, mapped, corners):
    du1, dv1, du2, dv2 = _own_edges(tables, surface, mapped, corners)
    wanted = mapped & (surface.chart.set != 0)
    if any_lane(wanted):
        c = triangle_uvs(tables, surface, where(wanted, surface.chart.set, 0))
        wanted = wanted & c.further
        du1, dv1 = where(wanted, c.u1 - c.u0, du1), where(wanted, c.v1 - c.v0, dv1)
        du2, dv2 = where(wanted, c.u2 - c.u0, du2), where(wanted, c.v2 - c.v0, dv2)
    return du1, dv1, du2, dv2


@specialised
def moved_chart(program):
    """``(scene, surface, du, dv)``: the `Chart` after a step of (u, v), of those `uv_derivatives`.

    Without coordinates, or where they do not vary, u and v are barycentric.
    """
    if UV_SETS not in program.textures:
        return _its_chart

    @kernel
    def moved(scene, surface, du, dv):
        chart, tables = surface.chart, scene.shapes
        mapped = (gather(tables.info, surface.shape * INFO + 4) & UVS) != 0
        du1, dv1, du2, dv2 = uv_edges(tables, surface, mapped, chart.corners)
        determinant = du1 * dv2 - dv1 * du2
        mapped = mapped & (determinant != 0.0)
        per = 1.0 / where(mapped, determinant, 1.0)
        # (du, dv) = db1 (du1, dv1) + db2 (du2, dv2): Cramer's rule.
        b1 = where(mapped, per * (dv2 * du - du2 * dv), du)
        b2 = where(mapped, per * (du1 * dv - dv1 * du), dv)
        return Chart(chart.b1 + b1, chart.b2 + b2, chart.corners, chart.set)

    return moved


@kernel
def _its_chart(scene, surface, du, dv):
    return surface.chart


@kernel
def derivatives(tables, k, surface):
    """(dp/du, dp/dv) of the triangles of meshes."""
    flags = gather(tables.info, surface.shape * INFO + 4)
    corners = corners_of(tables, surface.shape, surface.prim)
    v0 = gather_vec3(tables.vertices, 3 * corners.i0)
    e1 = gather_vec3(tables.vertices, 3 * corners.i1) - v0
    e2 = gather_vec3(tables.vertices, 3 * corners.i2) - v0
    # Without texture coordinates (u, v) are barycentric.
    along, across = e1 + 0.0, e2 + 0.0
    mapped = (flags & UVS) != 0
    if any_lane(mapped):
        du1, dv1, du2, dv2 = uv_edges(tables, surface, mapped, corners)
        determinant = du1 * dv2 - dv1 * du2
        mapped = mapped & (determinant != 0.0)
        per = 1.0 / where(mapped, determinant, 1.0)
        along = where(mapped, per * (dv2 * e1 - dv1 * e2), along)
        across = where(mapped, per * (du1 * e2 - du2 * e1), across)
    instanced = (flags & INSTANCED) != 0
    if any_lane(instanced):
        k = where(instanced, k, 0)
        along = where(instanced, along_rows(tables.data, k, along), along)
        across = where(instanced, along_rows(tables.data, k, across), across)
    return along, across
