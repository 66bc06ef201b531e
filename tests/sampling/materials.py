"""Every registered BSDF and every example of it, through the tables and the dispatcher."""

from collections import namedtuple

import pytest

from alight.bsdfs import MODELS
from alight.laws.materials import (
    COSINES,
    Material,
    Scene,
    Shapes,
    direction,
    random_numbers,
    unit_interval,
)

#: The fields of `alight.shapes.hit.Surface` that materials look at.
Surface = namedtuple("Surface", "u v shape bsdf color")

EXAMPLES = [example for model in MODELS for example in model.EXAMPLES]
NAMES = [f"{e.type_name()}-{i}" for model in MODELS for i, e in enumerate(model.EXAMPLES)]

ALL = [
    pytest.param(spec, cosine, id=f"{name} {cosine}")
    for spec, name in zip(EXAMPLES, NAMES, strict=True)
    for cosine in COSINES
]
#: For tests of ``spec``, and of ``(spec, cosine)``: all examples, and those without densities.
each_spec = pytest.mark.parametrize("spec", EXAMPLES, ids=NAMES)
each_example = pytest.mark.parametrize(("spec", "cosine"), ALL)
each_delta_example = pytest.mark.parametrize(
    ("spec", "cosine"), [case for case in ALL if Material(case.values[0]).is_delta(direction(0.7))]
)

__all__ = [
    "EXAMPLES",
    "NAMES",
    "Material",
    "Scene",
    "Shapes",
    "Surface",
    "direction",
    "each_delta_example",
    "each_example",
    "each_spec",
    "random_numbers",
    "unit_interval",
]
