"""Textures made of others, in kernels: a list of steps over a stack of colours.

`texture_info` holds for such a texture (COMPOSED + the number of its steps, the row of the first);
a step is a row of (kind, start in `texture_data`) like that of a plain texture. See
`alight.textures.nesting` for the order of the steps.
"""

from __future__ import annotations

from collections import namedtuple

from alight.core.switch import is_one_of, switch
from alight.core.vec import gather_vec3
from alight.textures.model import constants, operators, patterns
from lanewise.jit import kernel
from lanewise.records import replace
from lanewise.simd import any_lane, gather, lanes_vec3, where

#: Added to the number of steps.
COMPOSED = 1 << 31


#: Colours, that of the last step first: as many as `alight.textures.nesting.REGISTERS`.
Stack = namedtuple("Stack", "a b c d e f")


def pattern_switch(program):
    """Write ``(scene, surface, kind, base, active, value) -> Vec3``: textures without parts.

    The value stays where the texture is none of them.
    """
    return switch((model.number, _evaluating(model)) for model in patterns(program))


def _evaluating(model):
    evaluate = model.evaluate

    @kernel
    def answer(scene, surface, kind, base, mine, value):
        return evaluate(scene, where(mine, base, 0), surface)

    return answer


def composed_value(program):
    """``texture_value`` of programs with operators, see `alight.textures.fetch`."""
    of_pattern = pattern_switch(program)
    operate = switch((model.number, _operating(model)) for model in operators(program))
    is_operator = is_one_of(model.number for model in operators(program))
    is_constant = is_one_of(model.number for model in constants(program))

    @kernel
    def leaf_value(scene, surface, kind, base, active):
        plain = where(active & is_constant(kind), base, 0)
        value = gather_vec3(scene.materials.texture_data, plain)
        return of_pattern(scene, surface, kind, base, active, value)

    @kernel
    def texture_value(scene, texture, surface, value):
        textured = texture != 0
        if any_lane(textured):
            info = scene.materials.texture_info
            row = where(textured, 2 * (texture - 1), 0)
            head = gather(info, row)
            is_list = head >= COMPOSED
            step = where(is_list, gather(info, row + 1), row)
            end = step + where(is_list, 2 * (head - COMPOSED), 2)
            zero = lanes_vec3(0.0)
            s = Stack(zero, zero, zero, zero, zero, zero)
            more = textured & (step < end)
            while any_lane(more):
                at = where(more, step, 0)
                kind, base = gather(info, at), gather(info, at + 1)
                operates = is_operator(kind)
                pushed = more & ~operates
                if any_lane(pushed):
                    new = leaf_value(scene, surface, kind, base, pushed)
                    s = where(pushed, Stack(new, s.a, s.b, s.c, s.d, s.e), s)
                s = operate(scene, surface, kind, base, more & operates, s)
                step = step + 2
                more = textured & (step < end)
            value = where(textured, s.a, value)
        return value

    return texture_value


def _operating(model):
    """What an operator makes of the stack; the first of its parts lies deepest."""
    load, pop = model.load, _POPS[len(model.spec.fields)](model.operate)

    @kernel
    def answer(scene, surface, kind, base, mine, stack):
        return pop(load(scene, where(mine, base, 0), surface), stack)

    return answer


def _pop_one(operate):
    @kernel
    def one(params, s):
        return replace(s, a=operate(params, s.a))

    return one


def _pop_two(operate):
    @kernel
    def two(params, s):
        return Stack(operate(params, s.b, s.a), s.c, s.d, s.e, s.f, s.f)

    return two


def _pop_three(operate):
    @kernel
    def three(params, s):
        return Stack(operate(params, s.c, s.b, s.a), s.d, s.e, s.f, s.f, s.f)

    return three


#: By how many parts an operator takes.
_POPS = {1: _pop_one, 2: _pop_two, 3: _pop_three}
