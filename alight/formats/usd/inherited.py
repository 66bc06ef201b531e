"""What the prims above a prim hand down to it: materials and primvars.

Instances that are handed the same share what they show. A prototype has no root of its own that
could hold either, so it is read by way of an instance.

Source: Pixar, OpenUSD documentation, "Scenegraph instancing" and "UsdShadeMaterialBindingAPI".
"""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any

from alight.formats.usd.modules import Usd, UsdGeom, UsdShade
from alight.formats.usd.stage import Stage

#: Whether a prim belongs to a collection, and how a skeleton moves it, depends on where it stands.
_BY_PLACE = ("material:binding:collection", "skel:skeleton", "skel:animationSource")


def handed_down(stage: Stage, prim: Any) -> Hashable:
    """What a prim and those above it hand down to the prims below, equal where that looks alike."""
    return _bindings(prim), _primvars(stage, prim)


def constants_of(stage: Stage, prim: Any) -> tuple[tuple[str, str], ...]:
    """Names and values of the primvars that are the same all over a prim, its own or from above."""
    found = UsdGeom.PrimvarsAPI(prim).FindPrimvarsWithInheritance()
    return tuple(
        (primvar.GetPrimvarName(), str(primvar.Get(stage.time)))
        for primvar in found
        if primvar.GetInterpolation() == UsdGeom.Tokens.constant and primvar.HasValue()
    )


def shown_of(stage: Stage, prim: Any) -> str:
    """Colour and opacity that a prim shows without a material, equal where those are alike."""
    found = (
        UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(name)
        for name in ("displayColor", "displayOpacity")
    )
    text = " ".join(str(p.Get(stage.time)) if p and p.HasValue() else "" for p in found)
    return text if len(text) <= 200 else str(prim.GetPath())


def children_of(prim: Any) -> Any:
    """The prims below a prim; those of an instance as they look there."""
    if prim.IsInstance():
        return prim.GetFilteredChildren(Usd.TraverseInstanceProxies())
    # The default predicate leaves out classes, what is inactive and what is not defined.
    return prim.GetChildren()


def source_of(prim: Any) -> str:
    """Where a prim is defined: the same for one prim as it is seen by way of many instances."""
    return str((prim.GetPrimInPrototype() if prim.IsInstanceProxy() else prim).GetPath())


def _bindings(prim: Any) -> tuple[Hashable, ...]:
    """Relations that bind materials, from a prim up to the root."""
    found: list[Hashable] = []
    above = prim
    while above and not above.IsPseudoRoot():
        for name in above.GetAuthoredPropertyNames():
            if not name.startswith(("material:binding", *_BY_PLACE)):
                continue
            relation = above.GetRelationship(name)
            if name.startswith(_BY_PLACE):
                found.append(str(prim.GetPath()))
            targets = [prim.GetStage().GetPrimAtPath(path) for path in relation.GetTargets()]
            strength = UsdShade.MaterialBindingAPI.GetMaterialBindingStrength(relation)
            found.append((name, tuple(source_of(t) for t in targets if t), str(strength)))
        above = above.GetParent()
    return tuple(found)


def _primvars(stage: Stage, prim: Any) -> tuple[tuple[str, str], ...]:
    found = UsdGeom.PrimvarsAPI(prim).FindInheritablePrimvars()
    return tuple((primvar.GetPrimvarName(), str(primvar.Get(stage.time))) for primvar in found)
