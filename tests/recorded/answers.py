"""Answers that were right once, kept: whatever changes one of them is seen.

Laws say why an answer is right; a record says that it is still the same. Each module in `cases`
has a dictionary ``CASES`` of functions without arguments, by name; their answers are made of
numbers, texts, arrays, lists and dictionaries. The same input must give the same answer on every
machine: a case fixes its seeds, and leaves out times, paths and widths of terminals.

    python -m tests.recorded [NAME ...]

records answers anew, of all cases or of those whose names contain one of the words. The difference
is then read: each line of it is a change that was meant, and the message of the commit says why.
"""

from __future__ import annotations

import importlib
import json
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

FOLDER = Path(__file__).with_name("answers")
CASES = Path(__file__).with_name("cases")

#: Numbers are kept with this many significant digits.
DIGITS = 6
#: By which rounding may move them from machine to machine, of themselves and of the largest number
#: of their array. Slips move them by far more.
OF_ITSELF, OF_LARGEST = 1e-4, 1e-6

Answer = Any
Case = Callable[[], Answer]


def modules_of_cases() -> Iterator[tuple[str, ModuleType]]:
    """Name and module of all files of cases."""
    for path in sorted(CASES.glob("*.py")):
        yield path.stem, importlib.import_module(f"tests.recorded.cases.{path.stem}")


def all_cases() -> dict[str, Case]:
    """By name: the module's and the function's."""
    found: dict[str, Case] = {}
    for module, loaded in modules_of_cases():
        for name, case in loaded.CASES.items():
            found[f"{module}/{name}"] = case
    return found


def path_of(name: str) -> Path:
    """Where a case's answer is kept."""
    return FOLDER / f"{name}.json"


def plain(answer: Answer) -> Answer:
    """What JSON holds of an answer: numbers rounded, arrays as lists."""
    if isinstance(answer, np.ndarray):
        return plain(answer.tolist())
    if isinstance(answer, dict):
        return {str(key): plain(value) for key, value in answer.items()}
    if isinstance(answer, (list, tuple)):
        return [plain(value) for value in answer]
    if isinstance(answer, str) and "\n" in answer:
        return answer.splitlines()
    if isinstance(answer, (bool, str, np.bool_)) or answer is None:
        return bool(answer) if isinstance(answer, np.bool_) else answer
    if isinstance(answer, (int, np.integer)):
        return int(answer)
    if isinstance(answer, (float, np.floating)):
        number = float(answer)
        return float(f"{number:.{DIGITS}g}") if math.isfinite(number) else str(number)
    raise TypeError(f"an answer cannot hold {type(answer).__name__}")


def save(name: str, answer: Answer) -> None:
    """Record an answer."""
    path = path_of(name)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(_lines(plain(answer))) + "\n", "utf-8")


def _lines(value: Answer, indent: str = "") -> Iterator[str]:
    """JSON whose innermost lists of numbers are a line each."""
    inner = list(value.values()) if isinstance(value, dict) else value
    nested = isinstance(inner, list) and any(isinstance(v, (list, dict, str)) for v in inner)
    if not nested:
        yield json.dumps(value, ensure_ascii=False)
        return
    heads = [f"{json.dumps(k)}: " for k in value] if isinstance(value, dict) else [""] * len(inner)
    yield "{" if isinstance(value, dict) else "["
    for position, (head, item) in enumerate(zip(heads, inner, strict=True)):
        first, *rest = _lines(item, indent + " ")
        comma = "," if position + 1 < len(inner) else ""
        lines = [f"{indent} {head}{first}", *rest]
        lines[-1] += comma
        yield from lines
    yield indent + ("}" if isinstance(value, dict) else "]")


def recorded(name: str) -> Answer:
    """The answer that was right."""
    return json.loads(path_of(name).read_text("utf-8"))


def differences(found: Answer, right: Answer, place: str = "answer") -> Iterator[str]:
    """Where two plain answers differ, one line for each place."""
    scale = max(map(abs, _numbers(right)), default=0.0)
    yield from _differences(found, right, place, scale)


def _numbers(answer: Answer) -> Iterator[float]:
    if isinstance(answer, dict):
        answer = list(answer.values())
    if isinstance(answer, list):
        for value in answer:
            yield from _numbers(value)
    elif isinstance(answer, float):
        yield answer


def _differences(found: Answer, right: Answer, place: str, scale: float) -> Iterator[str]:
    if isinstance(right, dict) and isinstance(found, dict):
        if [*found] != [*right]:
            yield f"{place}: keys {[*found]} instead of {[*right]}"
            return
        for key, value in right.items():
            # Each entry is in units of its own.
            yield from differences(found[key], value, f"{place}.{key}")
    elif isinstance(right, list) and isinstance(found, list):
        if len(found) != len(right):
            yield f"{place}: {len(found)} values instead of {len(right)}"
            return
        for index, (one, other) in enumerate(zip(found, right, strict=True)):
            yield from _differences(one, other, f"{place}[{index}]", scale)
    elif type(found) is type(right) is float:
        largest = max(abs(found), abs(right))
        if abs(found - right) > OF_ITSELF * largest + OF_LARGEST * scale:
            yield f"{place}: {found} instead of {right}"
    elif type(found) is not type(right) or found != right:
        yield f"{place}: {found!r} instead of {right!r}"
