"""Errors that a user can fix: one message on stderr, exit code 2, no traceback."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

import typer

from alight.cli.words import spelling_of
from alight.core.errors import AlightError, OptionError

if TYPE_CHECKING:
    from alight.scene import Scene

#: Exit codes: wrong input, and stopped by Ctrl-C (128 + SIGINT, as shells expect).
WRONG_INPUT = 2
INTERRUPTED = 130


def reporting_errors(command: Callable[..., Any]) -> Callable[..., Any]:
    """Wrap a command so that a user's errors become messages; bugs keep their traceback."""

    @functools.wraps(command)
    def wrapped(*args: Any, **options: Any) -> Any:
        try:
            return command(*args, **options)
        except OptionError as error:
            message = error.spelled(spelling_of(command))
        except AlightError as error:
            message = str(error)
        except MemoryError as error:
            message = f"not enough memory: {error}"
        except KeyboardInterrupt:
            typer.echo("stopped; nothing was written", err=True)
            raise typer.Exit(INTERRUPTED) from None
        typer.echo(f"error: {message}", err=True)
        raise typer.Exit(WRONG_INPUT)

    return wrapped


def warn(message: str) -> None:
    """Say on stderr what is legal but suspicious."""
    # Through a progress bar that is shown, which moves out of the way.
    sys.stderr.write(f"warning: {message}\n")


class WarnOnce:
    """Prints each warning to stderr once, when it first comes up.

    Attributes
    ----------
    told : list of str
    """

    def __init__(self) -> None:
        self.told: list[str] = []

    def __call__(self, messages: Iterable[str]) -> None:
        """Print those that are new."""
        for message in messages:
            if message not in self.told:
                self.told.append(message)
                warn(message)


def warn_of_scene(scene: Scene) -> None:
    """Say on stderr all that is suspicious of a scene, what only compiling it tells too."""
    from alight.compiled.warnings.scenes import warnings_of_scene

    for message in warnings_of_scene(scene):
        warn(message)


def note_unused(name: str, scene: Scene) -> None:
    """Say on stderr how much of a foreign file plays no part in the picture."""
    count = len(scene.source.remarks.notes)
    if count:
        what = "1 item of the file has" if count == 1 else f"{count} items of the file have"
        typer.echo(f"note: {what} no effect on the picture; see alight info {name}", err=True)


def show_remarks(scene: Scene) -> None:
    """Say on stderr all that a reader of a foreign file dropped or approximated."""
    remarks = scene.source.remarks
    for note in remarks.notes:
        typer.echo(f"dropped: {note}", err=True)
    for warning in remarks.warnings:
        typer.echo(f"approximated: {warning}", err=True)
    for warning in scene.warnings:
        if warning not in remarks.warnings:
            warn(warning)
