"""``alight trace``: one sample of one pixel, vertex by vertex, in plain Python."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from alight.cli.words import Pixel, SceneName, parse_pixel, takes_words
from alight.options.laboratory import TraceOptions


@takes_words(TraceOptions)
def trace(
    options: TraceOptions,
    scene: SceneName,
    pixel: Pixel,
    as_json: Annotated[bool, typer.Option("--json", help="Print all numbers as JSON.")] = False,
) -> None:
    """Follow one sample of a pixel, one path vertex a line; breakpoints in kernels work."""
    import alight
    from alight.cli.reporting import warn_of_scene
    from alight.options.loading import scene_of

    position = parse_pixel(pixel)
    description = scene_of(scene, options)
    warn_of_scene(description)
    found = alight.trace(description, position, options.with_loaded_scene())
    typer.echo(json.dumps(found.to_dict(), indent=1) if as_json else str(found))
