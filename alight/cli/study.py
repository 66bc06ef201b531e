"""``alight study``: run an experiment and write its report."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from alight.cli.progress import Bar
from alight.cli.reporting import INTERRUPTED, WarnOnce
from alight.cli.words import Quiet, takes_words
from alight.cluster.fork_server import STUDIES, start_fork_server
from alight.options.laboratory import StudyOptions

if TYPE_CHECKING:
    from alight.lab.replicates.session import StudyProgress


@takes_words(StudyOptions, first=lambda said: start_fork_server(said.get("cluster"), STUDIES))
def study(
    options: StudyOptions,
    name: Annotated[
        str | None, typer.Argument(help="Study file, or a name that --list shows.")
    ] = None,
    list_ready: Annotated[bool, typer.Option("--list", help="List the ready studies.")] = False,
    quiet: Quiet = False,
) -> None:
    """Compare techniques: how much noise each leaves, at what cost, with what certainty."""
    from alight.core.errors import OptionError
    from alight.lab.study_file import load_study, ready_names
    from alight.options.plugins import load_plugins

    if list_ready:
        _list()
        return
    if name is None:
        raise OptionError(f"name a study file or one of: {', '.join(ready_names())}")
    load_plugins(options.plugins)
    description = load_study(name, options.root)
    # After the messages about a wrong file: these imports take a second.
    import alight

    with StudyBar(quiet) as bar:
        try:
            found = alight.study(description, options.changed(progress=bar, plugins=()))
        except KeyboardInterrupt:
            typer.echo("stopped; the same command continues from here", err=True)
            raise typer.Exit(INTERRUPTED) from None
    if not quiet:
        typer.echo(str(found))


def _list() -> None:
    from alight.lab.study_file import load_study, ready_names

    names = ready_names()
    width = max(len(name) for name in names)
    for name in names:
        typer.echo(f"{name:<{width}}  {load_study(name).title}")


class StudyBar(Bar):
    """Shows `StudyProgress` on stderr, with the time that is left."""

    def __init__(self, quiet: bool) -> None:
        super().__init__(quiet)
        self._total: float | None = None
        self._warns = WarnOnce()

    def __call__(self, progress: StudyProgress) -> None:
        """Show how far the study is, and say what is suspicious of its scenes."""
        self._warns(progress.warnings)
        if progress.total != self._total:
            # Another phase: its speed says nothing about the last one's.
            self._bar.remove_task(self._task)
            self._task = self._begin(progress.text, progress.total or None)
            self._total = progress.total
        self._bar.update(self._task, description=progress.text, completed=progress.done)
