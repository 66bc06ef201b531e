"""Every model of every family obeys the laws of its family: registry times examples.

BSDFs and samplers have tests of their own that walk the same laws example by example
(`test_bsdfs.py`, `tests/samplers/test_samplers.py`).
"""

import numpy as np
import pytest

import alight
from alight.core.registry import FAMILIES, modules, type_name_of
from alight.laws import cameras, filters
from alight.laws.bodies import PLACEMENTS, Body
from alight.laws.check import CHECKS
from alight.laws.shapes import demand_same_surfaces
from alight.laws.textures import demand_same_textures
from alight.scene import Node, rotate, translate
from tests.static.sources import FAMILIES as FAMILIES_OF_THE_PACKAGE

#: Walked elsewhere, example by example.
ELSEWHERE = {"bsdfs", "samplers"}

MODELS = [
    pytest.param(module, id=f"{family}-{type_name_of(module)}")
    for family in FAMILIES
    if family not in ELSEWHERE
    for module in modules(family)
]


def test_every_family_has_laws():
    assert set(CHECKS) == set(FAMILIES) == set(FAMILIES_OF_THE_PACKAGE)


def test_machine_code_sees_every_shape_as_the_python_text_does():
    """All shapes in a ring around the first one, so that one compilation tells."""
    first, *others = [model.EXAMPLES[0] for model in modules("shapes")]
    places = [rotate((0, 0, 1), 360.0 * k / len(others)) for k in range(len(others))]
    nodes = {
        f"other{k}": Node(
            shape=shape, transform=place @ translate(1.3, 0, 0) @ rotate((1, 2, 0), 70)
        )
        for k, (shape, place) in enumerate(zip(others, places, strict=True))
    }
    body = Body(first, PLACEMENTS["as it is"], **nodes)
    hit, _ = body.hit(*body.lines(7), np.ones(20_000, bool))
    assert set(hit.shape[np.isfinite(hit.t)]) == set(range(len(body.shapes.motions)))
    demand_same_surfaces(body)


def test_machine_code_sees_every_texture_as_the_python_text_does():
    demand_same_textures([spec for model in modules("textures") for spec in model.EXAMPLES])


#: Families whose kernels are small enough to be compiled one model at a time.
SMALL = {"cameras": cameras.COMPILED_LAWS, "filters": filters.COMPILED_LAWS}


@pytest.mark.parametrize("family", SMALL)
def test_machine_code_of_cameras_and_filters_is_the_python_text(family):
    for model in modules(family):
        for law in SMALL[family]:
            law(model.EXAMPLES[-1])


@pytest.mark.parametrize("module", MODELS)
def test_it_obeys_the_laws_of_its_family(module):
    report = alight.check_laws(module, compiled=False)
    assert report.results
    assert report, str(report)
