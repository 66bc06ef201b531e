"""What docs/materialx.md says is so: it names all that is covered."""

import re

from alight.formats.materialx.evaluate import COVERED
from alight.formats.materialx.shaders import SHADERS
from tests.docs.pages import ROOT

PAGE = ROOT / "docs" / "materialx.md"


def test_page_names_everything_that_is_covered():
    named = set(re.findall(r"`([\w-]+)`", PAGE.read_text(encoding="utf-8")))
    assert {*COVERED, *SHADERS} - named == set()
