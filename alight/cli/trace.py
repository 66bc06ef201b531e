"""``alight trace``: one sample of one pixel, vertex by vertex, in plain Python."""

from __future__ import annotations

import json
import re
from typing import Annotated

import typer

from alight.cli.words import SceneName, takes_words
from alight.options.laboratory import TraceOptions


@takes_words(TraceOptions)
def trace(
    options: TraceOptions,
    scene: SceneName,
    pixel: Annotated[
        str, typer.Option(metavar="X,Y", help="Pixel of the film, from the top left.")
    ],
    as_json: Annotated[bool, typer.Option("--json", help="Print all numbers as JSON.")] = False,
) -> None:
    """Follow one sample of a pixel, one path vertex a line; breakpoints in kernels work."""
    import alight
    from alight.cli.reporting import warn
    from alight.options.loading import scene_of

    position = parse_pixel(pixel)
    description = scene_of(scene, options)
    for warning in description.warnings:
        warn(warning)
    found = alight.trace(description, position, options.with_loaded_scene())
    typer.echo(json.dumps(found.to_dict(), indent=1) if as_json else str(found))


def parse_pixel(text: str) -> tuple[int, int]:
    """Read ``x,y``; minus signs are left for the check against the film.

    Examples
    --------
    >>> parse_pixel("12, 7")
    (12, 7)
    """
    from alight.core.errors import OptionError, quote

    found = re.fullmatch(r"(-?\d{1,9}),(-?\d{1,9})", text.replace(" ", ""))
    if found is None:
        raise OptionError(f"must be X,Y in pixels, such as 12,7, got {quote(text)}", "--pixel")
    return int(found[1]), int(found[2])
