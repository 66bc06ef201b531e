"""The end of a render on the command line: pictures, the last lines, and ways to continue."""

from __future__ import annotations

import os
import shlex
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from alight.cli.interrupts import cancelling
from alight.cli.reporting import warn
from alight.core.errors import AlightError, OutputError

if TYPE_CHECKING:
    from alight.films import Film
    from alight.films.ledger import Bias
    from alight.outputs.display import Display


@dataclass(frozen=True)
class Results:
    """What is to be written when the render ends.

    Parameters
    ----------
    outputs : list of Path
        Pictures, and ``.alight`` files for the film itself; at least one.
    display : Display
        For display formats.
    denoise : bool, default False
        Whether the pictures, not the film, are denoised.
    stats : Path or None
        JSON file.
    checkpoint : Path or None
        File that the render can be resumed from.
    quiet : bool
    warnings : list of str
        Given already; for `stats`.
    """

    outputs: list[Path]
    display: Display
    denoise: bool = False
    stats: Path | None = None
    checkpoint: Path | None = None
    quiet: bool = False
    warnings: Sequence[str] = ()

    def check(self) -> None:
        """Refuse files that cannot be written, before any time is spent.

        Raises
        ------
        OutputError
        """
        from alight.films.denoising import check_denoiser
        from alight.films.storage import is_film_file
        from alight.outputs.atomic import check_folder
        from alight.outputs.image import check_writable

        if self.denoise:
            check_denoiser()
        for path in self.outputs:
            (check_folder if is_film_file(path) else check_writable)(path)
        if self.stats is not None:
            check_folder(self.stats)


def run_and_finish(render: Callable[..., Film], results: Results, time_limit: float | None) -> None:
    """Render until the end or a signal, with a progress bar, and write the result.

    Parameters
    ----------
    render : callable
        Takes `progress` and `cancel`, as `alight.render` does.
    results : Results
    time_limit : float or None
        For the progress bar.

    Raises
    ------
    typer.Exit
        After a signal.
    OutputError
        If a picture cannot be written; the message says where the samples are.
    """
    from alight.cli.progress import ProgressBar

    begin, cancel = time.perf_counter(), threading.Event()
    film, stopped = None, False
    with ProgressBar(results.quiet, time_limit) as bar, cancelling(cancel, bar) as interruption:
        try:
            film = render(progress=bar, cancel=cancel)
        except KeyboardInterrupt:
            stopped = True
        except AlightError:
            raise
        except Exception:
            # Out of memory, or a bug of ours: the samples are no worse for it.
            _save_partial(bar.film, results)
            raise
    if stopped or cancel.is_set():
        _save_partial(film or bar.film, results)
        raise typer.Exit(interruption.exit_code)
    assert film is not None
    try:
        _finish(film, results, time.perf_counter() - begin)
    except OutputError as error:
        raise OutputError(f"{error}\n{_rescue(film, results)}") from error


def _save_partial(film: Film | None, results: Results) -> None:
    """Write an interrupted picture next to its target, which stays as it is."""
    if film is None or not film.sample_count.any():
        typer.echo("stopped before the first samples; nothing was written", err=True)
    else:
        target = results.outputs[0]
        try:
            path = film.save(target.with_name(f"{target.stem}.partial.exr"))
            typer.echo(f"stopped at {film.spp:.3g} spp; the samples so far are in {path}", err=True)
        except OutputError as error:
            typer.echo(f"stopped at {film.spp:.3g} spp; {error}", err=True)
    if results.checkpoint is not None and results.checkpoint.exists():
        typer.echo(f"to continue: {_command('resume', results.checkpoint)}", err=True)


def _finish(film: Film, results: Results, seconds: float) -> None:
    """Write the files and say what they are."""
    from alight.cli.summary import statistics_of, summary_lines, warnings_of, write_json

    denoiser = write_outputs(film, results)
    error = film.relmse_estimate(literature=results.stats is not None)
    told = results.stats is not None or not results.quiet
    unsure = film.interval().unsure_share if told else 0.0
    found = warnings_of(film)
    for warning in found:
        warn(warning)
    if results.stats is not None:
        warnings = [*results.warnings, *found]
        statistics = statistics_of(film, error, unsure, results.outputs, warnings, denoiser)
        write_json(results.stats, statistics)
    if not results.quiet:
        for line in summary_lines(film, error, unsure, seconds, denoiser):
            typer.echo(line)
        if results.display.exposure == "auto" and any(map(_is_display, results.outputs)):
            typer.echo(f"exposure: {results.display.developed(film.image).exposure:+.2f} stops")
        for path in results.outputs:
            typer.echo(f"{_kind(path)}: {path}")
        if results.checkpoint is not None:
            typer.echo(f"checkpoint: {results.checkpoint}")


def write_outputs(film: Film, results: Results) -> list[Bias]:
    """Write the pictures, and the film where the suffix says so.

    Returns
    -------
    list of Bias
        What the pictures have in the ledger beyond the film: the denoiser.

    Raises
    ------
    OutputError
        If one cannot be written; the others before it are.
    """
    from alight.films.denoising import denoise
    from alight.films.storage import is_film_file, save_film
    from alight.outputs.image import write_image

    source, found = film, []
    if results.denoise and not all(is_film_file(path) for path in results.outputs):
        source, bias = denoise(film)
        found = [bias]
    for path in results.outputs:
        if is_film_file(path):
            save_film(path, film)
        else:
            write_image(path, source, **asdict(results.display))
    return found


def _kind(path: Path) -> str:
    from alight.films.storage import is_film_file

    return "film" if is_film_file(path) else "picture"


def _is_display(path: Path) -> bool:
    from alight.films.storage import is_film_file
    from alight.outputs.image import format_of

    return not is_film_file(path) and format_of(path).IS_DISPLAY


def _rescue(film: Film, results: Results) -> str:
    """Say where the samples of a picture are that cannot be written; put them there if need be."""
    if results.checkpoint is not None and not _failure(film):
        again = _command(
            "resume", results.checkpoint, "-o", f"ELSEWHERE{results.outputs[0].suffix}"
        )
        return f"nothing is lost, all samples are in {results.checkpoint}; to write them: {again}"
    path = Path(tempfile.gettempdir()) / f"alight-{os.getpid()}.alight"
    try:
        film.save(path)
    except OutputError as error:
        return f"the samples could not be kept either: {error}"
    again = _command("merge", path, "-o", f"ELSEWHERE{results.outputs[0].suffix}")
    return f"nothing is lost, all samples are in {path}; to write them: {again}"


def _failure(film: Film) -> str | None:
    return film.stats.get("checkpoint", {}).get("failure")


def _command(name: str, *arguments: object) -> str:
    return " ".join(["alight", name, *(shlex.quote(str(argument)) for argument in arguments)])
