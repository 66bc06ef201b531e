"""Every ready study has a page with its figure, its numbers and its place in the navigation."""

import re

import pytest

from alight.lab.study_file import ready_names
from tests.docs.pages import ROOT

PAGES = ROOT / "docs" / "studies"
IMAGES = ROOT / "docs" / "images" / "studies"


@pytest.mark.parametrize("name", ready_names())
def test_page_shows_the_finished_figure_and_numbers(name):
    text = (PAGES / f"{name}.md").read_text(encoding="utf-8")
    assert f"(../images/studies/{name}.svg)" in text
    assert f"alight study {name} -o out/{name}" in text
    measured = re.search(
        r"<!-- measured: docs/figures/studies\.py -->\n(.*?)<!-- end -->", text, re.DOTALL
    )
    assert measured is not None
    # A line of heads, a ruler, at least two rows, and where it was measured, at the full size.
    assert measured[1].count("\n|") >= 4
    assert "95 % intervals" in measured[1]
    assert "--quick" not in measured[1]


def test_pages_are_in_the_navigation_and_the_overview():
    navigation = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    overview = (ROOT / "docs" / "studies.md").read_text(encoding="utf-8")
    assert set(re.findall(r"- studies/([\w-]+)\.md", navigation)) == set(ready_names())
    assert set(re.findall(r"\(studies/([\w-]+)\.md\)", overview)) == set(ready_names())
    assert {path.stem for path in PAGES.glob("*.md")} == set(ready_names())


def test_figures_are_small():
    assert all(path.stat().st_size < 300_000 for path in IMAGES.glob("*"))
