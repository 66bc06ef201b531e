"""Colour of area lights, one number triple or a texture over the shape, and points chosen by it.

Only programs with `TEXTURED` in their lights look at textures, and only those with `MAPPED` choose
points by them.
"""

from __future__ import annotations

from alight.core.constants import ONE_MINUS_EPSILON
from alight.core.switch import is_one_of
from alight.core.vec import dot, gather_vec3, length_squared
from alight.lights.area_map import draw, map_at, mixed_pdf, share_of, square_of
from alight.lights.shining import sample_area, sample_shape, shape_pdf
from alight.lights.tables import INFO, MAPPED, STRIDE, TEXTURED
from alight.shapes.hit import INFO as SHAPE_INFO
from alight.shapes.hit import Hit, ShapeHit, ShapeSample
from alight.shapes.model import SHAPES, ShapeModel
from alight.shapes.surfaces import surface_at_rest, surface_from_rest
from alight.textures.fetch import texture_value
from lanewise.jit import kernel, specialised
from lanewise.records import replace
from lanewise.simd import (
    any_lane,
    gather,
    lanes,
    lanes_mask,
    lanes_u32,
    lanes_vec3,
    maximum,
    minimum,
    sqrt,
    where,
)


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
def sample_point(program):
    """``sample_point(scene, index, p, u, u2) -> (ShapeSample, radiance over the light's colour)``.

    Of the lights `index` seen from p; u, u2: uniform in [0, 1).
    """
    if TEXTURED not in program.lights:

        @kernel
        def by_shape(scene, index, p, u, u2):
            info = scene.lights.info
            shape, start = gather(info, index * INFO + 1), gather(info, index * INFO + 3)
            s = sample_shape(scene.shapes, scene.lights.cdf, start, shape, p, u, u2)
            return s, lanes_vec3(1.0)

        return by_shape

    if MAPPED not in program.lights:

        @kernel
        def colored(scene, index, p, u, u2):
            info = scene.lights.info
            shape, start = gather(info, index * INFO + 1), gather(info, index * INFO + 3)
            s = sample_shape(scene.shapes, scene.lights.cdf, start, shape, p, u, u2)
            color, texture = lanes_vec3(1.0), gather(info, index * INFO + 2)
            textured = texture != 0
            if any_lane(textured):
                x, y, prim = coordinates(scene, shape, start, p + s.distance * s.wi, u, u2)
                hit = Hit(s.distance, x, y, shape, prim)
                surface = surface_from_rest(scene, hit, p, s.wi, textured)
                color = texture_value(scene, texture, surface, color)
            return s, color

        return colored

    @kernel
    def by_texture(scene, index, p, u, u2):
        info, cdf = scene.lights.info, scene.lights.cdf
        shape, start = gather(info, index * INFO + 1), gather(info, index * INFO + 3)
        texture = gather(info, index * INFO + 2)
        textured = lanes_u32(0) + texture != 0
        at, by_map, numbers = _choose(scene, index, textured, p, u, u2)
        s = sample_shape(scene.shapes, cdf, start, shape, p, u, numbers)
        # Of a scene's only light the error bound is the same for all lanes.
        s = replace(s, error=lanes(0.0) + s.error)
        color = lanes_vec3(1.0)
        if any_lane(textured):
            s = _placed(scene, shape, start, p, numbers, by_map, s)
            x, y, prim = coordinates(scene, shape, start, p + s.distance * s.wi, u, numbers)
            hit = Hit(s.distance, x, y, shape, prim)
            at_rest, surface = _surfaces(scene, hit, p, s.wi, textured)
            color = texture_value(scene, texture, surface, color)
            cosine = where(by_map, -dot(s.wi, at_rest.ng), s.cosine)
            error = where(by_map, at_rest.error, s.error)
            met = ShapeHit(prim, s.wi, s.distance, cosine)
            density = s.pdf
            if any_lane(by_map):
                own = shape_pdf(scene.shapes, cdf, start, shape, p, met)
                density = where(by_map, own, density)
            x, y, per_area = square_of(scene, shape, start, prim, p + s.distance * s.wi)
            square = where(by_map, numbers[0], x), where(by_map, numbers[1], y), per_area
            density = mixed_pdf(scene, at, square, p, met, density)
            s = ShapeSample(s.wi, s.distance, cosine, error, density)
        return s, color

    return by_texture


@specialised
def point_pdf(program):
    """``point_pdf(scene, index, p, hit)``: density of `sample_point` at a `ShapeHit`."""

    @kernel
    def of_the_shape(scene, index, p, hit):
        info = scene.lights.info
        shape, start = gather(info, index * INFO + 1), gather(info, index * INFO + 3)
        return shape_pdf(scene.shapes, scene.lights.cdf, start, shape, p, hit)

    if MAPPED not in program.lights:
        return of_the_shape

    @kernel
    def of_both(scene, index, p, hit):
        info = scene.lights.info
        density = of_the_shape(scene, index, p, hit)
        textured = lanes_u32(0) + gather(info, index * INFO + 2) != 0
        if any_lane(textured):
            shape, start = gather(info, index * INFO + 1), gather(info, index * INFO + 3)
            at = map_at(scene, index, hit.prim)
            square = square_of(scene, shape, start, hit.prim, p + hit.distance * hit.wi)
            density = mixed_pdf(scene, at, square, p, hit, density)
        return density

    return of_both


@kernel
def _choose(scene, index, textured, p, u, u2):
    """(where their maps begin, mask: a point is drawn by the map, numbers that it comes from)."""
    at, by_map, x, y = lanes_u32(0), lanes_mask(False), u2[0], u2[1]
    if any_lane(textured):
        info = scene.lights.info
        shape, start = gather(info, index * INFO + 1), gather(info, index * INFO + 3)
        _, _, prim = coordinates(scene, shape, start, p, u, u2)
        at = map_at(scene, index, prim)
        if any_lane(at != 0):
            share = share_of(scene, at, p)
            by_map = x < share
            # Either way what is left of the first number is uniform again.
            left, right = x / where(by_map, share, 1.0), (x - share) / maximum(1.0 - share, 1e-30)
            x = minimum(where(by_map, left, right), ONE_MINUS_EPSILON)
            a, b = draw(scene, at, u, (x, y))
            x, y = where(by_map, a, x), where(by_map, b, y)
    return at, by_map, (x, y)


@specialised
def _placed(program):
    """``(scene, shape, start, p, u2, by_map, s)``: s, in the lanes of `by_map` as by area.

    Of shapes with a formula, whose own samples need not be.
    """
    models = [SHAPES[name] for name in program.light_shapes]
    numbers = [model.number for model in models if model.has_formula and model.square]
    has_formula = is_one_of(numbers)

    @kernel
    def placed(scene, shape, start, p, u2, by_map, s):
        kind = lanes_u32(0) + gather(scene.shapes.info, shape * SHAPE_INFO)
        mine = by_map & has_formula(kind)
        if any_lane(mine):
            point = sample_area(scene.shapes, scene.lights.cdf, start, shape, u2[0], u2).p
            to_light = point - p
            distance = sqrt(length_squared(to_light))
            wi = to_light * (1.0 / maximum(distance, 1e-30))
            wi, distance = where(mine, wi, s.wi), where(mine, distance, s.distance)
            s = ShapeSample(wi, distance, s.cosine, s.error, s.pdf)
        return s

    return placed


@specialised
def _surfaces(program):
    """``(scene, hit, o, d, active)``: surfaces before what moves has moved, and afterwards."""
    moves = "shapes" in program.motion

    @kernel
    def both(scene, hit, o, d, active):
        at_rest = surface_at_rest(scene, hit, o, d, active)
        if moves:
            return at_rest, surface_from_rest(scene, hit, o, d, active)
        return at_rest, at_rest

    return both


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
