"""``alight scene random``: a random scene from a seed."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

#: What `--kind` takes to show the kinds.
LIST = "list"


def random(
    seed: Annotated[int, typer.Option(help="Any whole number; each gives another scene.")] = 0,
    kind: Annotated[
        str | None,
        typer.Option(
            metavar="KIND|list", help="What sort of scene; list shows them.", show_default="drawn"
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            help="File to write, .yaml, .yml or .json; large meshes and pictures next to it.",
            show_default="printed",
        ),
    ] = None,
    size: Annotated[str | None, typer.Option(metavar="WxH", help="Pixels.")] = None,
) -> None:
    """Generate a random scene from all registered shapes, materials and lights."""
    from alight.core.errors import OutputError
    from alight.formats import dumps, save
    from alight.lab.random_scenes import random_scene
    from alight.lab.random_scenes.kinds import KINDS, summary
    from alight.options.scene import SizedOptions

    if kind == LIST:
        width = max(map(len, KINDS))
        for name in KINDS:
            typer.echo(f"{name:<{width}}  {summary(name)}")
        return
    scene = random_scene(seed, kind, SizedOptions.options()["size"].parse(size))
    if output is None:
        typer.echo(dumps(scene), nl=False)
        return
    try:
        save(scene, output)
    except OSError as error:
        raise OutputError(f"cannot write {output}: {error.strerror or error}") from None
    typer.echo(f"scene: {output}")
