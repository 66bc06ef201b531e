"""Laws of integrators: finite, a pure function of the sample, the light that all of them find.

Each law is a function of an example and raises `BrokenLawError`. They render a small room with a
mirror ball and a lamp.
"""

from __future__ import annotations

import numpy as np

from alight.compiled.scene import CompiledScene, compile_scene
from alight.core.noise_only import noise_only_fields
from alight.core.registry import default_of
from alight.core.spec import Integrator
from alight.films.fixed_point import carry, to_float
from alight.formats import loads
from alight.integrators.walk import make_settings
from alight.laws.remembered import remembered
from alight.laws.report import demand, demand_close
from alight.laws.statistics import LARGEST_Z
from alight.rendering.tiles.tile import make_kernels, render_tile
from alight.rendering.tiles.tile_kernel import Tile
from alight.rendering.training.guide_training import is_to_be_guided, trained
from alight.scene import flatten

SPP, REPLICATES = 8, 4
#: Samples of the whole room; one of each replicate, where two pictures must have the same bits.
MANY, FEW = 16, REPLICATES
#: Rounds that train a guide.
ROUNDS = 4

ROOM = """
alight: 1
camera: {type: pinhole, fov: 60, transform: {look_at: {origin: [0, 1, 4], target: [0, 1, 0]}}}
film: {size: [16, 16]}
sampler: independent
environment: {type: constant, radiance: 0.2}
nodes:
  floor: {shape: plane, transform: {rotate: {axis: x, angle: -90}}}
  ball: {shape: {type: sphere, center: [-0.6, 0.6, 0], radius: 0.6}, bsdf: mirror}
  block: {shape: cube, bsdf: {type: phong}, transform: [{scale: 0.5}, {translate: [0.8, 0.5, 0]}]}
  lamp:
    shape: disk
    light: {type: area, radiance: 20}
    transform: [{rotate: {axis: x, angle: 90}}, {scale: 0.5}, {translate: [0, 3, 1]}]
bsdfs: {mirror: {type: mirror, reflectance: 0.9}}
"""


#: The lamp switched off, and a brighter sky.
DARK_LAMP = ROOM.replace("radiance: 20", "radiance: 0").replace("radiance: 0.2", "radiance: 1")


@remembered(8)
def room(spec: Integrator) -> CompiledScene:
    """The room, with this integrator."""
    return _compiled(spec, ROOM)


def _compiled(spec: Integrator, text: str) -> CompiledScene:
    flat = flatten(loads(text, "room").replaced(integrator=spec))
    scene = compile_scene(flat, structure="list")
    if is_to_be_guided(scene):
        scene, _ = trained(scene, seed=1, threads=1, rounds=ROUNDS)
    return scene


def picture(
    scene: CompiledScene, tile: Tile, *, compiled: bool = False, seed: int = 0, spp: int = SPP
) -> np.ndarray:
    """Sums (height, width, replicates, 3) of a tile; every number must be finite."""
    settings = make_settings(scene.integrator, seed=seed, replicates=REPLICATES, guide=scene.guide)
    ranges = np.tile(
        np.array([0, spp], np.int64),
        (-(-tile.y1 // 8) - tile.y0 // 8, -(-tile.x1 // 8) - tile.x0 // 8, 1),
    )
    kernels = make_kernels(scene, compiled=compiled)
    film, _ = render_tile(kernels, scene, settings, tile, ranges)
    demand(film.invalid == 0, f"{film.invalid} samples are not finite numbers")
    carry(film.sums)
    return to_float(film.sums)


@remembered(8)
def sums(spec: Integrator, lit: bool) -> np.ndarray:
    """Sums (16, 16, replicates, 3) of the whole room, with the lamp or by the sky alone."""
    scene = room(spec) if lit else _compiled(spec, DARK_LAMP)
    return picture(scene, Tile(0, 0, 16, 16), spp=MANY)


def samples_are_finite_and_not_negative(spec: Integrator) -> None:
    """Samples are finite and not negative."""
    demand(sums(spec, True) >= 0.0, "a sample is negative")


def its_picture_is_that_of_all_others(spec: Integrator) -> None:
    """One that transports light has the mean of a path tracer with paths as long."""
    if not spec.transports:
        return
    tracer, free = default_of(Integrator), {"type", *noise_only_fields(spec)}
    shared = {n: v for n, v in spec if n in type(tracer).model_fields and n not in free}
    if spec.longest_path is not None:
        shared |= {"max_depth": spec.longest_path, "russian_roulette": "none"}
    # Chance finds a small lamp too rarely for a standard error: a sky is met by every path.
    lit = not spec.finds_light_by_chance
    others = tracer.replaced(**shared)
    mine, other = (sums(s, lit) * (REPLICATES / MANY) for s in (spec, others))
    # The same random numbers: what both have in common has no noise.
    difference = mine - other
    variance = (difference.var(axis=2, ddof=1) / REPLICATES).mean(axis=(0, 1)) / (16 * 16)
    rounding = 1e-5 * other.mean(axis=(0, 1, 2))
    z = difference.mean(axis=(0, 1, 2)) / np.sqrt(variance + rounding**2)
    worst = int(np.argmax(np.abs(z)))
    a, b = (side[..., worst].mean() for side in (mine, other))
    text = f"channel {worst}: mean {a:.5g}, that of a path tracer {b:.5g}"
    demand(abs(z[worst]) < LARGEST_Z, f"{text}, {abs(z[worst]):.1f} standard errors")


def tiles_do_not_matter(spec: Integrator) -> None:
    """A tile holds the same bits whatever is rendered with it."""
    if spec.splats:
        # Each half adds to the whole picture.
        tiles = (Tile(0, 0, 16, 16), Tile(0, 0, 16, 8), Tile(0, 8, 16, 16))
        whole, upper, lower = (picture(room(spec), tile, spp=FEW) for tile in tiles)
        demand(upper + lower == whole, "a pixel depends on how the paths are divided")
        return
    # A corner of each of the four cells.
    part = picture(room(spec), Tile(6, 5, 10, 10), spp=MANY)
    demand(part == sums(spec, True)[5:10, 6:10], "a pixel depends on the other pixels of its tile")


def compiled_picture_is_the_twins(spec: Integrator) -> None:
    """Machine code gives the picture of the Python text."""
    tile = Tile(0, 0, 16, 16)
    found, expected = (picture(room(spec), tile, compiled=c).sum(axis=2) for c in (True, False))
    # A path whose choice hangs on a rounding error goes another way: very few do.
    close = np.isclose(found, expected, rtol=1e-3, atol=1e-4).all(axis=-1)
    demand(close.mean() >= 0.97, f"{100 * (1 - close.mean()):.1f} % of the pixels differ")
    demand_close(found.mean(), expected.mean(), "mean, compiled against Python", rtol=0.02)


LAWS = (
    samples_are_finite_and_not_negative,
    tiles_do_not_matter,
    its_picture_is_that_of_all_others,
)
COMPILED_LAWS = (compiled_picture_is_the_twins,)
