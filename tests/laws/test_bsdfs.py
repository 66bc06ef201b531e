"""Every example of every BSDF obeys the laws of BSDFs, seen from all sides."""

import pytest

from alight.laws.check import CHECKS
from alight.laws.report import Report
from tests.sampling.materials import EXAMPLES, NAMES


@pytest.mark.parametrize("spec", EXAMPLES, ids=NAMES)
def test_it_obeys_the_laws_of_bsdfs(spec):
    report = Report(spec.type_name(), tuple(CHECKS["bsdfs"]([spec], False)))
    assert report.results
    assert report, str(report)
