"""Laws of a scene's random numbers: they are uniform, and none is used for two purposes.

The second one and the length of paths are looked at from inside: a few samples of the scene run in
plain Python while somebody looks on.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from alight.compiled.scene import CompiledScene
from alight.core.spec import Sampler
from alight.integrators.contributions import FIELDS, HALF, Log
from alight.integrators.walk import CAMERA_DIMENSIONS, make_settings
from alight.laws.samplers import FAR, sequence, twin, u32
from alight.laws.scene.findings import Finding
from alight.laws.statistics import chi_square_tail, uniform_p_value
from alight.rendering.tiles.tile import Scratch
from alight.rendering.tiles.tile_kernel import Tile
from alight.rendering.tiles.tile_loop import render_tile_kernel
from alight.rendering.tracing.contribution_recorder import recorded_tables, recording_program
from alight.samplers.sampling import get_1d, get_2d, sampler_state
from lanewise.jit import instantiate
from lanewise.simd import LANES
from lanewise.view import View

#: Pixels (side) and depth of the paths that are looked at in plain Python.
SIDE, DEPTH = 4, 4
#: A list of more primitives takes too long in plain Python.
MOST_PRIMITIVES = 2000

#: Pixels that a number is looked at in, and dimensions of the camera, of some vertices and beyond.
_N = 1 << 14
_DIMENSIONS = (0, 9, 11, 12, 14, 27, FAR)


def check_numbers(spec: Sampler, seed: int) -> Iterator[Finding]:
    """Judge the sampler that the scene uses, in the dimensions of a few vertices."""
    part, pixel, good = f"sampler {spec.type_name()}", u32(np.arange(_N)), True
    pairs, singles = [], []
    for dimension in _DIMENSIONS:
        state = sampler_state(pixel & u32(127), pixel >> u32(7), u32(np.full(_N, 3)), 1, seed)
        x, y = twin(spec)(state, dimension)
        single = twin(spec, False)(state, dimension)
        good &= all(bool(((u >= 0.0) & (u < 1.0)).all()) for u in (x, y, single))
        counts = np.histogram2d(x, y, bins=16, range=[[0, 1], [0, 1]])[0]
        expected = _N / counts.size
        statistic = float(((counts - expected) ** 2 / expected).sum())
        pairs.append(chi_square_tail(statistic, counts.size - 1))
        singles.append(uniform_p_value(single, 256))
    for what, p_values in (("pairs", pairs), ("numbers", singles)):
        # One line for all dimensions: the smallest p-value of all.
        p = min(1.0, len(p_values) * min(p_values))
        yield Finding(part, f"{what} are uniform over the pixels (chi-square)", p=p)
    repeated = np.unique(twin(spec, False)(sequence(256, seed=seed), 10)).size < 250
    yield Finding(part, "numbers lie in [0, 1) and do not repeat", holds=good and not repeated)


def check_paths(scene: CompiledScene, seed: int) -> Iterator[Finding]:
    """Judge how paths use random numbers, and how long they are.

    Parameters
    ----------
    scene : CompiledScene
        With the structure "list", and an integrator that records.
    seed : int
    """
    laws = (
        "no random number is used for two purposes",
        "paths are as long as max_depth allows, and no longer",
    )
    stats = scene.stats
    if stats["listed"] > MOST_PRIMITIVES:
        for law in laws:
            detail = f"{stats['listed']} primitives: too many for plain Python"
            yield Finding("paths", law, detail=detail)
        return
    reads: dict[tuple[int, ...], int] = {}
    _followed(scene, seed, DEPTH, _watching(reads))
    again = sorted({key[-1] for key, count in reads.items() if count > 1})
    detail = f"dimensions that are read again: {', '.join(map(str, again[:6]))}" if again else ""
    yield Finding("paths", laws[0], holds=not again, detail=detail)
    longest = {cap: int(_followed(scene, seed, cap).max(initial=0)) for cap in (1, 2, 3)}
    # What is longer than the cap is wrong; what is shorter may be for want of light.
    wrong = [f"{found} edges with max_depth {cap}" for cap, found in longest.items() if found > cap]
    reached = int(_followed(scene, seed, DEPTH).max(initial=0))
    if reached == DEPTH:
        wrong += [
            f"only {found} edges with max_depth {cap}"
            for cap, found in longest.items()
            if cap > 1 and found < cap
        ]
    yield Finding("paths", laws[1], holds=not wrong, detail="; ".join(wrong))


def _followed(
    scene: CompiledScene, seed: int, max_depth: int, observe: Callable | None = None
) -> np.ndarray:
    """Depths of all contributions to a few pixels in the middle of the picture."""
    kernel = instantiate(
        render_tile_kernel, recording_program(scene.program), compiled=False, observe=observe
    )
    width, height = scene.size
    # Pixels far apart, each a tile of its own; as many samples as lanes, so that none lies idle.
    depths = []
    settings = make_settings(scene.integrator, seed=seed, replicates=1)
    settings = settings._replace(max_depth=max_depth, rr_depth=2)
    for j in range(SIDE):
        y = (2 * j + 1) * height // (2 * SIDE)
        row = [(2 * i + 1) * width // (2 * SIDE) for i in range(SIDE)]
        for x in dict.fromkeys(row):
            tile = Tile(x, y, x + 1, y + 1)
            log = Log(
                View(np.zeros((64 * max_depth, FIELDS), np.uint32)),
                View(np.zeros((64 * max_depth, 3), np.float32)),
                View(np.zeros(1, np.int64)),
                View(np.zeros(int(LANES), np.uint32)),
                View(np.array([x, y, 1, int(LANES), 1], np.uint32)),
            )
            film = Scratch().film(settings, tile, False)
            ranges = View(np.array([[[0, int(LANES)]]], np.int64))
            with np.errstate(all="ignore"):
                kernel(recorded_tables(scene, log), settings, tile, ranges, film)
            words = log.words.shaped[: int(log.count.array[0])]
            depths.append(words[:, 1].astype(np.int64) & ((1 << HALF) - 1))
    return np.concatenate(depths)


def _watching(reads: dict[tuple[int, ...], int]) -> Callable[[Any, Callable], Callable]:
    """What notes every random number behind the camera that a kernel asks for.

    Light sampling's own repetition of the light's choice, for the log, is not one.
    """

    def observe(node: Any, made: Callable) -> Callable:
        if node is not get_1d and node is not get_2d:
            return made
        width = 2 if node is get_2d else 1

        def get(state, dimension):
            caller = sys._getframe(1)
            if caller.f_globals.get("__name__") != "alight.integrators.contributions":
                arrays = np.broadcast_arrays(*state[:4], dimension)
                for *sample, first in zip(*(a.ravel().tolist() for a in arrays), strict=True):
                    for k in range(max(first, CAMERA_DIMENSIONS), first + width):
                        reads[*sample, k] = reads.get((*sample, k), 0) + 1
            return made(state, dimension)

        return get

    return observe
