"""``alight warm``: compile kernels before they are needed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from alight.cli.progress import Bar
from alight.cli.reporting import INTERRUPTED, warn
from alight.cli.words import Quiet, takes_words
from alight.options.scene import SceneOptions

if TYPE_CHECKING:
    from alight.lab.warm import WarmProgress

#: Exit code if a scene could not be compiled.
_NOT_ALL = 1


@takes_words(SceneOptions)
def warm(
    options: SceneOptions,
    scenes: Annotated[
        list[str] | None,
        typer.Argument(
            help="Scenes whose kernels are wanted.", show_default="every model and built-in scene"
        ),
    ] = None,
    processes: Annotated[
        int | None,
        typer.Option(
            "--processes", min=1, max=256, help="That compile at the same time.",
            show_default="processors, at most 4",
        ),
    ] = None,
    quiet: Quiet = False,
) -> None:  # fmt: skip
    """Compile kernels now and keep them: later renders start at once."""
    from alight.lab.warm import warm as compile_all
    from alight.rendering.resources import usable_processors
    from lanewise.machine import cache_folder

    with WarmBar(quiet) as bar:
        try:
            count = processes or min(4, usable_processors())
            done = compile_all(scenes or (), options, processes=count, progress=bar)
        except KeyboardInterrupt:
            typer.echo("stopped; what was compiled is kept", err=True)
            raise typer.Exit(INTERRUPTED) from None
    for name, problem in done.failures.items():
        warn(f"{name}: {problem}")
    if not quiet:
        count = done.scenes - len(done.failures)
        typer.echo(f"compiled: {count} scenes in {done.seconds:.0f} s, kept in {cache_folder()}")
    if done.failures:
        raise typer.Exit(_NOT_ALL)


class WarmBar(Bar):
    """Shows `WarmProgress` on stderr."""

    def __call__(self, progress: WarmProgress) -> None:
        """Show how far it is."""
        text, done, total = progress
        self._bar.update(self._task, description=f"compiled {text}", completed=done, total=total)
