"""Materials made of others: shares, sampling, sides and tables."""

import numpy as np
import pytest

from alight.bsdfs.adapters.blend import Blend
from alight.bsdfs.adapters.mask import Mask
from alight.bsdfs.adapters.two_sided import TwoSided
from alight.bsdfs.conductors.conductor import Conductor
from alight.bsdfs.conductors.mirror import Mirror
from alight.bsdfs.dispatch import LAYERED_NAME, albedo_bsdf
from alight.bsdfs.flags import DELTA, LAYER, NULL
from alight.bsdfs.matte.diffuse import Diffuse
from alight.bsdfs.nesting import MOST_LEAVES, leaves
from alight.bsdfs.plastics.phong import Phong
from alight.bsdfs.plastics.plastic import Plastic
from alight.compiled.materials import compile_materials
from alight.core.errors import SceneError
from alight.core.vec import Vec3
from alight.textures.checkerboard import Checkerboard
from lanewise.jit import instantiate
from tests.sampling.materials import Material, direction, random_numbers, unit_interval
from tests.sampling.statistics import unit_vectors

N = 4096
RED, GREEN = Diffuse(reflectance=(0.9, 0.1, 0.1)), Diffuse(reflectance=(0.1, 0.9, 0.1))
GLOSSY, COATED = Phong(), Plastic(diffuse_reflectance=0.8)
#: Four models, of which two are mixtures of their own, with shares of three factors.
DEEP = Blend(
    weight=0.25,
    bsdfs=(Mask(opacity=0.6, bsdf=Blend(weight=0.7, bsdfs=(GLOSSY, COATED))), Mirror()),
)


def pairs():
    """Directions (3, N) of the viewer and of the light."""
    return unit_vectors(N, 1), unit_vectors(N, 2)


def test_a_blend_is_the_weighed_sum_of_its_parts():
    wo, wi = pairs()
    f_cos, pdf = Material(DEEP).evaluate(wo, wi)
    glossy, coated = (Material(spec).evaluate(wo, wi) for spec in (GLOSSY, COATED))
    shares = 0.75 * 0.6 * 0.3, 0.75 * 0.6 * 0.7
    for seen, a, b in zip((f_cos, pdf), glossy, coated, strict=True):
        np.testing.assert_allclose(seen, shares[0] * a + shares[1] * b, rtol=2e-6, atol=1e-9)


def test_delta_lobes_have_their_share_and_keep_their_weight():
    cosine = 0.4
    _, weight, pdf, flags = Material(DEEP).sample(direction(cosine), unit_interval(N))
    _, _, lobe, kinds = Material(COATED).sample(direction(cosine), unit_interval(N))
    coat = lobe[kinds & DELTA != 0][0]
    null, mirrors = flags & NULL != 0, (flags & (DELTA | NULL)) == DELTA
    assert pdf[null] == pytest.approx(0.75 * 0.4)
    np.testing.assert_array_equal(weight[:, null], 1.0)
    # Mirror and coat reflect to the same direction; each keeps its own probability and weight.
    for probability in (0.25, 0.75 * 0.6 * 0.7 * coat):
        here = mirrors & np.isclose(pdf, probability, rtol=1e-5)
        assert here.mean() == pytest.approx(probability, abs=2.0 / N)
    np.testing.assert_array_equal(weight[:, mirrors & np.isclose(pdf, 0.25)], 1.0)


def test_the_weight_is_the_part_of_the_second_and_may_be_a_texture():
    squares = Checkerboard(color0=0.0, color1=1.0, scale=2.0)
    material = Material(Blend(weight=squares, bsdfs=(RED, GREEN)))
    albedo = instantiate(albedo_bsdf, material.program, compiled=False)
    surface = material.surface(4)._replace(
        u=np.float32([0.1, 0.6, 0.1, 0.6]), v=np.float32([0.1, 0.1, 0.6, 0.6])
    )
    up = Vec3(*np.float32([[0.0] * 4, [0.0] * 4, [1.0] * 4]))
    seen = albedo(material.scene, surface, up, np.ones(4, bool))
    np.testing.assert_allclose(seen.x, [0.9, 0.1, 0.1, 0.9], rtol=1e-6)
    np.testing.assert_allclose(seen.y, [0.1, 0.9, 0.9, 0.1], rtol=1e-6)


@pytest.mark.parametrize("weight", [0.0, 1.0])
def test_a_part_without_share_leaves_no_trace(weight):
    parts = RED, Conductor()
    blend = Material(Blend(weight=weight, bsdfs=parts))
    alone = Material(parts[int(weight)])
    u, wo = random_numbers(N, 3), direction(0.6)
    *seen, flags = blend.sample(wo, u)
    *expected, wanted = alone.sample(wo, u)
    for one, other in zip(seen, expected, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-6)
    # Above the bits of what it did is the number of the model that was chosen.
    assert (flags == wanted | (int(weight) << LAYER)).all()


def test_both_orders_of_two_sided_and_blend_are_one_material():
    wo, wi = pairs()
    inside = Material(TwoSided(bsdf=Mask(opacity=0.6, bsdf=Blend(bsdfs=(RED, COATED)))))
    parts = TwoSided(bsdf=RED), TwoSided(bsdf=COATED)
    outside = Material(Mask(opacity=0.6, bsdf=Blend(bsdfs=parts)))
    for seen, expected in zip(inside.evaluate(wo, wi), outside.evaluate(wo, wi), strict=True):
        np.testing.assert_array_equal(seen, expected)
    assert inside.evaluate(wo, wi)[0][:, (wo[2] < 0.0) & (wi[2] < 0.0)].min() > 0.0
    u = random_numbers(N, 4)
    for below in (direction(-0.3), direction(0.3)):
        for seen, expected in zip(inside.sample(below, u), outside.sample(below, u), strict=True):
            np.testing.assert_array_equal(seen, expected)


def test_programs_without_layers_do_not_know_of_them():
    for specs in ((RED,), (TwoSided(bsdf=RED), GLOSSY, COATED)):
        tables, names, _ = compile_materials(specs)
        assert LAYERED_NAME not in names
        assert tables.info.size == 2 * len(specs)


def test_parts_that_occur_more_than_once_are_stored_once():
    tables, _, _ = compile_materials((RED, DEEP, Blend(bsdfs=(RED, GREEN))))
    # RED; DEEP with its mask, blend, null, GLOSSY, COATED and Mirror; the blend and GREEN.
    assert tables.info.size == 2 * (1 + 7 + 2)


def test_the_number_of_leaves_is_limited():
    spec = RED
    for _ in range(MOST_LEAVES - 1):
        spec = Mask(bsdf=spec)
    assert len(list(leaves(spec))) == MOST_LEAVES
    wo, wi = pairs()
    f_cos, _ = Material(spec).evaluate(wo, wi)
    expected, _ = Material(RED).evaluate(wo, wi)
    np.testing.assert_allclose(f_cos, expected * 0.5 ** (MOST_LEAVES - 1), rtol=1e-5)
    with pytest.raises(SceneError, match=f"at most {MOST_LEAVES} materials"):
        Mask(bsdf=spec)
