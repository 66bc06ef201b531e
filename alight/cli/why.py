"""``alight why``: the parts of a picture's noise, and measured advice to lower it."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Annotated

import typer

from alight.cli.words import DEFAULT_SCENE, Quiet, SceneName, takes_words
from alight.options.laboratory import WhyOptions


@takes_words(WhyOptions)
def why(
    options: WhyOptions,
    scene: SceneName = DEFAULT_SCENE,
    as_json: Annotated[bool, typer.Option("--json", help="Print all numbers as JSON.")] = False,
    quiet: Quiet = False,
) -> None:
    """Explain a picture's noise by path depth, technique, light and first material."""
    import alight
    from alight.cli.reporting import warn_of_scene
    from alight.lab.panels import check_sheet
    from alight.options.loading import scene_of

    target = options.output or Path(f"{Path(scene).stem}.why.png")
    check_sheet(target)
    description = scene_of(scene, options)
    warn_of_scene(description)
    begin = time.perf_counter()

    def progress(text: str) -> None:
        if not quiet:
            typer.echo(f"{time.perf_counter() - begin:5.1f} s  {text}", err=True)

    found = alight.why(description, options.with_loaded_scene(output=target, progress=progress))
    if as_json:
        typer.echo(json.dumps(found.to_dict(), indent=1))
        return
    typer.echo(str(found))
    typer.echo(f"maps: {target}")
