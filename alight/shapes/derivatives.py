"""Derivatives of a surface point by its texture coordinates, for bump and normal maps."""

from __future__ import annotations

from alight.core.motion import matrix_at, point_of_rest, turned
from alight.shapes.hit import INFO
from alight.shapes.model import SHAPES
from lanewise.jit import kernel, specialised
from lanewise.records import replace
from lanewise.simd import any_lane, gather, where


@specialised
def uv_derivatives(program):
    """``(scene, surface) -> (dp/du, dp/dv)`` in the world, metres; (s, t) without shapes.

    Of the set of coordinates that the surface's `Chart` names, where it has one.
    """
    kinds = [SHAPES[name] for name in SHAPES if name in program.shapes]
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
    return replace(surface, p=point_of_rest(scene, surface))


@kernel
def _tangents(scene, surface):
    return surface.s, surface.t


@kernel
def _as_tangents(tables, k, surface):
    return surface.s, surface.t


def _chain(kinds):
    """``(tables, kind, k, surface)``: the kernel of each kind where lanes need it."""
    own = kinds[0].derivatives or _as_tangents
    if len(kinds) == 1:

        @kernel
        def last(tables, kind, k, surface):
            return own(tables, k, surface)

        return last
    number, rest = kinds[0].number, _chain(kinds[1:])

    @kernel
    def choose(tables, kind, k, surface):
        along, across = rest(tables, kind, k, surface)
        mine = kind == number
        if any_lane(mine):
            a, b = own(tables, where(mine, k, 0), surface)
            along, across = where(mine, a, along), where(mine, b, across)
        return along, across

    return choose
