"""``alight render``: a scene becomes a picture with an error bar."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from alight.cli import arguments
from alight.cli.reporting import INTERRUPTED, note_unused, warn

if TYPE_CHECKING:
    from alight.cli.progress import ProgressBar
    from alight.films import Film
    from alight.scene import Scene

DEFAULT_SCENE = "cornell-box"


def render(
    scene: arguments.SceneName = DEFAULT_SCENE,
    output: arguments.Output = None,
    spp: arguments.Spp = None,
    time_limit: arguments.TimeLimit = None,
    seed: arguments.Seed = 0,
    first_sample: arguments.FirstSample = 0,
    replicates: arguments.Replicates = None,
    threads: arguments.Threads = None,
    spp_per_pass: arguments.SppPerPass = None,
    size: arguments.Size = None,
    crop: arguments.Crop = None,
    integrator: arguments.IntegratorName = None,
    sampler: arguments.SamplerName = None,
    filter_name: arguments.FilterName = None,
    max_depth: arguments.MaxDepth = None,
    rr_depth: arguments.RrDepth = None,
    assignments: arguments.Assignments = None,
    plugin: arguments.Plugins = None,
    define: arguments.Definitions = None,
    lenient: arguments.Lenient = False,
    aov: arguments.Layers = None,
    exposure: arguments.Exposure = 0.0,
    tone_map: arguments.ToneMap = "none",
    bits: arguments.Bits = 8,
    stats: arguments.Stats = None,
    quiet: arguments.Quiet = False,
) -> None:
    """Render a scene, by default the Cornell box."""
    from alight.cli.options import changes_of, parse_definitions, parse_names
    from alight.cli.plugins import load_plugins
    from alight.cli.progress import ProgressBar
    from alight.outputs.atomic import check_folder
    from alight.outputs.image import check_writable
    from alight.outputs.tone_mapping import Display
    from alight.scene import load

    # Everything that can be wrong is found before the first second is spent.
    display = Display(exposure, tone_map, bits)
    outputs = output or [Path(f"{Path(scene).stem}.png")]
    for path in outputs:
        check_writable(path)
    if stats is not None:
        check_folder(stats)
    load_plugins(plugin)
    options = {
        "size": size, "crop": crop, "integrator": integrator, "sampler": sampler,
        "filter": filter_name, "max_depth": max_depth, "rr_depth": rr_depth,
        "replicates": replicates,
    }  # fmt: skip
    description = load(
        scene,
        changes_of(options, assignments or []),
        definitions=parse_definitions(define),
        lenient=lenient,
    )
    if not quiet:
        note_unused(scene, description)
    layers = parse_names(aov)
    warnings = [*description.warnings, *_useless_options(outputs, display, layers)]
    for warning in warnings:
        warn(warning)

    begin = time.perf_counter()
    with ProgressBar(quiet, time_limit) as bar:
        film, interrupted = _run(
            description, bar, spp=spp, time_limit=time_limit, seed=seed, threads=threads,
            replicates=description.film.replicates, spp_per_pass=spp_per_pass,
            first_sample=first_sample, aovs=layers,
        )  # fmt: skip
    if interrupted:
        _save_partial(film, outputs[0])
        raise typer.Exit(INTERRUPTED)
    _finish(film, outputs, display, stats, warnings, time.perf_counter() - begin, quiet)


def _run(scene: Scene, bar: ProgressBar, **options: Any) -> tuple[Film | None, bool]:
    """Render until the end or Ctrl-C: the film so far, and whether it was interrupted."""
    from alight.rendering import render as render_scene

    cancel = threading.Event()
    with _cancelling(cancel, bar):
        try:
            film = render_scene(scene, progress=bar, cancel=cancel, **options)
        except KeyboardInterrupt:
            return bar.film, True
    return film, cancel.is_set()


@contextmanager
def _cancelling(cancel: threading.Event, bar: ProgressBar) -> Iterator[None]:
    """Let the first Ctrl-C while rendering end the render in order; others interrupt at once."""

    def on_signal(number: int, frame: Any) -> None:
        if cancel.is_set() or bar.phase != "render":
            raise KeyboardInterrupt
        cancel.set()

    if threading.current_thread() is not threading.main_thread():
        # Only the main thread may set handlers.
        yield
        return
    before = signal.signal(signal.SIGINT, on_signal)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _save_partial(film: Film | None, target: Path) -> None:
    """Write an interrupted picture beside its target, which stays as it is."""
    if film is None or not film.sample_count.any():
        typer.echo("stopped before the first samples; nothing was written", err=True)
        return
    path = film.save(target.with_name(f"{target.stem}.partial.exr"))
    typer.echo(f"stopped at {film.spp:.3g} spp; what there is is in {path}", err=True)


def _finish(
    film: Film | None,
    outputs: list[Path],
    display: Any,
    stats: Path | None,
    warnings: list[str],
    seconds: float,
    quiet: bool,
) -> None:
    """Write the files and say what they are."""
    from alight.cli.summary import statistics_of, summary_lines, warnings_of, write_json
    from alight.outputs.image import write_image

    assert film is not None
    for path in outputs:
        write_image(path, film, exposure=display.exposure, tone_map=display.tone_map,
                    bits=display.bits)  # fmt: skip
    error = film.relmse_estimate()
    found = warnings_of(film)
    for warning in found:
        warn(warning)
    if stats is not None:
        write_json(stats, statistics_of(film, error, outputs, warnings + found))
    if not quiet:
        for line in summary_lines(film, error, seconds):
            typer.echo(line)
        for path in outputs:
            typer.echo(f"picture: {path}")


def _useless_options(outputs: list[Path], display: Any, layers: tuple[str, ...]) -> list[str]:
    """Say which options have no effect on any of the files."""
    from alight.outputs.image import format_of
    from alight.outputs.tone_mapping import Display

    formats = [format_of(path) for path in outputs]
    found = []
    if display != Display() and not any(module.IS_DISPLAY for module in formats):
        found.append("--exposure, --tone-map and --bits change display formats (PNG, JPEG) only")
    if layers and not any(module.KEEPS_LAYERS for module in formats):
        found.append("--aov: only EXR keeps layers; add -o FILE.exr")
    return found
