"""``alight check``: the laws of light transport, tested on a user's own scene and models."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperCommand

from alight.cli.words import DEFAULT_SCENE, Quiet, SceneName, takes_words
from alight.options.laboratory import CheckOptions

#: The value of ``--mutant`` without a name.
LIST = "list"


class MutantCommand(TyperCommand):
    """Lets ``--mutant`` come without a name, to list them."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Add the name `LIST` where there is none."""
        words = []
        for word, after in zip(args, [*args[1:], "-"], strict=True):
            words.append(word)
            if word == "--mutant" and after.startswith("-"):
                words.append(LIST)
        return super().parse_args(ctx, words)


@takes_words(CheckOptions)
def check(
    options: CheckOptions,
    scene: SceneName = DEFAULT_SCENE,
    mutant: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Plant a classic bug first; without a name, list them."),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Test a scene: materials, lights, random numbers, and that all methods give the same picture.

    Exit code 1 if something fails.
    """
    if mutant == LIST:
        from alight.laws.mutants import mutant_lines

        typer.echo("\n".join(mutant_lines()))
        return
    if mutant is not None:
        _check_mutant(mutant, ["check", scene, *options.words(), *(["--quiet"] if quiet else [])])
        return
    import alight
    from alight.cli.reporting import WarnOnce
    from alight.laws.scene.dump import write_failures
    from alight.options.loading import scene_of

    description = scene_of(scene, options)
    begin = time.perf_counter()

    def progress(text: str) -> None:
        if not quiet:
            typer.echo(f"{time.perf_counter() - begin:5.1f} s  {text}", err=True)

    verdict = alight.check(description, options.with_loaded_scene(output=None, progress=progress))
    WarnOnce()(verdict.warnings)
    for line in verdict.lines(failures_only=quiet):
        typer.echo(line)
    for path in write_failures(verdict, options.output or Path("check-failures")):
        typer.echo(f"picture: {path}")
    if not verdict.ok:
        raise typer.Exit(1)


def _check_mutant(name: str, words: list[str]) -> None:
    """Run a command line in a copy of alight with the bug."""
    from alight.laws.mutants import find_mutant, run_with

    found = find_mutant(name)
    typer.echo(f"planted: {found.words}", err=True)
    code = run_with(found, words)
    if code == 0:
        typer.echo(f"not found: {name} shows {found.shows}")
    raise typer.Exit(code)
