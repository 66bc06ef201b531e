"""XML text of Mitsuba -> a tree of elements, in one spelling.

See `alight.formats.reading.xml` for what is refused.
"""

from __future__ import annotations

from alight.core.errors import Issue, SceneError
from alight.formats.mitsuba.spelling import is_old, to_snake_case
from alight.formats.reading.xml import MOST_ELEMENTS, Element, read


def parse(text: str, name: str, most: int = MOST_ELEMENTS) -> tuple[Element, int]:
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
        The ``<scene>``.
    count : int
        Number of elements.

    Raises
    ------
    SceneError
        If the text is no XML, uses a part of it that is refused, or is no scene of Mitsuba.
    """
    root, count = read(text, name, most)
    if root.tag != "scene":
        text = f"must be a <scene> of Mitsuba, got {root.label}"
        raise SceneError([Issue("", text, root.place)])
    _normalise(root)
    return root, count


def _normalise(root: Element) -> None:
    """Mark every element with the spelling of its file, and put names into snake_case."""
    try:
        old = is_old(root.attributes.get("version", ""))
    except ValueError as error:
        raise SceneError([Issue(root.label, str(error), root.place)]) from None
    stack = [root]
    while stack:
        element = stack.pop()
        element.old = old
        element.tag = element.tag.lower()
        if old and "name" in element and element.tag != "default":
            element.attributes["name"] = to_snake_case(element.attributes["name"])
        stack.extend(element.children)
