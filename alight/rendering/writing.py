"""The files that a render ends with, and that no sample is lost when one cannot be written."""

from __future__ import annotations

import os
import shlex
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from alight.core.errors import OutputError
from alight.films import Film
from alight.films.denoising import check_denoiser, denoise
from alight.films.ledger import Bias
from alight.films.storage import is_film_file, save_film
from alight.outputs import png
from alight.outputs.atomic import check_folder
from alight.outputs.display import Display
from alight.outputs.image import check_writable, format_of, write_image
from alight.rendering.summary import statistics_of, summary_lines, write_json

#: Share of the lit pixels that may clip to white or to black without a warning.
MOST_LOST = 0.5


@dataclass(frozen=True)
class Targets:
    """What is to be written when a render ends.

    Parameters
    ----------
    outputs : sequence of Path
        Pictures, and ``.alight`` files for the film itself.
    display : Display
        For display formats.
    denoise : bool, default False
        Whether the pictures, not the film, are denoised.
    stats : Path or None
        JSON file.
    checkpoint : Path or None
        File that the render can be resumed from.
    plugins : sequence of Path
        Scripts that registered models for it; who resumes it must give them again.
    """

    outputs: Sequence[Path]
    display: Display
    denoise: bool = False
    stats: Path | None = None
    checkpoint: Path | None = None
    plugins: Sequence[Path] = ()

    def check(self) -> None:
        """Refuse files that cannot be written, before any time is spent.

        Raises
        ------
        OutputError
        OptionError
            If there is no denoiser.
        """
        if self.denoise:
            check_denoiser()
        for path in self.outputs:
            (check_folder if is_film_file(path) else check_writable)(path)
        if self.stats is not None:
            check_folder(self.stats)

    def useless(self, layers: Sequence[str], alpha: bool) -> list[tuple[str, tuple[str, ...]]]:
        """Say which options have no effect on any of the files: the problem, and their names.

        Parameters
        ----------
        layers : sequence of str
            Requested ones.
        alpha : bool
            Whether the background is not the scene's.
        """
        pictures = [path for path in self.outputs if not is_film_file(path)]
        formats = [format_of(path) for path in pictures]
        keeps_layers = len(pictures) < len(self.outputs) or any(m.KEEPS_LAYERS for m in formats)
        found = []
        shown = replace(self.display, dpi=None) != Display()
        if shown and not any(module.IS_DISPLAY for module in formats):
            names = ("exposure", "white_balance", "tone_map", "bits")
            text = (
                "{exposure}, {white_balance}, {tone_map} and {bits} change display formats "
                "(PNG, JPEG) only"
            )
            found.append((text, names))
        elif self.display.bits > 8 and png not in formats:
            found.append(("{bits}: only PNG has 16; add {output} FILE.png", ("bits", "output")))
        if self.denoise and not pictures:
            text = "{denoise}: a film keeps its samples as they are; add {output} FILE.exr"
            found.append((text, ("denoise", "output")))
        if self.display.dpi is not None and not any(module.KEEPS_DPI for module in formats):
            found.append(("{dpi}: only PNG, JPEG and EXR keep it", ("dpi",)))
        keeps_alpha = len(pictures) < len(self.outputs) or any(m.KEEPS_ALPHA for m in formats)
        if alpha and not keeps_alpha:
            found.append(("{background}: only EXR and PNG keep alpha; add {output} FILE.png",
                          ("background", "output")))  # fmt: skip
        if layers and not keeps_layers:
            found.append(("{aovs}: only EXR keeps layers; add {output} FILE.exr",
                          ("aovs", "output")))  # fmt: skip
        return found

    def notes(self) -> dict[str, Any]:
        """What a checkpoint keeps of this; it may be resumed from another folder."""
        return {
            "outputs": [str(path.absolute()) for path in self.outputs],
            "plugins": [str(path.absolute()) for path in self.plugins],
            "display": asdict(self.display),
            "denoise": self.denoise,
        }

    @classmethod
    def noted(cls, notes: Mapping[str, Any]) -> Targets:
        """From what `notes` gave; a checkpoint need not say anything."""
        outputs = [Path(path) for path in notes.get("outputs", ())]
        display = Display(**dict(notes.get("display", {})))
        plugins = [Path(path) for path in notes.get("plugins", ())]
        return cls(outputs, display, bool(notes.get("denoise", False)), plugins=plugins)

    def resuming(self, *words: object) -> str:
        """The command line that goes on from the checkpoint."""
        plugins = (word for path in self.plugins for word in ("--plugin", path))
        return command("resume", self.checkpoint, *words, *plugins)


@dataclass(frozen=True)
class Outcome:
    """A render that has ended, and whose files are written.

    Attributes
    ----------
    film : Film
    targets : Targets
    seconds : float
        From the first to the last.
    denoiser : list of Bias
        What the pictures have in the ledger beyond the film.
    """

    film: Film
    targets: Targets
    seconds: float
    denoiser: list[Bias] = field(default_factory=list)

    def __str__(self) -> str:
        """What the command line ends with."""
        film, targets = self.film, self.targets
        error, unsure = film.judged(literature=False)
        lines = summary_lines(film, error, float(unsure.mean()), self.seconds, self.denoiser)
        if targets.display.exposure == "auto" and any(map(_is_display, targets.outputs)):
            lines.append(f"exposure: {targets.display.developed(film.image).exposure:+.2f} stops")
        elif any(map(_is_display, targets.outputs)):
            lines += exposure_advice(targets.display, film.image)
        lines += [f"{_kind(path)}: {path}" for path in targets.outputs]
        if targets.checkpoint is not None:
            lines.append(f"checkpoint: {targets.checkpoint}")
        return "\n".join(lines)


def exposure_advice(display: Display, linear: np.ndarray) -> list[str]:
    """One line where a picture shows nothing of most of what it holds, and what would show it.

    That is so if more than half of the pixels with light are cut at white, or are shown as black.

    Parameters
    ----------
    display : Display
        Of a fixed exposure.
    linear : ndarray, shape (h, w, 3)
    """
    shown = display.apply(linear)[(np.nan_to_num(linear) > 0.0).any(axis=2)]
    step = 0.5 / 255.0
    found = {"cut at white": shown >= 1.0 - step, "too dark to be seen": shown < step}
    for what, lost in found.items():
        share = float(lost.all(axis=1).mean()) if len(shown) else 0.0
        if share > MOST_LOST:
            stops = replace(display, exposure="auto").developed(linear).exposure
            advice = f"--exposure auto shows it ({stops:+.1f} stops)"
            return [f"exposure: {100.0 * share:.0f} % of what has light is {what}; {advice}"]
    return []


def finish(film: Film, targets: Targets, begin: float, told: Sequence[str] = ()) -> Outcome:
    """Write everything; what cannot be written is rescued to a place that the error names.

    Parameters
    ----------
    film : Film
    targets : Targets
    begin : float, seconds
        When the render began, by `time.perf_counter`.
    told : sequence of str, optional
        Warnings that the film does not know, for ``stats``.

    Raises
    ------
    OutputError
        If a file cannot be written; it says where the samples are.
    """
    try:
        if targets.stats is not None:
            # Before pictures need one half of it.
            film.judged()
        denoiser = write_outputs(film, targets)
        seconds = time.perf_counter() - begin
        if targets.stats is not None:
            outputs = list(targets.outputs)
            found = list(dict.fromkeys([*told, *film.warnings]))
            error, unsure = film.judged()
            share = float(unsure.mean())
            statistics = statistics_of(film, error, share, outputs, found, denoiser)
            write_json(targets.stats, statistics)
    except OutputError as error:
        raise OutputError(f"{error}\n{_rescue(film, targets)}") from error
    return Outcome(film, targets, seconds, denoiser)


def write_outputs(film: Film, targets: Targets) -> list[Bias]:
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
    source, found = film, []
    if targets.denoise and not all(is_film_file(path) for path in targets.outputs):
        source, bias = denoise(film)
        found = [bias]
    for path in targets.outputs:
        if is_film_file(path):
            save_film(path, film)
        else:
            write_image(path, source, **asdict(targets.display))
    return found


def _kind(path: Path) -> str:
    return "film" if is_film_file(path) else "picture"


def _is_display(path: Path) -> bool:
    return not is_film_file(path) and format_of(path).IS_DISPLAY


def _rescue(film: Film, targets: Targets) -> str:
    """Say where the samples of a picture are that cannot be written; put them there if need be."""
    elsewhere = f"ELSEWHERE{targets.outputs[0].suffix}" if targets.outputs else "ELSEWHERE.exr"
    if targets.checkpoint is not None and not _failure(film):
        again = targets.resuming("-o", elsewhere)
        return f"nothing is lost, all samples are in {targets.checkpoint}; to write them: {again}"
    path = Path(tempfile.gettempdir()) / f"alight-{os.getpid()}.alight"
    try:
        film.save(path)
    except OutputError as error:
        return f"the samples could not be kept either: {error}"
    again = command("merge", path, "-o", elsewhere)
    return f"nothing is lost, all samples are in {path}; to write them: {again}"


def _failure(film: Film) -> str | None:
    return film.stats.get("checkpoint", {}).get("failure")


def command(name: str, *arguments: object) -> str:
    """Write a command line that can be copied."""
    return " ".join(["alight", name, *(shlex.quote(str(argument)) for argument in arguments)])
