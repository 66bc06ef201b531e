"""``alight info``: what a scene, a film or a picture holds."""

from __future__ import annotations

from typing import Annotated

import typer

from alight.cli.words import takes_words
from alight.options.laboratory import InfoOptions


@takes_words(InfoOptions)
def info(
    options: InfoOptions,
    scene: Annotated[str, typer.Argument(help="Scene file, built-in name, film or picture.")],
) -> None:
    """Show what a scene, a film or a picture holds, without rendering it."""
    import alight

    found = alight.info(scene, options)
    typer.echo(str(found))
    for line in found.remarks():
        typer.echo(line, err=True)
