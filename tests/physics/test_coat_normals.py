"""Coats with normals of their own: what is below follows a map, the coat does not."""

import numpy as np
import pytest

from alight.bsdfs.adapters.blend import Blend
from alight.bsdfs.adapters.normal_map import NormalMap
from alight.bsdfs.adapters.two_sided import TwoSided
from alight.bsdfs.disney.principled import Principled
from alight.bsdfs.normals.coat_normals import OwnCoat, left_below
from alight.core.vec import Vec3
from alight.laws.check import CHECKS
from alight.laws.materials import Material, random_numbers
from alight.laws.report import Report
from alight.laws.statistics import unit_vectors
from alight.shapes.hit import Bend
from alight.textures.bitmap import Bitmap
from lanewise.jit import instantiate

BENT = (0.75, 0.4, 0.85)
FLAT = (0.5, 0.5, 1.0)
BLACK = {"base_color": 0.0, "specular": 0.0}
#: Below a coat: matte, brushed metal, and both with a sheen.
BELOW = {
    "plastic": {"base_color": (0.8, 0.4, 0.1), "roughness": 0.4},
    "brushed": {"metallic": 1.0, "roughness": 0.5, "anisotropy": 0.7, "anisotropy_rotation": 0.4},
    "cloth": {"sheen_color": 0.4, "roughness": 0.8},
}
COAT = {"clearcoat": 0.8, "clearcoat_roughness": 0.35}


def upper(n, seed):
    w = unit_vectors(n, seed)
    w[2] = np.abs(w[2])
    return w


def values(bsdf, wo, wi, **where):
    return Material(bsdf, **where).evaluate(wo, wi)[0]


def mapped(bsdf, texture=BENT):
    return NormalMap(texture=texture, bsdf=bsdf, rims="black")


@pytest.mark.parametrize("below", BELOW.values(), ids=BELOW)
def test_without_a_map_a_flat_coat_is_the_usual_one(below):
    wo, wi = upper(400, 1), upper(400, 2)
    usual = values(Principled(**below, **COAT), wo, wi)
    np.testing.assert_allclose(
        values(Principled(**below, **COAT, clearcoat_normal=FLAT), wo, wi), usual, atol=2e-5
    )


@pytest.mark.parametrize("below", BELOW.values(), ids=BELOW)
def test_a_flat_coat_is_sampled_as_the_usual_one(below):
    """The same numbers choose the same lobes and, in whichever frame, the same directions."""
    wo, u = upper(400, 1), random_numbers(400, 3)
    usual, flat = (
        Material(Principled(**below, **COAT, **own)).sample(wo, u)
        for own in ({}, {"clearcoat_normal": FLAT})
    )
    sent = (usual[2] > 0.0) & (flat[2] > 0.0)
    assert sent.sum() > 300
    # A coat is round, so where its base is turned the same numbers may turn its facets besides.
    for found, wanted in zip(flat, usual, strict=True):
        close = np.isclose(found, wanted, rtol=2e-3, atol=2e-5)
        assert close[..., sent].mean() > (0.8 if "anisotropy" in below else 0.97)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_maps_around_others_do_as_before_beside_such_a_coat(side):
    """What passes a surface is not faded, what it reflects is."""
    wo, wi = upper(400, 1), upper(400, 2) * np.float32([[1.0], [1.0], [side]])
    u = random_numbers(400, 5)
    through = Principled(transmission=1.0, thin=True, roughness=0.5)
    alone = Material(mapped(through))
    coated = Principled(**BLACK, **COAT, clearcoat_normal=FLAT)
    beside = Material(Blend(weight=0.0, bsdfs=(mapped(through), coated)))
    assert np.abs(alone.evaluate(wo, wi)[0]).max() > 0.01
    pairs = [*zip(beside.evaluate(wo, wi), alone.evaluate(wo, wi), strict=True)]
    pairs += zip(beside.sample(wo, u), alone.sample(wo, u), strict=True)
    for found, wanted in pairs:
        np.testing.assert_allclose(found, wanted, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("below", BELOW.values(), ids=BELOW)
def test_a_smooth_coat_lies_on_a_base_that_a_map_bends(below):
    """f = coat(w) + (1 - c E(wo)) base(w'), w' in the bent frame, E seen along the true normal."""
    wo, wi = upper(400, 1), upper(400, 2)
    whole = values(mapped(Principled(**below, **COAT, clearcoat_normal=FLAT)), wo, wi)
    coat = values(Principled(**BLACK, **COAT), wo, wi)
    base = values(mapped(Principled(**below)), wo, wi)
    # What the coat leaves of a base that nothing bends.
    plain = values(Principled(**below), wo, wi)
    left = (values(Principled(**below, **COAT), wo, wi) - coat) / np.maximum(plain, 1e-9)
    usable = plain.min(axis=0) > 1e-3
    assert usable.sum() > 200
    np.testing.assert_allclose(
        whole[:, usable], (coat + left * base)[:, usable], rtol=1e-3, atol=2e-5
    )


@pytest.mark.parametrize("through", [{"thin": True}, {}], ids=["sheet", "glass"])
def test_a_coat_stays_where_what_is_below_turns_away(through):
    """Seen from below the slope of the map: the base is cut, whatever it lets through."""
    wo, wi = upper(4000, 5), upper(4000, 6)
    opaque = values(mapped(Principled(**BLACK, **COAT, clearcoat_normal=FLAT)), wo, wi)
    glass = Principled(**BLACK, **COAT, **through, transmission=1.0, clearcoat_normal=FLAT)
    normal = 2.0 * np.array(BENT) - 1.0
    away = normal @ wo < 0.0
    assert away.sum() > 100
    assert opaque[:, away].max() > 0.01
    np.testing.assert_allclose(
        values(mapped(glass), wo, wi)[:, away], opaque[:, away], rtol=1e-4, atol=1e-6
    )


def test_a_coat_has_the_normals_of_its_texture():
    """Over black it is the coat that a map of the same normals bends."""
    wo, wi = upper(400, 1), upper(400, 2)
    own = Principled(**BLACK, **COAT, clearcoat_normal=BENT)
    bent = NormalMap(texture=BENT, bsdf=Principled(**BLACK, **COAT))
    for tried in (own, mapped(own, (0.3, 0.6, 0.9)), TwoSided(bsdf=own)):
        np.testing.assert_allclose(
            values(tried, wo, wi), values(bent, wo, wi), rtol=1e-4, atol=2e-5
        )
    for scale in (0.5, -0.7):
        scaled = values(own.replaced(clearcoat_normal_scale=scale), wo, wi)
        right = values(bent.replaced(scale=scale), wo, wi)
        np.testing.assert_allclose(scaled, right, rtol=1e-4, atol=2e-5)


def test_pictures_of_a_coats_normals_turn_with_their_transforms():
    pixels = np.array([[(0.8, 0.5, 0.9), (0.4, 0.7, 0.9)]])
    turned = {"to_uv": {"rotate": 70.0}}
    picture = Bitmap(pixels=pixels, color_space="linear", **turned)
    wo, wi = upper(400, 1), upper(400, 2)
    own = Principled(**BLACK, **COAT, clearcoat_normal=picture)
    bent = NormalMap(texture=picture, bsdf=Principled(**BLACK, **COAT))
    at = {"uv": (0.3, 0.6)}
    found, wanted = values(own, wo, wi, **at), values(bent, wo, wi, **at)
    assert wanted.max() > 0.1
    np.testing.assert_allclose(found, wanted, rtol=1e-4, atol=2e-5)


def test_the_back_of_two_sides_has_the_same_coat():
    wo, wi = upper(400, 1), upper(400, 2)
    bsdf = TwoSided(bsdf=mapped(Principled(**BELOW["plastic"], **COAT, clearcoat_normal=FLAT)))
    down = np.array([[1.0], [1.0], [-1.0]], np.float32)
    np.testing.assert_array_equal(values(bsdf, wo, wi), values(bsdf, wo * down, wi * down))


@pytest.mark.parametrize("below", BELOW.values(), ids=BELOW)
def test_a_tilted_coat_takes_what_it_reflects_at_its_own_angle(below):
    """(1 - c E) is that of a coat which a map tilts as much, with all that lies below it."""
    wo, wi = upper(400, 1), upper(400, 2)
    tilted = values(mapped(Principled(**below, **COAT)), wo, wi)
    tilted -= values(mapped(Principled(**BLACK, **COAT)), wo, wi)
    bent = values(mapped(Principled(**below)), wo, wi)
    own = values(Principled(**below, **COAT, clearcoat_normal=BENT), wo, wi)
    own -= values(Principled(**BLACK, **COAT, clearcoat_normal=BENT), wo, wi)
    plain = values(Principled(**below), wo, wi)
    usable = (plain.min(axis=0) > 1e-2) & (bent.min(axis=0) > 1e-2) & is_plainly_seen(wo)
    assert usable.sum() > 50
    np.testing.assert_allclose(
        own[:, usable] / plain[:, usable], tilted[:, usable] / bent[:, usable], rtol=2e-3
    )


def is_plainly_seen(wo):
    """Where the mirrored viewer is above the surface, so that rims do not move the normal."""
    n = 2.0 * np.array(BENT) - 1.0
    n /= np.linalg.norm(n)
    return 2.0 * (n @ wo) * n[2] - wo[2] > 0.2


@pytest.mark.parametrize(
    "bsdf",
    [
        Principled(**BELOW["plastic"], **COAT, clearcoat_normal=(0.7, 0.4, 0.9)),
        mapped(Principled(transmission=0.7, thin=True, **COAT, clearcoat_normal=FLAT)),
    ],
    ids=["tilted", "sheet"],
)
def test_the_laws_of_bsdfs_hold(bsdf):
    """A sample of one frame's lobe may lie where only the other frame's lobes send light."""
    report = Report(bsdf.type_name(), tuple(CHECKS["bsdfs"]([bsdf], False)))
    assert report, str(report)


def test_below_a_coat_reflected_light_fades_and_passing_light_does_not():
    n = np.array([0.48, -0.36, 0.8], np.float32)
    one = np.ones(400, np.float32)
    bent = Vec3(*(c * one for c in n))
    own = OwnCoat(one > 0.0, bent, Bend(bent, bent, bent, one > 0.0), one)
    wo, wi = upper(400, 1), unit_vectors(400, 2)
    left = instantiate(left_below, compiled=False)(own, Vec3(*wo), Vec3(*wi))
    agrees = (n @ wo > 0.0) & ((n @ wi > 0.0) == (wi[2] > 0.0))
    passing = agrees & (wi[2] < 0.0)
    assert passing.sum() > 50
    np.testing.assert_array_equal(left[~agrees], 0.0)
    np.testing.assert_array_equal(left[passing], 1.0)
    mirrored = agrees & (wi[2] > 0.0)
    assert (left[mirrored] < 1.0).any() and (left[mirrored] > 0.0).all()
