"""``alight plan``: what a picture of a given error will cost."""

from __future__ import annotations

import typer

from alight.cli import arguments, promises


def plan(
    scene: arguments.SceneName,
    error: promises.Error = "2%",
    confidence: promises.Confidence = "95%",
    metric: promises.Metric = "relrmse",
    share: promises.Share = "95%",
    seed: arguments.Seed = 0,
    threads: arguments.Threads = None,
    size: arguments.Size = None,
    crop: arguments.Crop = None,
    assignments: arguments.Assignments = None,
    plugin: arguments.Plugins = None,
    define: arguments.Definitions = None,
    lenient: arguments.Lenient = False,
    root: arguments.Root = None,
) -> None:
    """Predict the samples and time needed to reach an error, from a short pilot."""
    from alight.cli.loading import load_scene
    from alight.cli.options import changes_of
    from alight.rendering.plan import make_plan
    from alight.rendering.resources import usable_processors

    promise = promises.parse_promise(error or "2%", confidence, metric, share)
    description = load_scene(
        scene,
        changes_of({"size": size, "crop": crop}, assignments or []),
        plugin=plugin,
        define=define,
        lenient=lenient,
        root=root,
    )
    threads = threads or usable_processors()
    result = make_plan(description, promise, seed=seed, threads=threads)
    spp, seconds = result.spp, result.seconds
    typer.echo(f"pilot: {result.pilot_spp} spp, relRMSE {result.pilot_error:.2%}")
    typer.echo(f"samples: {spp.value:.0f} per pixel (95 %: {spp.low:.0f} to {spp.high:.0f})")
    typer.echo(
        f"processor time: {seconds.value:.3g} s (95 %: {seconds.low:.3g} to {seconds.high:.3g} s), "
        f"on {threads} threads about {seconds.value / threads:.3g} s"
    )
