"""What names and calls in the pages stand for, looked up in the packages."""

import ast
import importlib
import inspect
import re
import typing
from functools import cache
from pathlib import Path

from tests.docs.pages import ROOT, blocks, prose

PACKAGE, COMPILER = ROOT / "alight", ROOT / "lanewise"
SIGNATURE = re.compile(r"[A-Za-z_][\w.]*\([^()]*\)")


def code_spans(page: Path) -> list[str]:
    """Short pieces of code in the text of a page."""
    return re.findall(r"`([^`\n]+)`", prose(page))


def calls(page: Path) -> list[str]:
    """Pieces such as ``name(a, b)``: in the text, and in drawings outside of the theory."""
    found = [span for span in code_spans(page) if SIGNATURE.fullmatch(span)]
    if page.parent.name != "theory":
        found += [call for block in blocks(page, "text") for call in SIGNATURE.findall(block)]
    return found


def import_path(dotted: str) -> object:
    """The object of a dotted path: modules, then attributes, fields and annotations.

    Raises
    ------
    LookupError
        If a part does not exist.
    """
    parts = dotted.split(".")
    for n in range(len(parts), 0, -1):
        name = ".".join(parts[:n])
        try:
            found = importlib.import_module(name)
        except ModuleNotFoundError as error:
            # A missing optional package is not a missing name.
            if error.name and not name.startswith(error.name):
                raise
            continue
        for part in parts[n:]:
            found = _member(found, part)
        return found
    raise LookupError(dotted)


def _member(owner: object, name: str) -> object:
    """An attribute of a module or of a class, or the default of a description's field."""
    fields = getattr(owner, "model_fields", None)
    if isinstance(owner, type) and fields is not None and name in fields:
        return fields[name].get_default()
    if hasattr(owner, name):
        return getattr(owner, name)
    if isinstance(owner, type) and name in _annotated(owner):
        return None
    raise LookupError(f"{owner!r} has no {name!r}")


@cache
def _annotated(owner: type) -> frozenset[str]:
    """Fields that a class annotates, and what its methods assign to ``self``."""
    names = {name for base in owner.__mro__ for name in getattr(base, "__annotations__", {})}
    for base in owner.__mro__[:-1]:
        try:
            source = inspect.getsource(base)
        except (OSError, TypeError):
            continue
        names |= set(re.findall(r"\bself\.(\w+)(?:,| *[:=][^=])", source))
    return frozenset(names)


@cache
def definitions() -> dict[str, list[tuple[str, ...]]]:
    """Parameters of all functions of the packages, those of classes being their constructor's."""
    found: dict[str, list[tuple[str, ...]]] = {}
    for path in sorted([*PACKAGE.rglob("*.py"), *COMPILER.rglob("*.py")]):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef):
                found.setdefault(node.name, []).append(_parameters(node.args))
    for path in sorted([*PACKAGE.rglob("*.py"), *COMPILER.rglob("*.py")]):
        # A factory's kernel is documented as ``name(a, b)`` at the head of its docstring.
        for name, inside in re.findall(r"``(\w+)\(([^()`]*)\)``", path.read_text(encoding="utf-8")):
            if name in found:
                found[name].append(tuple(part.strip() for part in inside.split(",")))
    return found


def _parameters(arguments: ast.arguments) -> tuple[str, ...]:
    names = [a.arg for a in [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs]]
    extra = [f"*{a.arg}" for a in (arguments.vararg, arguments.kwarg) if a]
    return tuple(name for name in names if name not in ("self", "cls")) + tuple(extra)


def fits(text: str, parameters: tuple[str, ...]) -> bool:
    """Whether the arguments of a call as a page writes it are parameters, in their order."""
    given = [part.strip() for part in text.split(",") if part.strip()]
    if given and given[-1] in ("…", "..."):
        given.pop()
    free = any(name.startswith("*") for name in parameters)
    for place, argument in enumerate(given):
        keyword = re.match(r"(\w+) *=", argument)
        if keyword:
            if keyword[1] not in parameters and not free:
                return False
        elif place >= len(parameters) and not free:
            return False
        elif place < len(parameters) and _is_name(argument) and argument != parameters[place]:
            return free
    return True


def _is_name(argument: str) -> bool:
    return argument.isidentifier() and argument not in ("True", "False", "None")


def parameters_of(found: object) -> tuple[str, ...]:
    """Parameters of an imported function or class."""
    target = getattr(found, "factory", found)
    kinds = inspect.signature(typing.cast(typing.Any, target)).parameters.values()
    stars = {inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD}
    return tuple(f"*{p.name}" if p.kind in stars else p.name for p in kinds)
