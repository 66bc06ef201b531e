"""``alight convert``: any scene that can be read, written in the native format."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from alight.cli import arguments
from alight.cli.reporting import show_remarks


def convert(
    scene: arguments.SceneName,
    output: Annotated[
        Path, typer.Argument(help="File to write: .yaml, .yml or .json; meshes stand beside it.")
    ],
    camera: arguments.CameraName = None,
    assignments: arguments.Assignments = None,
    define: arguments.Definitions = None,
    lenient: arguments.Lenient = False,
) -> None:
    """Write a scene in the native format, with its meshes and pictures beside it."""
    from alight.cli.options import changes_of, parse_definitions
    from alight.core.errors import OutputError
    from alight.scene import load, save

    changes = changes_of({"camera": camera}, assignments or [])
    description = load(scene, changes, definitions=parse_definitions(define), lenient=lenient)
    show_remarks(description)
    try:
        save(description, output)
    except OSError as error:
        raise OutputError(f"cannot write {output}: {error.strerror or error}") from None
    typer.echo(f"scene: {output}")
