"""Options as the fields of a dataclass, each with its kind, default and help in one place.

A command takes its words from such a table (`alight.cli.words`), a function of Python its keywords
(`alight.options.entry`), and both their documentation.

Examples
--------
>>> from alight.options.kinds import Whole
>>> @table
... class Toss(Options):
...     coins: int = option(Whole(1, 9), "How many.", default=2)
>>> Toss.of({"coin": 3})
Traceback (most recent call last):
    ...
alight.core.errors.OptionError: unknown option "coin"; did you mean "coins"?  (valid: coins)
"""

from __future__ import annotations

import dataclasses
import textwrap
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, Self, TypeVar, dataclass_transform

from alight.core.errors import OptionError, unknown_name
from alight.options.kinds import Kind, Switch

T = TypeVar("T")

#: Headings of the command line's help, in their order.
PICTURE, SAMPLING = "Picture", "Sampling"
PROMISE = "Target error and adaptive sampling"
ANIMATION = "Animation"
SCENE, FOREIGN = "Overriding the scene file", "Scene files of other programs"
PANELS = ("", PICTURE, SAMPLING, PROMISE, ANIMATION, SCENE, FOREIGN)

#: Types as documentation words them, the longest first.
_TYPES = {
    "Sequence[str | PathLike[str]] | str | PathLike[str]": "path or sequence of paths",
    "Sequence[str] | str": "str or sequence of str",
    "str | PathLike[str]": "path",
    "Mapping[str, str]": "mapping of str to str",
    " | None": "",
    " | ": " or ",
}


@dataclass(frozen=True)
class Option:
    """One option.

    Parameters
    ----------
    kind : Kind
        What it may be.
    help : str
        What it does, for both readers.
    default : value
    flag : str
        On the command line, with the short form or the opposite after a blank or a slash; empty
        if only Python has it. By default the name with hyphens.
    panel : str
        Heading of the command line's help.
    shown : str
        What help says of the default; by default the value itself.
    metavar : str
        How help names a value; by default as the kind says.
    key : str
        Key path of the scene file that it sets.
    name : str
        In Python.
    type : str
        In Python, as it was annotated.
    """

    kind: Kind
    help: str
    default: Any = None
    flag: str | None = None
    panel: str = ""
    shown: str = ""
    metavar: str = ""
    key: str = ""
    name: str = ""
    type: str = ""

    @property
    def flags(self) -> list[str]:
        """As the command line spells it, the long form first; empty if only Python has it."""
        if self.flag is not None:
            return self.flag.split()
        return [f"--{self.name.replace('_', '-')}"]

    @property
    def spelling(self) -> str:
        """As messages of the command line name it."""
        return self.flags[0].partition("/")[0] if self.flags else self.name

    def check(self, value: Any) -> Any:
        """Give the value of a Python call as the renderer takes it.

        Raises
        ------
        OptionError
            Naming the option, its value and what is allowed.
        """
        return self._tried(self.kind.check, value)

    def parse(self, text: Any) -> Any:
        """Read the value of a command line; raises as `check` does."""
        return self._tried(self.kind.parse, text)

    def _tried(self, read: Any, value: Any) -> Any:
        if value is None and self.default in (None, (), {}):
            return self.default
        try:
            return read(value)
        except (TypeError, ValueError) as error:
            if isinstance(error, OptionError):
                raise
            raise OptionError(str(error), self.name) from None


def option(
    kind: Kind,
    help: str,
    *,
    default: Any,
    flag: str | None = None,
    panel: str = "",
    shown: str = "",
    metavar: str = "",
    key: str = "",
) -> Any:
    """Declare a field of a `table`: see `Option` for the parameters."""
    made = Option(kind, help, default, flag, panel, shown, metavar, key)
    if isinstance(default, dict):
        return dataclasses.field(default_factory=dict, metadata={"option": made})
    return dataclasses.field(default=default, metadata={"option": made})


class Options:
    """Base class of the tables: checks the values, whoever gives them."""

    def __post_init__(self) -> None:
        """Check every value."""
        for name, one in self.options().items():
            object.__setattr__(self, name, one.check(getattr(self, name)))

    @classmethod
    @cache
    def options(cls) -> dict[str, Option]:
        """Every option by its name in Python, under the headings of help."""
        fields: Any = dataclasses.fields(cls)  # type: ignore[arg-type]
        found = [replace(f.metadata["option"], name=f.name, type=f.type) for f in fields]
        classes = [vars(one).get("__annotations__", {}) for one in cls.__mro__]

        def place(one: Option) -> tuple[bool, int, int]:
            # What only Python has goes last; a class goes before those that it is made of.
            declared = next(i for i, names in enumerate(classes) if one.name in names)
            return not one.flags, PANELS.index(one.panel), declared

        return {one.name: one for one in sorted(found, key=place)}

    @classmethod
    def of(cls, words: Mapping[str, Any]) -> Self:
        """Make the options of a Python call.

        Raises
        ------
        OptionError
            For a name that does not exist, with the nearest one, and for a wrong value.
        """
        cls.check_names(words)
        return cls(**words)

    @classmethod
    def check_names(cls, words: Mapping[str, Any]) -> None:
        """Refuse names that do not exist.

        Raises
        ------
        OptionError
            With the nearest name.
        """
        for name in words:
            if name not in cls.options():
                raise OptionError(unknown_name("option", name, cls.options()))

    @classmethod
    def parsed(cls, texts: Mapping[str, Any]) -> Self:
        """Make the options of a command line, from the texts that were given.

        Raises
        ------
        OptionError
            For a wrong value.
        """
        options = cls.options()
        return cls(**{name: options[name].parse(text) for name, text in texts.items()})

    def given(self, *names: str) -> dict[str, Any]:
        """Those that differ from their defaults, of some names or of all."""
        options = self.options()
        return {
            name: getattr(self, name)
            for name in names or options
            if getattr(self, name) != _default_of(type(self), name)
        }

    def words(self) -> list[str]:
        """The words of a command line that give these options; what only Python has is left out."""
        found: list[str] = []
        for name, value in self.given().items():
            one = self.options()[name]
            if not one.flags:
                continue
            if isinstance(one.kind, Switch):
                found.append(one.flags[0].split("/")[not value])
                continue
            texts = one.kind.write(value)
            for text in texts if one.kind.is_repeated else [texts]:
                found += [one.spelling, text]
        return found

    def changed(self, **words: Any) -> Self:
        """Copy the options with other values."""
        self.check_names(words)
        return replace(self, **words)  # type: ignore[type-var]


@cache
def _default_of(kind: type[Options], name: str) -> Any:
    """The default as the checks leave it."""
    one = kind.options()[name]
    return one.check(one.default)


@dataclass_transform(kw_only_default=True, frozen_default=True, field_specifiers=(option,))
def table(cls: type[T]) -> type[T]:
    """Make a frozen dataclass of keywords, and write its documentation from the options."""
    made: Any = dataclass(frozen=True, kw_only=True)(cls)
    made.__doc__ = f"{textwrap.dedent(cls.__doc__ or '').rstrip()}\n\n{documented(made)}\n"
    return made


def documented(cls: type[Options]) -> str:
    """Write the options as a numpydoc section."""
    lines = ["Parameters", "----------"]
    for one in cls.options().values():
        kind = getattr(one.kind, "type", "") or one.type
        for text, words in _TYPES.items():
            kind = kind.replace(text, words)
        optional = one.default in (None, {}, ())
        lines.append(f"{one.name} : {kind}, {'optional' if optional else f'default {one.default}'}")
        lines += textwrap.wrap(help_in_python(one), 95, initial_indent="    ",
                               subsequent_indent="    ")  # fmt: skip
    return "\n".join(lines)


def help_in_python(one: Option) -> str:
    """What an option does, what is allowed, and how a command line spells it, if in its own way."""
    parts = [one.help.rstrip(".")]
    if one.kind.range:
        parts.append(f"Must be {one.kind.range}")
    if one.shown:
        parts.append(f"By default {one.shown}")
    if one.flags and one.spelling != f"--{one.name.replace('_', '-')}":
        parts.append(f"On the command line ``{one.spelling}``")
    return ". ".join(parts) + "."
