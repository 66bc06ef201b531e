"""BSDFs whose light goes in single directions: which ones, how likely, with what weight."""

import numpy as np
import pytest

from alight.bsdfs.conductors.conductor import Conductor
from alight.bsdfs.conductors.mirror import Mirror
from alight.bsdfs.dielectrics.dielectric import Dielectric
from alight.bsdfs.dielectrics.null import Null
from alight.bsdfs.flags import DELTA, NULL, REFLECTION, TRANSMISSION
from tests.sampling.materials import Material, direction, unit_interval

N = 4096


def lobes(material, wo):
    """One entry a lobe: (wi, weight, pmf, flags, share of u that chooses it)."""
    wi, weight, pdf, flags = material.sample(wo, unit_interval(N))
    found = []
    chosen = (pdf > 0.0) & (flags & DELTA != 0)
    for kind in np.unique(flags[chosen]):
        here = (flags == kind) & chosen
        assert np.ptp(wi[:, here], axis=1).max() == 0.0, "a lobe has one direction"
        i = np.argmax(here)
        found.append((wi[:, i], weight[:, i], pdf[i], int(kind), here.mean()))
    return found


@pytest.mark.parametrize("cosine", [1.0, 0.5, 0.02])
@pytest.mark.parametrize("spec", [Mirror(reflectance=(0.9, 0.6, 0.2)), Conductor()])
def test_mirrors_send_light_to_the_mirrored_direction(spec, cosine):
    wo = direction(cosine)[:, 0]
    ((wi, _, pmf, flags, _),) = lobes(Material(spec), direction(cosine))
    assert flags == REFLECTION | DELTA and pmf == 1.0
    np.testing.assert_array_equal(wi, [-wo[0], -wo[1], wo[2]])


def test_mirror_weighs_by_its_reflectance():
    ((_, weight, *_),) = lobes(Material(Mirror(reflectance=(0.9, 0.6, 0.2))), direction(0.3))
    np.testing.assert_array_equal(weight, np.float32([0.9, 0.6, 0.2]))


def test_null_passes_straight_on():
    wo = direction(-0.5)
    ((wi, weight, pmf, flags, _),) = lobes(Material(Null()), wo)
    assert flags == TRANSMISSION | DELTA | NULL and pmf == 1.0
    np.testing.assert_array_equal(wi, -wo[:, 0])
    np.testing.assert_array_equal(weight, 1.0)


@pytest.mark.parametrize("cosine", [1.0, 0.5, 0.02, -0.02, -0.9])
@pytest.mark.parametrize("ior", [1.5, 1.0 / 1.5, 2.4])
def test_glass_refracts_by_snell_and_scales_radiance(ior, cosine):
    spec = Dielectric(int_ior=1.5 * max(1.0, ior), ext_ior=1.5 * max(1.0, 1.0 / ior))
    wo = direction(cosine)[:, 0].astype(float)
    eta = ior if cosine > 0.0 else 1.0 / ior
    found = {lobe[3]: lobe for lobe in lobes(Material(spec), direction(cosine))}
    sine = np.hypot(wo[0], wo[1]) / eta
    if sine >= 1.0:
        assert set(found) == {REFLECTION | DELTA}, "total internal reflection"
        return
    wi, weight, pmf, _, _ = found[TRANSMISSION | DELTA]
    cos_t = np.sqrt(1.0 - sine * sine)
    expected = [-wo[0] / eta, -wo[1] / eta, -np.copysign(cos_t, cosine)]
    np.testing.assert_allclose(wi, expected, atol=3e-7)
    # Radiance: the same power leaves within a solid angle that is eta^2 times as large.
    np.testing.assert_allclose(weight, 1.0 / eta**2, rtol=1e-6)
    c = abs(wo[2])
    s, p = (c - eta * cos_t) / (c + eta * cos_t), (eta * c - cos_t) / (eta * c + cos_t)
    assert 1.0 - pmf == pytest.approx(0.5 * (s * s + p * p), abs=1e-6)


def test_equal_indices_let_everything_through():
    for cosine in (1.0, 0.3, 1e-3, -1e-3):
        ((wi, weight, pmf, flags, _),) = lobes(
            Material(Dielectric(int_ior=1.0, ext_ior=1.0)), direction(cosine)
        )
        assert flags == TRANSMISSION | DELTA and pmf == pytest.approx(1.0, abs=1e-6)
        np.testing.assert_allclose(wi, -direction(cosine)[:, 0], atol=1e-7)
        np.testing.assert_array_equal(weight, 1.0)
