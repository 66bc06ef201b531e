"""``alight reference``: a picture whose own error is known and small."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from alight.cli import arguments


def reference(
    scene: arguments.SceneName,
    output: Annotated[Path, typer.Option("-o", "--output", help="EXR file to write.")],
    error: Annotated[str, typer.Option(help="Requested relRMSE, such as 0.5%.")] = "1%",
    seed: arguments.Seed = 0,
    threads: arguments.Threads = None,
    size: arguments.Size = None,
    assignments: arguments.Assignments = None,
    root: arguments.Root = None,
    quiet: arguments.Quiet = False,
) -> None:
    """Render a reference picture to a given error."""
    from alight.cli.loading import load_scene
    from alight.cli.options import changes_of
    from alight.cli.progress import ProgressBar
    from alight.core.errors import OptionError
    from alight.lab.study_file import parse_share
    from alight.outputs.image import check_writable

    if output.suffix.lower() != ".exr":
        raise OptionError(f"--output: must end in .exr, which keeps standard errors, got {output}")
    check_writable(output)
    try:
        wanted = parse_share(error)
    except ValueError as problem:
        raise OptionError(f"--error: {problem}") from None
    description = load_scene(scene, changes_of({"size": size}, assignments or []), root=root)
    from alight.lab.make_reference import make_reference

    with ProgressBar(quiet) as bar:
        made = make_reference(description, wanted, seed=seed, threads=threads, progress=bar)
    path = made.film.save(output)
    if not quiet:
        found = made.film.relmse_estimate(literature=False).relrmse
        interval = f"[{found.low:.3%}, {found.high:.3%}]"
        typer.echo(f"{made.film.spp:.0f} spp, relRMSE {found.value:.3%} {interval}")
        typer.echo(f"picture: {path}")
