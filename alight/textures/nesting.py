r"""Textures made of other textures: their parts, and the steps to evaluate them.

Kernels do not call each other recursively. A texture made of others is written as a list of steps
in postfix order (Lukasiewicz): a texture without parts puts its value on a stack, an
operator takes the values of its parts from there and leaves its own. The stack is `REGISTERS`
colours deep. An operator whose parts commute has the one first that needs the
deepest stack (Sethi and Ullman).

Source: Sethi and Ullman, The generation of optimal code for arithmetic expressions, Journal of the
ACM 17(4), 1970.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import ClassVar, Self

import numpy as np
from pydantic import model_validator

from alight.core.field_types import Triple
from alight.core.fields import invalid
from alight.core.spec import Texture

#: Most steps of a texture: kernels run them one after the other.
MOST_STEPS = 64
#: Depth of the stack of kernels.
REGISTERS = 6

Value = Triple | float | Texture | str


class Composed(Texture):
    """Base class of textures made of others.

    Attributes
    ----------
    fields : tuple of str
        Names of the fields that hold the parts, in the order in which `operate` takes them.
    commutes : bool
        Whether the parts may be exchanged.
    """

    fields: ClassVar[tuple[str, ...]] = ("a", "b")
    commutes: ClassVar[bool] = False

    @model_validator(mode="after")
    def _has_few_steps(self) -> Self:
        problem = steps_problem(self)
        if problem:
            raise invalid(problem)
        return self

    @property
    def parts(self) -> tuple[Value, ...]:
        """What it is made of."""
        return tuple(getattr(self, name) for name in self.fields)

    def set_of_coordinates(self) -> int | None:
        """That of the first part which has one."""
        found = (p.set_of_coordinates() for p in self.parts if isinstance(p, Texture))
        return next((number for number in found if number is not None), None)

    def lookup(self) -> np.ndarray | None:
        """That of the first part which has one."""
        found = (p.lookup() for p in self.parts if isinstance(p, Texture))
        return next((matrix for matrix in found if matrix is not None), None)

    @property
    def ordered(self) -> tuple[Value, ...]:
        """The parts in the order in which kernels compute them."""
        if not self.commutes:
            return self.parts
        return tuple(sorted(self.parts, key=depth_of, reverse=True))


def most(part: Value) -> Triple:
    """Largest value of each channel of a part; 0 for names, which are not known yet."""
    if isinstance(part, Texture):
        return part.maximum()
    if isinstance(part, str):
        return (0.0, 0.0, 0.0)
    return part if isinstance(part, tuple) else (part, part, part)


def average(part: Value) -> Triple:
    """Mean of each channel of a part; 0 for names, which are not known yet."""
    return part.mean() if isinstance(part, Texture) else most(part)


def reads_uv(part: Value, named: Mapping[str, Texture]) -> bool:
    """Whether a texture is looked up in (u, v) anywhere; solid ones are looked up in space.

    Names stand for those of `named`, unknown ones for none; circles are found elsewhere.
    """
    if isinstance(part, str):
        others = {name: texture for name, texture in named.items() if name != part}
        return part in named and reads_uv(named[part], others)
    if isinstance(part, Composed):
        return any(reads_uv(inner, named) for inner in part.parts)
    return isinstance(part, Texture) and part.set_of_coordinates() is not None


def names_in(spec: Texture) -> Iterator[str]:
    """Names of textures that a description mentions, at any depth."""
    for part in spec.parts if isinstance(spec, Composed) else ():
        if isinstance(part, str):
            yield part
        elif isinstance(part, Texture):
            yield from names_in(part)


def count_steps(part: Value, counts: Mapping[str, int] | None = None) -> int:
    """How many steps a texture takes; names count as `counts` says, others as one."""
    if isinstance(part, str):
        return (counts or {}).get(part, 1)
    if not isinstance(part, Composed):
        return 1
    return 1 + sum(count_steps(inner, counts) for inner in part.parts)


def depth_of(part: Value) -> int:
    """How deep a stack a texture needs; names count as one step."""
    if not isinstance(part, Composed):
        return 1
    depths = [depth_of(inner) for inner in part.parts]
    if part.commutes:
        depths.sort(reverse=True)
    return max(i + depth for i, depth in enumerate(depths))


def steps_problem(spec: Texture, counts: Mapping[str, int] | None = None) -> str | None:
    """Say so if a texture takes too many steps, or too deep a stack."""
    count = count_steps(spec, counts)
    if count > MOST_STEPS:
        return f"must be made of at most {MOST_STEPS} textures and colours, got {count}"
    depth = depth_of(spec)
    if depth > REGISTERS:
        return f"must be nested so that at most {REGISTERS} values are kept, got {depth}"
    return None
