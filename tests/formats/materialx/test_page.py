"""What docs/materialx.md says is so: it names all that is covered."""

import re

import pytest

import alight
from alight.formats.materialx.evaluate import COVERED
from alight.formats.materialx.scene import VERSIONS
from alight.formats.materialx.shaders import SHADERS
from tests.docs.pages import ROOT

PAGE = ROOT / "docs" / "materialx.md"


def test_page_names_everything_that_is_covered():
    named = set(re.findall(r"`([\w-]+)`", PAGE.read_text(encoding="utf-8")))
    assert {*COVERED, *SHADERS} - named == set()


METAL = """<materialx version="{}"><standard_surface name="s" type="surfaceshader"/>
<surfacematerial name="Brass" type="material">
<input name="surfaceshader" type="surfaceshader" nodename="s"/></surfacematerial>{}</materialx>"""


@pytest.mark.parametrize("version", [*VERSIONS, "1.35", "2.0"])
def test_versions_of_the_page_are_read_and_others_with_a_remark(tmp_path, version):
    first, last = re.findall(r"versions (\S+) to (\S+) are read", PAGE.read_text(encoding="utf-8"))[
        0
    ]
    assert (first, last) == (VERSIONS[0], VERSIONS[-1])
    (tmp_path / "a.mtlx").write_text(METAL.format(version, ""))
    told = [text for text in alight.load(tmp_path / "a.mtlx").warnings if "version" in text]
    assert bool(told) == (version not in VERSIONS)


def test_looks_are_not_read_and_that_is_said(tmp_path):
    look = '<look name="gold"><materialassign name="a" material="Brass" geom="/x"/></look>'
    (tmp_path / "a.mtlx").write_text(METAL.format("1.38", look))
    notes = alight.load(tmp_path / "a.mtlx").source.remarks.notes
    assert any('looks ("gold")' in text for text in notes)
