"""``alight animate``: many pictures of a scene, as files or as one moving picture."""

from __future__ import annotations

import typer

from alight.cli.words import Quiet, SceneName, takes_words
from alight.options.animation import AnimationOptions


@takes_words(AnimationOptions)
def animate(options: AnimationOptions, scene: SceneName, quiet: Quiet = False) -> None:
    """Render an animation; frames that are there already are kept."""
    from alight.cli.reporting import warn
    from alight.rendering.animation import Animation

    animation = Animation(scene, options)
    for warning in animation.scene.warnings:
        warn(warning)
    written = animation.render()
    if not quiet:
        kept = f", {len(animation.kept)} of them kept" if animation.kept else ""
        typer.echo(f"{len(animation.numbers)} frames: {len(written)} files{kept}")
