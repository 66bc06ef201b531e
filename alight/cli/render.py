"""``alight render``: a scene becomes a picture with an error bar, or an animation."""

from __future__ import annotations

from pathlib import Path

from alight.cli.reporting import note_unused
from alight.cli.words import DEFAULT_SCENE, Quiet, SceneName, spelling_of, takes_words
from alight.cluster.fork_server import RENDERS, start_fork_server
from alight.options.animation import AnimationOptions


@takes_words(AnimationOptions, first=lambda said: start_fork_server(said.get("cluster"), RENDERS))
def render(
    options: AnimationOptions, scene: SceneName = DEFAULT_SCENE, quiet: Quiet = False
) -> None:
    """Render a scene, by default the Cornell box, or with --frames or --turntable an animation."""
    from alight.cli.finishing import run_and_finish
    from alight.cli.frames import render_frames
    from alight.rendering.render import prepare
    from alight.rendering.schedules.selection import time_limit_of

    if options.has_frames:
        render_frames(scene, options, spelling_of(render), quiet=quiet)
        return
    still = options.of_still
    output = still.output or _own_name(Path(scene).stem, still.part)
    prepared = prepare(scene, still.changed(output=output))
    if not quiet:
        note_unused(scene, prepared.scene)
    run_and_finish(
        prepared.render, prepared.targets, warnings=prepared.warnings(spelling_of(render)),
        quiet=quiet, time_limit=time_limit_of(still),
    )  # fmt: skip


def _own_name(stem: str, part: tuple[int, int] | None) -> Path:
    """The file that is written where none is named: a part of a render is a film."""
    if part is None:
        return Path(f"{stem}.png")
    return Path(f"{stem}.part-{part[0]}-of-{part[1]}.alight")
