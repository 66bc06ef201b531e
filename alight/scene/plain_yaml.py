"""YAML text -> plain data with the place of every value, and back: the text of the native format.

Only the plain part of YAML is read: mappings, lists and scalars. Anchors, aliases, tags and
several documents are refused, because a file of a few lines can expand to billions of values with
them. JSON files are YAML files. See docs/decisions/0003-scene-format.md.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from typing import Any

import yaml

from alight.core.errors import Issue, SceneError, join_path, quote

MOST_BYTES = 64 * 2**20
MOST_DEPTH = 64
MOST_VALUES = 4_000_000
# Places are kept for lists up to this length; longer ones are reported at the list.
MOST_PLACED_ITEMS = 64

# The accelerated scanner is part of PyYAML's wheels; the plain one reads the same language.
_Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

#: YAML's words for these numbers; no field takes one.
_NOT_FINITE = {".nan", ".inf", "+.inf", "-.inf"}
_NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?")
_WORDS = {"": None, "~": None, "null": None, "true": True, "false": False}


@dataclass
class _Open:
    """A mapping or list that is being read."""

    container: dict[str, Any] | list[Any]
    path: str
    placed: bool
    key: str | None = None


@dataclass
class _Reader:
    """Turns parser events into data; the stack is ours, so depth cannot exhaust Python's."""

    name: str
    places: dict[str, str] = field(default_factory=dict)
    issues: list[Issue] = field(default_factory=list)
    stack: list[_Open] = field(default_factory=list)
    root: Any = None
    count: int = 0
    documents: int = 0

    def fail(self, message: str, mark: Any, path: str = "") -> SceneError:
        return SceneError([Issue(path, message, f"{self.name}:{_place(mark)}")])

    def read(self, text: str) -> Any:
        try:
            for event in yaml.parse(text, Loader=_Loader):
                self.handle(event)
        except yaml.MarkedYAMLError as error:
            mark = error.problem_mark or error.context_mark
            raise self.fail(f"is not YAML: {error.problem or error.context}", mark) from None
        except yaml.YAMLError as error:
            raise self.fail(f"is not YAML: {_first_line(error)}", None) from None
        except UnicodeEncodeError as error:
            wrong = error.object[error.start]
            raise self.fail(f"must be text, got half of a character, {wrong!r}", None) from None
        return self.root

    def handle(self, event: yaml.Event) -> None:
        self.refuse(event)
        if isinstance(event, yaml.ScalarEvent):
            self.scalar(event)
        elif isinstance(event, yaml.MappingStartEvent):
            self.open({}, event)
        elif isinstance(event, yaml.SequenceStartEvent):
            self.open([], event)
        elif isinstance(event, yaml.MappingEndEvent | yaml.SequenceEndEvent):
            self.stack.pop()
        elif isinstance(event, yaml.DocumentStartEvent):
            self.documents += 1
            if self.documents > 1:
                raise self.fail("must hold one YAML document only", event.start_mark)

    def refuse(self, event: yaml.Event) -> None:
        mark = event.start_mark
        if isinstance(event, yaml.AliasEvent) or getattr(event, "anchor", None):
            raise self.fail("YAML anchors (&) and aliases (*) are not allowed", mark)
        if getattr(event, "tag", None) not in (None, "!"):
            raise self.fail("YAML tags (!) are not allowed", mark)
        self.count += 1
        if self.count > MOST_VALUES:
            text = f"has more than {MOST_VALUES} values: put large meshes into PLY files"
            raise self.fail(text, mark)

    def open(self, container: dict[str, Any] | list[Any], event: yaml.Event) -> None:
        if len(self.stack) >= MOST_DEPTH:
            raise self.fail(f"is nested deeper than {MOST_DEPTH} levels", event.start_mark)
        path, placed = self.put(container, event)
        self.stack.append(_Open(container, path, placed))

    def scalar(self, event: yaml.ScalarEvent) -> None:
        top = self.stack[-1] if self.stack else None
        if top and isinstance(top.container, dict) and top.key is None:
            self.key(top, event)
        else:
            plain = event.style in (None, "")
            self.put(resolve(event.value) if plain else event.value, event)

    def key(self, top: _Open, event: yaml.ScalarEvent) -> None:
        top.key = event.value
        path = join_path(top.path, event.value)
        if event.value in top.container:
            text = (
                f"key {quote(event.value)} is given twice, first at {self.places.get(path + '~')}"
            )
            self.issues.append(Issue(path, text, f"{self.name}:{_place(event.start_mark)}"))
        elif top.placed:
            self.places[path + "~"] = _place(event.start_mark)

    def put(self, value: Any, event: yaml.Event) -> tuple[str, bool]:
        """Store a value in the innermost open container; return its key path."""
        top = self.stack[-1] if self.stack else None
        if top is None:
            self.root, path, placed = value, "", True
        elif isinstance(top.container, list):
            index = len(top.container)
            path, placed = join_path(top.path, index), top.placed and index < MOST_PLACED_ITEMS
            top.container.append(value)
        elif top.key is None:
            raise self.fail("keys must be plain texts", event.start_mark, top.path)
        else:
            path, placed = join_path(top.path, top.key), top.placed
            top.container[top.key], top.key = value, None
        if placed:
            self.places[path] = _place(event.start_mark)
        return path, placed


def parse(text: str, name: str) -> tuple[Any, dict[str, str], list[Issue]]:
    """Read YAML text.

    Parameters
    ----------
    text : str
        Content of the file.
    name : str
        Its name, for messages.

    Returns
    -------
    data : dict, list, str, float, int, bool or None
        Plain data.
    places : dict of str to str
        ``line:column`` of each key path's value, and with ``~`` appended of its key.
    issues : list of Issue
        Problems after which reading could continue (keys given twice).

    Raises
    ------
    SceneError
        If the text is not YAML or uses a part of it that is refused.
    """
    reader = _Reader(name)
    return reader.read(text), reader.places, reader.issues


def parse_value(text: str) -> Any:
    """Read one value as it would follow a key, for ``--set path=value``.

    Raises
    ------
    SceneError
        If the text is not YAML.
    """
    data, _, issues = parse(text, "value")
    if issues:
        raise SceneError(issues)
    return data


def resolve(text: str) -> float | int | bool | str | None:
    """Give a plain scalar its type: number, true, false, null or text.

    YAML 1.1 reads ``1e-3`` as a text and ``yes`` as a truth value; here the first is a number and
    the second a text.
    """
    if text in _WORDS:
        return _WORDS[text]
    if text.lower() in _NOT_FINITE:
        return float(text.replace(".", ""))
    if not _NUMBER.fullmatch(text):
        return text
    # Python limits the digits of whole numbers; no count has that many.
    if len(text) <= 18 and text.lstrip("+-").isdigit():
        return int(text)
    return float(text)


def _place(mark: Any) -> str:
    return f"{mark.line + 1}:{mark.column + 1}" if mark is not None else "1:1"


def _first_line(error: Exception) -> str:
    return str(error).strip().splitlines()[0]


def write(data: Any) -> str:
    """Write plain data as YAML that `parse` reads back exactly.

    Mappings are blocks, except small ones in lists; lists of numbers fit on one line.
    """
    lines: list[str] = []
    _write_block(data, 0, lines)
    return "\n".join(lines) + "\n"


def _write_block(data: dict[str, Any], indent: int, lines: list[str]) -> None:
    for key, value in data.items():
        head = " " * indent + _text(key) + ":"
        if isinstance(value, dict) and value and not _fits(value):
            lines.append(head)
            _write_block(value, indent + 2, lines)
        elif isinstance(value, list) and not _fits(value):
            lines.append(head)
            lines.extend(" " * (indent + 2) + "- " + _flow(item) for item in value)
        else:
            lines.append(f"{head} {_flow(value)}")


def _fits(value: Any) -> bool:
    """Whether a value is short and flat enough for the line of its key."""
    if isinstance(value, dict):
        flat = not any(isinstance(item, dict) and item for item in value.values())
        return flat and len(_flow(value)) <= 80
    if isinstance(value, list | tuple):
        return len(value) <= 4 and len(_flow(value)) <= 80
    return True


def _flow(value: Any) -> str:
    if isinstance(value, dict):
        items = (f"{_text(key)}: {_flow(item)}" for key, item in value.items())
        return "{" + ", ".join(items) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_flow(item) for item in value) + "]"
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        assert math.isfinite(value)
        return repr(value)
    return str(value) if isinstance(value, int) else _text(value)


def _text(value: str) -> str:
    """A text, in double quotes (escaped as in JSON) unless it is a plain word."""
    if (
        re.fullmatch(r"[A-Za-z_][\w./+-]*( [\w./+-]+)*", value, re.ASCII)
        and resolve(value) == value
    ):
        return value
    escaped = []
    for c in value:
        code = ord(c)
        if c in '"\\':
            escaped.append("\\" + c)
        elif c.isprintable() and code < 0x10000:
            escaped.append(c)
        else:
            escaped.append(f"\\x{code:02x}" if code < 256 else f"\\U{code:08x}")
    return '"' + "".join(escaped) + '"'
