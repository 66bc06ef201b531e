"""Laws of a scene's picture: all ways of computing it have the same mean.

Small pictures with many independent seeds are compared block by block (`alight.metrics.comparison`
has the idea). BSDF sampling may find light in rare samples only; the spread of few of them would
say too little about those that did not come. So its variance is taken to be at least what a mean
of so much, made of the largest possible samples, would have: with values in [0, M] and mean m,
a sample has a variance of up to m M. Where light is found often, this changes little; where it is
found hardly ever, nothing is claimed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from alight.compiled.displacement import displaced
from alight.compiled.scene import CompiledScene, compile_scene
from alight.core.constants import LUMINANCE
from alight.core.registry import default_of, specs_of
from alight.core.spec import Integrator, Sampler, Texture
from alight.films import CELL_SIZE
from alight.films.fixed_point import carry, to_float
from alight.integrators.walk import make_settings
from alight.laws.scene.findings import Finding
from alight.laws.statistics import chi_square_tail
from alight.metrics.statistics import student_t_tail, t_to_z, welch
from alight.rendering.resources import usable_processors
from alight.rendering.tiles.division import tiles_of
from alight.rendering.tiles.tile import make_kernels, render_tile
from alight.rendering.tiles.tile_kernel import Tile
from alight.scene import Scene, flatten
from alight.scene.flatten import FlatScene
from alight.textures.images import Image

#: Pixels of the longer side, pixels of a block's side, independent seeds, samples of each seed.
SIZE, BLOCK, SEEDS, SPP = 48, 4, 32, 16
#: The longest paths that are compared, and where roulette begins.
MAX_DEPTH, RR_DEPTH = 6, 2
#: Rays of a brute-force picture times its triangles.
MOST_TESTS = 4e9


class Side(NamedTuple):
    """One way of computing the picture.

    Attributes
    ----------
    name : str
    pictures : (SEEDS, h, w, 3) float64
    largest : float
        Luminance of the largest sample that must be reckoned with; 0 where that does not matter.
    """

    name: str
    pictures: np.ndarray
    largest: float = 0.0


def small(scene: Scene, integrator: Integrator | None = None, size: int = SIZE) -> Scene:
    """The scene as a small picture with independent samples; whole blocks, no crop."""
    width, height = scene.film.size
    scale = size / max(width, height)
    shape = tuple(max(BLOCK, BLOCK * round(n * scale / BLOCK)) for n in (width, height))
    film = scene.film.replaced(size=shape, crop=None)
    integrator = integrator or scene.integrator
    # A copy made by hand: it must keep its folder.
    sampler = next(spec for spec in specs_of(Sampler).values() if spec.independent)()
    copy = scene.replaced(film=film, sampler=sampler, integrator=integrator)
    return copy.from_source(scene.source)


def integrator_of(scene: Scene, **options: object) -> Integrator | None:
    """A path tracer with short paths and these options; None where it has another picture."""
    own, tracer = scene.integrator, default_of(Integrator)
    if own.sees_media or not own.transports:
        return None
    fields = {n: v for n, v in own if n in type(tracer).model_fields and n != "type"}
    depth = own.longest_path
    fields["max_depth"] = MAX_DEPTH if depth is None else min(depth, MAX_DEPTH)
    return tracer.replaced(**{**fields, "rr_depth": RR_DEPTH, **options})


class Sums:
    """Renders sums of samples; its kernels are made once."""

    def __init__(self, scene: CompiledScene) -> None:
        self.scene, self.kernels = scene, make_kernels(scene)
        self.tiles = tiles_of((0, 0, *scene.size), CELL_SIZE * 2)

    def of(self, seed: int, spp: int, replicates: int) -> np.ndarray:
        """Sums (h, w, replicates, 3) of samples 0 to spp - 1, exact whatever the threads do."""
        settings = make_settings(self.scene.integrator, seed=seed, replicates=replicates)
        width, height = self.scene.size
        found = np.zeros((height, width, replicates, 3))

        def work(tile: Tile) -> None:
            rows = -(-tile.y1 // CELL_SIZE) - tile.y0 // CELL_SIZE
            columns = -(-tile.x1 // CELL_SIZE) - tile.x0 // CELL_SIZE
            ranges = np.tile(np.array([0, spp], np.int64), (rows, columns, 1))
            film, _ = render_tile(self.kernels, self.scene, settings, tile, ranges)
            carry(film.sums)
            found[tile.y0 : tile.y1, tile.x0 : tile.x1] = to_float(film.sums)

        with ThreadPoolExecutor(usable_processors()) as pool:
            list(pool.map(work, self.tiles))
        return found


def _seed(seed: int, number: int) -> int:
    return int(np.random.SeedSequence((seed, 3, number)).generate_state(1)[0])


#: Ways of computing the picture: name, options of the integrator.
_WAYS = {
    "light": ("light sampling", {"light_sampling": "emitter"}),
    "bsdf": ("BSDF sampling", {"light_sampling": "bsdf"}),
    "mis": ("both combined", {"light_sampling": "mis"}),
    "none": ("no roulette", {"light_sampling": "mis", "russian_roulette": "none"}),
}


def check_strategies(
    scene: Scene, seed: int, say: Callable[[str], None] = lambda text: None
) -> Iterator[Finding]:
    """Light sampling, BSDF sampling and both combined; roulette on against off."""
    if integrator_of(scene) is None:
        kind = scene.integrator.type_name()
        detail = f"the integrator {kind} has no strategies to compare"
        yield Finding("picture", "strategies agree", detail=detail)
        return
    yield from compare_ways(ways_of(scene), _brightest(flatten(scene)), seed, say)


def ways_of(scene: Scene) -> dict[str, Sums]:
    """Renderers of the small picture in each of the ways."""
    found = {}
    for key, (_, options) in _WAYS.items():
        made = integrator_of(scene, **({"russian_roulette": "throughput"} | options))
        found[key] = Sums(compile_scene(flatten(small(scene, made))))
    return found


def compare_ways(
    ways: dict[str, Sums],
    brightest: float,
    seed: int,
    say: Callable[[str], None] = lambda text: None,
) -> Iterator[Finding]:
    """Render the picture in all ways, and compare them in pairs.

    Parameters
    ----------
    ways : dict of str to Sums
        From `ways_of`.
    brightest : float
        Luminance of the brightest thing that BSDF sampling can come upon.
    seed : int
    say : callable
        Called with a description of what runs next.
    """
    sides = {}
    for number, (key, sums) in enumerate(ways.items()):
        name = _WAYS[key][0]
        say(f"picture by {name}")
        pictures = np.moveaxis(sums.of(_seed(seed, number), SPP * SEEDS, SEEDS), 2, 0) / SPP
        sides[key] = Side(name, pictures, brightest if key == "bsdf" else 0.0)
    for a, b in (("light", "bsdf"), ("light", "mis"), ("bsdf", "mis")):
        yield from compared(f"{sides[a].name} and {sides[b].name} agree", sides[a], sides[b])
    yield from compared("roulette and no roulette agree", sides["mis"], sides["none"])


def _brightest(flat: FlatScene) -> float:
    """Luminance of the brightest thing that BSDF sampling can come upon."""
    found = [0.0]
    lights = [shape.light for shape in flat.shapes if shape.light is not None]
    lights += [placed.light for placed in flat.environments]
    for light in lights:
        # Its colours, and the largest values of its pictures and textures.
        values = [v.maximum() if isinstance(v, Texture | Image) else v for _, v in light]
        colors = [v for v in values if isinstance(v, tuple) and len(v) == 3]
        found.append(float(np.prod(np.array(colors), axis=0) @ LUMINANCE) if colors else 0.0)
    return max(found)


def compared(law: str, a: Side, b: Side) -> Iterator[Finding]:
    """Two tests of equal means: of the blocks, and of the three channels."""
    z = block_z(a, b)
    judged = z[np.isfinite(z)]
    pictures = {a.name: a.pictures.mean(0), b.name: b.pictures.mean(0), "z": z}
    if not len(judged):
        yield Finding("picture", law, detail="no block varies: there is nothing to judge")
        return
    largest = float(np.abs(judged).max())
    at_one = min(1.0, len(judged) * math.erfc(largest / math.sqrt(2.0)))
    everywhere = chi_square_tail(float(np.sum(judged**2)), len(judged))
    # Two looks at the same numbers: twice the smaller p-value is one.
    yield Finding(
        "picture",
        f"{law}, blocks",
        p=min(1.0, 2.0 * min(at_one, everywhere)),
        detail=f"largest |z| {largest:.1f}, rms {np.sqrt(np.mean(judged**2)):.2f}",
        pictures=pictures,
    )
    t, dof = _welch(a, b, lambda side: side.pictures.mean(axis=(1, 2)), side_pixels(a))
    p = min(1.0, 3.0 * float(np.min(student_t_tail(t, dof))))
    means = [side.pictures.mean(axis=(0, 1, 2)) @ LUMINANCE for side in (a, b)]
    detail = f"mean luminance {means[0]:.5g} and {means[1]:.5g}"
    yield Finding("picture", f"{law}, mean", p=p, detail=detail, pictures=pictures)


def side_pixels(side: Side) -> int:
    """How many pixels its pictures have."""
    return side.pictures.shape[1] * side.pictures.shape[2]


def block_z(a: Side, b: Side) -> np.ndarray:
    """A z for each block, NaN where nothing varies."""

    def blocks(side: Side) -> np.ndarray:
        s, h, w, _ = side.pictures.shape
        luminance = side.pictures @ LUMINANCE
        return luminance.reshape(s, h // BLOCK, BLOCK, w // BLOCK, BLOCK).mean(axis=(2, 4))

    t, dof = _welch(a, b, blocks, BLOCK * BLOCK)
    z = t_to_z(t, dof)
    return np.where(np.isinf(dof) & (t == 0.0), np.nan, z)


def _welch(
    a: Side, b: Side, means: Callable[[Side], np.ndarray], pixels: int
) -> tuple[np.ndarray, np.ndarray]:
    """Welch's t of means of the given pixels; no variance is below what rare samples would have."""
    values = [means(side) for side in (a, b)]
    average = [v.mean(axis=0) for v in values]
    variance = [v.var(axis=0, ddof=1) for v in values]
    for i, side in enumerate((a, b)):
        if side.largest > 0.0:
            mean = np.maximum(np.abs(average[0]), np.abs(average[1]))
            variance[i] = np.maximum(variance[i], mean * side.largest / (pixels * SPP))
    return welch(average[0], variance[0], SEEDS, average[1], variance[1], SEEDS)


def check_accelerators(scene: Scene, seed: int, say: Callable[[str], None]) -> Iterator[Finding]:
    """The same seed through a list of all primitives and through the tree: the same bits."""
    law = "list and tree give the same bits"
    flat = displaced(flatten(small(scene)))
    triangles = sum(len(flat.geometries[s.geometry].faces) for s in flat.shapes if s.geometry >= 0)
    size = SIZE if triangles < 2000 else 16
    rays = 8 * size * size
    spp = int(min(8, MOST_TESTS / max(rays * triangles, 1)))
    if spp < 1:
        yield Finding("accelerator", law, detail=f"{triangles} triangles: too many for a list")
        return
    sums = {}
    for structure in ("list", "bvh"):
        say(f"picture by {'a list of all shapes' if structure == 'list' else 'the tree'}")
        compiled = compile_scene(flatten(small(scene, size=size)), structure=structure)
        sums[structure] = Sums(compiled).of(_seed(seed, 9), spp, 1)[:, :, 0]
    different = (sums["list"] != sums["bvh"]).any(axis=-1)
    detail = f"{int(different.sum())} of {different.size} pixels differ" if different.any() else ""
    pictures = {"list": sums["list"] / spp, "tree": sums["bvh"] / spp}
    holds = not different.any()
    yield Finding("accelerator", law, holds=holds, detail=detail, pictures=pictures)
