"""``alight reference``: a picture whose own error is known and small."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from alight.cli.words import Quiet, SceneName, takes_words
from alight.options.laboratory import ReferenceOptions


@takes_words(ReferenceOptions)
def reference(
    options: ReferenceOptions,
    scene: SceneName,
    output: Annotated[Path, typer.Option("-o", "--output", help="EXR file to write.")],
    quiet: Quiet = False,
) -> None:
    """Render a reference picture to a given error."""
    from alight.cli.progress import ProgressBar
    from alight.core.errors import OptionError
    from alight.options.loading import scene_of
    from alight.outputs.image import check_writable

    if output.suffix.lower() != ".exr":
        text = f"must end in .exr, which keeps standard errors, got {output}"
        raise OptionError(text, "--output")
    check_writable(output)
    description = scene_of(scene, options)
    from alight.lab.make_reference import make_reference

    with ProgressBar(quiet) as bar:
        made = make_reference(
            description, options.error, seed=options.seed, threads=options.threads, progress=bar
        )
    path = made.film.save(output)
    if not quiet:
        found = made.film.relmse_estimate(literature=False).relrmse
        interval = f"[{found.low:.3%}, {found.high:.3%}]"
        typer.echo(f"{made.film.spp:.0f} spp, relRMSE {found.value:.3%} {interval}")
        typer.echo(f"picture: {path}")
