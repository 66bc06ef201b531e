"""Values of BSDFs against the formulas of their pages, in float64."""

import numpy as np
import pytest

from alight.bsdfs.conductors.conductor import METALS, Conductor
from alight.bsdfs.disney.burley import Burley
from alight.bsdfs.matte.diffuse import Diffuse
from alight.bsdfs.matte.uniform_scatter import UniformScatter
from alight.bsdfs.plastics.phong import SHARPEST, Phong
from tests.sampling.materials import Material, direction, random_numbers, unit_interval
from tests.sampling.statistics import unit_vectors

COLOR = (0.9, 0.5, 0.1)


def upper(seed, n=5000):
    w = unit_vectors(n, seed)
    w[2] = np.abs(w[2])
    return w


@pytest.mark.parametrize("sampling", ["cosine", "uniform"])
def test_diffuse_is_lambert_however_it_is_sampled(sampling):
    wi = upper(1)
    f_cos, pdf = Material(Diffuse(reflectance=COLOR, sampling=sampling)).evaluate(upper(2), wi)
    exact = np.multiply.outer(COLOR, wi[2].astype(float)) / np.pi
    np.testing.assert_allclose(f_cos, exact, rtol=5e-7)
    density = wi[2] / np.pi if sampling == "cosine" else np.full(wi.shape[1], 0.5 / np.pi)
    np.testing.assert_allclose(pdf, density, rtol=5e-7)


@pytest.mark.parametrize("m", [0, 1, 2, 8])
def test_uniform_sampling_of_diffuse_has_the_variance_that_its_page_states(m):
    wo, variances = direction(0.7), {}
    for sampling in ("cosine", "uniform"):
        wi, weight, _, _ = Material(Diffuse(sampling=sampling)).sample(
            wo, random_numbers(60_000, 6)
        )
        estimate = weight[0].astype(float) * wi[2].astype(float) ** m
        variances[sampling] = estimate.var() / estimate.mean() ** 2
    assert variances["cosine"] == pytest.approx(m * m / (4.0 * (m + 1.0)), rel=0.05, abs=1e-9)
    assert variances["uniform"] == pytest.approx((m + 1.0) ** 2 / (2.0 * m + 3.0), rel=0.05)


def test_uniform_scatter_is_the_model_that_is_not_reciprocal():
    assert not Material(UniformScatter()).is_reciprocal()


def test_uniform_scatter_forgets_the_cosine():
    f_cos, pdf = Material(UniformScatter(reflectance=COLOR)).evaluate(upper(3), upper(4))
    np.testing.assert_allclose(f_cos, np.outer(COLOR, np.ones(5000)) / (2.0 * np.pi), rtol=5e-7)
    np.testing.assert_allclose(pdf, 0.5 / np.pi, rtol=5e-7)


@pytest.mark.parametrize("exponent", [0.0, 1.0, 7.5, 300.0, 1e4])
def test_phong_is_its_formula(exponent):
    kd, ks = np.array([0.5, 0.2, 0.0]), np.array([0.3, 0.4, 0.9])
    material = Material(Phong(diffuse=tuple(kd), specular=tuple(ks), exponent=exponent))
    # Around the mirrored direction, where a sharp lobe has values.
    wo = upper(5)
    wi, *_ = material.sample(wo, random_numbers(wo.shape[1], 6))
    above = wi[2] > 1e-3
    wo, wi = wo[:, above], wi[:, above]
    f_cos, _ = material.evaluate(wo, wi)
    mirrored = wo.astype(float) * np.array([[-1.0], [-1.0], [1.0]])
    chord2 = np.sum((wi - mirrored) ** 2, axis=0)
    cosine = 1.0 - 0.5 * chord2
    lobe = np.where(cosine > 0.0, np.exp(exponent * np.log(np.maximum(cosine, 1e-300))), 0.0)
    exact = kd[:, None] / np.pi + ks[:, None] * (exponent + 2.0) / (2.0 * np.pi) * lobe
    # The chord of two float32 vectors, to the power of n.
    np.testing.assert_allclose(f_cos, exact * wi[2], rtol=1e-5 + 2e-7 * exponent, atol=1e-7)


@pytest.mark.parametrize("exponent", [0.0, 3.0, 50.0, 1e4, 1e7, 1e12])
def test_phong_lobe_seen_from_above_reflects_exactly_its_specular_part(exponent):
    material = Material(Phong(diffuse=0.0, specular=0.8, exponent=exponent))
    wi, weight, pdf, _ = material.sample(direction(1.0), unit_interval(20_000))
    assert np.all(pdf > 0.0)
    # Each weight is 0.8 (n + 2) / (n + 1) cos theta, of mean 0.8: ratio of two exact moments.
    n = min(exponent, SHARPEST)
    exact = 0.8 * (n + 2.0) / (n + 1.0) * wi[2].astype(float)
    np.testing.assert_allclose(weight[0], exact, rtol=1e-5)
    spread = np.sqrt((n + 2.0) ** 2 / ((n + 1.0) * (n + 3.0)) - 1.0)
    assert weight[0].mean() == pytest.approx(0.8, abs=5.0 * 0.8 * spread / np.sqrt(20_000) + 1e-6)


@pytest.mark.parametrize("metal", sorted(METALS))
@pytest.mark.parametrize("cosine", [1.0, 0.5, 0.02])
def test_metals_reflect_by_fresnel(metal, cosine):
    _, weight, _, _ = Material(Conductor(metal=metal)).sample(direction(cosine), unit_interval(1))
    eta, k = (np.array(v) for v in METALS[metal])
    index = eta + 1j * k
    cos_t = np.sqrt(1.0 - (1.0 - cosine**2) / index**2)
    s = (cosine - index * cos_t) / (cosine + index * cos_t)
    p = (index * cosine - cos_t) / (index * cosine + cos_t)
    exact = 0.5 * (np.abs(s) ** 2 + np.abs(p) ** 2)
    np.testing.assert_allclose(weight[:, 0], exact, atol=3e-6)


@pytest.mark.parametrize("gloss", [0.0, 0.4, 0.8])
@pytest.mark.parametrize("metallic", [0.0, 1.0])
def test_the_coat_of_burley_is_its_formula_in_value_and_density(gloss, metallic):
    """GTR with gamma = 1; the lobe's share is so small that no chi-squared test sees a few %."""
    alpha2, matte = (0.1 + gloss * (0.001 - 0.1)) ** 2, 1.0 - metallic
    rng = np.random.default_rng(8)
    # Half vectors of the coat's own density, so that it matters.
    cosine = np.sqrt((1.0 - alpha2 ** rng.random(4000)) / (1.0 - alpha2))
    phi, sine = 2.0 * np.pi * rng.random(4000), np.sqrt(1.0 - cosine**2)
    h = np.array([sine * np.cos(phi), sine * np.sin(phi), cosine]).astype(np.float32)
    wo = np.broadcast_to(direction(0.8), h.shape).astype(float)
    wi = 2.0 * (wo * h).sum(axis=0) * h - wo
    h, wo, wi = (w[:, wi[2] > 0.02].astype(np.float32) for w in (h, wo, wi))
    found = []
    for clearcoat in (1.0, 0.0):
        spec = Burley(metallic=metallic, roughness=0.9, clearcoat=clearcoat, clearcoat_gloss=gloss)
        f_cos, pdf = Material(spec).evaluate(wo, wi)
        found.append((f_cos.astype(float), pdf * (1.0 + 0.25 * clearcoat + matte)))
    value, density = (a - b for a, b in zip(*found, strict=True))
    wo, wi = wo.astype(float), wi.astype(float)
    h = (wo + wi) / np.linalg.norm(wo + wi, axis=0)
    to_h = (wo * h).sum(axis=0)
    d = (alpha2 - 1.0) / (np.pi * np.log(alpha2) * (1.0 + (alpha2 - 1.0) * h[2] ** 2))
    schlick = 0.04 + 0.96 * (1.0 - to_h) ** 5
    g = [2.0 / (1.0 + np.sqrt(1.0 + (0.25 / w[2]) ** 2 * (1.0 - w[2] ** 2))) for w in (wo, wi)]
    np.testing.assert_allclose(4.0 * density, d * h[2] / (4.0 * to_h), rtol=5e-3, atol=1e-4)
    np.testing.assert_allclose(
        value, np.tile(0.25 * schlick * d * g[0] * g[1] * wi[2], (3, 1)), rtol=5e-3, atol=1e-4
    )
