"""``alight merge``: films of different samples of one picture become one film, exactly."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from alight.cli import arguments


def merge(
    films: Annotated[
        list[Path], typer.Argument(help="Film files (.alight) and checkpoints, in any order.")
    ],
    output: Annotated[
        list[Path],
        typer.Option(
            "-o", "--output", help="Picture, or film (.alight) to merge again. Repeatable."
        ),
    ],
    exposure: arguments.Exposure = "0",
    white_balance: arguments.WhiteBalance = "none",
    tone_map: arguments.ToneMap = "none",
    bits: arguments.Bits = 8,
    denoise: arguments.Denoise = False,
    quiet: arguments.Quiet = False,
) -> None:
    """Merge films of different samples of the same picture, or convert a single film."""
    from alight.cli.finishing import Results, write_outputs
    from alight.cli.reporting import warn
    from alight.cli.summary import bias_lines, error_line, warnings_of
    from alight.outputs.display import Display
    from alight.rendering import merge as merge_films

    display = Display(exposure, tone_map, bits, white_balance)
    results = Results(output, display, denoise)
    results.check()
    film = merge_films(*films)
    denoiser = write_outputs(film, results)
    for warning in warnings_of(film):
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
