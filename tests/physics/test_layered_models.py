"""Coats, blends and masks are their formulas."""

import numpy as np
import pytest

from alight.bsdfs.adapters.blend import Blend
from alight.bsdfs.adapters.mask import Mask
from alight.bsdfs.adapters.two_sided import TwoSided
from alight.bsdfs.conductors.rough_conductor import RoughConductor
from alight.bsdfs.flags import DELTA, NULL
from alight.bsdfs.matte.diffuse import Diffuse
from alight.bsdfs.plastics.phong import Phong
from alight.bsdfs.plastics.plastic import Plastic
from alight.laws.materials import Material, direction, random_numbers, unit_interval

N = 4096
MATTE = Diffuse(reflectance=(0.9, 0.5, 0.1))
SHINY = RoughConductor(alpha=0.4)
VEIL = Mask(opacity=0.7, bsdf=MATTE)
GILDED = Blend(weight=0.1, bsdfs=(MATTE, SHINY))


def directions(seed):
    """(3, n) on the whole sphere."""
    v = np.random.default_rng(seed).normal(size=(3, N))
    return (v / np.linalg.norm(v, axis=0)).astype(np.float32)


@pytest.mark.parametrize(
    ("spec", "shares"),
    [
        (Blend(weight=0.2, bsdfs=(MATTE, SHINY)), {MATTE: 0.8, SHINY: 0.2}),
        (Blend(weight=0.2, bsdfs=(VEIL, SHINY)), {MATTE: 0.56, SHINY: 0.2}),
        (Mask(opacity=0.7, bsdf=GILDED), {MATTE: 0.63, SHINY: 0.07}),
        (Mask(opacity=0.3, bsdf=TwoSided(bsdf=MATTE)), {TwoSided(bsdf=MATTE): 0.3}),
    ],
    ids=["blend", "mask in a blend", "blend in a mask", "two-sided in a mask"],
)  # fmt: skip
def test_values_and_densities_are_weighted_sums(spec, shares):
    wo, wi = directions(1), directions(2)
    f_cos, pdf = Material(spec).evaluate(wo, wi)
    parts = [(share, *Material(part).evaluate(wo, wi)) for part, share in shares.items()]
    np.testing.assert_allclose(f_cos, sum(s * f for s, f, _ in parts), rtol=1e-5, atol=1e-7)
    np.testing.assert_allclose(pdf, sum(s * p for s, _, p in parts), rtol=1e-5, atol=1e-7)
    assert np.count_nonzero(pdf) > N // 5


@pytest.mark.parametrize("cosine", [0.7, -0.5])
def test_holes_of_a_mask_let_light_straight_on(cosine):
    wo = direction(cosine)
    wi, weight, pdf, flags = Material(Mask(opacity=0.3, bsdf=MATTE)).sample(wo, unit_interval(N))
    holes = (flags & NULL) != 0
    assert np.count_nonzero(holes) == pytest.approx(0.7 * N, abs=1.0)
    np.testing.assert_array_equal(wi[:, holes], np.broadcast_to(-wo, wi.shape)[:, holes])
    np.testing.assert_allclose(weight[:, holes], 1.0, rtol=1e-6)
    np.testing.assert_allclose(pdf[holes], 0.7, rtol=1e-6)


def test_the_parts_of_a_blend_are_chosen_by_its_weight():
    # Phong's lobe and the matte part overlap; only the mirror's flag tells the parts apart.
    spec = Blend(weight=0.25, bsdfs=(Phong(), Plastic(diffuse_reflectance=0.0)))
    _, _, _, flags = Material(spec).sample(direction(0.7), unit_interval(N))
    assert np.count_nonzero(flags & DELTA) == pytest.approx(0.25 * N, abs=1.0)


def fresnel(cosine, eta):
    """Reflectance of an interface."""
    refracted = np.sqrt(np.maximum(0.0, 1.0 - (1.0 - cosine**2) / eta**2))
    s = (cosine - eta * refracted) / (cosine + eta * refracted)
    p = (eta * cosine - refracted) / (eta * cosine + refracted)
    return 0.5 * (s * s + p * p)


@pytest.mark.parametrize("nonlinear", [False, True])
def test_plastic_is_its_formula(nonlinear):
    eta, albedo = 1.6, np.array([[0.9], [0.5], [0.1]])
    spec = Plastic(int_ior=eta, ext_ior=1, diffuse_reflectance=MATTE.reflectance,
                   nonlinear=nonlinear)  # fmt: skip
    wo, wi = np.abs(directions(3)), np.abs(directions(4))
    # Diffuse light inside is reflected as outside, and wholly beyond the critical angle.
    mu = (np.arange(20_000) + 0.5) / 20_000
    inside = 1.0 - (1.0 - np.mean(2.0 * mu * fresnel(mu, eta))) / eta**2
    base = albedo / (1.0 - (albedo if nonlinear else 1.0) * inside)
    through = (1.0 - fresnel(wo[2], eta)) * (1.0 - fresnel(wi[2], eta)) / eta**2
    f_cos, _ = Material(spec).evaluate(wo, wi)
    np.testing.assert_allclose(f_cos, base * through * wi[2] / np.pi, rtol=2e-4, atol=1e-7)


@pytest.mark.parametrize("cosine", [0.9, 0.3])
def test_the_coat_of_plastic_reflects_by_fresnel(cosine):
    tint = np.array([0.9, 0.5, 0.2])
    spec = Plastic(int_ior=1.6, ext_ior=1, specular_reflectance=tuple(tint))
    _, weight, pdf, flags = Material(spec).sample(direction(cosine), random_numbers(N, 5))
    coat = (flags & DELTA) != 0
    assert 0 < np.count_nonzero(coat) < N
    energy = weight[:, coat] * pdf[coat]
    np.testing.assert_allclose(energy, np.broadcast_to((tint * fresnel(cosine, 1.6))[:, None],
                               energy.shape), rtol=1e-4)  # fmt: skip
