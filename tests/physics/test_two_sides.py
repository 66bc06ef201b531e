"""A surface whose back is of another material shows each side as that material alone would."""

import numpy as np
import pytest

from alight.bsdfs.adapters.blend import Blend
from alight.bsdfs.adapters.normal_map import NormalMap
from alight.bsdfs.adapters.two_sided import TwoSided
from alight.bsdfs.conductors.mirror import Mirror
from alight.bsdfs.conductors.rough_conductor import RoughConductor
from alight.bsdfs.flags import LAYER
from alight.bsdfs.matte.diffuse import Diffuse
from alight.bsdfs.matte.oren_nayar import OrenNayar
from alight.compiled.scene import compile_scene
from alight.films import fixed_point
from alight.formats import loads
from alight.laws.materials import Material, direction, random_numbers
from alight.laws.statistics import unit_vectors
from alight.scene import flatten
from tests.twin import film_of

GOLD = RoughConductor(metal="gold", alpha=0.4)
CLAY = OrenNayar(reflectance=(0.7, 0.3, 0.2), sigma=20.0)
BOTH = TwoSided(bsdf=GOLD, back=CLAY)
N = 500
SHEET = """
alight: 1
film: {{size: [4, 4]}}
integrator: {{type: path, light_sampling: bsdf}}
camera: {{type: pinhole, fov: 10, transform: {{look_at: {{origin: [0, 0, {z}],
    target: [0, 0, 0]}}}}}}
environment: {{type: constant, radiance: 1}}
bsdfs: {{paint: {{type: diffuse, reflectance: [0.8, 0.4, 0.2]}}}}
nodes: {{sheet: {{shape: rectangle, bsdf: {{type: two_sided, bsdf: paint,
    back: {{type: diffuse, reflectance: [0.1, 0.2, 0.9]}}}}}}}}
"""

#: Materials, and what their front and back are to look like.
CASES = {
    "alone": (BOTH, GOLD, CLAY),
    "blended": (
        Blend(weight=0.3, bsdfs=(BOTH, TwoSided(bsdf=Diffuse()))),
        Blend(weight=0.3, bsdfs=(GOLD, Diffuse())),
        Blend(weight=0.3, bsdfs=(CLAY, Diffuse())),
    ),
    "sides of several parts": (
        TwoSided(bsdf=Blend(weight=0.2, bsdfs=(GOLD, CLAY)), back=Blend(weight=0.6)),
        Blend(weight=0.2, bsdfs=(GOLD, CLAY)),
        Blend(weight=0.6),
    ),
    "inside what shows its front twice": (
        TwoSided(bsdf=Blend(weight=0.25, bsdfs=(BOTH, Diffuse()))),
        Blend(weight=0.25, bsdfs=(GOLD, Diffuse())),
        Blend(weight=0.25, bsdfs=(GOLD, Diffuse())),
    ),
    "one of them bent": (
        TwoSided(bsdf=GOLD, back=NormalMap(texture=(0.6, 0.5, 0.9), bsdf=CLAY)),
        GOLD,
        NormalMap(texture=(0.6, 0.5, 0.9), bsdf=CLAY),
    ),
}


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_each_side_is_that_of_its_material(case, side):
    both, front, back = case
    alone, both = Material(front if side > 0.0 else back), Material(both)
    wo, wi = direction(0.6), unit_vectors(N, 5)
    mirror = np.array([[1.0], [1.0], [side]], np.float32)
    for got, wanted in zip(
        both.evaluate(mirror * wo, mirror * wi), alone.evaluate(wo, wi), strict=True
    ):
        np.testing.assert_allclose(got, wanted, rtol=2e-5, atol=1e-6)
    u = random_numbers(N, 6)
    wi, weight, pdf, flags = both.sample(mirror * wo, u)
    expected = alone.sample(wo, u)
    np.testing.assert_allclose(mirror * wi, expected[0], atol=2e-5)
    np.testing.assert_allclose(weight, expected[1], rtol=1e-3, atol=1e-5)
    np.testing.assert_allclose(pdf, expected[2], rtol=1e-3, atol=1e-5)
    # The number of the model that was chosen is above the bits of what it did.
    what = (1 << LAYER) - 1
    assert (flags & what == expected[3] & what).all()


@pytest.mark.parametrize(("z", "albedo"), [(3.0, (0.8, 0.4, 0.2)), (-3.0, (0.1, 0.2, 0.9))])
def test_pictures_and_their_layers_show_the_side_that_is_seen(z, albedo):
    aovs = ("albedo", "albedo_through")
    scene = compile_scene(flatten(loads(SHEET.format(z=z))), structure="list", aovs=aovs)
    film = film_of(scene, spp=4)
    # All directions of a white surrounding bring the same light.
    for sums in (film.sums.sum(axis=2)[..., :3], *(film.aovs[name] for name in aovs)):
        fixed_point.carry(sums)
        found = fixed_point.to_float(sums) / 4.0
        np.testing.assert_allclose(found, np.broadcast_to(albedo, (4, 4, 3)), rtol=1e-4)


def test_a_mirror_behind_a_matte_front_is_not_seen_from_there():
    material = Material(TwoSided(bsdf=Diffuse(reflectance=0.5), back=Mirror()))
    assert not material.is_delta(direction(0.5))
    assert material.is_delta(direction(-0.5))
