"""``alight guide``: what a guide has learnt at the place that a pixel sees."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Annotated

import typer

from alight.cli.words import Pixel, Quiet, SceneName, parse_pixel, takes_words
from alight.options.laboratory import GuideOptions


@takes_words(GuideOptions)
def guide(
    options: GuideOptions,
    scene: SceneName,
    pixel: Pixel,
    as_json: Annotated[bool, typer.Option("--json", help="Print all numbers as JSON.")] = False,
    quiet: Quiet = False,
) -> None:
    """Draw what a trained guide knows at a point, next to the light that arrives there."""
    import alight
    from alight.cli.reporting import warn_of_scene
    from alight.lab.panels import check_sheet
    from alight.options.loading import scene_of

    position = parse_pixel(pixel)
    target = Path(options.output or f"{Path(scene).stem}.guide.png")
    check_sheet(target)
    description = scene_of(scene, options)
    warn_of_scene(description)
    begin = time.perf_counter()

    def progress(text: str) -> None:
        if not quiet:
            typer.echo(f"{time.perf_counter() - begin:5.1f} s  {text}", err=True)

    words = options.with_loaded_scene(output=target, progress=progress)
    found = alight.guide(description, position, words)
    typer.echo(json.dumps(found.to_dict(), indent=1) if as_json else f"{found}\ndisks: {target}")
