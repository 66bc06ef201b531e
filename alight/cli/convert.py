"""``alight convert``: any readable scene in the native format, or as far as glTF can hold it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from alight.cli.reporting import show_remarks
from alight.cli.words import SceneName, takes_words
from alight.options.laboratory import ConvertOptions


@takes_words(ConvertOptions)
def convert(
    options: ConvertOptions,
    scene: SceneName,
    output: Annotated[
        Path,
        typer.Argument(help="File to write: .yaml, .yml, .json or .glb."),
    ],
) -> None:
    """Write a scene in the native format with its meshes and pictures next to it, or as glTF."""
    from alight.core.errors import OutputError
    from alight.formats import save
    from alight.options.loading import scene_of

    check_suffix(output)
    description = scene_of(scene, options)
    show_remarks(description)
    try:
        for line in save(description, output):
            typer.echo(f"glTF cannot hold: {line}", err=True)
    except OutputError:
        raise
    except OSError as error:
        raise OutputError(f"cannot write {output}: {error.strerror or error}") from None
    typer.echo(f"scene: {output}")


def check_suffix(output: Path) -> None:
    """Refuse a file whose name ends in nothing that can be written, before the scene is read.

    Raises
    ------
    OutputError
        With the endings that there are.
    """
    from alight.core.errors import OutputError, unknown_name
    from alight.formats.native import WRITTEN

    if output.suffix.lower() not in WRITTEN:
        text = unknown_name("suffix", output.suffix, WRITTEN)
        raise OutputError(f"cannot write {output}: {text}")
