"""Roulette knows that radiance is concentrated in glass: paths there are not ended as dim ones."""

from __future__ import annotations

from collections import namedtuple
from types import SimpleNamespace

import numpy as np
import pytest

import alight
from alight.bsdfs.dielectrics.dielectric import Dielectric
from alight.bsdfs.dielectrics.rough_dielectric import RoughDielectric
from alight.bsdfs.disney.principled import Principled
from alight.bsdfs.matte.diffuse import Diffuse
from alight.bsdfs.switch import concentration, refracts
from alight.compiled.materials import compile_materials
from alight.compiled.program import Program
from alight.formats import loads
from alight.integrators.roulette import MAX_SURVIVAL, play_roulette
from alight.samplers.state import sampler_state
from alight.textures.checkerboard import Checkerboard
from lanewise.jit import instantiate
from lanewise.vec3 import Vec3
from tests.sampling.materials import Scene, Shapes, Surface

#: What the roulette reads of a path.
Paths = namedtuple("Paths", "beta depth sampler active")

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


@pytest.mark.parametrize("brightness", [0.05, 0.2, 0.4, 0.9, 1.0, 2.25])
def test_survival_is_the_brightness_up_to_its_cap(brightness):
    n = 20_000
    program = Program(sampler=("independent",))
    index = np.arange(n, dtype=np.uint32)
    beta = Vec3(*(np.full(n, part, np.float32) for part in (0.1, 0.2, 0.05)))
    path = Paths(
        beta=beta,
        depth=np.where(index % 2, 5, 4).astype(np.uint32),
        sampler=sampler_state(0 * index, 0 * index, index, 0 * index, 0 * index),
        active=np.ones(n, bool),
    )
    play = instantiate(play_roulette, program, compiled=False)
    left = play(SimpleNamespace(rr_depth=5), path, 8, np.float32(brightness))
    survival, playing = min(brightness, MAX_SURVIVAL), path.depth == 5
    np.testing.assert_allclose(left.beta.y[playing], 0.2 / survival, rtol=1e-6)
    spread = np.sqrt(survival * (1.0 - survival) / playing.sum())
    assert abs(left.active[playing].mean() - survival) < 4.5 * spread
    # Before its depth the roulette is not played.
    np.testing.assert_array_equal(left.beta.y[~playing], beta.y[~playing])
    assert left.active[~playing].all()
