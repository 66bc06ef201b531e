"""One scene of a contact sheet: its picture, or why there is none."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from alight.core.errors import AlightError
from alight.films import Film
from alight.formats import load
from alight.outputs.display import Display
from alight.rendering import render
from alight.scene import Scene

#: Relative errors above this are no figures: a few pixels decide on all of the picture.
_LARGEST = 10.0


@dataclass(frozen=True)
class Tile:
    """What the sheet shows of a scene.

    Parameters
    ----------
    name : str
        Folder and name of the file.
    kind : str
        Format, by the ending of the file's name; "built in" without one.
    pixels : (h, w, 3) uint8 or None
        The picture, encoded for a display.
    message : str
        Why there is no picture.
    spp : float
        Samples per pixel.
    seconds : float
        Of rendering alone.
    all_seconds : float
        Of loading, compiling and rendering.
    error : float
        Estimated relRMSE; NaN where it is unknown.
    approximated, dropped : tuple of str
        Remarks of the reader, as ``alight info`` gives them.
    """

    name: str
    kind: str
    pixels: np.ndarray | None = None
    message: str = ""
    spp: float = 0.0
    seconds: float = 0.0
    all_seconds: float = 0.0
    error: float = math.nan
    approximated: tuple[str, ...] = ()
    dropped: tuple[str, ...] = ()

    @property
    def facts(self) -> list[str]:
        """Two short lines: samples, time and error; remarks."""
        error = f"± {100.0 * self.error:.2g} %"
        if not self.error <= _LARGEST:
            error = (
                "error unknown" if math.isnan(self.error) else f"± over {100.0 * _LARGEST:.0f} %"
            )
        remarks = [
            f"{len(found)} {word}"
            for found, word in ((self.approximated, "approximated"), (self.dropped, "dropped"))
            if found
        ]
        first = f"{self.spp:.3g} spp, {self.seconds:.3g} s, {error}"
        return [first, ", ".join(remarks) or "read as it is"]


def render_tile(
    scene: str,
    size: tuple[int, int],
    *,
    spp: int = 64,
    time_limit: float | None = None,
    threads: int | None = None,
    lenient: bool = False,
    root: Path | None = None,
    display: Display | None = None,
) -> Tile:
    """Render a scene as large as fits into a tile; what is wrong with it becomes the message.

    Parameters
    ----------
    scene : str
        File, or name of a built-in scene.
    size : (int, int)
        Width and height of the tile, pixels.
    spp, time_limit, threads
        See `alight.render`.
    lenient, root
        See `alight.load`.
    display : Display, optional
    """
    begin = time.perf_counter()
    path = Path(scene)
    name = f"{path.parent.name}/{path.stem}".lstrip("/")
    kind = path.suffix.lstrip(".").lower() or "built in"
    try:
        loaded = load(scene, lenient=lenient, root=root)
        width, height = fitted(loaded.film.size, size)
        # Loaded again, so that an automatic camera is placed for this picture.
        changes = ["film.crop=null", f"film.size=[{width}, {height}]"]
        loaded = load(scene, changes, lenient=lenient, root=root)
        film = render(loaded, spp=spp, time_limit=time_limit, threads=threads)
    except (AlightError, OSError, MemoryError) as error:
        text = str(error) or type(error).__name__
        return Tile(name, kind, message=text, all_seconds=time.perf_counter() - begin)
    shown = (display or Display()).apply(film.image)
    remarks = loaded.source.remarks
    return Tile(
        name,
        kind,
        np.rint(shown * 255.0).astype(np.uint8),
        spp=film.spp,
        seconds=film.stats["seconds"]["render"],
        all_seconds=time.perf_counter() - begin,
        error=film.relmse_estimate().relrmse.value,
        approximated=_approximated(loaded, film),
        dropped=remarks.notes,
    )


def fitted(size: tuple[int, int], tile: tuple[int, int]) -> tuple[int, int]:
    """Largest size of the same shape that fits into a tile.

    Examples
    --------
    >>> fitted((1920, 1080), (256, 192)), fitted((10, 20), (256, 192))
    ((256, 144), (96, 192))
    """
    scale = min(tile[0] / size[0], tile[1] / size[1])
    width, height = (max(1, round(scale * length)) for length in size)
    return width, height


def _approximated(scene: Scene, film: Film) -> tuple[str, ...]:
    """Remarks of the reader, and warnings of the scene and its render, each once."""
    return tuple(dict.fromkeys([*scene.source.remarks.warnings, *film.warnings]))
