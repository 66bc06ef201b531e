"""Reading a material's parameters: a number from its table, or the value of a texture.

Every parameter has a slot in `materials.data`; `materials.texture` holds, for the first slot of a
colour or for that of a number, 0 or the index of a texture plus 1. Scenes without textures compile
to the table alone.
"""

from __future__ import annotations

from typing import Annotated, Any

from alight.core.parameters import Slots
from alight.core.vec import gather_vec3, luminance
from alight.textures.composed import composed_value, pattern_switch
from alight.textures.model import operators, patterns
from lanewise.jit import kernel, specialised
from lanewise.simd import any_lane, gather, gather_row, lanes_vec3, where


def is_textured(program) -> bool:
    """Whether any parameter varies."""
    return bool(patterns(program) or operators(program))


@kernel
def scalar(scene, slot, surface):
    """The number in a slot."""
    return gather(scene.materials.data, slot)


@kernel
def constant_color(scene, slot, surface):
    """The colour in the three slots from `slot`."""
    return gather_vec3(scene.materials.data, slot)


@specialised
def texture_value(program):
    """``texture_value(scene, texture, surface, value)``: what a texture shows at a point.

    `texture` holds the index of a texture plus 1 in each lane; lanes with 0 keep `value` (Vec3).
    """
    if operators(program):
        return composed_value(program)
    if not patterns(program):
        return _no_texture
    of_pattern = pattern_switch(program)

    @kernel
    def texture_value(scene, texture, surface, value):
        textured = texture != 0
        if any_lane(textured):
            row = where(textured, 2 * (texture - 1), 0)
            kind, base = gather_row(scene.materials.texture_info, row, 2)
            value = of_pattern(scene, surface, kind, base, textured, value)
        return value

    return texture_value


@kernel
def _no_texture(scene, texture, surface, value):
    return value


@specialised
def color(program):
    """``color(scene, slot, surface)``: the colour of a parameter at a point of a surface."""
    if not is_textured(program):
        return constant_color

    @kernel
    def fetch(scene, slot, surface):
        texture = gather(scene.materials.texture, slot)
        return texture_value(scene, texture, surface, constant_color(scene, slot, surface))

    return fetch


@specialised
def textured_scalar(program):
    """``textured_scalar(scene, slot, surface)``: the number of a parameter at a point.

    Of a texture it is the luminance.
    """
    if not is_textured(program):
        return scalar

    @kernel
    def fetch(scene, slot, surface):
        value = scalar(scene, slot, surface)
        texture = gather(scene.materials.texture, slot)
        if any_lane(texture != 0):
            color = texture_value(scene, texture, surface, lanes_vec3(0.0))
            value = where(texture != 0, luminance(color), value)
        return value

    return fetch


# ---------------------------------------------------------------- fields of a material's parameters

#: See `alight.core.parameters`. A number, a number or the luminance of a texture, a colour, a
#: colour or that of a texture.
Scalar = Annotated[Any, Slots(scalar)]
TexturedScalar = Annotated[Any, Slots(textured_scalar)]
PlainColor = Annotated[Any, Slots(constant_color, 3)]
TexturedColor = Annotated[Any, Slots(color, 3)]
