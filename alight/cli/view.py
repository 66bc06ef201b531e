"""``alight view``: a live view in the browser."""

from __future__ import annotations

from contextlib import suppress
from typing import Annotated

import typer

from alight.cli.words import DEFAULT_SCENE, takes_words
from alight.options.view import ViewOptions


@takes_words(ViewOptions)
def view(
    options: ViewOptions,
    subject: Annotated[
        str,
        typer.Argument(
            metavar="SCENE|FILM.alight|PICTURE",
            help="Scene file, name of a built-in scene, film or picture.",
        ),
    ] = DEFAULT_SCENE,
) -> None:
    """Look at a scene, a film or a picture in the browser, and move in it while it renders."""
    from alight.view.serve import serve

    with suppress(KeyboardInterrupt):
        serve(subject, options, lambda address: typer.echo(f"view: {address}  (Ctrl-C ends it)"))
