"""Every example of every BSDF obeys the laws of BSDFs, seen from all sides."""

import pytest

from alight.bsdfs.matte.diffuse import Diffuse
from alight.laws.check import CHECKS
from alight.laws.materials import Material
from alight.laws.report import Report
from tests.sampling.materials import EXAMPLES, NAMES


@pytest.mark.parametrize("spec", EXAMPLES, ids=NAMES)
def test_it_obeys_the_laws_of_bsdfs(spec):
    report = Report(spec.type_name(), tuple(CHECKS["bsdfs"]([spec], False)))
    assert report.results
    assert report, str(report)


def test_laws_ask_a_material_about_the_same_directions_once(monkeypatch):
    """What takes longest is shared by them."""
    asked, evaluate = [], Material.evaluate

    def remember(self, wo, wi, bsdf=None):
        asked.append((wo.tobytes(), wi.tobytes()))
        return evaluate(self, wo, wi, bsdf)

    monkeypatch.setattr(Material, "evaluate", remember)
    results = [*CHECKS["bsdfs"]([Diffuse(reflectance=0.5)], False)]
    assert not any(result.problem for result in results)
    assert len(asked) == len(set(asked)) > 0
