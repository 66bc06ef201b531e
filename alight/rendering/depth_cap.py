r"""How much light a depth cap cuts off, from a small pilot that follows the same paths further.

Random numbers belong to (pixel, sample, dimension). So a path under a cap is the beginning of the
same path under none, and what the cap cuts off is the difference of two renders of the same
samples, pixel by pixel, without the noise of what they share. The cap is a number that kernels are
given, so both are the machine code of the picture, which itself does not change.

Roulette ends the longer paths, and the difference is then all that is missing. Without roulette
paths are followed for twice `_FURTHER` edges, and the rest is the geometric series that their two
halves begin:

.. math:: A + B + \frac{B q}{1 - q}, \qquad q = B / A

Where light is found by chance alone (a random walk, BSDF sampling, a lamp behind clear glass), the
pilot takes more samples, and may still have missed what is rare and bright. An event that none of
its N samples met has a probability below 3 / N with 95 % confidence; as bright as the brightest
sample, that is added to the standard error. So is the root of the mean square of what N samples
miss of light behind glass (`alight.rendering.light_behind_glass`).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from alight.films import CELL_SIZE
from alight.films.fixed_point import to_float
from alight.films.ledger import Bias
from alight.films.sample_ranges import cells_of
from alight.integrators.walk import UNLIMITED
from alight.rendering.pilot_rays import POINTS
from alight.rendering.tiles.tile import Scratch, render_tile
from alight.rendering.tiles.tile_kernel import Tile

if TYPE_CHECKING:
    from alight.core.spec import Integrator
    from alight.rendering.job import Job

#: Pixels per sample of the pilot, and the least and most samples. They depend on the
#: picture's size alone: parts of a render, and their sum, say the same.
_PIXELS, _LEAST, _MOST = 8, 2048, 2**16

#: So many times more where light is found by chance alone.
_BY_CHANCE = 8

#: Cells of a pilot, whatever their samples: how much they differ is what it knows of its error.
_FEWEST_CELLS = 8

#: How often light behind glass is to be met, in the mean, and the most samples for that.
_OFTEN, _MOST_FOR_GLASS = 100, 2**17

#: Extra edges along which paths without roulette are followed, twice.
_FURTHER = 8


#: Standard deviations that correspond to the rule of three (95 %).
_RULE_OF_THREE = 3.0 / 1.96


class Lost(NamedTuple):
    """Radiance beyond a cap, mean over the picture; infinite where the series does not end."""

    radiance: float
    error: float


def cap_of(integrator: Integrator) -> int | None:
    """The longest path of an integrator, in edges; None where it has no limit."""
    return dict(integrator).get("max_depth")


def unmeasured(integrator: Integrator) -> tuple[Bias, ...]:
    """The entry of a cap before its effect is known."""
    cap = cap_of(integrator)
    return () if cap is None else (Bias("depth cap", _text(cap)),)


def measured(job: Job, seed: int) -> tuple[Bias, ...]:
    """The entry of a job's cap, from a pilot of its own seed."""
    cap = cap_of(job.scene.integrator)
    if cap is None:
        return ()
    lost = light_beyond(job, cap, seed)
    if not math.isfinite(lost.radiance):
        return (Bias("depth cap", f"{_text(cap)}; what it cuts off could not be measured"),)
    return (Bias("depth cap", _text(cap), 0.0 - lost.radiance, lost.error),)


def _text(cap: int) -> str:
    return f"paths end at depth {cap}"


def light_beyond(job: Job, cap: int, seed: int) -> Lost:
    """Measure the radiance of longer paths in a few cells of the picture, drawn at random."""
    tiles, spp = _some_cells(job, seed)
    if dict(job.scene.integrator).get("russian_roulette") == "throughput":
        caps = (cap, UNLIMITED)
    else:
        caps = (cap, cap + _FURTHER, cap + 2 * _FURTHER)
    scratch, brightest = Scratch(), 0.0
    pixels = np.array([(tile.x1 - tile.x0) * (tile.y1 - tile.y0) for tile in tiles], np.float64)
    one, replicates = len(tiles) == 1, job.rounds[0].replicates
    if one:
        # A single cell, the whole picture, is no spread: its replicates, pixel by pixel, are.
        pixels = np.full(int(pixels[0]) * replicates, 1.0 / replicates)
    sums, ranges = np.zeros((len(pixels), len(caps))), np.array([[[0, spp]]])
    # Settings that are given again, as the same object, are not taken apart again.
    for j, limit in enumerate(caps):
        settings = job.settings._replace(seed=seed, max_depth=limit)
        for i, tile in enumerate(tiles):
            part, _ = render_tile(job.kernels, job.scene, settings, tile, ranges, scratch)
            # A replicate of a pixel has one sample, but for the most in small pictures.
            samples = to_float(part.sums[..., :3, :]).mean(axis=3)
            brightest = max(brightest, float(samples.max()))
            sums[slice(None) if one else i, j] = (samples.ravel() if one else samples.sum()) / spp
    found = sums[:, 1:] - sums[:, :-1]
    total, slope = _series(found.sum(axis=0))
    radiance = total / pixels.sum()
    if not math.isfinite(radiance):
        return Lost(math.inf, math.inf)
    # A ratio of sums over cells that are independent of each other.
    residual = found @ slope - radiance * pixels
    spread = float((residual**2).sum()) * len(pixels) / max(len(pixels) - 1, 1)
    error = math.sqrt(spread) / float(pixels.sum())
    if job.scene.integrator.finds_light_by_chance or job.rare_light.behind_glass is not None:
        error = math.hypot(error, _RULE_OF_THREE * brightest / (spp * float(pixels.sum())))
    return Lost(float(radiance), math.hypot(error, _unmet(job, spp * float(pixels.sum()))))


def _enough(behind: np.ndarray) -> int:
    """Samples that meet nine tenths of the light behind glass often enough."""
    order = np.argsort(-behind[:, 5])
    light = np.cumsum(behind[order, 2:5].sum(axis=1))
    rare = behind[order, 5][np.searchsorted(light, 0.9 * light[-1])]
    return min(math.ceil(_OFTEN / max(rare, 1e-300)), _MOST_FOR_GLASS) if rare > 0.0 else _MOST


def _unmet(job: Job, samples: float) -> float:
    """Light behind glass that so many samples miss, mean radiance: the root of the mean square."""
    if job.rare_light.behind_glass is None:
        return 0.0
    light, found = job.rare_light.behind_glass[:, 2:5], samples * job.rare_light.behind_glass[:, 5]
    # They miss such light as a whole, with probability e^-f, or have met it.
    return float((light.mean(axis=1) * np.exp(-0.5 * found)).sum()) / POINTS


def _series(found: np.ndarray) -> tuple[float, np.ndarray]:
    """The sum of the series that begins so, and its derivative by what was found."""
    if len(found) == 1 or not found.any():
        return float(found.sum()), np.ones(len(found))
    a, b = found
    if not 0.0 <= b < a:
        return math.inf, np.ones(2)
    return float(a + a * b / (a - b)), np.array([1.0 - (b / (a - b)) ** 2, (a / (a - b)) ** 2])


def _some_cells(job: Job, seed: int) -> tuple[list[Tile], int]:
    """Cells of the picture's window, all equally likely, as tiles of their own; and their spp."""
    film = job.rounds[0]
    x, y, w, h = film.crop
    samples = min(max(w * h // _PIXELS, _LEAST), _MOST)
    if job.scene.integrator.finds_light_by_chance:
        samples *= _BY_CHANCE
    if job.rare_light.behind_glass is not None:
        samples = max(samples, _enough(job.rare_light.behind_glass))
    rows, columns = cells_of(*film.crop)
    down, across = rows.stop - rows.start, columns.stop - columns.start
    count = max(math.ceil(samples / (CELL_SIZE**2 * film.replicates)), _FEWEST_CELLS)
    more = math.ceil(count / (down * across)) if job.rare_light.behind_glass is not None else 1
    count = min(count, down * across)
    chosen = np.random.default_rng(seed).permutation(down * across)[:count]
    tiles = []
    for cell in sorted(chosen.tolist()):
        left = (columns.start + cell % across) * CELL_SIZE
        top = (rows.start + cell // across) * CELL_SIZE
        right, bottom = min(left + CELL_SIZE, x + w), min(top + CELL_SIZE, y + h)
        tiles.append(Tile(max(left, x), max(top, y), right, bottom))
    return tiles, more * film.replicates
