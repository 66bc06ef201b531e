"""All samples of a small picture at once, by the NumPy twin: one lane each, step by step."""

from __future__ import annotations

from collections.abc import Iterator
from unittest import mock

import numpy as np

from alight.cameras.rays import generate_ray
from alight.compiled.scene import CompiledScene, compile_scene
from alight.filters.importance import sample_filter
from alight.formats import loads
from alight.integrators import walk
from alight.integrators.moments import at_times_of
from alight.integrators.walk import FILTER, LENS, empty_paths, make_settings, start_paths, step
from alight.samplers.sampling import get_2d, sampler_state
from alight.scene import Scene, flatten
from lanewise.jit import instantiate, kernel
from lanewise.simd import lanes_u32, to_float


@kernel
def begin(scene, settings, x, y, index, scramble):
    """Paths that wait for their first step, as in `alight.rendering.tiles.tile_kernel.start`."""
    sampler = sampler_state(x, y, index, scramble, lanes_u32(settings.seed))
    dx, dy, weight = sample_filter(scene, get_2d(sampler, FILTER))
    seen = at_times_of(scene, sampler)
    o, d = generate_ray(seen, to_float(x) + 0.5 + dx, to_float(y) + 0.5 + dy, get_2d(sampler, LENS))
    return start_paths(x == x, o, d, weight, sampler, empty_paths())


def compiled(text: str, integrator=None) -> CompiledScene:
    """A scene given as text."""
    scene = loads(text, "scene.yaml")
    if integrator is not None:
        scene = scene.replaced(integrator=integrator)
    return prepared(scene)


def prepared(scene: Scene) -> CompiledScene:
    """A scene without a tree, which would have to be looked for lane by lane."""
    return compile_scene(flatten(scene), structure="list")


def followed(scene: CompiledScene, spp: int, seed: int = 0) -> Iterator[tuple]:
    """Samples as they are before each step and after the last, `PathState` or `VolumePathState`.

    Lanes go row by row through the picture, then through the samples of a pixel.
    """
    width, height = scene.size
    y, x, index = (a.ravel().astype(np.uint32) for a in np.mgrid[:height, :width, :spp])
    settings = make_settings(scene.integrator, seed=seed, replicates=1)
    first, go_on = (
        np.errstate(all="ignore")(instantiate(root, scene.program, compiled=False))
        for root in (begin, step)
    )
    path = first(scene.tables, settings, x, y, index, np.zeros_like(x))
    yield path
    while np.any(path.active):
        # Rays are counted by the bits of a packet, of which there is none here.
        with mock.patch.object(walk, "mask_bits", lambda mask: 0):
            path = go_on(scene.tables, settings, path)
        yield path


def samples_of(scene: CompiledScene, spp: int = 4, seed: int = 0) -> np.ndarray:
    """The radiance of each sample, (height, width, spp, 3) float32."""
    width, height = scene.size
    *_, last = followed(scene, spp, seed)
    rows = [np.broadcast_to(c, width * height * spp) for c in (last.L.x, last.L.y, last.L.z)]
    return np.stack(rows, -1).reshape(height, width, spp, 3)
