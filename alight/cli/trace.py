"""``alight trace``: one sample of one pixel, vertex by vertex, in plain Python."""

from __future__ import annotations

import json
import re
from typing import Annotated

import typer

from alight.cli import arguments


def trace(
    scene: arguments.SceneName,
    pixel: Annotated[
        str, typer.Option(metavar="X,Y", help="Pixel of the film, from the top left.")
    ],
    sample: Annotated[int, typer.Option(help="Which sample of the pixel.")] = 0,
    seed: arguments.Seed = 0,
    size: arguments.Size = None,
    camera: arguments.CameraName = None,
    integrator: arguments.IntegratorName = None,
    sampler: arguments.SamplerName = None,
    filter_name: arguments.FilterName = None,
    max_depth: arguments.MaxDepth = None,
    rr_depth: arguments.RrDepth = None,
    replicates: arguments.Replicates = None,
    assignments: arguments.Assignments = None,
    plugin: arguments.Plugins = None,
    define: arguments.Definitions = None,
    lenient: arguments.Lenient = False,
    root: arguments.Root = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print all numbers as JSON.")] = False,
) -> None:
    """Follow one sample of a pixel, one path vertex a line; breakpoints in kernels work."""
    from alight.cli.loading import load_scene
    from alight.cli.options import changes_of
    from alight.cli.reporting import warn
    from alight.rendering.trace import trace as trace_sample

    position = parse_pixel(pixel)
    options = {
        "size": size, "camera": camera, "integrator": integrator, "sampler": sampler,
        "filter": filter_name, "max_depth": max_depth, "rr_depth": rr_depth,
        "replicates": replicates,
    }  # fmt: skip
    description = load_scene(
        scene,
        changes_of(options, assignments or []),
        plugin=plugin,
        define=define,
        lenient=lenient,
        root=root,
    )
    for warning in description.warnings:
        warn(warning)
    found = trace_sample(description, position, sample=sample, seed=seed)
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
        raise OptionError(f"--pixel: must be X,Y in pixels, such as 12,7, got {quote(text)}")
    return int(found[1]), int(found[2])
