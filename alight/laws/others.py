"""Laws of textures, filters and cameras."""

from __future__ import annotations

import numpy as np

from alight.cameras.rays import generate_ray
from alight.compiled.cameras import compile_camera
from alight.compiled.program import Program
from alight.core.registry import versions
from alight.core.spec import Camera, Filter, Texture
from alight.filters.importance import compile_filter, sample_filter
from alight.laws.report import demand
from alight.laws.statistics import LARGEST_Z, length_error, z_of_mean
from lanewise.jit import instantiate

N = 60_000


def _u2(seed: int):
    return tuple(np.random.default_rng(seed).random((2, N), np.float32))


class _Scene:
    """What the kernels of cameras and filters read of a scene."""

    def __init__(self, **tables) -> None:
        self.__dict__.update(tables)


def weights_have_mean_one(spec: Filter) -> None:
    """The mean weight of a filter is 1, and its offsets are finite."""
    program = Program(filter=spec.type_name(), registered=versions([spec]))
    run = instantiate(sample_filter, program, compiled=False)
    dx, dy, weight = run(_Scene(filter=compile_filter(spec)), _u2(1))
    demand(np.isfinite(dx) & np.isfinite(dy), "an offset is not finite")
    values = np.broadcast_to(weight, N).astype(float)
    z = z_of_mean(values, 1.0, 1e-5)
    demand(abs(z) < LARGEST_Z, f"the mean weight is {values.mean():.5g}")


def rays_have_unit_directions(spec: Camera) -> None:
    """Rays of a camera have finite origins and unit directions."""
    size = (64, 48)
    program = Program(camera=spec.type_name(), registered=versions([spec]))
    run = instantiate(generate_ray, program, compiled=False)
    x, y = _u2(2)
    scene = _Scene(camera=compile_camera(spec, np.eye(4), size))
    o, d = run(scene, x * np.float32(size[0]), y * np.float32(size[1]), _u2(3))
    origin = np.stack([np.broadcast_to(c, N) for c in (o.x, o.y, o.z)])
    demand(np.isfinite(origin), "an origin is not finite")
    error = length_error(np.stack([np.broadcast_to(c, N) for c in (d.x, d.y, d.z)]))
    demand(error < 1e-6, f"a length is {error:.2g} off")


def values_lie_below_the_maximum(spec: Texture) -> None:
    """Values of a texture are finite and lie in [0, maximum()]."""
    from alight.bsdfs.diffuse import Diffuse
    from alight.laws.materials import Material, stacked
    from alight.textures.fetch import texture_value
    from lanewise.vec3 import Vec3

    material = Material(Diffuse(reflectance=spec))
    u, v = (4.0 * c - 2.0 for c in _u2(4))
    surface = material.surface(N)._replace(u=u, v=v)
    zero = np.zeros(N, np.float32)
    run = instantiate(texture_value, material.program, compiled=False)
    with np.errstate(all="ignore"):
        value = run(material.scene, np.ones(N, np.uint32), surface, Vec3(zero, zero, zero))
    values = stacked(value, N)
    demand(np.isfinite(values) & (values >= 0.0), "a value is negative or not finite")
    most = np.reshape(spec.maximum(), (3, 1))
    demand(values <= most + 1e-6, f"a value is {values.max():.5g}, above maximum()")
