"""The picture that is made of a film: image, channels of its layers, and where it comes from."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from alight.films import mattes, readout
from alight.outputs.picture import Picture

if TYPE_CHECKING:
    from alight.films.film import Film


def picture_of(film: Film, layers: bool) -> Picture:
    """Image, layers (unless they are not wanted) and provenance."""
    # Tiles wait for the few milliseconds that this takes: a copy of the film would be its largest
    # use of memory.
    with film.lock:
        attributes = {key: str(value) for key, value in film.provenance.items()}
        planes: dict[str, np.ndarray] = {}
        header: dict[str, str] = {}
        if layers:
            # First, as it finds the unsure pixels along the way.
            attributes["error"] = film.judged(literature=False)[0].line
            error = film.standard_error
            planes |= {f"standard_error.{c}": error[..., i] for i, c in enumerate("RGB")}
            planes["unsure"] = film.unsure.astype(np.uint32)
            planes["samples"] = film.sample_count.astype(np.uint32)
            planes |= aov_planes(film) | mattes.planes_of(film)
            header = mattes.header_of(film)
        alpha, shadow = readout.cover_of(film)
        return Picture(
            film.image, planes, attributes, (film.width, film.height), film.crop[:2],
            alpha=alpha, shadow=shadow, header=header,
        )  # fmt: skip


def aov_planes(film: Film) -> dict[str, np.ndarray]:
    """The layers of a film by the full names of their channels, but for its alpha."""
    found: dict[str, np.ndarray] = {}
    for name in film.aov_sums:
        if name == "alpha" and film.alpha is not None:
            continue
        channels = film.aov_channels[name]
        plane = film.aov(name)
        found |= {f"{name}.{c}": plane[..., i] for i, c in enumerate(channels)}
    return found


def warnings_of(film: Film) -> list[str]:
    """What is suspicious of the scene, and what went wrong while rendering; see `alight.info`."""
    found = list(film.scene_warnings)
    if film.invalid:
        found.append(f"{film.invalid} samples were NaN or infinite and were added as black")
    if film.saturated:
        found.append(f"{film.saturated} sample values were cut to 2^36")
    return found


def line_of(film: Film) -> str:
    """Say size, samples and replicates, and that there are warnings."""
    _, _, w, h = film.crop
    count = len(film.warnings)
    told = f", {count} warning{'s' * (count > 1)}" if count else ""
    return f"<Film {w}x{h}, {film.spp:g} spp, {film.replicates} replicates{told}>"


def provenance_of(film: Film) -> dict[str, Any]:
    """What a film is a picture of, and how it was made."""
    return {
        "version": film.version,
        "scene_hash": film.scene_hash,
        "seed": film.seed,
        "spp": film.spp,
        "replicates": film.replicates,
        "size": (film.width, film.height),
        "crop": film.crop,
        "options": dict(film.options),
        "fingerprint": film.fingerprint,
        "invalid": film.invalid,
        "saturated": film.saturated,
        "biases": "; ".join(bias.line for bias in film.biases) or "none",
    }
