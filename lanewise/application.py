"""The application that brings the kernels: it names the settings, and its sources name the cache.

A package built on lanewise calls `set_application` once, when it is imported. Its users then set
``ALIGHT_CACHE`` and not the variable of a library that they have never heard of.
"""

from __future__ import annotations

import os
from typing import NamedTuple


class KernelError(TypeError):
    """A kernel is wrong: the place, its line, and what to write instead."""


class Application(NamedTuple):
    """A package with kernels of its own.

    Attributes
    ----------
    name : str
        Its import name; in capitals, the first word of its environment variables.
    folder : str
        Where its sources are.
    error : type of exception
        What is raised for kernels that are wrong.
    mathematics : tuple of str
        Modules with functions of lanes beyond `lanewise.simd`.
    """

    name: str
    folder: str
    error: type[Exception] = KernelError
    mathematics: tuple[str, ...] = ()


#: Without another application, scripts and notebooks use lanewise as it is.
LANEWISE = Application("lanewise", os.path.dirname(__file__))  # noqa: PTH120 (no pathlib here)

_current = LANEWISE


def set_application(
    name: str,
    folder: str,
    *,
    error: type[Exception] = KernelError,
    mathematics: tuple[str, ...] = (),
) -> None:
    """Compile for this package from now on; there is one in a process, the last one counts."""
    global _current
    _current = Application(name, folder, error, mathematics)


def application() -> Application:
    """The package that kernels are compiled for."""
    return _current


def variable(word: str) -> str:
    """Name of the environment variable of a setting, for instance ``LANEWISE_LANES``."""
    return f"{_current.name.upper()}_{word}"


def setting(word: str) -> str | None:
    """What the user has set in the environment; None if nothing."""
    return os.environ.get(variable(word))
