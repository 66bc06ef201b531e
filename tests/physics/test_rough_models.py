"""Rough metal and glass, panes and Oren-Nayar against their published formulas, in float64."""

import numpy as np
import pytest
from scipy.special import erf

from alight.bsdfs.conductors.conductor import METALS, Conductor
from alight.bsdfs.conductors.rough_conductor import RoughConductor
from alight.bsdfs.dielectrics.dielectric import Dielectric
from alight.bsdfs.dielectrics.rough_dielectric import RoughDielectric
from alight.bsdfs.dielectrics.thin_dielectric import ThinDielectric
from alight.bsdfs.flags import NULL, REFLECTION, TRANSMISSION
from alight.bsdfs.matte.oren_nayar import OrenNayar
from alight.core.errors import SceneError
from tests.sampling.materials import Material, direction, random_numbers, unit_interval
from tests.sampling.statistics import unit_vectors, z_of_mean

N = 20_000

GLASS = {"int_ior": 1.5, "ext_ior": 1.0}
SHAPES = [
    pytest.param({"distribution": "ggx", "alpha": 0.2}, id="ggx"),
    pytest.param({"distribution": "beckmann", "alpha": 0.4}, id="beckmann"),
    pytest.param({"distribution": "ggx", "alpha_u": 0.1, "alpha_v": 0.6}, id="anisotropic"),
    pytest.param({"distribution": "beckmann", "alpha_u": 0.7, "alpha_v": 0.2}, id="anisotropic b"),
]
each_shape = pytest.mark.parametrize("shape", SHAPES)


# ---------------------------------------------------------------- Walter et al. 2007, by the letter


def normal_density(spec, m):
    """D, equations 25 and 33, anisotropic."""
    ax, ay = spec.roughness
    tan2 = ((m[0] / ax) ** 2 + (m[1] / ay) ** 2) / m[2] ** 2
    scale = np.pi * ax * ay * m[2] ** 4
    d = (
        np.exp(-tan2) / scale
        if spec.distribution == "beckmann"
        else 1.0 / (scale * (1 + tan2) ** 2)
    )
    return np.where(m[2] > 0.0, d, 0.0)


def masking(spec, w, m):
    """G1, equations 26 and 34; 0 for facets that turn their back."""
    ax, ay = spec.roughness
    a = np.abs(w[2]) / np.maximum(np.hypot(ax * w[0], ay * w[1]), 1e-12)
    if spec.distribution == "beckmann":
        g = 2.0 / (1.0 + erf(a) + np.exp(-a * a) / (a * np.sqrt(np.pi)))
    else:
        g = 2.0 / (1.0 + np.sqrt(1.0 + 1.0 / a**2))
    return np.where(dot(w, m) * w[2] > 0.0, g, 0.0)


def dot(a, b):
    return np.sum(a * b, axis=0)


def fresnel(cos_i, eta):
    """Reflectance by the complex form."""
    cos_t = np.sqrt(1.0 - (1.0 - cos_i**2) / eta**2 + 0j)
    s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t)
    p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t)
    return 0.5 * (np.abs(s) ** 2 + np.abs(p) ** 2)


def walter(spec, wo, wi, index):
    """f cos theta_i for directions (3, n); `index` is complex, or real and then refracts."""
    eta = np.where(wo[2] > 0.0, index, 1.0 / index)
    reflects = wo[2] * wi[2] > 0.0
    m = np.where(reflects, wo + wi, wo + eta.real * wi)
    m = m / np.linalg.norm(m, axis=0)
    m = m * np.sign(m[2])
    co, ci = dot(wo, m), dot(wi, m)
    reflectance = fresnel(np.abs(co), eta)
    shared = normal_density(spec, m) * masking(spec, wo, m) * masking(spec, wi, m)
    shared = shared / np.abs(wo[2])
    # Equation 20, and equation 21 over eta^2: radiance; with cos theta_i.
    reflected = reflectance * shared / 4.0
    refracted = (1.0 - reflectance) * shared * np.abs(co * ci) / (co + eta.real * ci) ** 2
    legal = np.where(reflects, co * ci > 0.0, co * ci < 0.0)
    return np.where(legal, np.where(reflects, reflected, refracted), 0.0)


def pairs():
    """Directions of both hemispheres, near neither the horizon nor a grazing facet."""
    wo, wi = unit_vectors(4 * N, 1), unit_vectors(4 * N, 2)
    keep = (np.abs(wo[2]) > 0.05) & (np.abs(wi[2]) > 0.05)
    return wo[:, keep], wi[:, keep]


@each_shape
def test_rough_metal_is_walters_formula(shape):
    spec = RoughConductor(eta=(0.2, 1.5, 4.0), k=(3.9, 0.5, 2.2), **shape)
    wo, wi = pairs()
    wo[2], wi[2] = np.abs(wo[2]), np.abs(wi[2])
    f_cos, _ = Material(spec).evaluate(wo, wi)
    for channel, index in enumerate((0.2 + 3.9j, 1.5 + 0.5j, 4.0 + 2.2j)):
        expected = walter(spec, wo.astype(float), wi.astype(float), index)
        np.testing.assert_allclose(f_cos[channel], expected, rtol=4e-5, atol=1e-7)


@each_shape
def test_rough_glass_is_walters_formula(shape):
    spec = RoughDielectric(**GLASS, **shape)
    wo, wi = pairs()
    f_cos, _ = Material(spec).evaluate(wo, wi)
    expected = walter(spec, wo.astype(float), wi.astype(float), 1.5)
    assert np.count_nonzero(expected[wo[2] * wi[2] < 0.0]) > N // 4
    # The root of Snell's law near total reflection takes rounding errors to the power 1/2.
    error = np.abs(f_cos[0] - expected)
    assert np.quantile(error - 1e-4 * expected, 0.999) < 1e-6
    assert error.max() < 2e-3 * expected.max()


@each_shape
def test_rough_glass_is_reciprocal_through_the_interface(shape):
    # f(wo, wi) / eta_o^2 = f(wi, wo) / eta_i^2, with the index on the side of each.
    material = Material(RoughDielectric(**GLASS, **shape))
    wo, wi = pairs()
    there = material.evaluate(wo, wi)[0][0] / np.abs(wi[2])
    back = material.evaluate(wi, wo)[0][0] / np.abs(wo[2])
    there = there * np.where(wo[2] > 0.0, 1.0, 1.5**-2)
    back = back * np.where(wi[2] > 0.0, 1.0, 1.5**-2)
    assert np.quantile(np.abs(there - back) - 2e-4 * there, 0.999) < 1e-6


# ---------------------------------------------------------------- energy, and narrow lobes


def power(material, wo, eta, u):
    """Power that leaves again, of the light along wo: refracted radiance times eta^2."""
    _, weight, pdf, flags = material.sample(wo, u)
    return weight[0] * np.where(flags & TRANSMISSION, eta * eta, 1.0) * (pdf > 0.0)


@pytest.mark.parametrize("distribution", ["ggx", "beckmann"])
@pytest.mark.parametrize("cosine", [1.0, 0.6, -0.9, -0.4])
def test_glass_loses_only_what_meets_two_facets(distribution, cosine):
    eta = 1.5 if cosine > 0.0 else 1.0 / 1.5
    powers = []
    for alpha in (1e-3, 0.1, 0.4, 0.9):
        material = Material(RoughDielectric(**GLASS, distribution=distribution, alpha=alpha))
        powers.append(power(material, direction(cosine), eta, random_numbers(N, 3)).mean())
    # Smooth glass loses nothing, and rougher glass loses more.
    assert powers[0] == pytest.approx(1.0, abs=2e-4)
    assert np.all(np.diff(powers) < 1e-4)
    assert powers[-1] > 0.4


@pytest.mark.parametrize("distribution", ["ggx", "beckmann"])
@pytest.mark.parametrize("cosine", [0.9, 0.3, -0.9])
def test_almost_smooth_glass_is_smooth_glass(distribution, cosine):
    rough = Material(RoughDielectric(**GLASS, distribution=distribution, alpha=1e-3))
    smooth = Material(Dielectric(**GLASS))
    u = unit_interval(N)
    wi, weight, pdf, flags = rough.sample(direction(cosine), u)
    exact, expected, _, lobes = smooth.sample(direction(cosine), u)
    same = (flags & (REFLECTION | TRANSMISSION)) == (lobes & (REFLECTION | TRANSMISSION))
    assert same.mean() > 0.998
    assert np.quantile(np.linalg.norm(wi - exact, axis=0)[same], 0.9) < 0.02
    np.testing.assert_allclose(
        weight[:, same & (pdf > 0.0)], expected[:, same & (pdf > 0.0)], rtol=2e-2
    )
    assert np.median(weight[0, same] / expected[0, same]) == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize("alpha", [1e-4, 1e-3, 1e-2])
@pytest.mark.parametrize("distribution", ["ggx", "beckmann"])
def test_narrow_lobes_keep_their_density(distribution, alpha):
    spec = RoughConductor(distribution=distribution, alpha=alpha)
    material, wo = Material(spec), direction(0.6)
    wi, weight, pdf, _ = material.sample(wo, random_numbers(N, 4))
    expected = walter(
        spec, wo.astype(float), wi.astype(float), complex(*(c[0] for c in METALS["gold"]))
    )
    # A direction is known to 1e-7 or so, and the lobe's sides are as steep as 1 / alpha.
    ok = pdf > 0.0
    assert ok.mean() > 0.999
    ratio = (weight * pdf)[0, ok] / expected[ok]
    assert np.quantile(np.abs(ratio - 1.0), 0.99) < 2e-6 + 3e-6 / alpha
    assert abs(ratio.mean() - 1.0) < 2e-6 + 3e-7 / alpha


@pytest.mark.parametrize("spec", [
    RoughConductor(alpha=1e-4), RoughConductor(distribution="beckmann", alpha=1e-4),
    RoughDielectric(alpha=1e-4), RoughDielectric(distribution="beckmann", alpha=1e-4),
    RoughDielectric(int_ior=1.002, ext_ior=1.0, alpha=1.0),
    RoughConductor(alpha_u=1e-4, alpha_v=1.0),
], ids=lambda spec: f"{spec.type} {spec.distribution} {spec.roughness}")  # fmt: skip
def test_extremes_give_numbers(spec):
    material = Material(spec)
    for cosine in (1.0, 0.5, 1e-4, 1e-7, 0.0, -1e-7, -1e-4, -0.5, -1.0):
        wi, weight, pdf, _ = material.sample(direction(cosine), random_numbers(4096, 5))
        f_cos, density = material.evaluate(direction(cosine), wi)
        for values in (wi, weight, pdf, f_cos, density):
            assert np.all(np.isfinite(values))
        # No weight above 1 but for what is gained by entering the thinner side.
        assert weight.max() <= 1.0001 * max(1.0, getattr(spec, "int_ior", 1.0) ** 2)
        np.testing.assert_allclose(np.linalg.norm(wi, axis=0), 1.0, atol=1e-6)


# ---------------------------------------------------------------- panes, grooves, tints


@pytest.mark.parametrize("cosine", [1.0, 0.4, 0.05, -0.4])
def test_panes_add_up_all_inner_reflections(cosine):
    r = fresnel(abs(float(direction(cosine)[2, 0])), 1.5 + 0j)
    # Out at once, or in, some reflections inside, and out: at either face.
    inside = (1.0 - r) ** 2 * r ** np.arange(200)
    back, through = r + inside[1::2].sum(), inside[0::2].sum()
    wi, weight, pdf, flags = Material(ThinDielectric(**GLASS)).sample(
        direction(cosine), unit_interval(N)
    )
    passes = flags & TRANSMISSION != 0
    assert not (flags & NULL).any()
    assert pdf[~passes][0] == pytest.approx(back, rel=2e-5)
    assert pdf[passes][0] == pytest.approx(through, rel=2e-5)
    np.testing.assert_array_equal(wi[:, passes], -direction(cosine) + 0.0 * wi[:, passes])
    np.testing.assert_array_equal(weight, 1.0)


@pytest.mark.parametrize("sigma", [0.0, 10.0, 20.0, 45.0, 90.0])
def test_oren_nayar_is_its_formula_by_angles(sigma):
    squared = np.radians(sigma) ** 2
    a, b = 1.0 - 0.5 * squared / (squared + 0.33), 0.45 * squared / (squared + 0.09)
    if sigma == 10.0:
        assert a + b / 2 == pytest.approx(1.01464, abs=1e-5)
        a, b = a / 1.0146430561597821, b / 1.0146430561597821
    theta, phi = np.meshgrid(
        (np.arange(400) + 0.5) / 400 * np.pi / 2, (np.arange(800) + 0.5) / 400 * np.pi
    )
    wi = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    material = Material(OrenNayar(reflectance=(0.9, 0.5, 0.2), sigma=sigma))
    for cosine in (0.9, 0.3):
        wo = direction(cosine)
        alpha, beta = np.maximum(theta, np.arccos(cosine)), np.minimum(theta, np.arccos(cosine))
        along = np.maximum(0.0, np.cos(phi - 0.6)) * np.sin(alpha) * np.tan(beta)
        f = (a + b * along) / np.pi
        f_cos, _ = material.evaluate(wo, wi.reshape(3, -1))
        np.testing.assert_allclose(
            f_cos[1], (0.5 * f * np.cos(theta)).ravel(), rtol=1e-4, atol=1e-7
        )
        # Its quadrature is the mean of the weights.
        cell = (np.pi / 800) * (2.0 * np.pi / 800)
        albedo = 0.5 * np.sum(f * np.cos(theta) * np.sin(theta)) * cell
        weight = material.sample(wo, random_numbers(N, 6))[1][1].astype(float)
        assert abs(z_of_mean(weight, albedo, 1e-5)) < 4.5


def test_tints_scale_what_is_reflected_and_what_passes():
    colors = {"specular_reflectance": (0.9, 0.6, 0.2), "specular_transmittance": (0.3, 1.0, 0.8)}
    u, wo = unit_interval(N), direction(0.4)
    for kind, shape in ((Dielectric, {}), (ThinDielectric, {}), (RoughDielectric, {"alpha": 0.3})):
        plain = Material(kind(**shape)).sample(wo, u)
        tinted = Material(kind(**shape, **colors)).sample(wo, u)
        passes = plain[3] & TRANSMISSION != 0
        factor = np.where(
            passes, np.float32([[0.3], [1.0], [0.8]]), np.float32([[0.9], [0.6], [0.2]])
        )
        np.testing.assert_allclose(tinted[1], plain[1] * factor, rtol=3e-7)
    for kind in (Conductor, RoughConductor):
        plain = Material(kind()).sample(wo, u)
        tinted = Material(kind(specular_reflectance=(0.9, 0.6, 0.2))).sample(wo, u)
        np.testing.assert_allclose(
            tinted[1], plain[1] * np.float32([[0.9], [0.6], [0.2]]), rtol=3e-7
        )


@pytest.mark.parametrize(("make", "message"), [
    (lambda: RoughConductor(alpha=0.0), r"in \[0.0001, 1\], got 0"),
    (lambda: RoughConductor(alpha_u=0.2), "alpha_u and alpha_v together, got only one"),
    (lambda: RoughDielectric(alpha=0.1, alpha_u=0.2, alpha_v=0.3), "either alpha or alpha_u"),
    (lambda: RoughDielectric(distribution="ggxx"), 'did you mean "ggx"'),
    (lambda: RoughDielectric(int_ior=1.5, ext_ior=1.5), r"must differ by at least 0.1 %, got 1.5"),
    (lambda: RoughConductor(metal="gould"), 'did you mean "gold"'),
])  # fmt: skip
def test_messages(make, message):
    with pytest.raises(SceneError, match=message):
        make()
