"""Every model of every family obeys the laws of its family: registry times examples.

BSDFs and samplers have tests of their own that walk the same laws example by example
(`test_bsdfs.py`, `tests/samplers/test_samplers.py`).
"""

import pytest

import alight
from alight.core.registry import FAMILIES, modules, type_name_of
from alight.laws.check import CHECKS
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


@pytest.mark.parametrize("module", MODELS)
def test_it_obeys_the_laws_of_its_family(module):
    report = alight.check_laws(module, compiled=False)
    assert report.results
    assert report, str(report)
