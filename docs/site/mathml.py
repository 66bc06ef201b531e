"""Hook of mkdocs: formulas become MathML when the pages are built, so they need no script."""

import html
import re
import sys
from pathlib import Path

from latex2mathml.converter import convert

sys.path.append(str(Path(__file__).parent))
import spacing

_FORMULA = re.compile(r'<(span|div) class="arithmatex">\\([(\[])(.*?)\\[)\]]</\1>', re.DOTALL)


def on_page_content(content: str, **_: object) -> str:
    """Replace the formulas that arithmatex has found in a page; numbers stay on one line."""
    return spacing.within_numbers(_FORMULA.sub(_mathml, content))


def _mathml(found: re.Match[str]) -> str:
    if found[2] == "(":
        return spacing.around_functions(convert(html.unescape(found[3]), display="inline"))
    # Browsers align cells by style alone; long formulas scroll by themselves.
    formula = spacing.around_functions(convert(html.unescape(found[3]), display="block"))
    formula = re.sub(r'columnalign="(left|right)"', r'style="text-align: \1"', formula)
    return f'<div style="overflow-x: auto">{formula}</div>'
