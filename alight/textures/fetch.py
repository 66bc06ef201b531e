"""Reading a material's parameters: a number from its table, or the value of a texture.

Every parameter has a slot in `materials.data`; `materials.texture` holds, for the first slot of a
colour or for that of a number, 0 or the index of a texture plus 1. Scenes without textures compile
to the table alone.
"""

from __future__ import annotations

from alight.core.jit import kernel, specialised
from alight.core.registry import modules
from alight.core.simd import any_lane, gather, lanes_vec3, where
from alight.core.vec import Vec3, luminance


@kernel
def scalar(scene, slot, surface):
    """The number in a slot."""
    return gather(scene.materials.data, slot)


@kernel
def constant_color(scene, slot, surface):
    """The colour in the three slots from `slot`."""
    data = scene.materials.data
    return Vec3(gather(data, slot), gather(data, slot + 1), gather(data, slot + 2))


@specialised
def texture_value(program):
    """``texture_value(scene, texture, surface, value)``: what a texture shows at a point.

    `texture` holds the index of a texture plus 1 in each lane; lanes with 0 keep `value` (Vec3).
    """
    used = _models(program)
    if not used:
        return _no_texture
    varying = _switch(used)

    @kernel
    def texture_value(scene, texture, surface, value):
        textured = texture != 0
        if any_lane(textured):
            row = where(textured, 2 * (texture - 1), 0)
            kind = gather(scene.materials.texture_info, row)
            base = gather(scene.materials.texture_info, row + 1)
            value = varying(scene, kind, base, surface, textured, value)
        return value

    return texture_value


@kernel
def _no_texture(scene, texture, surface, value):
    return value


@specialised
def color(program):
    """``color(scene, slot, surface)``: the colour of a parameter at a point of a surface."""
    if not _models(program):
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
    if not _models(program):
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


def _models(program):
    """(kind number, module) of the textures that a program uses, constant ones left out."""
    return [
        (number, model)
        for number, model in enumerate(modules("textures"))
        if model.EXAMPLES[0].type_name() in program.textures and hasattr(model, "evaluate")
    ]


def _switch(models):
    """Write a kernel that replaces `value` in the lanes of each of the models."""
    if not models:
        return _keep
    (number, model), rest = models[0], _switch(models[1:])
    evaluate = model.evaluate

    @kernel
    def step(scene, kind, base, surface, active, value):
        mine = active & (kind == number)
        if any_lane(mine):
            safe = where(mine, base, 0)
            value = where(mine, evaluate(scene, safe, surface), value)
        return rest(scene, kind, base, surface, active, value)

    return step


@kernel
def _keep(scene, kind, base, surface, active, value):
    return value
