"""Materials made of other materials, resolved down to the models that scatter light.

A blend is a sum w_0 f_0 + w_1 f_1 + ..., and a blend of blends is one too: each model at the bottom
(a leaf) has a share that is a product of weights and of complements 1 - weight. Kernels only see
the list of the leaves; see `alight.bsdfs.dispatch`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import ClassVar, NamedTuple, Self

from pydantic import model_validator

from alight.bsdfs.model import BSDFS
from alight.core.fields import invalid
from alight.core.spec import Bsdf, largest_of

#: Most leaves of a material: kernels visit them one after the other.
MOST_LEAVES = 32
#: Most levels of a material: functions that walk them recurse.
MOST_LEVELS = 64


class Part(NamedTuple):
    """One of the materials that a nested one is made of.

    Attributes
    ----------
    bsdf : Bsdf or str
        Description, or name of one.
    share : {"all", "weight", "rest"}
        All of the light, the part that the outer material's weight says, or the rest of it.
    is_hole : bool
        Nothing is there, seen from both sides.
    side : {"", "front", "back"}
        The only side that it is seen from, if not both.
    """

    bsdf: Bsdf | str
    share: str = "all"
    is_hole: bool = False
    side: str = ""


class Nested(Bsdf):
    """Base class of materials made of others.

    Attributes
    ----------
    makes_two_sided : bool
        Whether the parts look the same from both sides.
    weight_field : str
        Name of the field that holds the weight, or "" without one.
    bends_normals : bool
        Whether it replaces the surface's normals, see `alight.bsdfs.normals.shading_normals`.
    """

    bends_normals: ClassVar[bool] = False
    makes_two_sided: ClassVar[bool] = False
    weight_field: ClassVar[str] = ""
    one_sided: ClassVar[bool] = True

    @model_validator(mode="after")
    def _is_small(self) -> Self:
        problem = levels_problem(self) or leaves_problem(self)
        if problem:
            raise invalid(problem)
        return self

    @property
    def parts(self) -> tuple[Part, ...]:
        """What it is made of."""
        raise NotImplementedError

    def problem_of(self, nested: Bsdf | str, known: Mapping[str, Bsdf]) -> str | None:
        """Say why a material can be no part of this one; names that are not known pass."""
        return None

    def largest_weight(self) -> float | None:
        """Bound of f cos / pdf: densities are mixed with the same shares as the values."""
        return largest_of(
            None if isinstance(part.bsdf, str) else part.bsdf.largest_weight()
            for part in self.parts
        )


class Leaf(NamedTuple):
    """A model at the bottom of a material.

    Attributes
    ----------
    bsdf : Bsdf
        Not `Nested`.
    two_sided : bool
        Whether something above it makes it so.
    factors : tuple of (Nested, bool)
        Its share is their product: the weight of each, or where True, 1 - weight.
    normals : Nested, optional
        The innermost material above it that bends normals.
    side : {"", "front", "back"}
        The only side that it is seen from, if not both.
    """

    bsdf: Bsdf
    two_sided: bool = False
    factors: tuple[tuple[Nested, bool], ...] = ()
    normals: Nested | None = None
    side: str = ""


def leaves(spec: Bsdf) -> Iterator[Leaf]:
    """The models of a material whose names are resolved, in the order of the description."""
    if not isinstance(spec, Nested):
        yield Leaf(spec)
        return
    for part in spec.parts:
        if not isinstance(part.bsdf, Bsdf):
            raise ValueError(f"the name {part.bsdf!r} must be resolved before compiling")
        own = () if part.share == "all" else ((spec, part.share == "rest"),)
        for leaf in leaves(part.bsdf):
            # What is made two-sided shows its front to both sides.
            if spec.makes_two_sided and leaf.side == "back":
                continue
            side = part.side if spec.makes_two_sided else leaf.side
            two_sided = leaf.two_sided or spec.makes_two_sided
            normals = leaf.normals or (spec if spec.bends_normals else None)
            yield Leaf(leaf.bsdf, two_sided, own + leaf.factors, normals, side)


def is_matte(spec: Bsdf) -> bool:
    """Whether all models of a material are matte."""
    return all(leaf.bsdf.matte for leaf in leaves(spec))


def names_in(spec: Bsdf) -> Iterator[str]:
    """Names of materials that a description mentions, at any depth."""
    for part in spec.parts if isinstance(spec, Nested) else ():
        if isinstance(part.bsdf, str):
            yield part.bsdf
        else:
            yield from names_in(part.bsdf)


def count_leaves(spec: Bsdf | str, counts: Mapping[str, int] | None = None) -> int:
    """How many leaves a material has; names count as `counts` says, others as one."""
    if isinstance(spec, str):
        return (counts or {}).get(spec, 1)
    if not isinstance(spec, Nested):
        return 1
    return sum(count_leaves(part.bsdf, counts) for part in spec.parts)


def leaves_problem(spec: Bsdf, counts: Mapping[str, int] | None = None) -> str | None:
    """Say so if a material has too many leaves."""
    count = count_leaves(spec, counts)
    return (
        f"must hold at most {MOST_LEAVES} materials, got {count}" if count > MOST_LEAVES else None
    )


def count_levels(spec: Bsdf | str, counts: Mapping[str, int] | None = None) -> int:
    """How deep a material is nested: 1 for a model; names count as `counts` says, others as one."""
    if isinstance(spec, str):
        return (counts or {}).get(spec, 1)
    if not isinstance(spec, Nested):
        return 1
    return 1 + max(count_levels(part.bsdf, counts) for part in spec.parts)


def levels_problem(spec: Bsdf, counts: Mapping[str, int] | None = None) -> str | None:
    """Say so if a material is nested too deep."""
    count = count_levels(spec, counts)
    text = f"must be at most {MOST_LEVELS} levels deep, got {count}"
    return text if count > MOST_LEVELS else None


def find_transmissive(spec: Bsdf | str, known: Mapping[str, Bsdf]) -> Bsdf | None:
    """The first model inside a material that has two sides already.

    Names that are not known are skipped. Holes are on both sides anyway and do not count.
    """
    if isinstance(spec, str):
        return find_transmissive(known[spec], known) if spec in known else None
    if not isinstance(spec, Nested):
        return spec if spec.transmissive else None
    for part in spec.parts:
        found = None if part.is_hole else find_transmissive(part.bsdf, known)
        if found is not None:
            return found
    return None


def has_holes(spec: Bsdf | str, known: Mapping[str, Bsdf]) -> bool:
    """Whether a material has holes; names that are not known are skipped."""
    if isinstance(spec, str):
        return spec in known and has_holes(known[spec], known)
    parts = spec.parts if isinstance(spec, Nested) else ()
    return any(part.is_hole or has_holes(part.bsdf, known) for part in parts)


def scatters_inside(spec: Bsdf | str, known: Mapping[str, Bsdf] | None = None) -> bool:
    """Whether a material, or a part of it, has an inside that scatters light."""
    if isinstance(spec, str):
        return spec in (known or {}) and scatters_inside((known or {})[spec], known)
    if not isinstance(spec, Nested):
        return BSDFS[spec.type_name()].inside is not None
    return any(scatters_inside(part.bsdf, known) for part in spec.parts)
