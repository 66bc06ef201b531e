"""Laws of textures: values have the declared range and mean, and the slopes that bump maps see.

Each law is a function of an example and raises `BrokenLawError`.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Sequence

import numpy as np

from alight.bsdfs.normals.shading_normals import HEIGHTS, STEP, BumpMapRow, bent_normal
from alight.compiled.program import Program
from alight.compiled.textures import TextureTable
from alight.core.registry import versions
from alight.core.spec import Texture
from alight.core.vec import luminance
from alight.laws.plane import plane_point, plane_surface
from alight.laws.report import demand, demand_close
from alight.laws.statistics import LARGEST_Z, UNIT, z_of_mean
from alight.laws.twins import demand_same_by_machine
from alight.shapes.hit import INFO
from alight.textures.fetch import texture_value
from lanewise.jit import instantiate, kernel
from lanewise.simd import (
    LANES,
    gather,
    lane_index,
    lanes,
    lanes_u32,
    lanes_vec3,
    load_lanes,
    store_lanes,
)
from lanewise.vec3 import Vec3
from lanewise.view import View

N = 60_000

#: Standard deviation of texture coordinates that are spread over the plane: of what repeats with
#: the frequency f, this leaves exp(-2 pi^2 SPREAD^2 f^2), below 1e-80 for one period in five.
SPREAD = 16.0


#: What textures see of a scene; numbers: of a law's examples.
_Scene = namedtuple("_Scene", "materials shapes numbers")
_Materials = namedtuple("_Materials", "texture_info texture_data texels")
_Shapes = namedtuple("_Shapes", "info")
_Bumps = namedtuple("_Bumps", (*_Materials._fields, "data", "texture"))


def compile_textures(specs: Sequence[Texture]) -> tuple[_Scene, Program]:
    """A scene of textures alone, and its program."""
    table = TextureTable()
    numbers = np.array([table.number(spec) for spec in specs], np.uint32)
    compiled = table.compiled()
    materials = _Materials(compiled.info, compiled.data, compiled.texels)
    scene = _Scene(materials, _Shapes(View(np.zeros(INFO, np.uint32))), View(numbers))
    return scene, Program(textures=compiled.names, registered=versions(specs))


def values_at(spec: Texture, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Values (3, n) at texture coordinates, on a surface without colours of its own."""
    n = u.size
    # What does not vary is seen by its number alone, as materials see it.
    scene, program = compile_textures([spec])
    number = scene.numbers.array[0]
    zero, none = np.zeros(n, np.float32), np.zeros(n, np.uint32)
    surface, start = plane_surface(u, v), (0.0, 0.0, 0.0) if spec.varies else spec.maximum()
    value = Vec3(*(zero + np.float32(c) for c in start))
    run = instantiate(texture_value, program, compiled=False)
    with np.errstate(all="ignore"):
        found = run(scene, none + np.uint32(number), surface, value)
    return np.stack([np.broadcast_to(c, n) for c in (found.x, found.y, found.z)]).astype(float)


def _coordinates(seed: int) -> np.ndarray:
    return (SPREAD * np.random.default_rng(seed).normal(size=(2, N))).astype(np.float32)


def values_lie_below_the_maximum(spec: Texture) -> None:
    """Values of a texture are finite and lie in [0, maximum()]."""
    values = values_at(spec, *_coordinates(4))
    demand(np.isfinite(values) & (values >= 0.0), "a value is negative or not finite")
    most = np.reshape(spec.maximum(), (3, 1))
    demand(values <= most + 1e-6, f"a value is {values.max():.5g}, above maximum()")


def the_mean_is_the_declared_one(spec: Texture) -> None:
    """The mean over the plane is mean() where that is exact; it is above 0 where any value is."""
    values = values_at(spec, *_coordinates(5))
    mean, most = np.array(spec.mean(), float), np.array(spec.maximum(), float)
    demand(mean <= most + 1e-9, "mean() exceeds maximum()")
    demand((mean > 0.0) | (values.max(axis=1) <= 0.0), "mean() is 0, and a value is not")
    if spec.mean_is_exact:
        for channel, (found, expected) in enumerate(zip(values, mean, strict=True)):
            z = z_of_mean(found, expected, 1e-6 * max(expected, 1e-3))
            text = f"channel {channel}: the mean is {found.mean():.5g}, declared {expected:.5g}"
            demand(abs(z) < LARGEST_Z, text)


# ---------------------------------------------------------------- slopes

#: Of the heights in a law: slopes of 100 are 1.
FLAT = 0.01


def _slopes(spec: Texture, uv: np.ndarray) -> np.ndarray:
    """Slopes (2, n) that a bump map of this height, in m, gives the plane along u and v."""
    scene, program = compile_textures([spec])
    data = np.array(BumpMapRow(scale=FLAT, modes=0.0, texture=0.0), np.float32)
    textures = np.array(BumpMapRow(scale=0, modes=0, texture=scene.numbers.array[0]), np.uint32)
    # The row of a bump map alone.
    bumps = scene._replace(materials=_Bumps(*scene.materials, View(data), View(textures)))
    program = program._replace(bsdfs=(HEIGHTS,))
    n, base = uv.shape[1], np.zeros(uv.shape[1], np.uint32)
    run = instantiate(bent_normal, program, compiled=False)
    with np.errstate(all="ignore"):
        normal = run(bumps, base, plane_surface(*uv), np.ones(n, bool), base > 0)
    x, y, z = (np.broadcast_to(c, n).astype(float) for c in (normal.x, normal.y, normal.z))
    return -np.stack([x, y]) / (FLAT * z)


def bump_maps_see_its_slopes(spec: Texture) -> None:
    """A bump map has the slopes of the texture's luminance, by differences over longer steps.

    Over twice, four and eight times the step the difference quotients of a smooth height are off by
    K, 5 K and 21 K; where an edge lies between, they are not.
    """
    if not spec.varies:
        return
    # Multiples of 2^-16: coordinates and their differences are exact.
    u, v = (np.random.default_rng(7).integers(2**14, 2**16, (2, 4000)) / 2.0**16).astype(np.float32)
    rounding = 16 * UNIT * float(luminance(Vec3(*spec.maximum()))) / STEP
    for axis, slope in enumerate(_slopes(spec, np.stack([u, v]))):
        quotients = []
        for times in (2, 4, 8):
            ends = []
            for side in (1, -1):
                at = [u.astype(float), v.astype(float)]
                at[axis] = at[axis] + 0.5 * STEP * (1 + side * times)
                ends.append(luminance(Vec3(*values_at(spec, *np.asarray(at, np.float32)))))
            quotients.append((ends[0] - ends[1]) / (times * STEP))
        two, four, eight = quotients
        smooth = np.abs(four - two) <= 0.5 * np.abs(eight - four) + rounding
        if smooth.mean() < 0.5:
            # It is finer than a step.
            return
        atol = np.abs(four - two) + 4.0 * rounding
        demand_close(slope[smooth], two[smooth], f"slope along {'uv'[axis]}", atol=atol[smooth])


# ---------------------------------------------------------------- machine code


@kernel
def look_up_all(scene, uv, out, n):
    """Values of all textures by turns, at n points of the plane."""
    for i in range(0, n, LANES):
        u, v = load_lanes(uv, i), load_lanes(uv, i + n)
        number = gather(scene.numbers, (lane_index() + i) % scene.numbers.size)
        color = Vec3(0.25, 0.5, 0.75) * u
        surface = plane_point(Vec3(u, v, lanes(0.0)), u, v, lanes_u32(0), color)
        value = texture_value(scene, number, surface, lanes_vec3(0.0))
        store_lanes(out, i, value.x)
        store_lanes(out, i + n, value.y)
        store_lanes(out, i + 2 * n, value.z)


def demand_same_textures(specs: Sequence[Texture]) -> None:
    """Compare the values of several textures by machine code and by the Python text."""
    scene, program = compile_textures(specs)
    n = 64 * len(specs)
    uv = np.random.default_rng(6).uniform(-2.0, 4.0, (2, n)).astype(np.float32)
    demand_same_by_machine(look_up_all, program, scene, uv, 3)


def compiled_values_are_the_twins(spec: Texture) -> None:
    """Machine code sees the values of the Python text."""
    demand_same_textures([spec])


LAWS = (
    values_lie_below_the_maximum,
    the_mean_is_the_declared_one,
    bump_maps_see_its_slopes,
)
COMPILED_LAWS = (compiled_values_are_the_twins,)
