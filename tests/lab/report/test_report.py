"""The page of a study: whole, self-contained, and with the numbers of the result."""

import csv
import dataclasses
import html.parser
import json
import math
import re
from contextlib import suppress

import numpy as np
import pytest

pytest.importorskip("matplotlib")
pytest.importorskip("jinja2")

import alight
from alight.core.errors import OptionError
from alight.lab.report import style, tables, write_report
from alight.lab.report.targets import check_target
from alight.lab.results import BIASED, Speedup
from alight.metrics.estimate import Estimate
from tests.lab.report import synthetic

NAN = math.nan
UNKNOWN = Estimate(NAN, NAN, NAN)

#: Elements that have no end.
VOID = {"meta", "img", "br", "input"}


class Balance(html.parser.HTMLParser):
    """Collects ids and text, and refuses elements that are not closed in order."""

    def __init__(self):
        super().__init__()
        self.open, self.ids, self.text = [], [], []

    def handle_starttag(self, tag, attrs):
        self.ids += [value for name, value in attrs if name == "id"]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.ids += [value for name, value in attrs if name == "id"]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


def written(tmp_path, result):
    """The page, its plain text, and the names of the files."""
    target = write_report(result, tmp_path)
    page = target.read_text("utf-8")
    parser = Balance()
    parser.feed(page)
    assert parser.open == []
    assert len(parser.ids) == len(set(parser.ids)), "an id stands twice"
    return page, " ".join(" ".join(parser.text).split())


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    page, text = written(folder, synthetic.study())
    return folder, page, text


def test_the_page_asks_nobody_for_anything(report):
    _, page, _ = report
    assert not re.search(r"""(src|href)="(?!data:|#)|url\((?!"?(data:|#))|<script|@import""", page)


def test_arms_are_sorted_by_efficiency(report):
    _, page, _ = report
    first = page[page.index("<tbody>") : page.index("</tbody>")]
    found = [first.index(f"<span>{name}") for name in ("Sobol", "Shallow", "Independent", "Tent")]
    assert found == sorted(found)


def test_biased_and_different_arms_are_named_so_and_cannot_win(report):
    _, page, text = report
    assert "Shallow is biased: more time does not lead to the truth." in text
    assert "Sobol has 4.00 (3.60 to 4.40) times the efficiency of Independent." in text
    assert '<b class="badge bad">biased</b>' in page
    assert '<b class="badge plain">different by declaration</b>' in page
    assert page.count('fill="#fff" stroke') == 2, "biased and different arms are hollow"


def test_what_repeats_the_study_is_there(report):
    _, _, text = report
    for words in ("alight study samplers --seed 7", "processor", "100 101 102 103", "abc123",
                  "sampler.type=sobol", "0.20 % relRMSE"):  # fmt: skip
        assert words in text


def test_diagrams_crops_maps_and_bars_are_there(report):
    _, page, text = report
    # Two of the scene and one of the study's own, all with words for those who cannot see them.
    assert len(re.findall(r'<svg role="img" aria-label="RMSE over', page)) == 3
    assert "slope −0.50 ± 0.02" in text
    assert "expected −0.50" in text
    strips = re.findall(r'<div class="strip" style.*?\n(.*)', page)
    assert [strip.count("<img") for strip in strips] == [5, 5, 5]
    rows = re.findall(r'<div class="row".*', page)
    assert [row.count("<img") for row in rows] == [4, 4, 4]
    assert page.count('class="bar"') == 3


def test_csv_and_json_hold_the_same_numbers(report):
    folder, _, _ = report
    with (folder / "arms.csv").open(encoding="utf-8") as file:
        arms = {row["arm"]: row for row in csv.DictReader(file)}
    assert list(arms) == ["independent", "sobol", "shallow", "tent"]
    assert float(arms["sobol"]["speedup"]) == 4.0
    assert float(arms["sobol"]["speedup_low"]) == 3.6
    assert arms["independent"]["speedup"] == ""
    assert arms["shallow"]["verdict"] == BIASED
    with (folder / "points.csv").open(encoding="utf-8") as file:
        points = list(csv.DictReader(file))
    assert len(points) == 4 * 2 * 3
    data = json.loads((folder / "report.json").read_text("utf-8"))
    first = data["scenes"][0]["arms"][1]
    assert first["speedup"]["ratio"] == {"value": 4.0, "low": 3.6, "high": 4.4}
    assert float(points[6]["mse"]) == first["samples"][0]["errors"]["mse"]["value"]
    assert "example" not in first["images"]
    with (folder / "table-ratio.csv").open(encoding="utf-8") as file:
        assert list(csv.reader(file))[1] == ["diffuse", "2.97 [2.9, 3.04]", "16"]


def test_text_is_escaped(tmp_path):
    page, text = written(tmp_path, synthetic.study(title="<b>a & b</b>", curves=[], tables=[]))
    assert "<b>a & b</b>" in text
    assert "<b>a & b</b>" not in page


def test_several_scenes_have_an_overview(tmp_path):
    scenes = [synthetic.scene(), synthetic.scene(name="other", label="Other")]
    _, text = written(tmp_path, synthetic.study(scenes=scenes))
    assert "Speed-up of every arm in every scene" in text


def test_studies_without_scenes_curves_or_tables_have_pages(tmp_path):
    _, text = written(tmp_path, synthetic.study(scenes=[], curves=[], tables=[], seconds={}))
    assert "Samplers" in text
    assert not (tmp_path / "arms.csv").exists()


def test_unknown_numbers_are_dashes_and_never_nan(tmp_path):
    """One replicate, one point, no variance: no interval and no slope is known."""
    scene = synthetic.scene()
    errors = {"relmse": UNKNOWN, "mse": Estimate(0.001, NAN, NAN)}
    old = scene.arms[0].samples[0]
    point = dataclasses.replace(old, errors={**old.errors, **errors}, bias2=UNKNOWN)
    bias = dataclasses.replace(
        scene.arms[0].bias, z_rms=NAN, z_low=NAN, z_high=NAN, z_largest=NAN, p_value=NAN,
        difference=[UNKNOWN] * 3, blocks=0,
    )  # fmt: skip
    arms = []
    for arm in scene.arms:
        images = dataclasses.replace(arm.images, variance=np.full_like(arm.images.mean, np.nan))
        speedup = arm.speedup and Speedup(Estimate(2.0, NAN, NAN), NAN, NAN, UNKNOWN)
        arms.append(dataclasses.replace(
            arm, samples=[point], times=[], efficiency=UNKNOWN, speedup=speedup, bias=bias,
            slope_spp=UNKNOWN, slope_time=UNKNOWN, expected_slope=None, images=images,
            microseconds_per_sample=UNKNOWN,
        ))  # fmt: skip
    page, _ = written(tmp_path, synthetic.study(scenes=[synthetic.scene(arms)]))
    assert not re.search(r"\bnan\b", re.sub(r"base64,[^\"]*|NaN or ∞", "", page), re.IGNORECASE)
    assert "NaN" not in (tmp_path / "report.json").read_text("utf-8")


def test_missing_packages_are_named_with_the_remedy_and_nothing_is_written(tmp_path, monkeypatch):
    import importlib.util

    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(OptionError, match=r'jinja2 and matplotlib: pip install ".*\[lab\]"'):
        write_report(synthetic.study(), tmp_path)
    allowed = []
    for name in ("a.html", "a.HTML", "a.Html"):
        with suppress(OptionError):
            check_target(tmp_path / name, (".html", ".png"))
            allowed.append(name)
    assert allowed == list(tmp_path.iterdir()) == []


def test_a_study_whose_report_cannot_be_written_is_not_begun(tmp_path, monkeypatch):
    import importlib.util

    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(OptionError, match="jinja2 and matplotlib"):
        alight.study("direct-light", quick=True, output=tmp_path / "out")
    assert not list(tmp_path.iterdir())


def test_looks_are_all_different_and_the_baseline_is_grey():
    found = style.looks(12, baseline=2)
    assert found[2].color == style.BASELINE
    assert len(set(found)) == 12


def test_the_same_result_gives_the_same_page(tmp_path, report):
    """No clock, no random id: a report can be kept under version control."""
    _, page, _ = report
    assert write_report(synthetic.study(), tmp_path).read_text("utf-8") == page


def test_small_and_large_speedups_keep_three_digits():
    column = tables._ratio_column([2.87211, 0.000405])
    assert (column.text(2.87211), column.text(0.000405)) == ("2.87", "0.000405")
    column = tables._ratio_column([0.91, 1.8765])
    assert (column.text(0.91), column.text(1.8765)) == ("0.91", "1.88")
