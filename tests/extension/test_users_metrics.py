"""A user's metric, one file: in comparisons and their limits, in studies, in the view."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import alight
from alight.cli.main import app
from alight.core.errors import OptionError
from alight.core.registration import unregister
from alight.core.registry import registered_versions
from alight.lab import pictures
from alight.lab.figures import Figures
from alight.lab.report.tables import error_table
from alight.metrics.model import Pair
from alight.view.contrast import contrast, ways
from tests.extension import absolute_error
from tests.lab.report.synthetic import arm

IMAGE = np.linspace(0.0, 1.0, 16 * 16 * 3, dtype=np.float32).reshape(16, 16, 3)
OTHER = IMAGE + np.float32(0.125)


STUDY = """
title: Two samplers
scenes: [{scene: cornell-box, set: {size: [16, 16]}}]
arms: {independent: {sampler: independent}, sobol: {sampler: sobol}}
baseline: independent
spp: [4]
replicates: 4
equal_time: false
"""


@pytest.fixture
def registered():
    alight.register(absolute_error)
    yield
    unregister("metrics", "absolute_error")


def test_it_obeys_the_laws(registered):
    report = alight.check_laws(absolute_error)
    assert report, str(report)


def test_comparisons_tell_it_and_draw_its_map(registered):
    found = alight.compare(OTHER, IMAGE, flip=False)
    (one,) = found.found
    assert one.errors["absolute_error"] == pytest.approx(0.125)
    np.testing.assert_allclose(one.maps["absolute_error"], 0.125, rtol=1e-5)
    assert "Absolute error" in str(found)
    assert found.to_dict()["absolute_error"] == pytest.approx(0.125)
    assert found.to_dict()["missing"] == {"flip": "slow metrics were not asked for (--no-flip)"}


def test_a_limit_can_be_set_to_it(registered):
    assert not alight.compare(OTHER, IMAGE, fail_above="absolute_error=0.2").exceeded
    (text,) = alight.compare(OTHER, IMAGE, fail_above="absolute_error=0.1").exceeded
    assert text == "absolute_error is 0.125, above 0.1"
    with pytest.raises(OptionError, match='did you mean "absolute_error"'):
        alight.compare(OTHER, IMAGE, fail_above="absolut_error=0.1")


def test_the_command_line_takes_its_script(tmp_path):
    for name, picture in (("a", OTHER), ("b", IMAGE)):
        np.save(tmp_path / f"{name}.npy", picture)
    words = ["compare", str(tmp_path / "a.npy"), str(tmp_path / "b.npy"), "--json", "--no-flip"]
    script = tmp_path / "stops.py"
    text = Path(absolute_error.__file__).read_text().replace('"absolute_error"', '"off"')
    script.write_text(text + "\n\nimport alight\n\nalight.register(__name__)\n")
    try:
        done = CliRunner().invoke(app, [*words, "--plugin", str(script)])
        assert done.exit_code == 0, done.output
        assert json.loads(done.stdout)["off"] == pytest.approx(0.125)
    finally:
        unregister("metrics", "off")


def test_studies_report_it(registered):
    """Its own noise is not subtracted, as it has no weights; reports have a column of it."""
    figures = Figures(IMAGE, np.full(IMAGE.shape, 1e-3))
    assert figures.of(OTHER)["absolute_error"] == pytest.approx(0.125)
    one = arm("base", 0, 0.01, np.ones((48, 48, 3), np.float32))
    point = one.samples[-1]
    point.errors["absolute_error"] = point.errors["smape"]
    table = error_table([(one, None)])
    assert any("Absolute error" in head for head in table.heads)


def test_a_study_measures_again_what_another_version_measured(registered):
    (first,) = registered_versions("metrics")
    changed = type(absolute_error)("changed")
    changed.__dict__.update({k: v for k, v in vars(absolute_error).items() if k[0] != "_"})
    changed.evaluate = lambda spec, pair: 2.0 * absolute_error.evaluate(spec, pair)
    alight.register(changed)
    (second,) = registered_versions("metrics")
    assert first[0] == second[0] == "absolute_error"
    assert first[1] != second[1]


class Planned(Exception):
    """The keys of the replicates in the store are known."""


def test_what_a_store_holds_is_known_by_the_metrics_too(tmp_path, monkeypatch):
    """Replicates without a metric's figure, or with that of another version, are not its own."""
    keys = []

    def stop(session, scene, plans, *more):
        keys.append(tuple(plan.key for plan in plans))
        raise Planned

    monkeypatch.setattr(pictures, "run_blocks", stop)
    study = tmp_path / "study.yaml"
    study.write_text(STUDY)
    for known in (False, True, False):
        if known:
            alight.register(absolute_error)
        try:
            with pytest.raises(Planned):
                alight.study(study, output=tmp_path / "out", threads=1)
        finally:
            if known:
                unregister("metrics", "absolute_error")
    assert keys[0] == keys[2]
    assert not set(keys[0]) & set(keys[1])


def test_the_view_compares_by_its_map(registered):
    assert "absolute_error" in ways()
    plane, mean = contrast("absolute_error", OTHER, IMAGE)
    assert plane.shape == (16, 16, 1)
    assert mean == pytest.approx(0.125)


def test_what_a_display_shows_is_cut_at_its_exposure():
    shown = Pair(np.full((2, 2, 3), 0.4), np.full((2, 2, 3), -1.0), exposure=1.0).shown()
    assert shown.image[0, 0, 0] == pytest.approx(0.8)
    assert shown.reference.max() == 0.0
    brighter = Pair(np.full((2, 2, 3), 0.4), np.zeros((2, 2, 3)), exposure=2.0).shown()
    assert brighter.image.max() == 1.0
    assert math.isclose(brighter.exposure, 0.0)
