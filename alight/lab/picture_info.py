"""What a film or a picture holds, as (name, text)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from alight.films import Film
from alight.films.storage import is_film_file
from alight.outputs import exr
from alight.outputs.image import FORMATS, format_of, read_image
from alight.rendering.summary import unsure_lines

Facts = list[tuple[str, str]]

#: What is shown of a picture's origin, where it is known.
_ORIGIN = ("error", "version", "seed", "replicates", "scene_hash", "fingerprint", "biases")


def is_film_or_picture(name: object) -> bool:
    """Whether a name is that of a film, or of a picture of a format that alight reads."""
    if not isinstance(name, str | Path):
        return False
    suffixes = {suffix for module in FORMATS for suffix in module.SUFFIXES}
    return is_film_file(name) or Path(name).suffix.lower() in suffixes


def picture_facts(path: str | Path) -> tuple[Facts, list[str]]:
    """Say what a film or a picture holds, and what is suspicious of it.

    Raises
    ------
    AlightError
        If it is missing, broken or of an unknown format.
    """
    path = Path(path)
    if not is_film_file(path):
        return _image_facts(path), []
    film = Film.load(path)
    return _film_facts(film), film.warnings


def _film_facts(film: Film) -> Facts:
    x, y, width, height = film.crop
    whole = (film.width, film.height)
    crop = f", at {x},{y} of {whole[0]}x{whole[1]}" if (width, height) != whole else ""
    counts = film.sample_count
    least, most = int(counts.min()), int(counts.max())
    spread = f" ({least} to {most} a pixel)" if least < most else ""
    estimate, unsure = film.judged()
    return [
        ("film", f"{width}x{height} pixels{crop}"),
        ("samples", f"{film.spp:g} spp{spread}"),
        ("layers", ", ".join(film.aov_channels) or "none"),
        *_range_of(film.mean),
        ("error", estimate.line),
        *(("", line) for line in unsure_lines(float(unsure.mean()))),
        *_origin(film.provenance),
    ]


def _image_facts(path: Path) -> Facts:
    image = read_image(path)
    height, width = image.shape[:2]
    found = [("picture", f"{width}x{height} pixels, {path.suffix[1:].upper()}")]
    if format_of(path) is not exr:
        return [*found, *_range_of(image)]
    channels, attributes = exr.read_layers(path)
    layers = sorted({name.rpartition(".")[0] or name for name in channels if name not in "RGBAY"})
    return [
        *found, ("layers", ", ".join(layers) or "none"), *_range_of(image), *_origin(attributes)
    ]  # fmt: skip


def _range_of(image: np.ndarray) -> Facts:
    finite = np.isfinite(image)
    values = image[finite]
    if not values.size:
        return [("values", "none is finite")]
    wrong = int(finite.size - values.size)
    tail = f", {wrong} not finite" if wrong else ""
    return [("values", f"{values.min():.4g} to {values.max():.4g}, mean {values.mean():.4g}{tail}")]


def _origin(known: Mapping[str, Any]) -> Iterable[tuple[str, str]]:
    for name in _ORIGIN:
        if known.get(name) not in (None, ""):
            yield name.replace("_", " "), str(known[name])
