"""Functions of Python whose keywords are a table of options.

The table gives the function its signature, for people, editors and type checkers, and the part of
its documentation that describes the options.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import Any, ParamSpec, Protocol, TypeVar, overload

from alight.core.errors import OptionError, unknown_name
from alight.options.table import Options, documented

P = ParamSpec("P")
A_contra = TypeVar("A_contra", contravariant=True)
B_contra = TypeVar("B_contra", contravariant=True)
R_co = TypeVar("R_co", covariant=True)
O_co = TypeVar("O_co", covariant=True)
A = TypeVar("A")
B = TypeVar("B")
R = TypeVar("R")


class OneSubject(Protocol[A_contra, P, R_co]):
    """A function of one thing, and of options by their names or all in one object."""

    @overload
    def __call__(self, subject: A_contra, /, *args: P.args, **words: P.kwargs) -> R_co: ...
    @overload
    def __call__(self, subject: A_contra, options: Options, /) -> R_co: ...


class TwoSubjects(Protocol[A_contra, B_contra, P, R_co]):
    """A function of two things, and of options by their names or all in one object."""

    @overload
    def __call__(self, a: A_contra, b: B_contra, /, *args: P.args, **words: P.kwargs) -> R_co: ...
    @overload
    def __call__(self, a: A_contra, b: B_contra, options: Options, /) -> R_co: ...


class Takes(Protocol[P, O_co]):
    """What `takes` gives: makes functions of options out of functions of a table."""

    @overload
    def __call__(self, function: Callable[[A, O_co], R]) -> OneSubject[A, P, R]: ...
    @overload
    def __call__(self, function: Callable[[A, B, O_co], R]) -> TwoSubjects[A, B, P, R]: ...


def takes(cls: Callable[P, O_co]) -> Takes[P, O_co]:
    """Let a function take the options of a table as keywords.

    Parameters
    ----------
    cls : class
        The table. The function has it as its last parameter, ``options``; callers may give a
        ready one there, too, and keywords then replace its values. ``{options}`` in the
        function's documentation becomes the list of the options.

    Returns
    -------
    callable
    """
    table: Any = cls
    assert issubclass(table, Options)

    def decorate(function: Callable[..., Any]) -> Any:
        signature = _signature_of(function, table)

        @functools.wraps(function)
        def entry(*args: Any, **words: Any) -> Any:
            for name in words:
                if name not in signature.parameters:
                    raise OptionError(unknown_name("option", name, table.options()))
            subjects = signature.bind(*args, **words).arguments
            given = {name: subjects.pop(name) for name in table.options() if name in subjects}
            ready = subjects.pop("options", None)
            options = table(**given) if ready is None else ready.changed(**given)
            return function(**subjects, options=options)

        entry.__signature__ = signature  # type: ignore[attr-defined]
        entry.__doc__ = _documentation_of(function, table)
        return entry

    return decorate


def _signature_of(function: Callable[..., Any], table: type[Options]) -> inspect.Signature:
    own = inspect.signature(function)
    last = own.parameters["options"].replace(default=None, annotation=f"{table.__name__} | None")
    subjects = [one for name, one in own.parameters.items() if name != "options"]
    words = [
        inspect.Parameter(
            name, inspect.Parameter.KEYWORD_ONLY, default=one.default, annotation=one.type
        )
        for name, one in table.options().items()
    ]
    return own.replace(parameters=[*subjects, last, *words])


def _documentation_of(function: Callable[..., Any], table: type[Options]) -> str:
    own = inspect.cleandoc(function.__doc__ or "")
    listed = documented(table).split("\n", 2)[2]
    ready = f"options : {table.__name__}, optional\n    All options in one object."
    return own.replace("{options}", f"{ready}\n{listed}")
