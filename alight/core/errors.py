"""Errors that a user can fix: place, value, allowed range, nearest valid name.

All problems of one scene are collected and raised together as one `SceneError`, so that a
user fixes a file in one go instead of one message per run.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Issue:
    """One problem of a scene.

    Parameters
    ----------
    path : str
        Key path of the culprit, for instance ``bsdfs.white.reflectance[0]``.
    message : str
        What is wrong, with the value and what is allowed.
    place : str, default ""
        ``file:line:column`` (one-based) where the scene came from a file.
    about_key : bool, default False
        Whether the key itself is wrong, not its value.
    """

    path: str
    message: str
    place: str = ""
    about_key: bool = False

    def __str__(self) -> str:
        """Place and path on the first line, the message indented on the next ones."""
        head = "  ".join(part for part in (self.place, self.path) if part) or "scene"
        return head + "".join(f"\n  {line}" for line in self.message.splitlines())

    @property
    def sentence(self) -> str:
        """The path, if there is one, and the message."""
        return f"{self.path} {self.message}" if self.path else self.message

    def under(self, prefix: str) -> Issue:
        """Return the same problem with `prefix` put before its path."""
        return replace(self, path=join_path(prefix, self.path))


class AlightError(Exception):
    """Base of every error that a user can fix: the command line shows it without a traceback."""


class FilmError(AlightError, ValueError):
    """Films that must not be merged, or a request for something that a film does not hold."""


class KernelError(AlightError, TypeError):
    """A kernel of a user's model that does not compile: its place, its line, and the remedy."""


class OutputError(AlightError, OSError):
    """A picture that cannot be written or read."""


class DeviceError(AlightError, RuntimeError):
    """A GPU that is not there, or does not go on.

    Parameters
    ----------
    message : str
    code : int, default 0
        The driver's number of the error.
    """

    def __init__(self, message: str, code: int = 0) -> None:
        super().__init__(message)
        self.code = code


class OptionError(AlightError, ValueError):
    """An option that does not exist, is out of range, or conflicts with another.

    Parameters
    ----------
    problem : str
        What is wrong, with the value and what is allowed.
    option : str, default ""
        Name of the culprit in Python; it goes before the problem.
    names : tuple of str, default ()
        Further options that the problem speaks of, as ``{spp}``.

    Examples
    --------
    >>> str(OptionError("must be > 0 seconds, got 0", "time_limit"))
    'time_limit: must be > 0 seconds, got 0'
    >>> both = OptionError("{error} and {spp} contradict each other", names=("error", "spp"))
    >>> both.spelled(lambda name: f"--{name}")
    '--error and --spp contradict each other'
    """

    def __init__(self, problem: str, option: str = "", names: tuple[str, ...] = ()) -> None:
        super().__init__(problem, option, names)
        self.problem, self.option, self.names = problem, option, names

    def __str__(self) -> str:
        """Options by their names in Python."""
        return self.spelled(str)

    def spelled(self, spell: Callable[[str], str]) -> str:
        """Write the message with the options spelled as the user has written them."""
        text = self.problem
        for name in self.names:
            text = text.replace(f"{{{name}}}", spell(name))
        return f"{spell(self.option)}: {text}" if self.option else text


class SceneError(AlightError, ValueError):
    """A scene that cannot be rendered, with every reason found.

    Parameters
    ----------
    issues : sequence of Issue
        At least one; duplicates are kept once.
    """

    def __init__(self, issues: Sequence[Issue]) -> None:
        self.issues = tuple(dict.fromkeys(issues))
        super().__init__(self.issues)

    def __str__(self) -> str:
        """One block per issue, in the order in which they were found."""
        return "\n".join(str(issue) for issue in self.issues)


def join_path(*parts: str | int) -> str:
    """Join key path parts: names with dots, whole numbers as ``[i]``.

    Examples
    --------
    >>> join_path("bsdfs", "white", "reflectance", 0)
    'bsdfs.white.reflectance[0]'
    """
    path = ""
    for part in parts:
        if isinstance(part, int):
            path += f"[{part}]"
        elif part:
            path += part if not path or part.startswith("[") else f".{part}"
    return path


def is_at_or_below(path: str, place: str) -> bool:
    """Whether a key path is a place or leads to something in it.

    Examples
    --------
    >>> is_at_or_below("nodes.lamp.light.scale[0]", "nodes.lamp.light")
    True
    >>> is_at_or_below("nodes.lamps.light", "nodes.lamp")
    False
    """
    rest = path.removeprefix(place)
    return bool(place) and path.startswith(place) and rest[:1] in ("", ".", "[")


def nearest(name: str, valid: Iterable[str]) -> str | None:
    """Find the valid name that looks most like `name`, or None where none is near."""
    by_lower_case = {word.lower(): word for word in valid}
    # Beyond this length a name is no misspelling, and difflib's time grows with its square.
    found = difflib.get_close_matches(name.lower()[:80], list(by_lower_case), n=1, cutoff=0.6)
    return by_lower_case[found[0]] if found else None


def unknown_name(kind: str, name: str, valid: Iterable[str], listed_as: str = "valid") -> str:
    """Write the message for a name that does not exist, with the nearest one and the list.

    Parameters
    ----------
    kind : str
        What the name should have been, for instance ``key`` or ``bsdf``.
    name : str
        What was written.
    valid : iterable of str
        The names that exist.
    listed_as : str, default "valid"
        Word before the list of names.

    Examples
    --------
    >>> unknown_name("bsdf", "difuse", ["mirror", "diffuse"])
    'unknown bsdf "difuse"; did you mean "diffuse"?  (valid: diffuse, mirror)'
    """
    names = sorted(valid)
    near = nearest(name, names)
    hint = f'; did you mean "{near}"?' if near else ""
    shown = ", ".join(names[:40]) + (", ..." if len(names) > 40 else "")
    return f"unknown {kind} {quote(name)}{hint}  ({listed_as}: {shown or 'none'})"


def quote(name: str) -> str:
    """`name` in double quotes, cut to a readable length, control characters escaped."""
    shown = name if len(name) <= 60 else name[:57] + "..."
    return '"' + "".join(c if c.isprintable() else repr(c)[1:-1] for c in shown) + '"'


def show_value(value: object) -> str:
    """Make a short text for any value in a message."""
    if isinstance(value, str):
        return quote(value)
    if value is None or isinstance(value, bool):
        return {None: "nothing", True: "true", False: "false"}[value]
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
