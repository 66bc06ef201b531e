"""``alight plan``: what a picture of a given error will cost."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from alight.cli.words import SceneName, takes_words
from alight.options.laboratory import PlanOptions


@takes_words(PlanOptions)
def plan(
    options: PlanOptions,
    scene: SceneName,
    as_json: Annotated[bool, typer.Option("--json", help="Print all numbers as JSON.")] = False,
) -> None:
    """Predict the samples and time needed to reach an error, from a short pilot."""
    import alight

    found = alight.plan(scene, options)
    typer.echo(json.dumps(found.to_dict(), indent=1, allow_nan=False) if as_json else str(found))
