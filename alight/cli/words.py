"""The options of a command, made from their one table (`alight.options`)."""

from __future__ import annotations

import functools
import inspect
import re
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, get_args

import typer
from typer.models import ArgumentInfo

from alight.options.kinds import Switch
from alight.options.table import Option, Options

SceneName = Annotated[str, typer.Argument(help="Scene file, or a name that `alight scenes` lists.")]
Pixel = Annotated[str, typer.Option(metavar="X,Y", help="Pixel of the film, from the top left.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Only warnings and errors.")]

Plugins = Annotated[
    list[Path] | None,
    typer.Option(
        "--plugin",
        metavar="FILE.py",
        help="Script that registers models (alight.register). Repeatable.",
    ),
]

DEFAULT_SCENE = "cornell-box"

#: How commands spell what has no table of theirs.
_SPELLING = {"plugins": "--plugin", "pixel": "--pixel"}


def takes_words(
    table: type[Options], first: Callable[[dict[str, Any]], None] | None = None
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Let a command take the options of a table as words.

    Parameters
    ----------
    table : class
        The command has its object as the keyword ``options``. Parameters of its own that are
        arguments go before the options, others after them.
    first : callable, optional
        Takes the words that were given, before they are checked, which imports every model that
        they may name.

    Returns
    -------
    callable
        Decorates the command; `spelling_of` it says how its options are spelled.
    """
    words = {name: one for name, one in table.options().items() if one.flags}
    defaults = {name: _default_text(one) for name, one in words.items()}

    def decorate(command: Callable[..., None]) -> Callable[..., None]:
        own = dict(inspect.signature(command, eval_str=True).parameters)
        del own["options"]
        keywords = [one.replace(kind=inspect.Parameter.KEYWORD_ONLY) for one in own.values()]
        made = [_parameter(one) for one in words.values()]
        parameters = sorted([*keywords, *made], key=lambda one: _place(one, made))

        @functools.wraps(command)
        def taking(**texts: Any) -> None:
            given = {name: texts.pop(name) for name in words}
            said = {k: v for k, v in given.items() if v not in (None, [], defaults[k])}
            if first is not None:
                first(said)
            command(**texts, options=table.parsed(said))

        signed: Any = taking
        signed.__signature__ = inspect.Signature(parameters)
        signed.__annotations__ = {one.name: one.annotation for one in parameters}
        signed.spelling = {name: one.spelling for name, one in words.items()}
        return taking

    return decorate


def spelling_of(command: Callable[..., Any]) -> Callable[[str], str]:
    """How the user of a command spells an option that Python calls by a name."""
    spelling = {**_SPELLING, **getattr(command, "spelling", {})}
    return lambda name: spelling.get(name, name)


def _place(parameter: inspect.Parameter, made: list[inspect.Parameter]) -> int:
    if any(isinstance(item, ArgumentInfo) for item in get_args(parameter.annotation)):
        return 0
    return 1 if parameter in made else 2


def _default_text(one: Option) -> Any:
    if one.kind.is_repeated or one.default is None:
        return None
    return one.default if isinstance(one.kind, Switch) else one.kind.write(one.default)


def _parameter(one: Option) -> inspect.Parameter:
    """A parameter as typer reads it; values stay texts, which the table reads."""
    default = _default_text(one)
    switch = isinstance(one.kind, Switch)
    settings = typer.Option(
        *one.flags,
        help=one.help,
        metavar=None if switch else one.metavar or one.kind.metavar,
        show_default=one.shown or not switch,
        rich_help_panel=one.panel or None,
    )
    kind: Any = bool if switch else list[str] | None if one.kind.is_repeated else str | None
    return inspect.Parameter(
        one.name, inspect.Parameter.KEYWORD_ONLY, default=default,
        annotation=Annotated[kind, settings],
    )  # fmt: skip


def parse_pixel(text: str) -> tuple[int, int]:
    """Read ``x,y``; minus signs are left for the check against the film.

    Examples
    --------
    >>> parse_pixel("12, 7")
    (12, 7)
    """
    from alight.core.errors import OptionError, quote

    found = re.fullmatch(r"(-?\d{1,9}),(-?\d{1,9})", text.replace(" ", ""))
    if found is None:
        raise OptionError(f"must be X,Y in pixels, such as 12,7, got {quote(text)}", "--pixel")
    return int(found[1]), int(found[2])
