"""XML text -> a tree of elements, each with its place; what could do harm is refused.

Only elements, attributes and comments are read. Document type declarations are refused, because
entities let a file of a few lines stand for billions of characters or for other files.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from xml.parsers import expat

from alight.core.errors import Issue, SceneError, quote

MOST_BYTES = 64 * 2**20
MOST_DEPTH = 32
MOST_ELEMENTS = 500_000


@dataclass(eq=False)
class Element:
    """One element of the file.

    Attributes
    ----------
    tag : str
        As written; in files of Mitsuba in lower case.
    attributes : dict of str to str
        As written; in files of Mitsuba `name` is in snake_case.
    place : str
        ``file:line:column``.
    old : bool
        Whether its file is in the spelling of Mitsuba 0.6.
    children : list of Element
    """

    tag: str
    attributes: dict[str, str]
    place: str
    old: bool = False
    children: list[Element] = field(default_factory=list)

    @property
    def name(self) -> str:
        """Name of the parameter that it gives; empty for unnamed objects."""
        return self.attributes.get("name", "")

    @property
    def type(self) -> str:
        """Name of the plug-in."""
        return self.attributes.get("type", "")

    @property
    def label(self) -> str:
        """The element as messages show it."""
        shown = [f'{key}="{self.attributes[key]}"' for key in ("type", "name", "id") if key in self]
        return quote_label(" ".join([self.tag, *shown]))

    def __contains__(self, attribute: str) -> bool:
        """Tell whether an attribute is given."""
        return attribute in self.attributes

    def copied(self, **changes: object) -> Element:
        """Copy the element without its children."""
        return replace(self, **{"children": [], "attributes": dict(self.attributes), **changes})


def quote_label(text: str) -> str:
    """Put a start tag in angle brackets, cut to a readable length."""
    shown = text if len(text) <= 100 else text[:97] + "..."
    return "<" + "".join(c if c.isprintable() else repr(c)[1:-1] for c in shown) + ">"


def read(text: str, name: str, most: int = MOST_ELEMENTS) -> tuple[Element, int]:
    """Read one file.

    Parameters
    ----------
    text : str
        Its content.
    name : str
        How messages call it.
    most : int, default MOST_ELEMENTS
        Elements that it may have.

    Returns
    -------
    root : Element
    count : int
        Number of elements.

    Raises
    ------
    SceneError
        If the text is no XML, or uses a part of it that is refused.
    """
    reader = _Reader(name, most)
    try:
        reader.parser.Parse(text, True)
    except expat.ExpatError as error:
        place = f"{name}:{error.lineno}:{error.offset + 1}"
        text = f"is not XML: {expat.ErrorString(error.code)}"
        raise SceneError([Issue("", text, place)]) from None
    except UnicodeEncodeError:
        raise SceneError([Issue("", "is not XML: holds half a character", name)]) from None
    assert reader.root is not None
    return reader.root, reader.count


class _Reader:
    """Builds the tree from expat's events; the stack is ours, so depth cannot exhaust Python's."""

    def __init__(self, name: str, most: int) -> None:
        self.name = name
        self.most = most
        self.root: Element | None = None
        self.stack: list[Element] = []
        self.count = 0
        self.parser = parser = expat.ParserCreate()
        parser.StartElementHandler = self.start
        parser.EndElementHandler = self.end
        parser.CharacterDataHandler = self.text
        parser.StartDoctypeDeclHandler = self.doctype
        parser.EntityDeclHandler = self.doctype
        parser.ProcessingInstructionHandler = self.instruction

    @property
    def place(self) -> str:
        line, column = self.parser.CurrentLineNumber, self.parser.CurrentColumnNumber
        return f"{self.name}:{line}:{column + 1}"

    def fail(self, message: str) -> SceneError:
        return SceneError([Issue("", message, self.place)])

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        self.count += 1
        if self.count > self.most:
            raise self.fail(f"there are more than {MOST_ELEMENTS} elements")
        if len(self.stack) >= MOST_DEPTH:
            raise self.fail(f"is nested deeper than {MOST_DEPTH} levels")
        element = Element(tag, dict(attributes), self.place)
        if self.stack:
            self.stack[-1].children.append(element)
        else:
            self.root = element
        self.stack.append(element)

    def end(self, tag: str) -> None:
        self.stack.pop()

    def text(self, text: str) -> None:
        if text.strip():
            raise self.fail(f"text between elements has no meaning: {quote(text.strip())}")

    def doctype(self, *_: object) -> None:
        raise self.fail("document type declarations (<!DOCTYPE, <!ENTITY) are not allowed")

    def instruction(self, target: str, _: str) -> None:
        raise self.fail(f"processing instructions are not allowed, got <?{target}")
