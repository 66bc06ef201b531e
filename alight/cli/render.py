"""``alight render``: a scene becomes a picture with an error bar."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from alight.cli.reporting import INTERRUPTED, warn

if TYPE_CHECKING:
    from alight.cli.progress import ProgressBar
    from alight.films import Film
    from alight.scene import Scene

DEFAULT_SCENE = "cornell-box"

_IMAGE = "Picture"
_SAMPLING = "Sampling"
_SCENE = "Instead of what the scene file says"


def render(
    scene: Annotated[
        str, typer.Argument(help="Scene file, or a name that `alight scenes` lists.")
    ] = DEFAULT_SCENE,
    output: Annotated[
        list[Path] | None,
        typer.Option(
            "-o", "--output", help="File to write; the suffix chooses the format. May be repeated.",
            rich_help_panel=_IMAGE, show_default="SCENE.png",
        ),
    ] = None,
    spp: Annotated[
        int | None,
        typer.Option(
            help="Samples per pixel.", min=1, rich_help_panel=_SAMPLING,
            show_default="64 without --time",
        ),
    ] = None,
    time_limit: Annotated[
        float | None,
        typer.Option(
            "--time", help="Seconds after which no pass starts.", rich_help_panel=_SAMPLING
        ),
    ] = None,
    seed: Annotated[
        int, typer.Option(help="Of the random numbers.", rich_help_panel=_SAMPLING)
    ] = 0,
    first_sample: Annotated[
        int,
        typer.Option(
            help="Index of the first sample, to extend a film.", rich_help_panel=_SAMPLING
        ),
    ] = 0,
    replicates: Annotated[
        int | None,
        typer.Option(help="Independent parts for the error bars.", rich_help_panel=_SAMPLING),
    ] = None,
    threads: Annotated[
        int | None, typer.Option(help="Default: all processors.", rich_help_panel=_SAMPLING)
    ] = None,
    spp_per_pass: Annotated[
        int | None, typer.Option(help="Between two progress reports.", rich_help_panel=_SAMPLING)
    ] = None,
    size: Annotated[
        str | None, typer.Option(metavar="WxH", help="Pixels.", rich_help_panel=_SCENE)
    ] = None,
    crop: Annotated[
        str | None,
        typer.Option(metavar="X,Y,W,H", help="Part to render, in pixels.", rich_help_panel=_SCENE),
    ] = None,
    integrator: Annotated[str | None, typer.Option(rich_help_panel=_SCENE)] = None,
    sampler: Annotated[str | None, typer.Option(rich_help_panel=_SCENE)] = None,
    filter_name: Annotated[str | None, typer.Option("--filter", rich_help_panel=_SCENE)] = None,
    max_depth: Annotated[
        int | None, typer.Option(help="Longest path, in edges.", rich_help_panel=_SCENE)
    ] = None,
    rr_depth: Annotated[
        int | None, typer.Option(help="Where Russian roulette begins.", rich_help_panel=_SCENE)
    ] = None,
    assignments: Annotated[
        list[str] | None,
        typer.Option(
            "--set", metavar="PATH=VALUE", help="Any key of the scene file. May be repeated.",
            rich_help_panel=_SCENE,
        ),
    ] = None,
    aov: Annotated[
        str | None,
        typer.Option(
            metavar="NAMES", help="Further layers (EXR), by commas: direct,indirect.",
            rich_help_panel=_IMAGE,
        ),
    ] = None,
    exposure: Annotated[
        float, typer.Option(help="Stops, for display formats.", rich_help_panel=_IMAGE)
    ] = 0.0,
    tone_map: Annotated[
        str, typer.Option(help="none, reinhard, aces or hable.", rich_help_panel=_IMAGE)
    ] = "none",
    bits: Annotated[int, typer.Option(help="8, or 16 (PNG).", rich_help_panel=_IMAGE)] = 8,
    stats: Annotated[
        Path | None, typer.Option(help="JSON file for times and errors.", rich_help_panel=_IMAGE)
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Only warnings and errors.")] = False,
) -> None:  # fmt: skip
    """Render a scene, by default the Cornell box."""
    from alight.cli.options import changes_of, parse_names
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
    options = {
        "size": size, "crop": crop, "integrator": integrator, "sampler": sampler,
        "filter": filter_name, "max_depth": max_depth, "rr_depth": rr_depth,
        "replicates": replicates,
    }  # fmt: skip
    description = load(scene, changes_of(options, assignments or []))
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
