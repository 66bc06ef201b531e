"""Plastics against the formulas of their pages in float64, and the tables of their coats."""

import numpy as np
import pytest
from scipy import special

from alight.bsdfs.dispatch import albedo_bsdf
from alight.bsdfs.flags import DELTA
from alight.bsdfs.plastics.coating import STEPS, coat_row, diffuse_reflectance
from alight.bsdfs.plastics.plastic import Plastic
from alight.bsdfs.plastics.rough_plastic import RoughPlastic
from alight.core.vec import Vec3
from alight.textures.checkerboard import Checkerboard
from alight.textures.constant import Constant
from lanewise.jit import instantiate
from tests.sampling.materials import Material, direction, unit_interval
from tests.sampling.statistics import unit_vectors

COLOR = (0.9, 0.5, 0.1)
TINT = (0.8, 1.0, 0.6)


def fresnel(cosine, eta):
    """Reflected part of the light, and the cosine of the refracted ray."""
    cosine = np.maximum(cosine, 1e-9)
    square = 1.0 - (1.0 - cosine**2) / eta**2
    cos_t = np.sqrt(np.maximum(square, 0.0))
    s = (cosine - eta * cos_t) / (cosine + eta * cos_t)
    p = (eta * cosine - cos_t) / (eta * cosine + cos_t)
    return np.where(square <= 0.0, 1.0, 0.5 * (s * s + p * p)), cos_t


def masking(distribution, cosine, alpha):
    """Smith's G1, 0 below the horizon."""
    c = np.clip(np.abs(cosine), 1e-9, 1.0)
    a = c / (alpha * np.sqrt(np.maximum(1.0 - c * c, 1e-18)))
    if distribution == "ggx":
        rest = 0.5 * (np.sqrt(1.0 + 1.0 / a**2) - 1.0)
    else:
        rest = np.exp(-a * a) / (2.0 * a * np.sqrt(np.pi)) - 0.5 * special.erfc(a)
    return np.where(cosine > 0.0, 1.0 / (1.0 + rest), 0.0)


def mean_over_facets(distribution, mu, alpha, value, n=1000):
    """Mean of value(cosine at the facet, its z) over the facets seen at the cosine mu.

    The slopes' distribution is inverted, so that D cos theta dm = du dphi; a facet then counts by
    its area as seen from there.
    """
    s = (np.arange(n) + 0.5) / n
    # One minus the probability as a cube: few facets are steep, but they are seen well.
    rest, weight = (s**3)[:, None], 3.0 * (s**2)[:, None]
    slope = np.sqrt((1.0 - rest) / rest) if distribution == "ggx" else np.sqrt(-np.log(rest))
    phi = np.pi * (np.arange(400) + 0.5) / 400
    along = mu - np.sqrt(1.0 - mu * mu) * alpha * slope * np.cos(phi)
    seen = np.maximum(along, 0.0) * weight
    z = 1.0 / np.sqrt(1.0 + (alpha * slope) ** 2) + 0.0 * along
    return np.sum(seen * value(np.clip(along * z, 0.0, 1.0), z)) / np.sum(seen)


@pytest.mark.parametrize("distribution", ["ggx", "beckmann"])
@pytest.mark.parametrize("alpha", [0.1, 0.6])
@pytest.mark.parametrize("eta", [1.5, 0.7])
def test_transmittance_is_the_integral_over_the_facets(distribution, alpha, eta):
    row = coat_row(distribution, alpha, eta)
    for k in (3, 20, STEPS - 1):
        mu = k / (STEPS - 1)

        def through(cosine, z, mu=mu):
            reflected, cos_t = fresnel(cosine, eta)
            refracted = mu / eta - (cosine / eta - cos_t) * z
            return (1.0 - reflected) * masking(distribution, refracted, alpha)

        exact = mean_over_facets(distribution, mu, alpha, through)
        assert row[k] == pytest.approx(exact, abs=1e-4)


@pytest.mark.parametrize("distribution", ["ggx", "beckmann"])
def test_internal_reflectance_is_the_mean_over_the_steps(distribution):
    alpha, eta = 0.3, 1.5
    mus = np.maximum(np.arange(STEPS) / (STEPS - 1), 1e-6)

    def back(cosine, z, mu):
        reflected, _ = fresnel(cosine, 1.0 / eta)
        return reflected * masking(distribution, 2.0 * cosine * z - mu, alpha)

    means = [
        mean_over_facets(distribution, mu, alpha, lambda c, z, mu=mu: back(c, z, mu), 200)
        for mu in mus
    ]
    expected = 2.0 * np.mean(mus * means)
    assert coat_row(distribution, alpha, eta)[STEPS] == pytest.approx(expected, abs=2e-4)


@pytest.mark.parametrize("eta", [1.0, 1.2, 1.5, 2.4])
def test_diffuse_light_is_reflected_by_both_sides_as_the_solid_angles_say(eta):
    mu = (np.arange(100_000) + 0.5) / 100_000
    outside = np.mean(2.0 * mu * fresnel(mu, eta)[0])
    assert diffuse_reflectance(eta) == pytest.approx(outside, abs=1e-6)
    inside = 1.0 - (1.0 - outside) / eta**2
    assert diffuse_reflectance(1.0 / eta) == pytest.approx(inside, abs=1e-6)


def directions():
    """Pairs above the surface, half of them near the mirrored direction, (3, n) each."""
    wo, wi = unit_vectors(4000, 1), unit_vectors(4000, 2)
    wi[:, ::2] = (wo * [[-1], [-1], [1]] + 0.2 * wi)[:, ::2]
    wi /= np.linalg.norm(wi, axis=0)
    return np.abs(wo[2]) * [[0], [0], [1]] + wo * [[1], [1], [0]], wi * np.sign(wi[2])


def base(nonlinear, internal, wo_part, wi_part, eta, cos_i):
    rho = np.array(COLOR)[:, None]
    rounds = rho / (1.0 - (rho if nonlinear else 1.0) * internal)
    return rounds / np.pi * wo_part * wi_part / eta**2 * cos_i


@pytest.mark.parametrize("nonlinear", [False, True])
def test_plastic_is_its_formula(nonlinear):
    eta = 1.7
    spec = Plastic(
        int_ior=eta,
        ext_ior=1.0,
        diffuse_reflectance=COLOR,
        specular_reflectance=TINT,
        nonlinear=nonlinear,
    )
    wo, wi = directions()
    f_cos, _ = Material(spec).evaluate(wo, wi)
    through = (1.0 - fresnel(c, eta)[0] for c in (wo[2], wi[2]))
    exact = base(nonlinear, diffuse_reflectance(1.0 / eta), *through, eta, wi[2])
    np.testing.assert_allclose(f_cos, exact, rtol=2e-5, atol=1e-7)
    # The lobe of the coat: what it reflects, however likely it is chosen.
    for cosine in (1.0, 0.4, 0.05):
        _, weight, pdf, flags = Material(spec).sample(direction(cosine), unit_interval(64))
        delta = flags & DELTA != 0
        lobe = (weight * pdf)[:, delta][:, 0]
        np.testing.assert_allclose(lobe, np.array(TINT) * fresnel(cosine, eta)[0], rtol=1e-5)


@pytest.mark.parametrize("nonlinear", [False, True])
@pytest.mark.parametrize("distribution", ["ggx", "beckmann"])
def test_rough_plastic_is_its_formula(distribution, nonlinear):
    eta, alpha = 1.7, 0.3
    spec = RoughPlastic(
        int_ior=eta,
        ext_ior=1.0,
        diffuse_reflectance=COLOR,
        specular_reflectance=TINT,
        nonlinear=nonlinear,
        distribution=distribution,
        alpha=alpha,
    )
    wo, wi = directions()
    f_cos, _ = Material(spec).evaluate(wo, wi)
    wm = wo + wi
    wm /= np.linalg.norm(wm, axis=0)
    tan2 = (1.0 - wm[2] ** 2) / wm[2] ** 2 / alpha**2
    shape = np.exp(-tan2) if distribution == "beckmann" else 1.0 / (1.0 + tan2) ** 2
    density = shape / (np.pi * alpha**2 * wm[2] ** 4)
    reflected, _ = fresnel(np.sum(wo * wm, axis=0), eta)
    both = masking(distribution, wo[2], alpha) * masking(distribution, wi[2], alpha)
    coat = np.array(TINT)[:, None] * (reflected * density * both / (4.0 * wo[2]))
    row = coat_row(distribution, alpha, eta).astype(float)
    through = (np.interp(c, np.linspace(0.0, 1.0, STEPS), row[:STEPS]) for c in (wo[2], wi[2]))
    exact = coat + base(nonlinear, row[STEPS], *through, eta, wi[2])
    np.testing.assert_allclose(f_cos, exact, rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize(("alpha", "tolerance"), [(0.25, 2e-6), (0.3, 1e-4), (0.012, 5e-4)])
def test_textured_roughness_gives_what_a_number_gives(alpha, tolerance):
    wo, wi = directions()
    same = Checkerboard(color0=alpha, color1=alpha)
    textured, _ = Material(RoughPlastic(alpha=same)).evaluate(wo, wi)
    number, _ = Material(RoughPlastic(alpha=alpha)).evaluate(wo, wi)
    constant, _ = Material(RoughPlastic(alpha=Constant(color=alpha))).evaluate(wo, wi)
    np.testing.assert_allclose(constant, number, rtol=1e-5)
    # Rows of the table stand at (i / 32)^2; between them it is interpolated.
    np.testing.assert_allclose(textured, number, rtol=2e-6, atol=tolerance)


def test_what_plastic_reflects_at_right_angles_has_a_closed_form():
    eta, tint = 1.8, np.array(TINT)
    material = Material(
        Plastic(int_ior=eta, ext_ior=1.0, diffuse_reflectance=0.0, specular_reflectance=TINT)
    )
    albedo = instantiate(albedo_bsdf, material.program, compiled=False)
    found = albedo(material.scene, material.surface(1), Vec3(*np.eye(3)[2]), np.ones(1, bool))
    mirrored = ((eta - 1.0) / (eta + 1.0)) ** 2
    np.testing.assert_allclose(np.ravel([found.x, found.y, found.z]), tint * mirrored, rtol=1e-4)
