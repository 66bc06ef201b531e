"""The sources of the packages as the static tests see them: files, syntax trees, families."""

import ast
from functools import cache
from pathlib import Path

from lanewise.jit import no_garbage_collection

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "alight"
COMPILER = ROOT / "lanewise"
FAMILIES = (
    "shapes",
    "bsdfs",
    "textures",
    "lights",
    "cameras",
    "samplers",
    "filters",
    "phases",
    "media",
    "integrators",
    "tone_curves",
    "metrics",
)
CODE_FOLDERS = ("alight", "lanewise", "tests", "benchmarks", "docs", "examples")

Function = ast.FunctionDef | ast.AsyncFunctionDef


def package_files() -> list[Path]:
    """Python files of both packages, sorted."""
    return sorted([*PACKAGE.rglob("*.py"), *COMPILER.rglob("*.py")])


def all_files() -> list[Path]:
    """Python files of the packages, the tests, the benchmarks and the figures, sorted."""
    return sorted(path for folder in CODE_FOLDERS for path in (ROOT / folder).rglob("*.py"))


@cache
def tree(path: Path) -> ast.Module:
    """The syntax tree of a file."""
    with no_garbage_collection():  # which takes four times as long as parsing
        return ast.parse(path.read_text(encoding="utf-8"), filename=str(path))


def functions(path: Path) -> list[Function]:
    """All functions and methods of a file, nested ones included."""
    return [node for node in ast.walk(tree(path)) if isinstance(node, Function)]


def code_lines(function: Function) -> int:
    """Lines of a function without its docstring."""
    total = function.end_lineno - function.lineno + 1
    first = function.body[0]
    if ast.get_docstring(function) is not None:
        total -= first.end_lineno - first.lineno + 1
    return total


def place(path: Path, line: int = 1) -> str:
    """``folder/file.py:line``, as an editor can open it."""
    return f"{path.relative_to(ROOT)}:{line}"


def assigned_names(path: Path) -> set[str]:
    """Names that a file assigns at module level."""
    names = set()
    for node in tree(path).body:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        names |= {target.id for target in targets if isinstance(target, ast.Name)}
    return names
