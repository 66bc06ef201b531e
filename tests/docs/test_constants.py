"""Numbers that the pages state are those of the code.

`stated_constants.txt` lists pages; below each, patterns whose groups are numbers as the page writes
them; and below each pattern the constants (or defaults of descriptions) that they stand for, in the
same order, relative to the package. Where a page counts in another unit, `*`, `/` or `+` and a
number follow; `log2` before a name asks for the exponent.
"""

import re
from pathlib import Path

import numpy as np
import pytest

from tests.docs.names import import_path
from tests.docs.pages import ROOT


def _stated():
    """Triples (page, pattern, names)."""
    found, page, pattern = [], "", ""
    for line in Path(__file__).with_name("stated_constants.txt").read_text().splitlines():
        if line.startswith(" " * 8):
            found.append((page, pattern, line.strip()))
        elif line.startswith(" " * 4):
            pattern = line[4:]
        else:
            page = line
    return found


STATED = _stated()
WORDS = ["zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten"]


def _number(text: str) -> float:
    if text in WORDS:
        return WORDS.index(text)
    return {"million": 1e6, "sixteen": 16.0}.get(text) or float(re.sub(r"[ ,]", "", text))


def _value(name: str) -> float:
    """A constant by its name: ``module.NAME``, ``module.TUPLE.1``, ``module.NAME*100``."""
    if name.startswith("log2 "):
        return float(np.log2(_value(name.removeprefix("log2 "))))
    path, operator, operand = re.fullmatch(r"([\w.]+?)(?:([*/+])([-\d.e]+))?", name).groups()
    index = re.search(r"\.(\d)$", path)
    path = path[: index.start()] if index else path
    found = import_path(path if path.startswith("lanewise.") else f"alight.{path}")
    value = float(np.ravel(found)[int(index[1]) if index else 0])
    if operator == "+":
        return value + float(operand)
    factor = float(operand) if operator else 1.0
    return value / factor if operator == "/" else value * factor


def _split(names: str) -> list[str]:
    return re.findall(r"(?:log2 )?\S+", names)


@pytest.mark.parametrize(("page", "pattern", "names"), STATED, ids=lambda value: value[:60])
def test_stated_constant_is_that_of_the_code(page, pattern, names):
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    stated = re.findall(pattern, text)
    assert stated, f"{page} no longer says {pattern!r}"
    for groups in stated:
        numbers = [_number(g) for g in (groups if isinstance(groups, tuple) else (groups,))]
        assert numbers == pytest.approx([_value(name) for name in _split(names)]), names
