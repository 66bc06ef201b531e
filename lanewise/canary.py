"""Which assumptions about Numba's inside hold for the Numba that is installed.

``python -m lanewise.canary`` prints a table and ends with 1 if one is broken. ``make canary`` does
so with the newest Numba and NumPy that exist.
"""

from __future__ import annotations

import ast
import io
import platform
import sys
import tokenize
from collections.abc import Iterator
from importlib import import_module, metadata
from pathlib import Path
from typing import NamedTuple

from lanewise.canary_checks import CHECKS

#: The files that import from the inside of Numba.
ADAPTERS = tuple(map(Path(__file__).with_name, ("numba_adapter.py", "numba_shortcuts.py")))


class Row(NamedTuple):
    """One assumption.

    Attributes
    ----------
    name : str
        A private name of Numba, or a part of the adapter.
    assumed : str
    broken : str
        What went wrong; empty if it holds.
    """

    name: str
    assumed: str
    broken: str = ""


# ---------------------------------------------------------------- names


def private_names() -> dict[tuple[str, str], str]:
    """(module, name) of all that is imported from the inside of Numba -> its comment."""
    texts = [path.read_text(encoding="utf-8") for path in ADAPTERS]
    return {key: said for text in texts for key, said in _private_names_in(text).items()}


def _private_names_in(text: str) -> dict[tuple[str, str], str]:
    words = tokenize.generate_tokens(io.StringIO(text).readline)
    comments = {t.start[0]: t.string.lstrip("# ") for t in words if t.type == tokenize.COMMENT}
    return {
        (str(node.module), alias.name): comments.get(alias.lineno, "")
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("numba.")
        for alias in node.names
    }


def try_names() -> Iterator[Row]:
    """Whether each name is still where it was."""
    for (module, name), assumed in private_names().items():
        try:
            found = import_module(module)
            broken = "" if hasattr(found, name) else f"{module} has no {name}"
        except ImportError as error:
            broken = str(error)
        yield Row(f"{module}.{name}", assumed, broken)


def try_methods() -> Iterator[Row]:
    """Whether objects of Numba and llvmlite still have what other files use of them."""
    from llvmlite import ir

    from lanewise.numba_adapter import METHODS

    made = {"llvmlite.ir.PointerType": ir.FloatType().as_pointer()}
    for (owner, name), assumed in METHODS.items():
        module, _, kind = owner.rpartition(".")
        found = made.get(owner) or getattr(import_module(module), kind, None)
        broken = "" if hasattr(found, name) else f"{owner} has no {name}"
        yield Row(f"{owner}.{name}", assumed, broken)


def try_parts() -> Iterator[Row]:
    """Whether each part still does what it is for."""
    for part, check in CHECKS.items():
        broken = ""
        try:
            check()
        except Exception as error:  # whatever it is, the other rows are wanted too
            broken = f"{type(error).__name__}: {error}"
        yield Row(part, str(check.__doc__), broken)


# ---------------------------------------------------------------- the table


def main() -> int:
    """Print the table; 1 if an assumption is broken, else 0."""
    versions = [f"{name} {metadata.version(name)}" for name in ("numba", "llvmlite", "numpy")]
    print(", ".join([*versions, f"Python {platform.python_version()}"]))
    rows = list(try_names())
    # An adapter that cannot be imported has no parts to try.
    has_names = not any(row.broken for row in rows)
    rows += [*try_methods(), *try_parts()] if has_names else []
    for row in rows:
        print(f"{'BROKEN' if row.broken else 'holds':<8}{row.name}: {row.assumed}")
        if row.broken:
            print(f"        {row.broken.strip()}")
    if not has_names:
        print("the parts of the adapter were not tried: mend the names first")
    broken = sum(bool(row.broken) for row in rows)
    print(f"{len(rows) - broken} hold, {broken} broken")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
