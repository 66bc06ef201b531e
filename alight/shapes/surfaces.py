"""The surface at a hit, whatever shapes the scene has, specialised for each program."""

from __future__ import annotations

from alight.core.frame import frame_from_normal, frame_from_tangent
from alight.core.motion import (
    direction_at_rest,
    error_in_world,
    inverse_rows,
    matrix_at,
    placed,
    point_at_rest,
    turned,
)
from alight.core.uv_sets import UV_SETS, Chart
from alight.core.vec import Vec3, dot, normalize
from alight.core.wavelengths import DISPERSIVE, LINE_D
from alight.shapes.charts import corners_of
from alight.shapes.hit import INFO, Bend, Geometry, Surface, is_bent_below
from alight.shapes.model import SHAPES, ShapeModel
from lanewise.jit import kernel, specialised
from lanewise.simd import (
    any_lane,
    gather,
    gather_row,
    lanes,
    lanes_mask,
    lanes_u32,
    lanes_vec3,
    where,
)


def needs_tangents(program) -> bool:
    """True if a material of the program is not the same all around the normal."""
    return "anisotropic" in program.bsdfs


@kernel
def blank():
    """A `Geometry` of zeros in every lane."""
    zero, vector = lanes(0.0), lanes_vec3(0.0)
    return Geometry(
        p=vector, error=zero, ng=vector, ns=vector, s=vector, t=vector, u=zero, v=zero, color=vector
    )


def _chain(kinds: tuple[ShapeModel, ...]):
    """A kernel that runs the surface kernel of each kind for the lanes that hit one."""
    if not kinds:

        @kernel
        def nothing(tables, kind, k, hit, o, d, active):
            return blank()

        return nothing
    number, surface, rest = kinds[0].number, kinds[0].surface, _chain(kinds[1:])
    assert surface is not None

    @kernel
    def choose(tables, kind, k, hit, o, d, active):
        result = rest(tables, kind, k, hit, o, d, active)
        mine = active & (kind == number)
        if any_lane(mine):
            result = where(mine, surface(tables, k, hit, o, d), result)
        return result

    return choose


@specialised
def find_geometry(program):
    """``find_geometry(tables, kind, k, hit, o, d, active) -> Geometry``."""
    kinds = tuple(SHAPES[name] for name in SHAPES if name in program.shapes)
    if len(kinds) != 1:
        return _chain(kinds)
    surface = kinds[0].surface
    assert surface is not None

    @kernel
    def only(tables, kind, k, hit, o, d, active):
        return surface(tables, k, hit, o, d)

    return only


@specialised
def tangents(program):
    """``tangents(geometry) -> (s, t)``: the shape's own where a model reads them, else any.

    A scene of isotropic materials does not see the difference, and need not look the shape's up.
    """
    if needs_tangents(program):

        @kernel
        def of_the_shape(g):
            return g.s, g.t

        return of_the_shape

    @kernel
    def of_the_normal(g):
        return frame_from_normal(g.ns)

    return of_the_normal


@specialised
def chart_of(program):
    """``chart_of(tables, hit)``: its `alight.core.uv_sets.Chart`, () where nothing asks for it."""
    if UV_SETS not in program.textures:
        return _no_chart

    @kernel
    def on_triangle(tables, hit):
        corners = corners_of(tables, hit.shape, hit.prim)
        return Chart(hit.u, hit.v, corners, lanes_u32(0))

    return on_triangle


@specialised
def usual_wavelength(program):
    """``usual_wavelength()``: the line d, for whoever follows no wavelength of its own."""
    return _line_d if DISPERSIVE in program.bsdfs else _no_wavelength


@kernel
def _line_d():
    return lanes(LINE_D)


@kernel
def _no_wavelength():
    return ()


@specialised
def usual_bend(program):
    """``usual_bend()``: none, before a map is looked at."""
    return unbent if is_bent_below(program) else _no_bend


@kernel
def unbent():
    """The `Bend` of a surface without a map."""
    zero, one = lanes(0.0), lanes(1.0)
    x, y, z = Vec3(one, zero, zero), Vec3(zero, one, zero), Vec3(zero, zero, one)
    return Bend(x, y, z, lanes_mask(False))


@kernel
def _no_bend():
    return ()


@kernel
def _no_chart(tables, hit):
    return ()


@specialised
def make_surface(program):
    """``make_surface(scene, hit, o, d, active)``: `surface_at_rest`, at the times of the rays."""
    if "shapes" not in program.motion:
        return surface_at_rest

    @kernel
    def make_moving_surface(scene, hit, o, d, active):
        number = gather(scene.motions.of_shape, hit.shape)
        moving = active & (number != 0)
        if any_lane(moving):
            m = matrix_at(scene.motions, where(moving, number - 1, 0), scene.time)
            w = inverse_rows(m)
            o = where(moving, point_at_rest(w, o), o)
            d = where(moving, direction_at_rest(w, d), d)
        return surface_from_rest(scene, hit, o, d, active)

    return make_moving_surface


@specialised
def surface_from_rest(program):
    """``surface_from_rest(scene, hit, o, d, active)``: `make_surface` for rays taken to rest."""
    if "shapes" not in program.motion:
        return surface_at_rest

    @kernel
    def moved_surface(scene, hit, o, d, active):
        surface = surface_at_rest(scene, hit, o, d, active)
        number = gather(scene.motions.of_shape, hit.shape)
        moving = active & (number != 0)
        if any_lane(moving):
            m = matrix_at(scene.motions, where(moving, number - 1, 0), scene.time)
            surface = _in_the_world(m, inverse_rows(m), surface, moving)
        return surface

    return moved_surface


@kernel
def _in_the_world(m, w, surface, moving):
    """A surface as it is at its time, from what it is at rest."""
    p = placed(m, surface.p)
    error = error_in_world(m, w, surface.p, surface.ng, surface.error)
    # Normals by the inverse transpose: they keep their side, mirrored or not.
    ng, ns = normalize(turned(w, surface.ng)), normalize(turned(w, surface.ns))
    # The tangent of the shape itself lies in its surface: s lost what stood along the old ns.
    tangent = dot(surface.ns, surface.ng) * surface.s - dot(surface.s, surface.ng) * surface.ns
    s, t = frame_from_tangent(ns, turned(m, tangent))
    return Surface(
        p=where(moving, p, surface.p),
        error=where(moving, error, surface.error),
        ng=where(moving, ng, surface.ng),
        ns=where(moving, ns, surface.ns),
        s=where(moving, s, surface.s),
        t=where(moving, t, surface.t),
        u=surface.u,
        v=surface.v,
        shape=surface.shape,
        prim=surface.prim,
        bsdf=surface.bsdf,
        light=surface.light,
        color=surface.color,
        chart=surface.chart,
        wavelength=surface.wavelength,
        bend=surface.bend,
    )


@kernel
def surface_at_rest(scene, hit, o, d, active):
    """Describe the surfaces that rays have hit, before what moves has moved.

    Parameters
    ----------
    scene : namedtuple
        With the field `shapes`.
    hit : Hit
        Of `intersect_closest`.
    o, d : Vec3
        The rays.
    active : mask
        Lanes that hit something; the others get valid but meaningless numbers.

    Returns
    -------
    Surface
    """
    tables = scene.shapes
    kind, bsdf, light, k = gather_row(tables.info, hit.shape * INFO, 4)
    g = find_geometry(tables, kind, k, hit, o, d, active)
    s, t = tangents(g)
    chart = chart_of(tables, hit)
    return Surface(
        p=g.p,
        error=g.error,
        ng=g.ng,
        ns=g.ns,
        s=s,
        t=t,
        u=g.u,
        v=g.v,
        shape=hit.shape,
        prim=hit.prim,
        bsdf=bsdf,
        light=light,
        color=g.color,
        chart=chart,
        wavelength=usual_wavelength(),
        bend=usual_bend(),
    )
