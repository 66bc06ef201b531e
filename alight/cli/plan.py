"""``alight plan``: what a picture of a given error will cost."""

from __future__ import annotations

import typer

from alight.cli.words import SceneName, takes_words
from alight.options.laboratory import PlanOptions


@takes_words(PlanOptions)
def plan(options: PlanOptions, scene: SceneName) -> None:
    """Predict the samples and time needed to reach an error, from a short pilot."""
    import alight

    typer.echo(str(alight.plan(scene, options)))
