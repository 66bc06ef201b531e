"""A scene file with all that it includes, ``$names`` replaced by their values.

``<default>`` gives a name a value unless ``-D name=value`` has given it one; from there on
``$name`` stands for the value in any attribute. ``<include>`` puts the content of another file in
its place, ``<path>`` names a folder to look for files in.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from alight.core.errors import Issue, SceneError, unknown_name
from alight.formats.mitsuba.elements import parse
from alight.formats.reading.packed import text_of
from alight.formats.reading.reach import OutOfReachError, Reach
from alight.formats.reading.report import Report
from alight.formats.reading.xml import MOST_BYTES, MOST_ELEMENTS, Element

MOST_INCLUDES = 64
MOST_INCLUDE_LEVELS = 8
# Values may hold names that stand for values: without a limit a few lines grow to gigabytes.
MOST_CHARACTERS = 1_000_000
MOST_CHARACTERS_IN_ALL = 64_000_000

_NAME = re.compile(r"\$(\w+)")


@dataclass
class Document:
    """Expands a file.

    Attributes
    ----------
    reach : Reach
        Finds files.
    report : Report
        Receives problems.
    values : dict of str to str
        Names and their values so far.
    used : set of str
        Those that appeared, in a ``<default>`` or behind ``$``.
    aliases : list of Element
        In the order of the file.
    """

    reach: Reach
    report: Report
    values: dict[str, str] = field(default_factory=dict)
    used: set[str] = field(default_factory=set)
    aliases: list[Element] = field(default_factory=list)
    includes: int = 0
    characters: int = 0
    elements: int = 0

    def read(self, text: str, name: str) -> Element:
        """Read one file; all together have a limited number of elements."""
        root, count = parse(text, name, MOST_ELEMENTS - self.elements)
        self.elements += count
        return root

    def expand(self, root: Element, level: int = 0) -> list[Element]:
        """Objects at the top level of a file and of those that it includes."""
        result: list[Element] = []
        for child in root.children:
            if child.tag == "default":
                self.default(child)
            elif child.tag == "path":
                self.add_path(self.replaced(child))
            elif child.tag == "include":
                result += self.include(self.replaced(child), level)
            elif child.tag == "alias":
                self.aliases.append(self.replaced(child))
            else:
                result.append(self.replaced_tree(child))
        return result

    def default(self, element: Element) -> None:
        """Give a name its value, unless it has one."""
        name, value = element.attributes.get("name", ""), element.attributes.get("value")
        if not re.fullmatch(r"\w+", name) or value is None:
            self.report.error(element, "needs a name of letters, digits and _, and a value")
            return
        self.used.add(name)
        if name not in self.values:
            self.values[name] = self.substituted(element, value)

    def add_path(self, element: Element) -> None:
        """Look for files in one more folder."""
        try:
            self.reach.add(element.attributes.get("value", ""))
        except OutOfReachError as error:
            self.report.error(element, str(error))

    def include(self, element: Element, level: int) -> list[Element]:
        """Objects of another file."""
        self.includes += 1
        if level >= MOST_INCLUDE_LEVELS:
            self.report.error(element, f"includes are nested deeper than {MOST_INCLUDE_LEVELS}")
            return []
        if self.includes > MOST_INCLUDES:
            if self.includes == MOST_INCLUDES + 1:
                self.report.error(element, f"there are more than {MOST_INCLUDES} includes")
            return []
        try:
            path = self.reach.find(element.attributes.get("filename", ""))
            root = self.read(text_of(path, MOST_BYTES), str(path))
        except OutOfReachError as error:
            self.report.lacks(element, error, "what it includes is left out")
            return []
        except SceneError as error:
            self.report.issues.extend(error.issues)
            return []
        return self.expand(root, level + 1)

    def replaced_tree(self, root: Element) -> Element:
        """Copy an object with the values of all names in it."""
        top = self.replaced(root)
        stack = [(root, top)]
        while stack:
            source, target = stack.pop()
            for child in source.children:
                copy = self.replaced(child)
                if child.tag in ("default", "include", "alias", "path"):
                    self.report.error(copy, "belongs to the top level of the file")
                else:
                    target.children.append(copy)
                    stack.append((child, copy))
        return top

    def replaced(self, element: Element) -> Element:
        """Copy an element with the values of the names in its attributes."""
        attributes = {
            key: self.substituted(element, value) if "$" in value else value
            for key, value in element.attributes.items()
        }
        return element.copied(attributes=attributes)

    def substituted(self, element: Element, text: str) -> str:
        """Put values in the place of ``$names``."""
        if "$" not in text:
            return text

        def value(found: re.Match[str]) -> str:
            word = found[1]
            # As Mitsuba does: $widthpx is the value of width and px, if there is no widthpx.
            name = next((word[:n] for n in range(len(word), 0, -1) if word[:n] in self.values), "")
            if not name:
                known = unknown_name("parameter", word, self.values, listed_as="parameters")
                self.report.error(element, f"{known}: give it with -D {word}=VALUE")
                return "0"
            self.used.add(name)
            return self.values[name] + word[len(name) :]

        result = _NAME.sub(value, text)
        self.characters += len(result)
        if len(result) > MOST_CHARACTERS or self.characters > MOST_CHARACTERS_IN_ALL:
            text = f"its values grow beyond {MOST_CHARACTERS} characters"
            raise SceneError([Issue(element.label, text, element.place)])
        return result


def read_document(
    text: str, name: str, reach: Reach, definitions: Mapping[str, str], report: Report
) -> tuple[list[Element], Document]:
    """Read a scene file and what it includes.

    Parameters
    ----------
    text, name : str
        Content of the file, and its name for messages.
    reach : Reach
        Where the files that it names may lie.
    definitions : mapping of str to str
        Names with values that go before those in the file.
    report : Report
        Receives problems.

    Returns
    -------
    objects : list of Element
        At the top level, in order.
    document : Document
        For its aliases and its `reach`.

    Raises
    ------
    SceneError
        If the file itself cannot be read.
    """
    document = Document(reach, report, dict(definitions))
    objects = document.expand(document.read(text, name))
    for unused in [word for word in definitions if word not in document.used]:
        known = unknown_name("parameter", unused, document.used, listed_as="parameters")
        report.issues.append(Issue(f"-D {unused}", known, name))
    return objects, document
