"""Normal and bump maps: the normals that they make, and what becomes of light at the rims."""

import numpy as np
import pytest

from alight.bsdfs.adapters.blend import Blend
from alight.bsdfs.adapters.bump_map import BumpMap
from alight.bsdfs.adapters.normal_map import NormalMap
from alight.bsdfs.adapters.two_sided import TwoSided
from alight.bsdfs.conductors.rough_conductor import RoughConductor
from alight.bsdfs.dielectrics.rough_dielectric import RoughDielectric
from alight.bsdfs.disney.principled import Principled
from alight.bsdfs.matte.diffuse import Diffuse
from alight.bsdfs.nesting import leaves
from alight.bsdfs.normals.shading_normals import _seen, fading, lit_normal
from alight.bsdfs.plastics.plastic import Plastic
from alight.core.vec import Vec3
from alight.laws.materials import Material, direction, random_numbers
from alight.laws.statistics import unit_vectors
from alight.textures.bitmap import Bitmap

PLAIN = {"rims": "black", "fading": False}


def upper(n, seed):
    w = unit_vectors(n, seed)
    w[2] = np.abs(w[2])
    return w


def lambert(normal, wo, wi):
    """f cos theta_i of white diffuse stuff with another normal."""
    normal = np.asarray(normal) / np.linalg.norm(normal)
    seen, lit = normal @ wo, normal @ wi
    return np.where((seen > 0.0) & (lit > 0.0), lit / np.pi, 0.0)


@pytest.mark.parametrize("outer", [NormalMap, BumpMap])
@pytest.mark.parametrize("inner", [NormalMap, BumpMap])
def test_of_two_maps_of_normals_the_inner_one_counts(outer, inner):
    def bent(wrapper, bsdf):
        texture = (0.7, 0.4, 0.9) if wrapper is NormalMap else Bitmap(pixels=((0.0, 1.0),))
        return wrapper(texture=texture, bsdf=bsdf)

    below = bent(inner, Diffuse())
    whole = TwoSided(bsdf=bent(outer, Blend(bsdfs=(below, Diffuse(reflectance=0.2)))))
    one, other = leaves(whole)
    assert one.normals is below
    assert other.normals is whole.bsdf


def test_normals_of_a_map_are_its_colours():
    bsdf = NormalMap(texture=(0.7, 0.4, 0.9), bsdf=Diffuse(reflectance=1.0), **PLAIN)
    wo, wi = upper(500, 1), upper(500, 2)
    value, _ = Material(bsdf).evaluate(wo, wi)
    np.testing.assert_allclose(value[0], lambert((0.4, -0.2, 0.8), wo, wi), atol=1e-6)
    half, _ = Material(bsdf.replaced(scale=0.5)).evaluate(wo, wi)
    np.testing.assert_allclose(half[0], lambert((0.2, -0.1, 0.8), wo, wi), atol=1e-6)
    # glTF has no bound for the scale.
    hollow, _ = Material(bsdf.replaced(scale=-0.5)).evaluate(wo, wi)
    np.testing.assert_allclose(hollow[0], lambert((-0.2, 0.1, 0.8), wo, wi), atol=1e-6)


def test_slopes_of_a_bump_map_are_those_of_its_picture():
    # Along u the height rises by 0.5 a texel, of which 4 make a unit; along v it falls by 0.25.
    rows = [[0.5 * x + 0.25 * y for x in range(4)] for y in range(4)]
    picture = Bitmap(pixels=np.array(rows), wrap="clamp")
    bsdf = BumpMap(texture=picture, scale=0.1, bsdf=Diffuse(reflectance=1.0), **PLAIN)
    wo, wi = upper(500, 1), upper(500, 2)
    value, _ = Material(bsdf, uv=(0.4, 0.55)).evaluate(wo, wi)
    # dh/du = 2, dh/dv = -1, in a frame where u and v are metres.
    np.testing.assert_allclose(value[0], lambert((-0.2, 0.1, 1.0), wo, wi), atol=1e-4)


#: What scatters most light to all sides, and what mirrors it.
MATTE = {
    "diffuse": Diffuse(reflectance=1.0),
    "both sides": TwoSided(bsdf=Diffuse(reflectance=1.0)),
    "rough": Principled(base_color=0.8, roughness=1.0),
    "plastic": Plastic(diffuse_reflectance=0.7),
}
SHINY = {
    "metal": Principled(base_color=0.8, metallic=1.0),
    "half metal": Principled(base_color=0.8, metallic=0.5),
    "black lacquer": Principled(base_color=0.0),
    "half a mirror": Blend(),
}
#: 60 degrees from the surface's normal.
STEEP = np.array([np.sqrt(0.75), 0.0, 0.5])


def test_a_steep_map_on_matte_stuff_is_as_bright_as_its_normal_is_turned_to_the_light():
    """Lit and seen head-on: pi f cos = n . l = 1/2, although its mirrored viewer is below."""
    texture = tuple((0.5 * (STEEP + 1.0)).tolist())
    head_on = direction(1.0)
    value, _ = Material(NormalMap(texture=texture, bsdf=MATTE["diffuse"])).evaluate(
        head_on, head_on
    )
    np.testing.assert_allclose(np.pi * value, 0.5, atol=1e-5)


@pytest.mark.parametrize("inside", (MATTE | SHINY).values(), ids=MATTE | SHINY)
def test_lit_rims_bend_matte_stuff_only_where_the_viewer_is_behind_it(inside):
    bsdf = NormalMap(texture=tuple((0.5 * (STEEP + 1.0)).tolist()), bsdf=inside)
    wo, wi = upper(2000, 4), upper(2000, 5)
    lit, _ = Material(bsdf).evaluate(wo, wi)
    plain, _ = Material(bsdf.replaced(rims="black")).evaluate(wo, wi)
    clear = STEEP @ wo > 0.1 * wo[2]
    is_alike = np.array_equal(lit[:, clear], plain[:, clear])
    assert is_alike == (inside in MATTE.values())
    # Elsewhere the normal is not lost but moved.
    hidden = (STEEP @ wo < 0.0) & (wi[2] > 0.5)
    assert (lit[0, hidden] > 0.0).mean() > 0.5 and not plain[0, hidden].any()


def test_the_bent_normal_of_matte_stuff_does_not_jump():
    """It rises until the viewer is a tenth of his height above the surface that it bends."""
    n, wo = upper(4000, 8), unit_vectors(4000, 9)
    moved = _seen(Vec3(*n), Vec3(*wo))
    found = np.stack([moved.x, moved.y, moved.z])
    w = np.where(wo[2] < 0.0, -wo, wo)
    above = (n * w).sum(axis=0)
    enough = above >= 0.1 * w[2]
    np.testing.assert_array_equal(found[:, enough], n[:, enough])
    steep = ~enough & (np.hypot(n[0], n[1]) > 0.1) & (w[2] > 0.01)
    length = np.hypot(n[0], n[1]) / np.hypot(found[0], found[1])
    after = (found * w).sum(axis=0)
    np.testing.assert_allclose((after * length)[steep], 0.1 * w[2][steep], rtol=0.02, atol=1e-3)
    assert 0.1 < steep.mean() < 0.9


@pytest.mark.parametrize("color", [(0.5, 0.5, 1.0), (0.7, 0.4, 0.9)])
@pytest.mark.parametrize(
    "inside",
    [Diffuse(), RoughConductor(alpha=0.3), RoughDielectric(alpha=0.4)],
    ids=lambda spec: spec.type_name(),
)
def test_a_bent_surface_is_the_same_one_turned_where_both_agree_on_the_sides(inside, color):
    """Values and densities of all directions, also of those that pass through."""
    n = 2.0 * np.array(color) - 1.0
    n /= np.linalg.norm(n)
    s = np.array([1.0, 0.0, 0.0]) - n[0] * n
    s /= np.linalg.norm(s)
    turned = np.stack([s, np.cross(n, s), n])
    wo, wi = unit_vectors(4000, 11), unit_vectors(4000, 12)
    inner_wo, inner_wi = (turned @ w for w in (wo, wi))
    agree = (inner_wo[2] * wo[2] > 0.0) & (inner_wi[2] * wi[2] > 0.0)
    bent = Material(NormalMap(texture=color, bsdf=inside, **PLAIN)).evaluate(wo, wi)
    plain = Material(inside).evaluate(inner_wo.astype(np.float32), inner_wi.astype(np.float32))
    # Rounding decides where a direction is grazing.
    clear = np.abs([wo[2], wi[2], inner_wo[2], inner_wi[2]]).min(0) > 1e-3
    for found, expected in zip(bent, plain, strict=True):
        found, expected = (np.atleast_2d(v)[:, clear] for v in (found, expected))
        np.testing.assert_allclose(found, np.where(agree[clear], expected, 0.0), 2e-3, 1e-5)
    through = (wo[2] * wi[2] < 0.0) & clear
    assert (np.atleast_2d(bent[0])[:, through].max() > 0.0) == isinstance(inside, RoughDielectric)


@pytest.mark.parametrize("rims", ["lit", "folded", "black"])
def test_white_surfaces_never_gain(rims):
    bsdf = NormalMap(texture=(0.9, 0.3, 0.75), rims=rims, bsdf=Diffuse(reflectance=1.0))
    for cosine in (1.0, 0.3, 0.05):
        for azimuth in (0.6, 3.7):
            wo = direction(cosine, azimuth=azimuth)
            _, weight, _, _ = Material(bsdf).sample(wo, random_numbers(20_000, 3))
            assert weight.max() <= 1.0 + 1e-5
            # Rims are black from behind only where nothing is done about it.
            normal = np.array([0.8, -0.4, 0.5])
            hidden = float(normal @ wo[:, 0]) < 0.0
            assert (weight.mean() < 1e-9) == (rims == "black" and hidden)


def test_backs_of_two_sided_maps_look_like_their_fronts():
    inside = NormalMap(texture=(0.7, 0.4, 0.9), bsdf=Diffuse(reflectance=1.0))
    material = Material(TwoSided(bsdf=inside))
    wo, wi = upper(200, 1), upper(200, 2)
    mirror = np.array([[1.0], [1.0], [-1.0]], np.float32)
    front, _ = material.evaluate(wo, wi)
    back, _ = material.evaluate(wo * mirror, wi * mirror)
    np.testing.assert_array_equal(front, back)
    assert front.any()


def test_rounded_normals_do_not_make_grazing_light_a_nan():
    # The slopes of flat places are such that the normal's length is rounded above 1.
    normal = Vec3(np.float32(0.0), np.float32(0.0), np.nextafter(np.float32(1.0), np.float32(2.0)))
    low = np.float32(1e-6) * np.arange(1, 100, dtype=np.float32)
    grazing = Vec3(np.sqrt(1 - low**2), np.zeros_like(low), low)
    np.testing.assert_array_equal(fading(normal, np.ones(99, bool), grazing), 1.0)


def test_lit_normals_rise_until_the_mirrored_viewer_is_above_the_surface():
    n, wo = upper(4000, 8), unit_vectors(4000, 9)
    wo[2] = np.copysign(np.maximum(np.abs(wo[2]), 0.01), wo[2])
    moved = lit_normal(Vec3(*n), Vec3(*wo))
    found = np.stack([moved.x, moved.y, moved.z])
    # Seen from below, the frame stands on its head.
    w = np.where(wo[2] < 0.0, -wo, wo)
    before, after = (2.0 * (m * w).sum(axis=0) * m[2] - w[2] for m in (n, found))
    enough = (before > 0.1 * w[2]) & ((n * w).sum(axis=0) > 0.0)
    assert 0.2 < enough.mean() < 0.8
    np.testing.assert_array_equal(found[:, enough], n[:, enough])
    # n + k z, normalised: a tenth of the viewer's height, over the square of its length.
    np.testing.assert_allclose(np.linalg.norm(found, axis=0), 1.0, atol=1e-5)
    np.testing.assert_allclose(found[0] * n[1], found[1] * n[0], atol=1e-5)
    length = np.hypot(n[0], n[1]) / np.hypot(found[0], found[1])
    bent = ~enough & (np.hypot(n[0], n[1]) > 0.1)
    np.testing.assert_allclose((after * length**2)[bent], 0.1 * w[2][bent], rtol=0.02, atol=1e-3)
    assert np.all(after[~enough] > -1e-5)
