"""Headers of PLY files: which tables follow, and how their numbers are written.

Source: Turk, The PLY polygon file format (1994).
"""

from __future__ import annotations

from dataclasses import dataclass

from alight.core.errors import quote, unknown_name
from alight.meshes.triangles import broken

TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1",
    "short": "i2", "int16": "i2", "ushort": "u2", "uint16": "u2",
    "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
LONGEST_HEADER = 100_000


@dataclass(frozen=True)
class Property:
    """One column of an element; `length` is the type of a list's count, or empty."""

    name: str
    kind: str
    length: str = ""


@dataclass(frozen=True)
class Element:
    """One table of a file."""

    name: str
    count: int
    properties: tuple[Property, ...]

    @property
    def has_lists(self) -> bool:
        """Whether rows differ in length."""
        return any(column.length for column in self.properties)


def parse_header(data: bytes) -> tuple[str, list[Element], int]:
    """Read the header: byte order ("" for ascii), elements, position of the data."""
    end = data.find(b"end_header", 0, LONGEST_HEADER)
    if not data.startswith(b"ply") or end < 0:
        raise broken("is not a PLY file: it must start with ply and have an end_header")
    start = data.find(b"\n", end) + 1 or len(data)
    order: str | None = None
    elements: list[Element] = []
    lines = data[:end].decode("latin-1").replace("\r", "\n").split("\n")
    for number, line in enumerate(lines, 1):
        words = line.split()
        if not words or words[0] in ("ply", "comment", "obj_info"):
            continue
        if words[0] == "format" and len(words) > 1:
            if words[1] not in ORDERS:
                raise broken(unknown_name("format", words[1], ORDERS))
            order = ORDERS[words[1]]
        elif words[0] == "element" and len(words) == 3 and words[2].isdecimal():
            # A row takes at least one byte, so a larger count is a lie.
            if len(words[2]) > 12 or int(words[2]) > len(data):
                raise broken(f"claims {words[2][:20]} {words[1]} rows in {len(data)} bytes")
            elements.append(Element(words[1], int(words[2]), ()))
        elif words[0] == "property" and elements:
            last = elements[-1]
            column = _parse_property(words, number)
            elements[-1] = Element(last.name, last.count, (*last.properties, column))
        else:
            raise broken(f"header line {number} makes no sense: {quote(line)}")
    if order is None:
        raise broken("header names no format")
    return order, elements, start


def _parse_property(words: list[str], number: int) -> Property:
    kinds = words[2:4] if len(words) == 5 and words[1] == "list" else words[1:2]
    if len(words) != (5 if len(kinds) == 2 else 3):
        raise broken(f"header line {number} makes no sense: {quote(' '.join(words))}")
    for kind in kinds:
        if kind not in TYPES:
            raise broken(f"header line {number}: {unknown_name('type', kind, TYPES)}")
    if len(kinds) == 2 and TYPES[kinds[0]][0] == "f":
        raise broken(f"header line {number}: a list's length must be a whole number type")
    length = TYPES[kinds[0]] if len(kinds) == 2 else ""
    return Property(words[-1], TYPES[kinds[-1]], length)
