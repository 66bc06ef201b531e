"""What a film says of its sums: means, errors, intervals, masks, ranks, ranges, archives."""

import tempfile
from dataclasses import asdict
from functools import cache
from pathlib import Path

import numpy as np

from alight.compiled.scene import compile_scene
from alight.films import Film, fixed_point, ledger, mattes, sample_ranges, statistics
from alight.films.sample_ranges import SampleRanges
from alight.formats import loads
from alight.integrators.walk import make_settings
from alight.rendering.layers import AOVS
from alight.rendering.tiles.tile import make_kernels, render_tile
from alight.rendering.tiles.tile_kernel import Tile
from alight.scene import flatten
from tests.recorded.cases.trees import ends_of
from tests.recorded.cases.zoo_shapes import COPIES, ROUND, TOOL
from tests.recorded.zoo import SEED, STAGE, scene

LAYERS = ("direct", "indirect", "normal", "depth", "id", "alpha", *mattes.MATTES)
SPP = 8


def film_of_part(first: int) -> Film:
    """A film of some samples of a crop whose cells are cut by its edges."""
    text = scene(
        STAGE + ROUND + COPIES, prototypes=TOOL,
        film="{size: [31, 23], crop: [9, 5, 11, 8], filter: {type: mitchell}, replicates: 4}",
        integrator="{type: path, max_depth: 4, hide_emitters: true}",
    )  # fmt: skip
    compiled = compile_scene(flatten(loads(text, "zoo.yaml")), structure="list", aovs=LAYERS)
    x, y, width, height = compiled.crop
    film = Film(
        *compiled.size, crop=compiled.crop, replicates=4, scene_hash="zoo", seed=SEED,
        aovs={name: AOVS[name] for name in LAYERS}, surfaces=compiled.surfaces.names,
    )  # fmt: skip
    values = make_settings(compiled.integrator, seed=SEED, replicates=4)
    kernels = make_kernels(compiled, compiled=False)
    rows, columns = sample_ranges.cells_of(x, y, width, height)
    cells = (rows.stop - rows.start, columns.stop - columns.start, 1)
    ranges = np.tile(np.array([first, SPP], np.int64), cells)
    tile = Tile(x, y, x + width, y + height)
    film.add_tile(render_tile(kernels, compiled, values, tile, ranges)[0])
    return film


@cache
def both() -> tuple[Film, Film]:
    """Two parts of the samples."""
    return film_of_part(0), film_of_part(SPP)


def read(film: Film) -> dict[str, object]:
    """Everything that a film answers."""
    bars = film.interval(0.9)
    means, counts = film.replicate_means()
    estimate = film.error
    return {
        "mean": film.mean, "error": film.standard_error, "image": ends_of(film.image),
        "low": ends_of(bars.low), "high": ends_of(bars.high), "unsure": film.unsure.sum(),
        "counts": ends_of(film.sample_count), "spp": film.spp, "means": ends_of(means),
        "counts of replicates": ends_of(counts), "relmse": asdict(estimate),
        "cells": [str(cell) for cell in film.cells.ravel()],
        **{name: ends_of(film.aov(name)) for name in ("direct", "normal", "depth", "id", "alpha")},
    }  # fmt: skip


def one() -> dict[str, object]:
    """A film of one part."""
    return read(both()[0])


def merged() -> dict[str, object]:
    """Both parts."""
    return read(Film.merge(*both()))


def masked() -> dict[str, object]:
    """Mattes: masks, ranks and colours."""
    film = both()[0]
    ids, weights = mattes.ranks_of(film, "cryptomatte_object")
    return {
        "ball": film.mask("ball"),
        "group": film.mask("group"),
        "ranks": [ends_of(ids), ends_of(weights)],
        "colors": ends_of(film.aov("cryptomatte_material")),
        "header": {key: value[:400] for key, value in mattes.header_of(film).items()},
        "planes": {name: ends_of(plane) for name, plane in mattes.planes_of(film).items()},
    }


def ranged() -> dict[str, object]:
    """Sets of samples."""
    one, other = SampleRanges([(0, 4), (7, 9), (4, 6)]), SampleRanges([(5, 8), (20, 22)])
    wide = SampleRanges([(9, 11), (30, 35), (12, 13)])
    return {
        "texts": [str(part) for part in (one, other, one.overlap(other), one.union(wide), wide)],
        "counts": [one.count, one.union(wide).count],
        "cells": [str(sample_ranges.cells_of(x, y, w, h))
                  for x, y, w, h in ((0, 0, 8, 8), (7, 9, 2, 30), (3, 5, 13, 1))],
    }  # fmt: skip


def summed() -> dict[str, object]:
    """Sums in two limbs, their statistics, and what is said of samples that did not count."""
    random = np.random.default_rng(4)
    values = (random.random((3, 4, 5, 3)).astype(np.float32) ** 4) * 1e4
    limbs = fixed_point.to_limbs(values)[0]
    counts = random.integers(0, 4, (3, 4, 5))
    fixed_point.carry(limbs)
    mean, error = statistics.mean_and_error(limbs, counts)
    biases = ledger.counted(3, 2, 700)
    other = ledger.Bias("clamp", "said", 0.25, 0.125)
    return {
        "limbs": ends_of(limbs), "floats": ends_of(fixed_point.to_float(limbs)),
        "mean": mean, "error": error, "pixels": statistics.pixel_mean(limbs, counts),
        "biases": [bias.state() | {"line": bias.line} for bias in (*biases, other)],
        "joined": [bias.line for bias in ledger.joined([biases, [other], biases])],
    }  # fmt: skip


def kept() -> dict[str, object]:
    """A film that was written and read."""
    with tempfile.TemporaryDirectory() as folder:
        path = Film.merge(*both()).save(Path(folder) / "film.alight")
        film = Film.load(path)
    return {"options": film.options, "seed": film.seed, "mean": ends_of(film.mean),
            "group": film.mask("group"), "error": ends_of(film.standard_error)}  # fmt: skip


CASES = {
    "one": one, "merged": merged, "masks": masked, "ranges": ranged, "sums": summed, "kept": kept,
}  # fmt: skip
