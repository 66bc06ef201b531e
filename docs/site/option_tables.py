"""Shows the reference pages what tables of options give to functions and classes.

The pages are made from the source without running it, where keywords and their descriptions do not
stand: `alight.options` writes both from its tables.
"""

from __future__ import annotations

import importlib
import inspect
from typing import Any

import griffe

_KINDS = {
    inspect.Parameter.POSITIONAL_OR_KEYWORD: griffe.ParameterKind.positional_or_keyword,
    inspect.Parameter.KEYWORD_ONLY: griffe.ParameterKind.keyword_only,
}


class OptionTables(griffe.Extension):
    """Takes signatures and documentation from the running code, where a table has written them."""

    def on_function(self, *, func: griffe.Function, **_: Any) -> None:
        """Give a function its keywords."""
        if any(str(one.value).startswith("takes(") for one in func.decorators):
            real = _real(func)
            func.parameters = griffe.Parameters(
                *(_parameter(one) for one in inspect.signature(real).parameters.values())
            )
            _document(func, real)

    def on_class(self, *, cls: griffe.Class, **_: Any) -> None:
        """Give a table the description of its fields."""
        if any(str(one.value) == "table" for one in cls.decorators):
            _document(cls, _real(cls))


def _real(shown: griffe.Object) -> Any:
    module = importlib.import_module(shown.module.path)
    return getattr(module, shown.name)


def _document(shown: griffe.Object, real: Any) -> None:
    assert shown.docstring is not None
    shown.docstring.value = inspect.cleandoc(real.__doc__)


def _parameter(one: inspect.Parameter) -> griffe.Parameter:
    default = None if one.default is inspect.Parameter.empty else repr(one.default)
    return griffe.Parameter(
        one.name, annotation=str(one.annotation), kind=_KINDS[one.kind], default=default
    )
