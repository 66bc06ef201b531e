"""Roulette knows that radiance is concentrated in glass: paths there are not ended as dim ones."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import alight
from alight.bsdfs.dielectric import Dielectric
from alight.bsdfs.diffuse import Diffuse
from alight.bsdfs.principled import Principled
from alight.bsdfs.rough_dielectric import RoughDielectric
from alight.bsdfs.switch import concentration, refracts
from alight.compiled.materials import compile_materials
from alight.compiled.program import Program
from alight.formats import loads
from alight.integrators.path import MAX_SURVIVAL, _write_play_roulette
from alight.samplers.state import sampler_state
from alight.textures.checkerboard import Checkerboard
from lanewise.jit import instantiate
from lanewise.vec3 import Vec3
from tests.sampling.materials import Scene, Shapes, Surface

# A ball that shows the same light in every direction; all of it comes through.
FURNACE = """
alight: 1
camera: {fov: 18, transform: {translate: [0, 0, 4]}}
film: {size: [8, 8]}
sampler: independent
environment: {type: constant, radiance: 1}
integrator: {type: path, light_sampling: bsdf, rr_depth: 1, max_depth: 64}
nodes:
  ball: {shape: sphere, bsdf: {type: dielectric, int_ior: 1.5, ext_ior: 1}}
"""


def test_light_through_glass_has_little_noise():
    seeds, spp = 64, 16
    scene = loads(FURNACE)
    films = (alight.render(scene, spp=spp, spp_per_pass=spp, seed=i) for i in range(seeds))
    green = np.stack([film.image[..., 1].astype(float) for film in films])
    variance = green.var(0, ddof=1).mean() * spp
    # A path that meets k surfaces is worth 0.95^-k with probability 0.95^k: variance 0.95^-k - 1.
    # k is 1 for the mirrored part, 2 for nearly all the rest. Were a path ended in the glass for
    # its throughput 1 / 1.5^2, the variance would be above 1.
    assert 0.1 < variance < 0.12
    assert abs(green.mean() - 1.0) < 4.5 * np.sqrt(variance / (spp * green.size))


def test_concentration_is_the_square_of_the_index_inside():
    specs = [
        Diffuse(),
        Dielectric(int_ior=1.5, ext_ior=1.0),
        RoughDielectric(int_ior=1.8, ext_ior=1.2),
        Dielectric(int_ior=1.0, ext_ior=1.5),
    ]
    tables, names, textures = compile_materials(specs)
    program = Program(bsdfs=names, textures=textures)
    assert refracts(program)
    assert not refracts(Program(bsdfs=("diffuse", "thin_dielectric", "plastic")))
    # Of a model with many faces, only glass.
    for spec, bends in (
        (Principled(metallic=1.0), False),
        (Principled(transmission=0.5), True),
        (Principled(transmission=Checkerboard()), True),
    ):
        _, names_of_one, textures_of_one = compile_materials([spec])
        assert refracts(Program(bsdfs=names_of_one, textures=textures_of_one)) == bends
    zero, one = np.zeros(8, np.float32), np.ones(8, np.float32)
    row = np.arange(8, dtype=np.uint32) % 4
    surface = Surface(zero, zero, row * 0, row, Vec3(zero, zero, zero))
    # The first four go in, the others come out or are reflected.
    wi = Vec3(zero, 0.6 * one, np.where(np.arange(8) < 4, -0.8, 0.8).astype(np.float32))
    kernel = instantiate(concentration, program, compiled=False)
    found = kernel(Scene(tables, Shapes(None)), surface, wi)
    # A bubble in glass would make paths dimmer than they are: it changes nothing.
    np.testing.assert_allclose(found, [1, 2.25, 2.25, 1, 1, 1, 1, 1], rtol=1e-6)


@pytest.mark.parametrize("brightness", [0.05, 0.2, 0.4, 0.9])
def test_survival_is_the_throughput_times_the_concentration(brightness):
    """Into glass, past diffuse stuff, and where no surface of the scene refracts."""
    n = 20_000
    tables, names, textures = compile_materials([Diffuse(), Dielectric(int_ior=1.5, ext_ior=1.0)])
    program = Program(bsdfs=names, textures=textures, sampler=("independent",))
    row = np.arange(n, dtype=np.uint32) % 2
    zero, every = np.zeros(n, np.float32), np.ones(n, bool)
    surface = Surface(zero, zero, 0 * row, row, Vec3(zero, zero, zero))
    beta = Vec3(*(np.float32(brightness) * np.float32(part) + zero for part in (0.5, 1.0, 0.25)))
    path = SimpleNamespace(
        sampler=sampler_state(0 * row, 0 * row, np.arange(n, dtype=np.uint32), 0 * row, 0 * row)
    )
    for refracting, concentrated in ((True, 2.25), (False, 1.0)):
        play = instantiate(_write_play_roulette(refracting), program, compiled=False)
        survival = np.minimum(brightness * np.where(row == 1, concentrated, 1.0), MAX_SURVIVAL)
        wi = Vec3(zero, 0.6 + zero, -0.8 + zero)
        depth = np.full(n, 5, np.uint32)
        args = (Scene(tables, Shapes(None)), SimpleNamespace(rr_depth=5), path, surface, wi)
        left, active = play(*args, depth, beta, every)
        np.testing.assert_allclose(left.y, brightness / survival, rtol=1e-5)
        for kind in (0, 1):
            mine = row == kind
            spread = np.sqrt(survival[mine][0] * (1.0 - survival[mine][0]) / mine.sum())
            assert abs(active[mine].mean() - survival[mine][0]) < 4.5 * spread
        # Before its depth the roulette is not played.
        left, active = play(*args, depth - 1, beta, every)
        np.testing.assert_array_equal(left.y, beta.y)
        assert active.all()
