"""A network of nodes, as documents and stages give it."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

#: Components of the types of values.
WIDTHS = {
    "float": 1, "integer": 1, "boolean": 1, "color3": 3, "color4": 4, "vector2": 2, "vector3": 3,
    "vector4": 4,
}  # fmt: skip
#: Suffixes of the names of definitions: types of outputs, and of inputs that differ from them.
_TYPES = (
    *WIDTHS, "string", "filename", "surfaceshader", "displacementshader", "material", "I", "B",
    "matrix33", "matrix44",
)  # fmt: skip
_SUFFIX = re.compile(r"_(" + "|".join(_TYPES) + r")(FA|I|B)?$")
#: Longest chain of nodes.
MOST_DEEP = 80


@dataclass(eq=False)
class Input:
    """What an input of a node is given.

    Attributes
    ----------
    kind : str
        Type of MaterialX.
    value : float, int, bool, str, tuple of float, or None
        None beside a connection, or without a value.
    source : Node or None
        What it is connected to.
    output : str
        Name of the source's output; empty for the only one.
    space : str
        Colour space of the value, or of the file that it names; empty if none is given.
    says_space : bool
        Whether the input itself names that space, not its node or its file.
    asset : object
        What the reader of the file needs to find a file by.
    """

    kind: str = ""
    value: Any = None
    source: Node | None = None
    output: str = ""
    space: str = ""
    says_space: bool = False
    asset: Any = None


@dataclass(eq=False)
class Node:
    """A node.

    Attributes
    ----------
    name : str
        As messages call it.
    category : str
        What it computes, for instance "image" or "standard_surface".
    kind : str
        Type of its output, empty if it has several.
    place : str
        Where it stands, for messages.
    inputs : dict of str to Input
    version : str
        Of its definition, empty for the default.
    """

    name: str
    category: str
    kind: str
    place: str
    inputs: dict[str, Input] = field(default_factory=dict)
    version: str = ""

    def plain(self, name: str, default: Any) -> Any:
        """The value of an input that is given as such, of the type of the default."""
        found = self.inputs.get(name)
        if found is None or found.value is None:
            return default
        value = found.value
        if isinstance(default, bool):
            return bool(value) if isinstance(value, bool | int | float) else default
        if isinstance(default, float | int):
            is_number = isinstance(value, int | float)
            return type(default)(value) if is_number else default
        return value if isinstance(value, type(default)) else default


def category_of(identifier: str) -> tuple[str, str, str]:
    """Category, type of the output and version of the name of a definition.

    Examples
    --------
    >>> category_of("ND_mix_color3")
    ('mix', 'color3', '')
    >>> category_of("ND_standard_surface_surfaceshader_100")
    ('standard_surface', 'surfaceshader', '1.0.0')
    >>> category_of("UsdPreviewSurface")
    ('UsdPreviewSurface', '', '')
    """
    name = identifier.removeprefix("ND_")
    version = ""
    numbered = re.fullmatch(r"(.+surfaceshader)_(\d)(\d)(\d)", name)
    if numbered:
        name, version = numbered[1], ".".join(numbered.groups()[1:])
    name = re.sub(r"^(UsdUVTexture)_\d+$", r"\1", name)
    kinds = []
    while name and (found := _SUFFIX.search(name)):
        kinds.append(found[1])
        name = name[: found.start()]
    # ND_convert_float_color3 ends in what it gives, all others in what they take beside it.
    kind = "" if not kinds else kinds[0 if name == "convert" else -1]
    return name, kind, version
