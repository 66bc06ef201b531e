r"""Triangle mesh, from a PLY, OBJ or STL file or from arrays.

.. math:: p(b_1, b_2) = (1 - b_1 - b_2)\, p_0 + b_1\, p_1 + b_2\, p_2

The geometric normal is along (p1 - p0) x (p2 - p0): vertices run counter-clockwise seen from
outside. Shading normals are interpolated from the vertex normals, where there are any.

Meshes are stored in world space, except where several instances share one: those keep object space
and a row of the table with two 3 x 4 matrices, object to world (0-11) and world to object (12-23).

**Error bound**, in units of the machine epsilon, along the normal n: with E = the sum over i of
\|n_i\| times the largest \|p_i\| of a corner, rounding of p takes 5 E, of the moved origin 2 E, of
the corners relative to it 1 E; gamma(16) E is taken. The watertight test finds t by barycentrics.
Seen edge-on at the angle of cosine c they are uncertain by the order of 1 / c; for a triangle whose
edges reach L along an axis this shifts t by the order of L / c, so the plane by the order of L:
2 L where it was measured. gamma(6) L is added.
For instances the bound in object space, with the rounding
of the transformed ray, sum \|n_i\| (sum \|W_ij p_j\| + \|W_i4\|), is taken to world space by
1 / \|W^T n\|.

Source: PBR4 sections 6.5 and 6.8.
"""

from __future__ import annotations

from typing import Literal

from alight.core.constants import gamma
from alight.core.distributions import pmf_discrete, sample_discrete
from alight.core.frame import frame_from_tangent
from alight.core.vec import (
    Vec3,
    absolute_vec3,
    cross,
    dot,
    gather_vec3,
    length_squared,
    max_component,
)
from alight.core.warps import square_to_triangle, triangle_to_square
from alight.shapes.arrays import TriangleShape
from alight.shapes.charts import along_rows, corners_of, rows_if
from alight.shapes.charts import derivatives as derivatives
from alight.shapes.hit import (
    COLORS,
    FLIP,
    INFO,
    INSTANCED,
    SMOOTH,
    UVS,
    AreaSample,
    Geometry,
    ShapeSample,
    area_to_solid_angle,
)
from lanewise.jit import kernel, specialised
from lanewise.simd import (
    absolute,
    any_lane,
    gather,
    gather_row,
    lanes,
    lanes_vec3,
    maximum,
    sqrt,
    to_uint,
    where,
)


class Mesh(TriangleShape):
    """Triangles that share vertices.

    Parameters
    ----------
    file : str, optional
        PLY, OBJ or STL file, relative to the scene file, or ``builtin:waves``, ripples on water;
        not together with arrays.
    vertices : (n, 3) float32, metres, optional
        Positions in the space of its node.
    faces : (m, 3) int32, optional
        Vertex indices of each triangle, counter-clockwise seen from outside.
    normals : (n, 3) float32, optional
        Vertex normals for smooth shading.
    uvs : (n, 2) float32, optional
        Texture coordinates.
    more_uvs : (k, n, 2) float32, k <= 7, optional
        Further sets of them, for textures with ``uv_set: 1`` and so on. Where a mesh or another
        shape lacks the set that a texture names, its own coordinates are taken.
    colors : (n, 3) float32, optional
        Linear sRGB vertex colours in [0, 1].
    face_normals : bool, default False
        Shade flat: do not use vertex normals.
    displacement : float or texture, optional
        Height by which the surface is moved along its normals; a bitmap needs
        ``color_space: linear`` if it has 8 or 16 bits.
    displacement_scale : float, metres, default 1
        Scale of the height; below 0 hills become hollows.
    displacement_midlevel : float, default 0
        Height at which the surface stays where it is.
    displacement_edge : float, metres, optional
        No edge of the displaced triangles is longer before they are moved; by default 1/256 of the
        diagonal of the mesh's box.
    flip_normals : bool, default False
        Turn the surface inside out.
    """

    type: Literal["mesh"] = "mesh"


_TETRAHEDRON = {
    "vertices": ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "faces": ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)),
}

EXAMPLES = (
    Mesh(**_TETRAHEDRON),
    Mesh(
        **_TETRAHEDRON,
        normals=((-1.0, -1.0, -1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
        uvs=((0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)),
        colors=((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    ),
    Mesh(
        vertices=((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.1, 0.0)),
        faces=((0, 1, 2),),
        face_normals=True,
        flip_normals=True,
    ),
)

STRIDE = 24

_GAMMA_6, _GAMMA_16 = gamma(6), gamma(16)


@kernel
def mix(view, mask, corners, b1, b2):
    """Rows of three numbers interpolated by barycentric coordinates, where the mask holds."""
    rows = rows_if(mask, corners)
    v0, v1 = gather_vec3(view, 3 * rows.i0), gather_vec3(view, 3 * rows.i1)
    return v0 + b1 * (v1 - v0) + b2 * (gather_vec3(view, 3 * rows.i2) - v0)


@kernel(strict=True)
def larger(a, b):
    """The larger one, component by component."""
    return Vec3(maximum(a.x, b.x), maximum(a.y, b.y), maximum(a.z, b.z))


@kernel(strict=True)
def triangle_error(v0, v1, v2, n):
    """The error bound of a triangle in the space of its vertices."""
    a0, a1, a2 = absolute_vec3(v0), absolute_vec3(v1), absolute_vec3(v2)
    extent = larger(absolute_vec3(v1 - v0), absolute_vec3(v2 - v0))
    reach = dot(absolute_vec3(n), larger(a0, larger(a1, a2)))
    return _GAMMA_16 * reach + _GAMMA_6 * max_component(extent)


@kernel(strict=True)
def along_columns(data, k, v):
    """Its transpose times v."""
    sums = v.x * gather_vec3(data, k) + v.y * gather_vec3(data, k + 4)
    return sums + v.z * gather_vec3(data, k + 8)


@kernel(strict=True)
def shift_of(data, k):
    """The last column of the 3 x 4 matrix at k."""
    return Vec3(gather(data, k + 3), gather(data, k + 7), gather(data, k + 11))


@kernel(strict=True)
def instance_error(data, k, p, n, error):
    """The error bound in world space of an instance.

    Parameters
    ----------
    k : uint32
        Offsets of the rows.
    p : Vec3
        World space.
    n : Vec3
        Unit normal in object space.
    error : float
        Bound in object space.
    """
    inverse = k + 12
    na, pa = absolute_vec3(n), absolute_vec3(p)
    reach = Vec3(
        dot(absolute_vec3(gather_vec3(data, inverse)), pa),
        dot(absolute_vec3(gather_vec3(data, inverse + 4)), pa),
        dot(absolute_vec3(gather_vec3(data, inverse + 8)), pa),
    )
    error = error + _GAMMA_16 * dot(na, reach + absolute_vec3(shift_of(data, inverse)))
    return error / sqrt(length_squared(along_columns(data, inverse, n)))


@kernel
def surface(tables, k, hit, o, d):
    """The `Geometry` of hits; k: offsets of the rows of instances, lanes."""
    data = tables.data
    flags = gather(tables.info, hit.shape * INFO + 4)
    corners = corners_of(tables, hit.shape, hit.prim)
    v0 = gather_vec3(tables.vertices, 3 * corners.i0)
    v1 = gather_vec3(tables.vertices, 3 * corners.i1)
    v2 = gather_vec3(tables.vertices, 3 * corners.i2)
    e1, e2 = v1 - v0, v2 - v0
    p = v0 + hit.u * e1 + hit.v * e2
    across = cross(e1, e2)
    n = across * (1.0 / sqrt(maximum(length_squared(across), 1e-37)))
    error = triangle_error(v0, v1, v2, n)
    tangent, u, v = texture_frame(tables, flags, hit, corners, e1, e2)

    ns = n
    smooth = (flags & SMOOTH) != 0
    if any_lane(smooth):
        mixed = mix(tables.normals, smooth, corners, hit.u, hit.v)
        ns = where(smooth & (length_squared(mixed) > 0.0), mixed, n)
    color = lanes_vec3(1.0)
    colored = (flags & COLORS) != 0
    if any_lane(colored):
        found = mix(tables.colors, colored, corners, hit.u, hit.v)
        color = where(colored, found, color)

    instanced = (flags & INSTANCED) != 0
    if any_lane(instanced):
        k = where(instanced, k, 0)
        world = along_rows(data, k, p) + shift_of(data, k)
        error = where(instanced, instance_error(data, k, world, n, error), error)
        p = where(instanced, world, p)
        tangent = where(instanced, along_rows(data, k, tangent), tangent)
        # Normals by the inverse transpose.
        n1, ns1 = along_columns(data, k + 12, n), along_columns(data, k + 12, ns)
        n = where(instanced, n1 * (1.0 / sqrt(length_squared(n1))), n)
        ns = where(instanced, ns1, ns)
    ns = ns * (1.0 / sqrt(length_squared(ns)))

    n = where((flags & FLIP) != 0, -n, n)
    ns = where(dot(ns, n) < 0.0, -ns, ns)
    s, t = frame_from_tangent(ns, tangent)
    return Geometry(p=p, error=error, ng=n, ns=ns, s=s, t=t, u=u, v=v, color=color)


@kernel
def texture_frame(tables, flags, hit, corners, e1, e2):
    """dp/du, u and v: from texture coordinates; e1 and the barycentrics where there are none."""
    tangent, u, v = e1 + lanes_vec3(0.0), hit.u, hit.v
    mapped = (flags & UVS) != 0
    if any_lane(mapped):
        rows = rows_if(mapped, corners)
        u0, v0 = gather_row(tables.uvs, 2 * rows.i0, 2)
        u1, v1 = gather_row(tables.uvs, 2 * rows.i1, 2)
        u2, v2 = gather_row(tables.uvs, 2 * rows.i2, 2)
        du1, dv1, du2, dv2 = u1 - u0, v1 - v0, u2 - u0, v2 - v0
        u = where(mapped, u0 + hit.u * du1 + hit.v * du2, u)
        v = where(mapped, v0 + hit.u * dv1 + hit.v * dv2, v)
        # e1 = du1 dp/du + dv1 dp/dv, and likewise e2: Cramer's rule.
        determinant = du1 * dv2 - dv1 * du2
        turned = dv2 * e1 - dv1 * e2
        turned = where(determinant < 0.0, -turned, turned)
        tangent = where(mapped & (absolute(determinant) > 0.0), turned, tangent)
    return tangent, u, v


@kernel
def light_triangle(tables, shape, prim):
    """First corner, two edges, unit outer normal, area and error bound of a triangle in the world.

    Meshes that shine are never instanced.
    """
    corners = corners_of(tables, shape, prim)
    v0 = gather_vec3(tables.vertices, 3 * corners.i0)
    v1 = gather_vec3(tables.vertices, 3 * corners.i1)
    v2 = gather_vec3(tables.vertices, 3 * corners.i2)
    e1, e2 = v1 - v0, v2 - v0
    across = cross(e1, e2)
    size = sqrt(maximum(length_squared(across), 1e-37))
    n = across * (1.0 / size)
    error = triangle_error(v0, v1, v2, n)
    flip = (gather(tables.info, shape * INFO + 4) & FLIP) != 0
    return v0, e1, e2, where(flip, -n, n), 0.5 * size, error


@specialised
def choose_triangle(program):
    """``choose_triangle(cdf, start, count, u) -> (triangle, probability)``.

    By its area; in a program with a light tree the tree has chosen it, and u is its number.
    """
    if program.light_tree:

        @kernel
        def as_chosen(cdf, start, count, u):
            return to_uint(u), lanes(1.0)

        return as_chosen

    @kernel
    def by_area(cdf, start, count, u):
        prim, pmf, _ = sample_discrete(cdf, start, count, u)
        return prim, pmf

    return by_area


@specialised
def triangle_probability(program):
    """``triangle_probability(cdf, start, prim)``: of `choose_triangle`."""
    if program.light_tree:

        @kernel
        def certain(cdf, start, prim):
            return lanes(1.0)

        return certain

    @kernel
    def by_area(cdf, start, prim):
        return pmf_discrete(cdf, start, prim)

    return by_area


@kernel
def sample(tables, cdf, start, shape, p, u, u2):
    """Choose a triangle, and a point on it uniformly.

    Parameters
    ----------
    tables : ShapeTables
    cdf : View
        Distributions of the triangles.
    start : uint32
        Where this mesh's begins.
    shape, p, u2
        See `alight.shapes.rectangle.sample`.
    u : float
        Chooses the triangle, see `choose_triangle`.

    Returns
    -------
    ShapeSample
    """
    count = gather(tables.info, shape * INFO + 7)
    prim, pmf = choose_triangle(cdf, start, count, u)
    v0, e1, e2, n, area, error = light_triangle(tables, shape, prim)
    b1, b2 = square_to_triangle(u2)
    to_light = (v0 - p) + b1 * e1 + b2 * e2
    distance = sqrt(length_squared(to_light))
    wi = to_light * (1.0 / maximum(distance, 1e-30))
    cosine = -dot(wi, n)
    # The probability as stored in the table, so that sampling and density agree to the last bit.
    density = area_to_solid_angle(pmf / area, distance, cosine)
    return ShapeSample(wi, distance, cosine, error, density)


@kernel
def pdf(tables, cdf, start, shape, p, hit):
    """Density of `sample` per solid angle at a `ShapeHit` seen from p."""
    mine = hit.prim < gather(tables.info, shape * INFO + 7)
    _, _, _, _, area, _ = light_triangle(tables, shape, hit.prim)
    pmf = triangle_probability(cdf, where(mine, start, 0), where(mine, hit.prim, 0))
    return area_to_solid_angle(pmf / area, hit.distance, hit.cosine)


@kernel
def sample_area(tables, cdf, start, shape, u, u2):
    """Choose a point uniformly by area; see `alight.shapes.rectangle.sample_area`."""
    count = gather(tables.info, shape * INFO + 7)
    prim, pmf, _ = sample_discrete(cdf, start, count, u)
    v0, e1, e2, _, area, _ = light_triangle(tables, shape, prim)
    b1, b2 = square_to_triangle(u2)
    return AreaSample(v0 + b1 * e1 + b2 * e2, b1, b2, prim, pmf / area)


@kernel
def coordinates(tables, cdf, start, shape, q, u, u2):
    """Barycentrics and triangle of a sampled point: the same numbers choose the same again."""
    count = gather(tables.info, shape * INFO + 7)
    prim, _ = choose_triangle(cdf, start, count, u)
    b1, b2 = square_to_triangle(u2)
    return b1, b2, prim


@kernel
def square(tables, cdf, start, shape, prim, q):
    """Where on the triangle `prim` a point q is; see `alight.shapes.rectangle.square`."""
    prim = where(prim < gather(tables.info, shape * INFO + 7), prim, 0)
    v0, e1, e2, n, area, _ = light_triangle(tables, shape, prim)
    # Barycentrics are quotients of areas: of the parts over all, along the normal.
    d, flip = q - v0, dot(cross(e1, e2), n)
    x, y = triangle_to_square(dot(cross(d, e2), n) / flip, dot(cross(e1, d), n) / flip)
    return x, y, triangle_probability(cdf, start, prim) / area
