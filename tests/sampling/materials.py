"""Every registered BSDF and every example of it, through the tables and the dispatcher."""

from collections import namedtuple

from alight.bsdfs import MODELS
from alight.laws.materials import Material, Scene, Shapes, direction, random_numbers, unit_interval

#: The fields of `alight.shapes.hit.Surface` that materials look at.
Surface = namedtuple("Surface", "u v shape bsdf color")

EXAMPLES = [example for model in MODELS for example in model.EXAMPLES]
NAMES = [f"{e.type_name()}-{i}" for model in MODELS for i, e in enumerate(model.EXAMPLES)]

__all__ = [
    "EXAMPLES",
    "NAMES",
    "Material",
    "Scene",
    "Shapes",
    "Surface",
    "direction",
    "random_numbers",
    "unit_interval",
]
