"""Mistakes in kernel text, reported with their place and the remedy.

`check_text` finds by its syntax what no kernel can hold: Numba would accept some of it and crash,
since kernels run without Python's memory. `explained` turns Numba's message about a kernel that it
cannot type into the place, the line, and what to write there instead.
"""

from __future__ import annotations

import ast
import builtins
import dis
import importlib
import inspect
import linecache
import math
import re
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FunctionType
from typing import Any

import numpy as np

from lanewise.application import LANEWISE, application

#: What kernels cannot hold, and what to do about it.
_FORBIDDEN: dict[tuple[type[ast.AST], ...], str] = {
    (ast.List, ast.Dict, ast.Set): "a kernel has no lists, sets or dictionaries: use a tuple",
    (ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp): (
        "a kernel has no comprehensions: write what they give as a tuple, or a loop"
    ),
    (ast.Raise, ast.Assert, ast.Try): (
        "a kernel never raises: refuse bad input before, or give a value that tells"
    ),
    (ast.With, ast.Yield, ast.YieldFrom, ast.Await): "a kernel is a plain function: returns only",
    (ast.JoinedStr,): "a kernel has no text",
    (ast.Lambda, ast.FunctionDef, ast.ClassDef): (
        "define it outside of the kernel, a function with @kernel"
    ),
    (ast.Import, ast.ImportFrom): "import outside of the kernel",
}

#: For names that are not there.
_NOTHING = object()

#: Tests that may stand in ``if`` and ``while``.
_WHOLE_TESTS = ("any_lane", "all_lanes")


def is_ours(function: FunctionType) -> bool:
    """Whether it belongs to lanewise or its application, whose own tests look at its text."""
    top = (function.__module__ or "").partition(".")[0]
    return top in (LANEWISE.name, application().name)


def check_text(function: FunctionType) -> None:
    """Refuse a kernel that holds what none can.

    Raises
    ------
    Exception
        The application's error (`lanewise.application`), with the first mistakes.
    """
    problems = mistakes_in(function)
    if problems:
        raise application().error("\n".join(problems[:2]))


def mistakes_in(function: FunctionType) -> list[str]:
    """What no kernel can hold, each with its place and line; nothing where the text is unknown."""
    tree, file, first = _tree(function)
    found = []
    for node in _inside(tree):
        remedy = next((text for kinds, text in _FORBIDDEN.items() if isinstance(node, kinds)), "")
        if remedy:
            found.append(
                _told(function.__name__, file, first + getattr(node, "lineno", 1) - 1, remedy)
            )
    if function.__code__.co_kwonlyargcount:
        why = "a kernel takes its arguments by position"
        found.append(_told(function.__name__, file, function.__code__.co_firstlineno, why))
    return found + _unknown_names(function, file)


def _inside(tree: ast.AST | None) -> Iterator[ast.AST]:
    """What is in the body; decorators, defaults and annotations are Python's."""
    top: Any = getattr(tree, "body", [None])[0]
    for statement in top.body if isinstance(top, ast.FunctionDef) else ():
        yield from ast.walk(statement)


def _unknown_names(function: FunctionType, file: str) -> list[str]:
    found, line = [], function.__code__.co_firstlineno
    for one in dis.get_instructions(function):
        line = one.positions.lineno or line if one.positions else line
        if one.opname != "LOAD_GLOBAL":
            continue
        value = function.__globals__.get(one.argval, getattr(builtins, one.argval, _NOTHING))
        why = ""
        if value is _NOTHING:
            why = f'the name "{one.argval}" is not defined'
        elif value is print:
            # Without the interpreter's lock it would wait for ever.
            why = "a kernel does not print: look at the Python twin (compiled=False)"
        if why:
            found.append(_told(function.__name__, file, line, why))
    return found


# ---------------------------------------------------------------- what Numba says


@contextmanager
def explained(texts: list[FunctionType]) -> Iterator[None]:
    """Tell what Numba does not compile by place, line and remedy.

    Parameters
    ----------
    texts : list of functions
        Users' kernels; those of the application are right.

    Raises
    ------
    Exception
        The application's error.
    """
    from lanewise.numba_adapter import NOT_COMPILED

    try:
        yield
    except NOT_COMPILED as error:
        raise application().error(_explanation(str(error), texts)) from error


def _explanation(message: str, texts: list[FunctionType]) -> str:
    """At most six lines."""
    place = re.search(r'File "([^"]+)", line (\d+)', message)
    reason = _reason(message)
    if place is None:
        return f"a kernel does not compile: {reason}"
    file, line = place[1], int(place[2])
    mine = [text for text in texts if _holds(text, file, line)]
    if mine:
        guess = _remedy(mine[0], line)
        # A guess by the line's syntax: unless it is certainly about masks, Numba is heard too.
        why = f"{guess}\n  (Numba: {reason})" if guess and "mask" not in reason else guess or reason
        return _told(mine[0].__name__, _file(mine[0]), line, why)
    told = _told("", file, line, reason)
    shown = _line(file, line)
    called = [text for text in texts if re.search(rf"\b{text.__name__}\b", shown)]
    # Kernels that are written by a program have no file.
    written = [text for text in called or texts if not _file(text).startswith("<")]
    suspects = [f"{text.__name__} ({_file(text)})" for text in written]
    if suspects:
        told += f"\n  {' or '.join(suspects)} takes or returns what does not fit there"
    return told


def _reason(message: str) -> str:
    """What Numba says, without where it was looking."""
    lines = [line.strip() for line in message.splitlines() if line.strip()]
    lines = [line for line in lines if not line.startswith("Failed in ")]
    own = re.compile(
        r"(?:\w*Error: )(?!No implementation|can't resolve|All arguments must be Sets)(.*)"
    )
    specific = next((found[1] for line in lines if (found := own.match(line))), "")
    call = next((line for line in lines if line.startswith(">>> ")), "")
    if specific or call:
        return specific or f"there is no {call.removeprefix('>>> ')}"
    return lines[0] if lines else "Numba does not say why"


def _remedy(function: FunctionType, line: int) -> str:
    """What is wrong in the statement at a line, if it is one of the usual mistakes."""
    tree, _, first = _tree(function)
    if tree is None:
        return ""
    at = line - first + 1
    statements = [
        node
        for node in ast.walk(tree)
        if isinstance(node, ast.stmt)
        and not isinstance(node, ast.FunctionDef)
        and node.lineno <= at <= (node.end_lineno or node.lineno)
    ]
    # The innermost one; of what has a body, only its test.
    statement = max(statements, key=lambda node: node.lineno, default=None)
    if statement is None:
        return ""
    searched = [getattr(statement, "test", statement)]
    if isinstance(statement, ast.If | ast.While) and not _is_whole(statement.test):
        word = "if" if isinstance(statement, ast.If) else "while"
        return (
            f"lanes may differ: {word} any_lane(mask):, "
            "and blend what changes with where(mask, new, old)"
        )
    for node in (one for root in searched for one in ast.walk(root)):
        found = _remedy_of(node, function)
        if found:
            return found
    return ""


def _remedy_of(node: ast.AST, function: FunctionType) -> str:
    if isinstance(node, ast.BoolOp):
        old, new = ("and", "&") if isinstance(node.op, ast.And) else ("or", "|")
        return f'a mask has a truth for each lane: write (a) {new} (b), not "a {old} b"'
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        return 'a mask has a truth for each lane: write ~mask, not "not mask"'
    if isinstance(node, ast.IfExp):
        return 'lanes may differ: write where(mask, a, b), not "a if mask else b"'
    if isinstance(node, ast.Compare) and len(node.ops) > 1:
        return 'a mask has a truth for each lane: write (a < b) & (b < c), not "a < b < c"'
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
        module = function.__globals__.get(node.value.id)
        if module in (math, np):
            return _function_of_lanes(node.value.id, node.attr)
    return ""


def _function_of_lanes(module: str, name: str) -> str:
    """Where a function of lanes stands that is called like one of numbers."""
    for place in ("lanewise.simd", *application().mathematics):
        if hasattr(importlib.import_module(place), name):
            return f"{module}.{name} is not for lanes: from {place} import {name}"
    return f"{module}.{name} is not for lanes: use the functions of lanewise.simd"


def _is_whole(test: ast.expr) -> bool:
    """Whether a test asks for all lanes at once."""
    return isinstance(test, ast.Call) and getattr(test.func, "id", "") in _WHOLE_TESTS


# ---------------------------------------------------------------- text and its places


def _tree(function: FunctionType) -> tuple[ast.AST | None, str, int]:
    """Syntax of a function, its file, and the line that its text begins at."""
    file = _file(function)
    try:
        lines, first = inspect.getsourcelines(function)
        return ast.parse(textwrap.dedent("".join(lines))), file, first
    except (OSError, TypeError, SyntaxError):
        return None, file, function.__code__.co_firstlineno


def _file(function: FunctionType) -> str:
    return function.__code__.co_filename


def _holds(function: FunctionType, file: str, line: int) -> bool:
    tree, own, first = _tree(function)
    body: Any = getattr(tree, "body", [None])[0]
    last = first + (body.end_lineno if body is not None else 1) - 1
    return _same_file(own, file) and first <= line <= last


def _same_file(a: str, b: str) -> bool:
    return a == b or Path(a).resolve() == Path(b).resolve()


def _line(file: str, line: int) -> str:
    return linecache.getline(str(file), line).strip()


def _told(name: str, file: str, line: int, why: str) -> str:
    """Where, the line itself, and what is wrong with it."""
    kernel = f"{name}: " if name else ""
    shown = _line(file, line)
    quoted = f"\n    {shown}" if shown else ""
    return f"{kernel}{file}:{line}{quoted}\n  {why}"
