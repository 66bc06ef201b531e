"""Fresnel's equations against their closed forms."""

import numpy as np
import pytest

from alight.core.fresnel import (
    cos_transmitted,
    fresnel_conductor,
    fresnel_dielectric,
    fresnel_schlick,
    refract,
)
from lanewise.vec3 import Vec3
from tests.sampling.statistics import length_error, unit_vectors

f = np.float32


def grey(value):
    return Vec3(*[np.atleast_1d(f(value))] * 3)


def exact_reflectance(cos_i, eta):
    """Reflectance for a complex index of refraction, float64."""
    cos_t = np.sqrt(1.0 - (1.0 - cos_i**2) / eta**2 + 0j)
    s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t)
    p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t)
    return 0.5 * (np.abs(s) ** 2 + np.abs(p) ** 2)


@pytest.mark.parametrize("eta", [1.5, 1.0 / 1.5, 2.4, 1.0003, 0.2])
def test_dielectric_agrees_with_the_complex_form(eta):
    cosines = np.linspace(1e-3, 1.0, 5000).astype(f)
    reflectance, _ = fresnel_dielectric(cosines, f(eta))
    exact = exact_reflectance(cosines.astype(float), float(f(eta)))
    # At the critical angle the reflectance is as steep as a square root.
    critical = np.abs(1.0 - (1.0 - cosines.astype(float) ** 2) / eta**2) < 1e-3
    np.testing.assert_allclose(reflectance[~critical], exact[~critical], atol=2e-5)
    np.testing.assert_allclose(reflectance[critical], exact[critical], atol=1e-2)


@pytest.mark.parametrize("eta", [1.0, 1.0 + 1e-6, 1.0 - 1e-6])
def test_metal_that_is_like_its_surroundings_reflects_nothing_not_less(eta):
    cosines = np.linspace(1e-3, 1.0, 5000).astype(f)
    reflectance = fresnel_conductor(cosines, grey(eta), grey(0.0)).x
    assert np.all(reflectance >= 0.0) and np.all(reflectance[cosines > 0.1] < 1e-6)


@pytest.mark.parametrize("eta", [1.5, 0.75, 2.4])
def test_dielectric_at_normal_incidence(eta):
    reflectance, cos_t = fresnel_dielectric(f(1.0), f(eta))
    assert reflectance == pytest.approx(((eta - 1.0) / (eta + 1.0)) ** 2, rel=2e-6)
    assert cos_t == pytest.approx(1.0, rel=2e-7)


def test_brewsters_angle_reflects_no_p_polarised_light():
    eta = 1.5
    cos_b = 1.0 / np.sqrt(1.0 + eta * eta)
    reflectance, cos_t = fresnel_dielectric(f(cos_b), f(eta))
    # There the refracted ray is at right angles to the reflected one.
    assert cos_t == pytest.approx(np.sqrt(1.0 - cos_b**2), rel=1e-6)
    s = (cos_b - eta * cos_t) / (cos_b + eta * cos_t)
    assert reflectance == pytest.approx(0.5 * s * s, rel=1e-5)


def test_total_internal_reflection_begins_at_the_critical_angle():
    eta = 1.0 / 1.5
    critical = np.sqrt(1.0 - eta * eta)
    beyond, _ = fresnel_dielectric(f([critical - 1e-3, 0.1, 0.0]), f(eta))
    np.testing.assert_array_equal(beyond, 1.0)
    before, _ = fresnel_dielectric(f([critical + 1e-3]), f(eta))
    assert before[0] < 0.9


def test_grazing_light_is_reflected_and_equal_media_reflect_nothing():
    assert fresnel_dielectric(f(0.0), f(1.5))[0] == 1.0
    cosines = np.linspace(1e-3, 1.0, 1000).astype(f)
    np.testing.assert_allclose(fresnel_dielectric(cosines, f(1.0))[0], 0.0, atol=1e-12)


def test_reflectance_is_the_same_from_both_sides():
    cosines = np.linspace(0.05, 1.0, 1000).astype(f)
    there, cos_t = fresnel_dielectric(cosines, f(1.5))
    back, cos_i = fresnel_dielectric(cos_t, f(1.0 / 1.5))
    np.testing.assert_allclose(back, there, atol=2e-5)
    np.testing.assert_allclose(cos_i, cosines, atol=6e-6)


@pytest.mark.parametrize("eta", [1.5, 1.0 / 1.5, 2.4])
def test_refraction_obeys_snell_and_keeps_the_length(eta):
    w = unit_vectors(5000, 1)
    cos_t = cos_transmitted(np.abs(w[2]), f(eta))
    w, cos_t = w[:, cos_t > 0.0], cos_t[cos_t > 0.0]
    t = refract(Vec3(*w), f(eta), cos_t)
    t = np.stack([t.x, t.y, t.z])
    assert length_error(t) < 5e-7
    assert np.all(t[2] * w[2] < 0.0)
    sine_i, sine_t = np.hypot(w[0], w[1]), np.hypot(t[0], t[1])
    np.testing.assert_allclose(sine_t * eta, sine_i, rtol=3e-7, atol=1e-9)
    # In the plane of incidence, on the other side of the normal.
    np.testing.assert_allclose(t[0] * w[1], t[1] * w[0], atol=2e-7)
    assert np.all(t[0] * w[0] <= 0.0)


@pytest.mark.parametrize(("eta", "k"), [(0.2, 3.9), (1.1, 2.1), (1.5, 0.0), (4.4, 5.2), (0.5, 0.0)])
def test_conductor_agrees_with_the_complex_form(eta, k):
    cosines = np.linspace(1e-3, 1.0, 5000).astype(f)
    reflectance = fresnel_conductor(cosines, grey(eta), grey(k)).y
    exact = exact_reflectance(cosines.astype(float), complex(f(eta), f(k)))
    critical = (k == 0.0) & (np.abs(cosines.astype(float) ** 2 - 1.0 + eta**2) < 1e-3)
    np.testing.assert_allclose(reflectance[~critical], exact[~critical], atol=2e-5)


@pytest.mark.parametrize(("eta", "k"), [(0.2, 3.9), (1.5, 0.0)])
def test_conductor_at_normal_incidence(eta, k):
    exact = ((eta - 1.0) ** 2 + k * k) / ((eta + 1.0) ** 2 + k * k)
    assert fresnel_conductor(f([1.0]), grey(eta), grey(k)).x[0] == pytest.approx(exact, rel=2e-6)


def test_conductor_has_a_channel_for_each_colour():
    eta, k = Vec3(f(0.2), f(0.9), f(1.1)), Vec3(f(3.9), f(2.5), f(2.1))
    color = fresnel_conductor(f(0.5), eta, k)
    for seen, n, absorbed in ((color.x, 0.2, 3.9), (color.y, 0.9, 2.5), (color.z, 1.1, 2.1)):
        assert seen == pytest.approx(exact_reflectance(0.5, complex(n, absorbed)), abs=2e-6)


def test_schlick_is_right_at_both_ends_and_near_fresnel_between():
    cosines = np.linspace(0.0, 1.0, 101).astype(f)
    approximation = fresnel_schlick(cosines, f(0.04))
    assert approximation[0] == 1.0
    assert approximation[-1] == f(0.04)
    assert fresnel_schlick(f(0.5), f(0.04)) == pytest.approx(0.04 + 0.96 / 32.0, rel=1e-6)
    np.testing.assert_allclose(approximation, fresnel_dielectric(cosines, f(1.5))[0], atol=0.04)
