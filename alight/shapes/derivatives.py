"""Derivatives of a surface point by its texture coordinates, for bump and normal maps."""

from __future__ import annotations

from alight.core.constants import PI, TWO_PI
from alight.core.maths import sincos
from alight.core.motion import matrix_at, point_of_rest, turned
from alight.core.uv_sets import UV_SETS, Chart, triangle_uvs
from alight.core.vec import Vec3, gather_vec3
from alight.shapes.cylinder import MATRIX as CYLINDER_MATRIX
from alight.shapes.flat import E1, E2, local_coordinates
from alight.shapes.hit import INFO, INSTANCED, UVS, Surface
from alight.shapes.mesh import along_rows, corners_of, rows_if
from alight.shapes.sphere import MATRIX as SPHERE_MATRIX
from alight.shapes.sphere import times
from alight.shapes.surfaces import KINDS
from lanewise.jit import kernel, specialised
from lanewise.simd import any_lane, gather, gather_row, lanes, sqrt, where


@specialised
def uv_derivatives(program):
    """``(scene, surface) -> (dp/du, dp/dv)`` in the world, metres; (s, t) without shapes.

    Of the set of coordinates that the surface's `Chart` names, where it has one.
    """
    kinds = [name for name in _DERIVATIVES if name in program.shapes]
    if not kinds:
        return _tangents
    chain = _chain(kinds)

    @kernel
    def derivatives(scene, surface):
        row = surface.shape * INFO
        kind, k = gather(scene.shapes.info, row), gather(scene.shapes.info, row + 3)
        return chain(scene.shapes, kind, k, surface)

    if "shapes" not in program.motion:
        return derivatives

    @kernel
    def moving_derivatives(scene, surface):
        along, across = derivatives(scene, _at_rest(scene, surface))
        number = gather(scene.motions.of_shape, surface.shape)
        moving = number != 0
        if any_lane(moving):
            m = matrix_at(scene.motions, where(moving, number - 1, 0), scene.time)
            along = where(moving, turned(m, along), along)
            across = where(moving, turned(m, across), across)
        return along, across

    return moving_derivatives


@kernel
def _at_rest(scene, surface):
    return Surface(
        point_of_rest(scene, surface), surface.error, surface.ng, surface.ns, surface.s, surface.t,
        surface.u, surface.v, surface.shape, surface.prim, surface.bsdf, surface.light,
        surface.color, surface.chart,
    )  # fmt: skip


@kernel
def _tangents(scene, surface):
    return surface.s, surface.t


def _chain(kinds):
    """``(tables, kind, k, surface)``: the kernel of each kind where lanes need it."""
    own = _DERIVATIVES[kinds[0]]
    if len(kinds) == 1:

        @kernel
        def last(tables, kind, k, surface):
            return own(tables, k, surface)

        return last
    number, rest = KINDS[kinds[0]], _chain(kinds[1:])

    @kernel
    def choose(tables, kind, k, surface):
        along, across = rest(tables, kind, k, surface)
        mine = kind == number
        if any_lane(mine):
            a, b = own(tables, where(mine, k, 0), surface)
            along, across = where(mine, a, along), where(mine, b, across)
        return along, across

    return choose


@kernel
def _of_plane(tables, k, surface):
    return gather_vec3(tables.data, k + E1), gather_vec3(tables.data, k + E2)


@kernel
def _of_rectangle(tables, k, surface):
    # u and v run from 0 to 1 over twice the half edges.
    return 2.0 * gather_vec3(tables.data, k + E1), 2.0 * gather_vec3(tables.data, k + E2)


@kernel
def _of_disk(tables, k, surface):
    # u is the radius, v the angle.
    e1, e2 = gather_vec3(tables.data, k + E1), gather_vec3(tables.data, k + E2)
    x, y = local_coordinates(tables.data, k, surface.p)
    r = sqrt(x * x + y * y)
    per_r = 1.0 / where(r > 0.0, r, 1.0)
    return (x * per_r) * e1 + (y * per_r) * e2, TWO_PI * (x * e2 - y * e1)


@kernel
def _of_sphere(tables, k, surface):
    s, c = sincos(TWO_PI * surface.u)
    sine, cosine = sincos(PI * surface.v)
    around = Vec3(-TWO_PI * sine * s, TWO_PI * sine * c, lanes(0.0))
    down = Vec3(PI * cosine * c, PI * cosine * s, -PI * sine)
    k = k + SPHERE_MATRIX
    return times(tables.data, k, around), times(tables.data, k, down)


@kernel
def _of_cylinder(tables, k, surface):
    s, c = sincos(TWO_PI * surface.u)
    around, up = Vec3(-TWO_PI * s, TWO_PI * c, lanes(0.0)), Vec3(0.0 * s, 0.0 * s, lanes(1.0))
    k = k + CYLINDER_MATRIX
    return times(tables.data, k, around), times(tables.data, k, up)


@specialised
def uv_edges(program):
    """``(tables, surface, mapped, i0, i1, i2) -> (du1, dv1, du2, dv2)``.

    How far (u, v) of the second and the third corner are from the first one's, in the set that the
    surface's `Chart` names.
    """
    return _edges_of_chart if UV_SETS in program.textures else _own_edges


@kernel
def _own_edges(tables, surface, mapped, i0, i1, i2):
    j0, j1, j2 = rows_if(mapped, i0, i1, i2)
    u0, v0 = gather_row(tables.uvs, 2 * j0, 2)
    u1, v1 = gather_row(tables.uvs, 2 * j1, 2)
    u2, v2 = gather_row(tables.uvs, 2 * j2, 2)
    du1, dv1, du2, dv2 = u1 - u0, v1 - v0, u2 - u0, v2 - v0
    return du1, dv1, du2, dv2


@kernel
def _edges_of_chart(tables, surface, mapped, i0, i1, i2):
    du1, dv1, du2, dv2 = _own_edges(tables, surface, mapped, i0, i1, i2)
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
        du1, dv1, du2, dv2 = uv_edges(tables, surface, mapped, chart.i0, chart.i1, chart.i2)
        determinant = du1 * dv2 - dv1 * du2
        mapped = mapped & (determinant != 0.0)
        per = 1.0 / where(mapped, determinant, 1.0)
        # (du, dv) = db1 (du1, dv1) + db2 (du2, dv2): Cramer's rule.
        b1 = where(mapped, per * (dv2 * du - du2 * dv), du)
        b2 = where(mapped, per * (du1 * dv - dv1 * du), dv)
        return Chart(chart.b1 + b1, chart.b2 + b2, chart.i0, chart.i1, chart.i2, chart.set)

    return moved


@kernel
def _its_chart(scene, surface, du, dv):
    return surface.chart


@kernel
def _of_mesh(tables, k, surface):
    flags = gather(tables.info, surface.shape * INFO + 4)
    i0, i1, i2 = corners_of(tables, surface.shape, surface.prim)
    v0 = gather_vec3(tables.vertices, 3 * i0)
    e1 = gather_vec3(tables.vertices, 3 * i1) - v0
    e2 = gather_vec3(tables.vertices, 3 * i2) - v0
    # Without texture coordinates (u, v) are barycentric.
    along, across = e1 + 0.0, e2 + 0.0
    mapped = (flags & UVS) != 0
    if any_lane(mapped):
        du1, dv1, du2, dv2 = uv_edges(tables, surface, mapped, i0, i1, i2)
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


_DERIVATIVES = {
    "sphere": _of_sphere,
    "plane": _of_plane,
    "rectangle": _of_rectangle,
    "disk": _of_disk,
    "mesh": _of_mesh,
    "cylinder": _of_cylinder,
}
