"""Controls of UsdLux that no real light has: they are ignored, and reported where they are used.

Source: Pixar, OpenUSD documentation, UsdLux: "LightAPI", "ShadowAPI", "LightFilter".
"""

from __future__ import annotations

from typing import Any

from alight.formats.usd.modules import UsdLux
from alight.formats.usd.stage import Stage

#: Attributes, the value that changes nothing, and the remark on any other.
_CONTROLS: tuple[tuple[str, Any, str], ...] = (
    ("inputs:diffuse", 1.0, "it shines on matte and shiny surfaces alike (diffuse)"),
    ("inputs:specular", 1.0, "it shines on matte and shiny surfaces alike (specular)"),
    ("inputs:shadow:enable", True, "it casts shadows all the same (shadow:enable)"),
    ("inputs:shadow:color", (0.0, 0.0, 0.0), "its shadows are without light (shadow:color)"),
    ("inputs:shadow:distance", -1.0, "its shadows reach as far as light does (shadow:distance)"),
    ("inputs:shadow:falloff", -1.0, "its shadows do not fade (shadow:falloff)"),
)
#: Collections of the prims that a light shines on, or that cast its shadows.
_LINKS = ("lightLink", "shadowLink")


def say_what_is_unphysical(stage: Stage, prim: Any) -> None:
    """Tell of the controls of a light that are left out."""

    def tell(text: str) -> None:
        stage.report.approximate(f"{prim.GetPath()}: {text}")

    for name, plain, text in _CONTROLS:
        value = stage.alike(prim.GetAttribute(name), plain)
        if value != plain:
            tell(text)
    for name in _LINKS:
        everything = stage.alike(prim.GetAttribute(f"collection:{name}:includeRoot"), True)
        excluded = prim.GetRelationship(f"collection:{name}:excludes")
        if not everything or (excluded and excluded.GetTargets()):
            tell(f"it shines on everything, and everything casts its shadows ({name})")
    filters = UsdLux.LightAPI(prim).GetFiltersRel()
    if filters and filters.GetTargets():
        tell("its filters are left out")
