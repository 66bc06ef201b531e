"""The principled material against furnaces and formulas, and Oren-Nayar's kin without loss."""

import numpy as np
import pytest

from alight.bsdfs.disney.principled import Principled
from alight.bsdfs.matte.diffuse import Diffuse
from alight.bsdfs.matte.eon import Eon
from alight.bsdfs.microfacets.albedo_rows import MEANS, ROW, Needs, alpha_along, facet_rows
from alight.bsdfs.microfacets.visible_facets import bounce, see_facets
from alight.core.microfacet import Facets
from alight.laws.compiled import N as LANES_OF_LAW
from alight.laws.compiled import scatter
from alight.laws.materials import Material, direction, random_numbers, refracts
from alight.textures.checkerboard import Checkerboard
from lanewise.vec3 import Vec3

N = 30_000
WHITE = {"base_color": 1.0}
FURNACES = {
    "metal": {"metallic": 1.0},
    "plastic": {},
    "glass": {"transmission": 1.0},
    "water": {"transmission": 1.0, "ior": 1.33},
    "sheet": {"transmission": 1.0, "thin": True},
    "dull glass": {"transmission": 1.0, "specular": 0.6},
    "tinted glass": {"transmission": 1.0, "specular_color": (0.9, 0.3, 0.5)},
    "half and half": {"metallic": 0.5, "transmission": 0.5, "thin": True},
    "layers": {"clearcoat": 1.0, "clearcoat_roughness": 0.4, "sheen_color": 0.6},
    "film": {"iridescence": 1.0},
}
ROUGHNESSES = (0.1, 0.35, 0.65, 1.0)


def power(spec, cosine, seed=3, azimuth=0.0):
    """(mean, standard error) of the part of the light from wo that leaves again, in green."""
    material = Material(spec)
    wo = direction(cosine, azimuth=azimuth)
    _, weight, _, flags = material.sample(wo, random_numbers(N, seed))
    leaving = weight[1] * material.radiance_scale(cosine, refracts(flags))
    return float(leaving.mean()), float(leaving.std() / np.sqrt(N))


@pytest.mark.parametrize("name", FURNACES)
@pytest.mark.parametrize("roughness", ROUGHNESSES)
def test_white_loses_less_than_one_percent_and_gains_nothing(name, roughness):
    spec = Principled(**WHITE, roughness=roughness, **FURNACES[name])
    for cosine in (0.9, 0.3, -0.6) if spec.transmissive else (0.9, 0.3, 0.1):
        mean, error = power(spec, cosine)
        assert abs(mean - 1.0) < 0.004 + 3.5 * min(error, 0.0015), (cosine, mean, error)


def test_glass_beside_leaves_matte_materials_as_they_are():
    """Programs with glass work out its scale for all: what lets nothing pass must not divide."""
    glass, matte = Principled(transmission=1.0), Principled(specular=0.0, roughness=1.0)
    alone, ids = scatter([matte], np.zeros(LANES_OF_LAW, np.uint32), False), np.ones(LANES_OF_LAW)
    beside = scatter([glass, matte], ids.astype(np.uint32), False)
    assert np.isfinite(beside).all()
    # Values and densities; a direction that gives nothing may be another one.
    np.testing.assert_allclose(beside[7:10], alone[7:10], rtol=1e-4, atol=1e-5)


def test_textured_roughness_is_compensated_too():
    for value in (0.13, 0.77):
        texture = Checkerboard(color0=value, color1=value)
        mean, error = power(Principled(**WHITE, metallic=1.0, roughness=texture), 0.5)
        assert abs(mean - 1.0) < 0.004 + 3.5 * error


def test_without_compensation_rough_metal_is_a_third_too_dark():
    mean, _ = power(Principled(**WHITE, metallic=1.0, roughness=1.0, compensation=False), 0.9)
    assert 0.3 < mean < 0.45


BRUSHED = {
    "metal": {"metallic": 1.0, "anisotropy": 0.6},
    "smooth metal": {"metallic": 1.0, "anisotropy": 1.0, "roughness": 0.1},
    "plastic": {"anisotropy": 0.6},
    "glass": {"transmission": 1.0, "anisotropy": 0.6},
    "film": {"iridescence": 1.0, "anisotropy": 0.6},
    "textured metal": {"metallic": 1.0, "anisotropy": Checkerboard(color0=0.55, color1=0.55)},
}


@pytest.mark.parametrize("name", BRUSHED)
def test_what_is_brushed_loses_nothing_from_any_side(name):
    spec = Principled(**(WHITE | BRUSHED[name]))
    # The rougher direction is that of azimuth 0.
    for azimuth in (0.0, 0.9, 1.5):
        for cosine in (0.9, 0.3, -0.6) if spec.transmissive else (0.9, 0.3, 0.1):
            mean, error = power(spec, cosine, azimuth=azimuth)
            assert abs(mean - 1.0) < 0.006 + 3.5 * min(error, 0.0015), (azimuth, cosine, mean)


@pytest.mark.parametrize(
    ("strength", "most"), [(1.0, 0.004), (Checkerboard(color0=1.0, color1=1.0), 0.008)]
)
def test_grazing_light_across_the_brush_loses_nothing(strength, most):
    """There the albedo changes within a few degrees of azimuth; textured, rows are fewer."""
    spec = Principled(**WHITE, metallic=1.0, roughness=0.2, anisotropy=strength)
    wo = direction(0.05, azimuth=1.55)
    _, weight, _, _ = Material(spec).sample(wo, random_numbers(400_000, 3))
    assert abs(weight[1].mean() - 1.0) < most + 3.5 * weight[1].std() / np.sqrt(400_000)


def test_means_of_brushed_facets_are_those_over_all_azimuths():
    needs = Needs(2.0)
    row = facet_rows(0.5, 0.9, needs).rows[:ROW]
    alpha = 0.25
    facets = Facets(alpha_along(alpha, 0.9), alpha, 0.0)
    mu, weights = np.polynomial.legendre.leggauss(24)
    mu, weights = 0.5 * (mu + 1.0), 0.5 * weights
    azimuths = (np.arange(16) + 0.5) * (np.pi / 32)
    found = [bounce(see_facets(facets, mu, float(phi)), 2.0) for phi in azimuths]
    mean = np.mean([2.0 * np.sum(weights * mu * one.reflected) for one in found])
    assert row[MEANS + 1] == pytest.approx(mean, abs=5e-4)


def test_film_gives_back_in_each_color_what_it_does_not_reflect():
    spec = Principled(**WHITE, iridescence=1.0, iridescence_ior=1.8, roughness=0.6)
    material = Material(spec)
    for cosine in (0.9, 0.2):
        _, weight, _, _ = material.sample(direction(cosine), random_numbers(N, 3))
        np.testing.assert_allclose(weight.mean(1), 1.0, atol=0.008)


def test_metal_is_ggx_with_alpha_roughness_squared():
    color, alpha = np.array([0.9, 0.5, 0.1]), 0.36
    wo, wi = direction(0.7), direction(0.4, azimuth=2.0)
    found, _ = Material(
        Principled(base_color=tuple(color), metallic=1.0, roughness=0.6, compensation=False)
    ).evaluate(wo, wi)
    h = wo[:, 0] + wi[:, 0]
    h /= np.linalg.norm(h)
    d = alpha**2 / (np.pi * (h[2] ** 2 * (alpha**2 - 1.0) + 1.0) ** 2)
    tan2 = lambda c: 1.0 / c**2 - 1.0  # noqa: E731
    g = [2.0 / (1.0 + np.sqrt(1.0 + alpha**2 * tan2(c))) for c in (0.7, 0.4)]
    f = color + (1.0 - color) * (1.0 - float(h @ wo[:, 0])) ** 5
    np.testing.assert_allclose(found[:, 0], f * d * g[0] * g[1] / (4.0 * 0.7), rtol=1e-4)


def test_parts_that_are_off_change_nothing():
    plain = Principled(base_color=(0.9, 0.5, 0.1), roughness=0.4)
    wo, wi = direction(0.6), direction(0.3, azimuth=2.5)
    value, _ = Material(plain).evaluate(wo, wi)
    for change in (
        {"clearcoat": Checkerboard(color0=0.0, color1=0.0)},
        {"iridescence": Checkerboard(color0=0.0, color1=0.0)},
        {"transmission": Checkerboard(color0=0.0, color1=0.0)},
        {"anisotropy": Checkerboard(color0=0.0, color1=0.0)},
    ):
        other, _ = Material(plain.replaced(**change)).evaluate(wo, wi)
        # Rows between which the roughness is interpolated are 1e-3 apart.
        np.testing.assert_allclose(other, value, rtol=2e-3, err_msg=str(change))


EVERYTHING = {
    "base_color": 0.7, "metallic": 0.3, "roughness": 0.5, "specular": 0.7, "specular_color": 0.6,
    "anisotropy": 0.5, "anisotropy_rotation": 0.3, "transmission": 0.4, "clearcoat": 0.6,
    "clearcoat_roughness": 0.4, "sheen_color": 0.5, "sheen_roughness": 0.5, "iridescence": 0.5,
    "iridescence_thickness": 0.9,
}  # fmt: skip


@pytest.mark.parametrize("name", EVERYTHING)
def test_each_parameter_alone_may_be_textured(name):
    """Programs in which no material has a texture there only read the number."""
    value = EVERYTHING[name]
    textured = Principled(**(EVERYTHING | {name: Checkerboard(color0=value, color1=value)}))
    wo, wi = direction(0.6), direction(0.3, azimuth=2.5)
    found, _ = Material(textured).evaluate(wo, wi)
    expected, _ = Material(Principled(**EVERYTHING)).evaluate(wo, wi)
    # Rows between which roughnesses are interpolated are 1e-3 apart.
    np.testing.assert_allclose(found, expected, rtol=2e-3)


def test_film_is_the_sum_of_all_wavelengths():
    """Belcour and Barla's sum against Airy's formula, over Gaussians of the eye's response."""
    from alight.bsdfs.disney.thin_film import film_fresnel

    f = np.float32
    for cosine in (1.0, 0.6):
        for thickness in (250.0, 600.0):
            f0 = Vec3(f(0.2), f(0.2), f(0.2))
            found = film_fresnel(f(cosine), f(1.4), f(thickness), f0)
            airy = _airy(cosine, 1.4, (1.0 + 0.2**0.5) / (1.0 - 0.2**0.5), thickness)
            # The sum ends with the second order.
            np.testing.assert_allclose([found.x, found.y, found.z], airy, atol=0.03)


@pytest.mark.parametrize("cosine", [1.0, 0.5, 0.1])
@pytest.mark.parametrize("film", [1.33, 2.0])
def test_of_a_thick_film_intensities_add_up_channel_by_channel(cosine, film):
    """Its fringes are finer than the eye's response: the geometric series of a glass plate."""
    from alight.bsdfs.disney.thin_film import film_fresnel

    f0 = np.array([0.9, 0.5, 0.04])
    found = film_fresnel(*np.float32((cosine, film, 2e5)), Vec3(*f0.astype(np.float32)))
    base = (1.0 + np.sqrt(f0)) / (1.0 - np.sqrt(f0))
    cos2 = np.sqrt(1.0 - (1.0 - cosine**2) / film**2)
    r12, r0 = _unpolarised(cosine, cos2, film), ((base - film) / (base + film)) ** 2
    r23 = r0 + (1.0 - r0) * (1.0 - cos2) ** 5
    expected = r12 + (1.0 - r12) ** 2 * r23 / (1.0 - r12 * r23)
    np.testing.assert_allclose([found.x, found.y, found.z], expected, rtol=1e-4)


def _airy(cosine, film, base, thickness):
    """Linear sRGB of the unpolarised Airy reflectance."""
    k = np.linspace(1.0e6, 3.2e6, 4000)  # wave numbers, 1/m
    cos2 = np.sqrt(1.0 - (1.0 - cosine**2) / film**2)
    r12 = _unpolarised(cosine, cos2, film)
    r0 = ((base - film) / (base + film)) ** 2
    r23 = r0 + (1.0 - r0) * (1.0 - cos2) ** 5
    turn = 2.0 * np.pi * 2.0 * film * thickness * 1e-9 * cos2 * k + np.pi * (base < film)
    both = np.sqrt(r12 * r23)
    total = (r12 + r23 + 2.0 * both * np.cos(turn)) / (1.0 + r12 * r23 + 2.0 * both * np.cos(turn))
    lobes = (
        ((0.84659, 1.6810e6, 4.3278e9), (0.15387, 2.2399e6, 4.5282e9)),
        ((1.00022, 1.7953e6, 9.3046e9),),
        ((1.00112, 2.2084e6, 6.6121e9),),
    )
    xyz = []
    for parts in lobes:
        # What the kernel has is the transform of these.
        response = sum(
            a * np.exp(-((k - k0) ** 2) / (4.0 * w)) / np.sqrt(4.0 * np.pi * w)
            for a, k0, w in parts
        )
        xyz.append(np.sum(response * total) * (k[1] - k[0]))
    to_rgb = np.array(
        [
            [3.2404542, -1.5371385, -0.4985314],
            [-0.9692660, 1.8760108, 0.0415560],
            [0.0556434, -0.2040259, 1.0572252],
        ]
    )
    return to_rgb @ np.array(xyz)


def _unpolarised(cos1, cos2, eta):
    s = (cos1 - eta * cos2) / (cos1 + eta * cos2)
    p = (eta * cos1 - cos2) / (eta * cos1 + cos2)
    return 0.5 * (s * s + p * p)


# ---------------------------------------------------------------- EON


def test_eon_without_grooves_is_lambert():
    wo, wi = direction(0.3), direction(0.8, azimuth=2.0)
    smooth, _ = Material(Eon(reflectance=0.7, roughness=0.0)).evaluate(wo, wi)
    lambert, _ = Material(Diffuse(reflectance=0.7)).evaluate(wo, wi)
    np.testing.assert_allclose(smooth, lambert, rtol=1e-6)


@pytest.mark.parametrize("roughness", [0.1, 0.5, 1.0])
def test_eon_loses_nothing(roughness):
    for cosine in (1.0, 0.5, 0.1):
        mean, error = power(Eon(reflectance=1.0, roughness=roughness), cosine)
        assert abs(mean - 1.0) < 4.0 * error + 1e-6


def seen_from_above(**fields):
    """f cos of what is black inside, looked at and lit along the normal."""
    spec = Principled(base_color=0.0, roughness=0.4, **fields)
    return Material(spec).evaluate(direction(1.0), direction(1.0))[0][:, 0].astype(float)


def test_plastic_is_tinted_channel_by_channel():
    tint = np.array([1.0, 0.6, 0.2])
    found = seen_from_above(specular_color=tuple(tint))
    np.testing.assert_allclose(found, tint * seen_from_above(), rtol=1e-4)
    # A film that is too thin to interfere shows what is below it.
    film = {"iridescence": 1.0, "iridescence_thickness": 0.0}
    np.testing.assert_allclose(seen_from_above(**film), seen_from_above(), rtol=1e-2)
    strong = seen_from_above(ior=2.5, specular_color=(1.0, 0.5, 0.25))
    np.testing.assert_allclose(strong / strong[0], [1.0, 0.5, 0.25], rtol=1e-4)
