"""Notes of what readers and writers answer in the tests of formats, kept and compared.

A test asks about a part of an answer; all of it is noted here: the plain data that a reader makes
of a file, the places of its values, what is said of it, each problem with its place, and the
document of a GLB that is written. Notes stand in ``tests/formats/notes``, a line for each test:
how many answers, a digest of their texts, keys, whole numbers and orders, and two sums of their
numbers, which have a tolerance. As records do (`tests.recorded.answers`), they prove nothing, and
notice that an answer is not the same any more.

    ALIGHT_NOTE=1 pytest tests/formats/usd

notes anew. ``ALIGHT_NOTE=FOLDER`` writes the answers themselves there, a file for each test, to be
compared with those of another version by ``diff``.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tests.recorded.making import masked

FOLDER = Path(__file__).with_name("notes")

#: By how much the sums may differ, of numbers on a scale on which one of 1 % is another by 0.01.
TOLERANCE = 1e-3

#: Messages that are OpenUSD's own, after these words.
OF_OPENUSD = re.compile(r"(is not an OpenUSD stage|does not fit together|^'?OpenUSD): .*")


def words(value: Any) -> Iterator[str | float | np.ndarray]:
    """All that a value holds, in order: texts of keys, kinds and whole numbers; and numbers."""
    if isinstance(value, np.ndarray) and value.dtype.kind == "f":
        yield f"array {value.shape}"
        yield value
    elif isinstance(value, np.ndarray):
        yield f"array {value.shape} {value.dtype.kind} {value.tolist()}"
    elif isinstance(value, (float, np.floating)):
        yield float(value)
    elif value is None or isinstance(value, (bool, int, str, np.integer, np.bool_)):
        yield repr(value) if not isinstance(value, np.generic) else repr(value.item())
    elif isinstance(value, Mapping):
        for key, one in value.items():
            yield f"{key}:"
            yield from words(one)
    elif isinstance(value, (set, frozenset)):
        yield from words(sorted(value, key=repr))
    elif isinstance(value, (list, tuple)):
        yield f"{len(value)} of"
        for one in value:
            yield from words(one)
    elif is_dataclass(value) and not isinstance(value, type):
        yield type(value).__name__
        for one in fields(value):
            yield from words(getattr(value, one.name))
    else:
        yield type(value).__name__
        held = getattr(value, "__dict__", None) or {
            name: getattr(value, name, None)
            for kind in type(value).__mro__
            for name in getattr(kind, "__slots__", ())
        }
        yield from words({k: one for k, one in held.items() if not k.startswith("_")})


def scaled(numbers: np.ndarray) -> np.ndarray:
    """Numbers of any size, of which each counts: nearly their logarithms, with their signs."""
    finite = np.nan_to_num(np.asarray(numbers, np.float64), nan=12.3, posinf=1e30, neginf=-1e30)
    return np.arcsinh(100.0 * finite)


#: Folders in remedies: that of the project, and the one to trust.
IN_REMEDIES = re.compile(r"""(pip install ["']|--root )[^\s"'\[]*""")


class Notes:
    """What one test was answered."""

    def __init__(self, folder: str) -> None:
        # Tests have folders of their own below it, which are numbered as they come.
        self.folder = re.compile(re.escape(folder) + r"(?:/popen-gw\d+)?(?:/[^/\s\"']*)?")
        self.count = 0
        self.text: list[str] = []
        self.numbers: list[np.ndarray] = []

    def add(self, *answers: Any) -> None:
        """Note an answer."""
        self.count += 1
        for word in words(answers):
            if isinstance(word, str):
                self.text.append(self.plain(word))
            else:
                self.numbers.append(np.atleast_1d(word).ravel())

    def plain(self, text: str) -> str:
        """A text without the folders of this run."""
        text = IN_REMEDIES.sub(r"\1", self.folder.sub("", text))
        # What OpenUSD says has other words in another version.
        return masked(OF_OPENUSD.sub(r"\1", text))

    def line(self) -> list[Any]:
        """The note."""
        numbers = scaled(np.concatenate([np.zeros(1), *self.numbers]))
        places = np.arange(numbers.size)
        sums = [np.sum(np.cos(turn * places + 0.2) * numbers) for turn in (1.3, 2.1)]
        digest = hashlib.sha256("\n".join(self.text).encode()).hexdigest()[:10]
        return [self.count, digest, *(round(float(one), 4) for one in sums)]

    def shown(self) -> str:
        """The answers themselves."""
        rows = [np.array2string(one, precision=6, threshold=100) for one in self.numbers]
        return "\n".join([*self.text, *rows, ""])


def path_of(module: str) -> Path:
    """Where the notes of a module of tests are kept, by its path below this folder."""
    return FOLDER / module.replace("/", "-").replace(".py", ".json")


def kept(module: str) -> dict[str, list[Any]]:
    """Notes of a module of tests, by name; none where it has none."""
    path = path_of(module)
    return json.loads(path.read_text("utf-8")) if path.exists() else {}


def keep(module: str, notes: Mapping[str, list[Any]]) -> None:
    """Write the notes of a module of tests, a line each."""
    rows = [f"{json.dumps(name)}: {json.dumps(line)}" for name, line in sorted(notes.items())]
    FOLDER.mkdir(exist_ok=True)
    path_of(module).write_text("{\n" + ",\n".join(rows) + "\n}\n", "utf-8")


def same(found: list[Any], right: list[Any]) -> bool:
    """Tell whether two notes are of the same answers."""
    return found[:2] == right[:2] and all(
        abs(one - other) <= TOLERANCE for one, other in zip(found[2:], right[2:], strict=True)
    )


def name_of(nodeid: str) -> tuple[str, str]:
    """Module below this folder and name of a test."""
    found = re.fullmatch(r"(?:.*tests/)?formats/(.*?\.py)::(.*)", nodeid)
    assert found, nodeid
    return found[1], found[2]
