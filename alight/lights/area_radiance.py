"""Colour of area lights: one number triple, or a texture over the shape.

Only programs with `TEXTURED` in their lights look at textures.
"""

from __future__ import annotations

from alight.core.vec import gather_vec3
from alight.lights.tables import INFO, STRIDE, TEXTURED
from alight.shapes.hit import INFO as SHAPE_INFO
from alight.shapes.hit import Hit
from alight.shapes.model import SHAPES, ShapeModel
from alight.shapes.surfaces import surface_from_rest
from alight.textures.fetch import texture_value
from lanewise.jit import kernel, specialised
from lanewise.simd import any_lane, gather, lanes, lanes_u32, lanes_vec3, where


@specialised
def emitted_color(program):
    """``emitted_color(scene, index, surface)``: radiance of the lights `index` at their surface."""
    if TEXTURED not in program.lights:

        @kernel
        def constant(scene, index, surface):
            return gather_vec3(scene.lights.data, index * STRIDE)

        return constant

    @kernel
    def varying(scene, index, surface):
        # Of a scene's only light the colour is the same for all lanes, its texture's is not.
        color = lanes_vec3(1.0) * gather_vec3(scene.lights.data, index * STRIDE)
        texture = gather(scene.lights.info, index * INFO + 2)
        return texture_value(scene, texture, surface, color)

    return varying


@specialised
def sampled_color(program):
    """``sampled_color(scene, index, p, s, u, u2)``: radiance over the light's colour at a sample.

    `s` is the `ShapeSample` that the numbers u and u2 gave, seen from p.
    """
    if TEXTURED not in program.lights:

        @kernel
        def one(scene, index, p, s, u, u2):
            return lanes_vec3(1.0)

        return one

    @kernel
    def of_the_texture(scene, index, p, s, u, u2):
        info = scene.lights.info
        color, texture = lanes_vec3(1.0), gather(info, index * INFO + 2)
        textured = texture != 0
        if any_lane(textured):
            shape, start = gather(info, index * INFO + 1), gather(info, index * INFO + 3)
            x, y, prim = coordinates(scene, shape, start, p + s.distance * s.wi, u, u2)
            hit = Hit(s.distance, x, y, shape, prim)
            surface = surface_from_rest(scene, hit, p, s.wi, textured)
            color = texture_value(scene, texture, surface, color)
        return color

    return of_the_texture


@specialised
def coordinates(program):
    """``coordinates(scene, shape, start, q, u, u2) -> (u, v, prim)``: a sample as a `Hit` has it.

    `q` is the sampled point.
    """
    chain = _chain([SHAPES[name] for name in program.light_shapes if SHAPES[name].coordinates])

    @kernel
    def by_kind(scene, shape, start, q, u, u2):
        kind = gather(scene.shapes.info, shape * SHAPE_INFO)
        return chain(scene, kind, shape, start, q, u, u2)

    return by_kind


@kernel
def _known_by_its_point(scene, kind, shape, start, q, u, u2):
    return lanes(0.0), lanes(0.0), lanes_u32(0)


def _chain(shapes: list[ShapeModel]):
    """The kernel of each kind where lanes need it."""
    if not shapes:
        return _known_by_its_point
    own, number, others = shapes[0].coordinates, shapes[0].number, _chain(shapes[1:])
    assert own is not None

    @kernel
    def choose(scene, kind, shape, start, q, u, u2):
        x, y, prim = others(scene, kind, shape, start, q, u, u2)
        mine = kind == number
        if any_lane(mine):
            first = where(mine, start, 0)
            x1, y1, prim1 = own(scene.shapes, scene.lights.cdf, first, shape, q, u, u2)
            x, y, prim = where(mine, x1, x), where(mine, y1, y), where(mine, prim1, prim)
        return x, y, prim

    return choose
