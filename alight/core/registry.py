"""The models of every family, by the name that scene files use.

A family is a package with one file per model and a tuple ``MODELS`` of those modules. Families
are imported by name at the first use: integrators live above the scene in the order of imports
(they run on the compiled scene), yet a scene file names them.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from types import ModuleType

    from alight.core.spec import Spec

FAMILIES = (
    "shapes",
    "bsdfs",
    "textures",
    "lights",
    "cameras",
    "samplers",
    "filters",
    "integrators",
)


@cache
def modules(family: str) -> tuple[ModuleType, ...]:
    """List the model modules of a family, in the order of its registry tuple."""
    return import_module(f"alight.{family}").MODELS


@cache
def specs(family: str) -> dict[str, type[Spec]]:
    """Map type names to description classes, for one family.

    Examples
    --------
    >>> sorted(specs("textures"))
    ['checkerboard', 'constant', 'vertex_color']
    """
    found = (type(module.EXAMPLES[0]) for module in modules(family))
    return {spec.type_name(): spec for spec in found}
