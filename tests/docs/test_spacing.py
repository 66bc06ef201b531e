"""Spaces of the site: thin ones around functions, and none within numbers that could break."""

import importlib.util
import re
from pathlib import Path

import pytest

_PATH = Path(__file__).parents[2] / "docs" / "site" / "spacing.py"
_spec = importlib.util.spec_from_file_location("spacing", _PATH)
spacing = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(spacing)

OPEN, CLOSE = '<mo stretchy="false">(</mo>', '<mo stretchy="false">)</mo>'


@pytest.mark.parametrize(
    ("row", "shown"),
    [
        (f"<mi>a</mi><mi>tan</mi>{OPEN}<mi>x</mi>{CLOSE}", "a~tan(x)"),
        ("<mn>4</mn><mi>cos</mi><msub><mi>θ</mi><mi>o</mi></msub>", "4~cos~θo"),
        (f"{OPEN}<mi>a</mi>{CLOSE}<msup><mi>tan</mi><mn>2</mn></msup>", "(a)~tan2"),
        ("<mi>x</mi><mspace width='0.167em'/><mi>ln</mi><mi>x</mi>", "x~ln~x"),
        ("<mo>|</mo><mi>cos</mi><mi>θ</mi><mo>|</mo>", "|cos~θ|"),
        ("<mi>a</mi><mo>=</mo><mi>max</mi>", "a=max"),
        ("<mfrac><mi>x</mi><mi>sin</mi></mfrac>", "xsin"),
        ("<mo>lim</mo><mi>b</mi><mi>c</mi>", "lim~bc"),
    ],
)
def test_functions_have_the_spaces_of_tex(row, shown):
    formula = f'<math xmlns="http://www.w3.org/1998/Math/MathML"><mrow>{row}</mrow></math>'
    found = spacing.around_functions(formula)
    assert found.startswith('<math xmlns="http://www.w3.org/1998/Math/MathML">')
    assert re.sub(r"<[^>]*>", "", re.sub(r"<mspace[^>]*>", "~", found)) == shown


def test_numbers_do_not_break():
    text = "of 8 192 to 1 234 567 samples, 17 % in [4\u2009374, 4\u2009867]: 12 3456 or 3 12"
    kept = "of 8~192 to 1~234~567 samples, 17~% in [4_374, 4_867]: 12 3456 or 3 12"
    found = spacing.within_numbers(text)
    assert found.replace("\u00a0", "~").replace("\u202f", "_") == kept


def test_code_keeps_its_spaces():
    page = '<pre class="x"><span>8 192</span></pre><td>8 192</td><code>1 000</code>'
    assert spacing.within_numbers(page) == page.replace("<td>8 ", "<td>8\N{NO-BREAK SPACE}")
