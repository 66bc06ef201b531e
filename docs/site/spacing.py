"""Spaces that keep a page readable: around the names of functions, and within numbers.

TeX sets a thin space between a symbol and the name of a function next to it; MathML does not, and
a tan φ would read as the arc tangent. Source: Knuth, The TeXbook (1984), chapter 18.
"""

from __future__ import annotations

import re
from xml.etree import ElementTree

FUNCTIONS = (
    "arccos", "arcsin", "arctan", "arg", "cos", "cosh", "cot", "csc", "deg", "det", "dim", "exp",
    "gcd", "inf", "lim", "ln", "log", "max", "min", "Pr", "sec", "sign", "sin", "sinh", "sup",
    "tan", "tanh",
)  # fmt: skip
_SCRIPTS = ("msub", "msup", "msubsup", "munder", "mover", "munderover")
_CLOSING = (")", "]", "}", "⟩", "⌋")
_NAMESPACE = "http://www.w3.org/1998/Math/MathML"
_TAG = re.compile(r"(<[^>]*>)")
_UNTOUCHED = ("pre", "code", "math", "script", "style")
_WITHIN_NUMBERS = re.compile(r"(?<=\d)[ \N{THIN SPACE}](?=\d{3}(?!\d)|%)")
_KEPT = {" ": "\N{NO-BREAK SPACE}", "\N{THIN SPACE}": "\N{NARROW NO-BREAK SPACE}"}


def around_functions(formula: str) -> str:
    """Set thin spaces between the names of functions and the symbols beside them.

    Parameters
    ----------
    formula : str
        A `math` element, as text.
    """
    ElementTree.register_namespace("", _NAMESPACE)
    root = ElementTree.fromstring(formula)
    for parent in list(root.iter()):
        kinds = [_kind(child) for child in parent]
        if _name(parent) not in ("math", "mrow", "mtd"):
            continue
        for place in range(len(kinds) - 1, 0, -1):
            before, after = kinds[place - 1 : place + 1]
            if (after == "function" and before in ("symbol", "closing", "function")) or (
                before == "function" and after == "symbol"
            ):
                space = ElementTree.Element(f"{{{_NAMESPACE}}}mspace", width="0.167em")
                parent.insert(place, space)
    return ElementTree.tostring(root, encoding="unicode")


def within_numbers(page: str) -> str:
    """Keep the digits of a number in a page's text on one line, and a percentage with its sign."""
    pieces = _TAG.split(page)
    depth = 0
    for k, piece in enumerate(pieces):
        if k % 2:
            name = piece.strip("</>").partition(" ")[0]
            if name in _UNTOUCHED:
                depth += -1 if piece.startswith("</") else 1
        elif depth == 0:
            pieces[k] = _WITHIN_NUMBERS.sub(lambda found: _KEPT[found[0]], piece)
    return "".join(pieces)


def _name(element: ElementTree.Element) -> str:
    return element.tag.rpartition("}")[2]


def _kind(element: ElementTree.Element) -> str:
    """What TeX's rules ask about an element: function, symbol, closing or something else."""
    name, text = _name(element), (element.text or "").strip()
    if name in _SCRIPTS:
        return _kind(element[0])
    if text in FUNCTIONS:
        return "function"
    if name == "mo":
        return "closing" if text in _CLOSING else "other"
    return "other" if name == "mspace" else "symbol"
