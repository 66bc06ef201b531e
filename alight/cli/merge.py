"""``alight merge``: films of different samples of one picture become one film, exactly."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from alight.cli.words import Plugins, Quiet, takes_words
from alight.options.render import DisplayOptions


@takes_words(DisplayOptions)
def merge(
    options: DisplayOptions,
    films: Annotated[
        list[Path], typer.Argument(help="Film files (.alight) and checkpoints, in any order.")
    ],
    output: Annotated[
        list[Path],
        typer.Option(
            "-o", "--output", help="Picture, or film (.alight) to merge again. Repeatable."
        ),
    ],
    spp: Annotated[
        int | None,
        typer.Option(min=1, help="Refuse unless every pixel has exactly so many samples."),
    ] = None,
    plugins: Plugins = None,
    quiet: Quiet = False,
) -> None:
    """Merge films of different samples of the same picture, or convert a single film."""
    from alight.cli.reporting import warn
    from alight.films.merging import check_samples
    from alight.options.plugins import load_plugins
    from alight.rendering import merge as merge_films
    from alight.rendering.summary import bias_lines, error_line
    from alight.rendering.writing import Targets, write_outputs

    load_plugins(plugins)
    targets = Targets(output, options.display, options.denoise)
    targets.check()
    film = merge_films(*films)
    if spp is not None:
        check_samples(film, spp)
    denoiser = write_outputs(film, targets)
    for warning in film.warnings:
        warn(warning)
    if not quiet:
        _, _, w, h = film.crop
        count = "1 film" if len(films) == 1 else f"{len(films)} films"
        typer.echo(f"{count}, {w}x{h} pixels, {film.spp:g} spp")
        for line in [
            error_line(film.relmse_estimate(literature=False)),
            *bias_lines(film, denoiser),
        ]:
            typer.echo(line)
        for path in output:
            typer.echo(f"written: {path}")
