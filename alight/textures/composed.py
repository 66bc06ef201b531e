"""Textures made of others, in kernels: a list of steps over a stack of colours.

`texture_info` holds for such a texture (COMPOSED + the number of its steps, the row of the first);
a step is a row of (kind, start in `texture_data`) like that of a plain texture. See
`alight.textures.nesting` for the order of the steps.
"""

from __future__ import annotations

from alight.core.registry import Numbers
from alight.core.vec import Vec3
from alight.textures.switch import models_of, value_switch
from lanewise.jit import kernel
from lanewise.simd import any_lane, gather, lanes_mask, lanes_vec3, where

#: Added to the number of steps.
COMPOSED = 1 << 31


def composed_value(program):
    """``texture_value`` of programs with operators, see `alight.textures.fetch`."""
    varying, operating = value_switch(models_of(program, "evaluate")), _operators(program)
    is_operator = _is_operator([number for number, _ in models_of(program, "operate")])
    constant_kind = Numbers("textures")["constant"]

    @kernel
    def leaf_value(scene, kind, base, surface, active):
        data = scene.materials.texture_data
        plain = where(active & (kind == constant_kind), base, 0)
        value = Vec3(gather(data, plain), gather(data, plain + 1), gather(data, plain + 2))
        return varying(scene, kind, base, surface, active, value)

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
            a, b, c, d, e, f = zero, zero, zero, zero, zero, zero
            more = textured & (step < end)
            while any_lane(more):
                at = where(more, step, 0)
                kind, base = gather(info, at), gather(info, at + 1)
                operates = is_operator(kind)
                pushed = more & ~operates
                if any_lane(pushed):
                    new = leaf_value(scene, kind, base, surface, pushed)
                    f, e, d = where(pushed, e, f), where(pushed, d, e), where(pushed, c, d)
                    c, b, a = where(pushed, b, c), where(pushed, a, b), where(pushed, new, a)
                mine = more & operates
                if any_lane(mine):
                    a, b, c, d, e, f = operating(scene, kind, base, mine, a, b, c, d, e, f)
                step = step + 2
                more = textured & (step < end)
            value = where(textured, a, value)
        return value

    return texture_value


def _is_operator(numbers):
    """A kernel that says which kinds are operators."""
    if not numbers:
        return _never
    number, rest = numbers[0], _is_operator(numbers[1:])

    @kernel
    def either(kind):
        return (kind == number) | rest(kind)

    return either


@kernel
def _never(kind):
    return lanes_mask(False)


def _operators(program):
    """A kernel that lets the operator of each lane work on the top of the stack."""
    chain = _keep
    for number, model in reversed(models_of(program, "operate")):
        parts = len(type(model.EXAMPLES[0]).fields)
        chain = _operator(number, _on_stack(model.operate, parts), chain)
    return chain


def _operator(number, work, rest):
    @kernel
    def step(scene, kind, base, active, a, b, c, d, e, f):
        mine = active & (kind == number)
        if any_lane(mine):
            data = scene.materials.texture_data
            a, b, c, d, e, f = work(data, where(mine, base, 0), mine, a, b, c, d, e, f)
        return rest(scene, kind, base, active, a, b, c, d, e, f)

    return step


def _on_stack(operate, parts):
    """A kernel that pops this many values; the first part lies deepest."""
    if parts == 1:

        @kernel
        def one(data, base, mine, a, b, c, d, e, f):
            return where(mine, operate(data, base, a), a), b, c, d, e, f

        return one
    if parts == 2:

        @kernel
        def two(data, base, mine, a, b, c, d, e, f):
            a = where(mine, operate(data, base, b, a), a)
            b, c = where(mine, c, b), where(mine, d, c)
            return a, b, c, where(mine, e, d), where(mine, f, e), f

        return two

    @kernel
    def three(data, base, mine, a, b, c, d, e, f):
        a = where(mine, operate(data, base, c, b, a), a)
        b, c = where(mine, d, b), where(mine, e, c)
        return a, b, c, where(mine, f, d), e, f

    return three


@kernel
def _keep(scene, kind, base, active, a, b, c, d, e, f):
    return a, b, c, d, e, f
