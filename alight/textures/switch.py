"""The models of textures that a program uses, and kernels that choose among them."""

from __future__ import annotations

from alight.core.registry import Models, Numbers
from lanewise.jit import kernel
from lanewise.simd import any_lane, where


def models_of(program, attribute):
    """(kind number, module) of the used textures that have a kernel of this name."""
    return [
        (Numbers("textures")[name], model)
        for name, model in Models("textures").items()
        if name in program.textures and hasattr(model, attribute)
    ]


def value_switch(models):
    """Write a kernel that replaces `value` in the lanes of each of the models."""
    if not models:
        return _keep
    (number, model), rest = models[0], value_switch(models[1:])
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
