"""``alight why``: the parts of a picture's noise, and measured advice to lower it."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer

from alight.cli import arguments
from alight.cli.render import DEFAULT_SCENE

#: Parts that get a map of their own.
MAPS = 4


def why(
    scene: arguments.SceneName = DEFAULT_SCENE,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help="PNG of the maps.", show_default="SCENE.why.png"),
    ] = None,
    size: Annotated[int, typer.Option(help="Pixels of the longer side.")] = 128,
    spp: Annotated[int, typer.Option(help="Samples per pixel.")] = 64,
    measure: Annotated[
        bool, typer.Option("--measure/--no-measure", help="Try other options, for advice.")
    ] = True,
    limit: Annotated[
        float, typer.Option("--time", help="Start no new trial after this many seconds.")
    ] = 60.0,
    as_json: Annotated[bool, typer.Option("--json", help="Print all numbers as JSON.")] = False,
    seed: arguments.Seed = 0,
    integrator: arguments.IntegratorName = None,
    max_depth: arguments.MaxDepth = None,
    assignments: arguments.Assignments = None,
    plugin: arguments.Plugins = None,
    define: arguments.Definitions = None,
    lenient: arguments.Lenient = False,
    root: arguments.Root = None,
    quiet: arguments.Quiet = False,
) -> None:
    """Explain a picture's noise by path depth, technique, light and first material."""
    import json

    from alight.cli.loading import load_scene
    from alight.cli.options import changes_of
    from alight.cli.reporting import warn
    from alight.core.errors import OptionError
    from alight.lab.why import shares_of, try_alternatives
    from alight.lab.why.maps import write_maps
    from alight.lab.why.words import plain, ranked, share_lines, trial_lines
    from alight.outputs.atomic import check_folder

    target = output or Path(f"{Path(scene).stem}.why.png")
    if target.suffix.lower() != ".png":
        raise OptionError(f"-o: the maps are a .png file, got {target}")
    check_folder(target)
    changes = changes_of({"integrator": integrator, "max_depth": max_depth}, assignments or [])
    description = load_scene(
        scene, changes, plugin=plugin, define=define, lenient=lenient, root=root
    )
    for warning in description.warnings:
        warn(warning)
    begin = time.perf_counter()

    def progress(text: str) -> None:
        if not quiet:
            typer.echo(f"{time.perf_counter() - begin:5.1f} s  {text}", err=True)

    progress("contributions of all paths")
    shares = shares_of(description, size=size, spp=spp, seed=seed)
    top = list(ranked(shares))
    cause = top[0] if top else None
    trials, left = (), ()
    if measure and cause is not None:
        trials, left = try_alternatives(
            description, cause=cause, seed=seed, limit=limit, progress=progress
        )
    write_maps(target, shares, top[:MAPS])
    if as_json:
        typer.echo(json.dumps(plain(shares, trials, left), indent=1))
        return
    for line in share_lines(shares):
        typer.echo(line)
    if measure and cause is not None:
        for line in trial_lines(trials, left):
            typer.echo(line)
    typer.echo(f"maps: {target}")
