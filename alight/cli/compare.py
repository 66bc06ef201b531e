"""``alight compare``: two pictures of any renderer, in figures and side by side."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from alight.cli.words import takes_words
from alight.options.laboratory import CompareOptions

#: Exit code when a limit is exceeded.
FAILED = 1


@takes_words(CompareOptions)
def compare(
    options: CompareOptions,
    a: Annotated[Path, typer.Argument(metavar="A", help="EXR, PNG, JPEG, NPY, HDR or PFM file.")],
    b: Annotated[Path, typer.Argument(metavar="B", help="The reference of relative figures.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print all numbers as JSON.")] = False,
) -> None:
    """Compare two pictures: errors, visible differences, and whether they exceed the noise."""
    import alight

    found = alight.compare(a, b, options)
    text = json.dumps(found.to_dict(), indent=1, allow_nan=False) if as_json else str(found)
    typer.echo(text)
    for failure in found.exceeded:
        typer.echo(failure, err=True)
    if found.exceeded:
        raise typer.Exit(FAILED)
