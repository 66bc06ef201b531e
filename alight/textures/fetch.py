"""Reading a material's parameters: a number from its table, or the value of a texture.

Every parameter has a slot in `materials.data`; `materials.texture` holds, for the first slot of a
colour, 0 or the index of a texture plus 1. Scenes without textures compile to the table alone.
"""

from __future__ import annotations

from alight.core.jit import kernel, specialised
from alight.core.simd import any_lane, gather, where
from alight.core.vec import Vec3
from alight.textures import MODELS


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
def color(program):
    """``color(scene, slot, surface)``: the colour of a parameter at a point of a surface."""
    used = [
        (number, model)
        for number, model in enumerate(MODELS)
        if model.EXAMPLES[0].type_name() in program.textures and hasattr(model, "evaluate")
    ]
    if not used:
        return constant_color
    varying = _switch(used)

    @kernel
    def fetch(scene, slot, surface):
        value = constant_color(scene, slot, surface)
        texture = gather(scene.materials.texture, slot)
        textured = texture != 0
        if any_lane(textured):
            row = where(textured, 2 * (texture - 1), 0)
            kind = gather(scene.materials.texture_info, row)
            base = gather(scene.materials.texture_info, row + 1)
            value = varying(scene, kind, base, surface, textured, value)
        return value

    return fetch


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
