"""Metal and matte bases under a coat against random walks between the layers, and formulas."""

import numpy as np
import pytest

from alight.bsdfs.conductors.coated_conductor import CoatedConductor, layers_of
from alight.bsdfs.microfacets.albedo_rows import LEAST_ALPHA, STEPS
from alight.bsdfs.microfacets.layered import _shared, albedos
from alight.bsdfs.plastics.plastic import Plastic
from alight.bsdfs.plastics.rough_plastic import RoughPlastic
from alight.formats.pbrt.walks import Coat, base_of_walk
from alight.laws.materials import Material, direction, random_numbers
from tests.physics.layered_walk import Lambert, Metal, fresnel, fresnel_of_metal, walks

COSINES = (0.95, 0.6, 0.3, 0.1)
COATED = {
    "smooth": CoatedConductor(alpha=0.001, int_ior=1.5, ext_ior=1.0),
    "smooth coat": CoatedConductor(alpha=0.3, int_ior=1.5, ext_ior=1.0),
    "smooth metal": CoatedConductor(alpha=0.001, coat_alpha=0.3, metal="copper"),
    "satin": CoatedConductor(alpha=0.05, coat_alpha=0.03, thickness=0.01, bounces=5),
    "rough": CoatedConductor(alpha=0.5, coat_alpha=0.1, metal="silver", int_ior="water"),
    "very rough": CoatedConductor(alpha=0.8, coat_alpha=0.8, int_ior="diamond", thickness=0.2),
}


def walks_of(layers, cosine):
    """Walks between the layers; the least roughness counts as none."""
    coat, metal = (a if a > LEAST_ALPHA else 0.0 for a in (layers.coat_alpha, layers.alpha))
    base = Metal(metal, layers.eta, layers.k)
    return walks(cosine, layers.coat_eta, coat, base, layers.thickness, layers.bounces)


def base_of(layers):
    """The metal of formulas."""
    return Metal(layers.alpha, layers.eta, layers.k)


def tabulated(spec, cosine):
    """Albedo (3,) by the table."""
    found = albedos(layers_of(spec))
    at = (STEPS - 1) * cosine**0.25
    return np.array([np.interp(at, np.arange(STEPS), found.coat + one) for one in found.metal])


@pytest.mark.parametrize("name", COATED)
def test_albedo_is_that_of_walks_between_the_layers(name):
    layers = layers_of(COATED[name])
    for cosine in COSINES:
        power = walks_of(layers, cosine).power
        error = power.std(1) / np.sqrt(power.shape[1])
        difference = tabulated(COATED[name], cosine) - power.mean(1)
        assert (np.abs(difference) < 0.002 + 3.5 * error).all(), (cosine, difference, error)


@pytest.mark.parametrize("name", COATED)
def test_the_lobe_has_the_albedo_of_the_table(name):
    material = Material(COATED[name])
    for cosine in COSINES:
        _, weight, _, _ = material.sample(direction(cosine), random_numbers(30_000, 3))
        error = weight.std(1) / np.sqrt(30_000)
        difference = weight.mean(1) - tabulated(COATED[name], cosine)
        assert (np.abs(difference) < 0.002 + 3.5 * error).all(), (cosine, difference, error)


def test_smooth_layers_are_a_geometric_series():
    layers = layers_of(COATED["smooth"])
    for cosine in (1.0, 0.6, 0.2):
        r, inside = fresnel(np.array([cosine]), layers.coat_eta)
        m = fresnel_of_metal(inside, base_of(layers))[:, 0]
        expected = r + (1.0 - r) ** 2 * m / (1.0 - r * m)
        np.testing.assert_allclose(tabulated(COATED["smooth"], cosine), expected, atol=0.0015)


def test_one_bounce_through_a_grey_coat_is_a_product():
    spec = COATED["smooth"].replaced(thickness=0.3, bounces=1)
    layers = layers_of(spec)
    r, inside = fresnel(np.array([0.6]), layers.coat_eta)
    m = fresnel_of_metal(inside, base_of(layers))[:, 0]
    expected = r + (1.0 - r) ** 2 * m * np.exp(-2.0 * 0.3 / inside)
    np.testing.assert_allclose(tabulated(spec, 0.6), expected, atol=0.0015)


BLACK = {
    "no light gets to the metal": CoatedConductor(alpha=0.3, thickness=1000.0),
    "hardly any gets there": CoatedConductor(alpha=0.3, thickness=300.0),
    "the metal is as dense as the coat": CoatedConductor(eta=1.5, k=0.0, int_ior=1.5),
}


@pytest.mark.parametrize("name", BLACK)
def test_of_a_black_metal_the_coat_is_left(name):
    material, wo = Material(BLACK[name]), direction(0.6)
    f_cos, pdf = material.evaluate(wo, direction(0.5))
    _, weight, _, _ = material.sample(wo, random_numbers(1000, 3))
    assert np.isfinite(f_cos).all() and np.isfinite(pdf).all()
    reflected, _ = fresnel(np.array([0.6]), layers_of(BLACK[name]).coat_eta)
    np.testing.assert_allclose(weight.mean(1), reflected[0], atol=1e-3)


def shape_of(wi, power):
    """(cells,) parts of the light in each cell of the disk below the hemisphere."""
    cells, _, _ = np.histogram2d(wi[0], wi[1], bins=17, range=[[-1, 1], [-1, 1]], weights=power)
    return cells.ravel() / cells.sum()


@pytest.mark.parametrize(
    ("name", "most"), [("smooth coat", 0.09), ("satin", 0.12), ("smooth metal", 0.25)]
)
def test_light_goes_where_the_walks_send_it(name, most):
    layers, material = layers_of(COATED[name]), Material(COATED[name])
    for cosine in (0.9, 0.5):
        wi, power, _ = walks_of(layers, cosine)
        # Light of the walks starts with azimuth 0.
        wo = direction(cosine, azimuth=0.0)
        there, weight, _, _ = material.sample(wo, random_numbers(40_000, 3))
        difference = shape_of(wi, power[1]) - shape_of(there, weight[1])
        assert 0.5 * np.abs(difference).sum() < most


@pytest.mark.parametrize(("alpha", "within"), [(0.0, 0.002), (0.1, 0.004), (0.4, 0.01)])
def test_matte_bases_of_pbrt_are_plastic_with_another_base(alpha, within):
    albedo = (0.95, 0.6, 0.2)
    keys = {"int_ior": 1.5, "ext_ior": 1.0, "nonlinear": True}
    keys["diffuse_reflectance"] = tuple(base_of_walk(albedo, Coat(alpha, 1.5, 0.05, 3)))
    spec = RoughPlastic(alpha=alpha, **keys) if alpha else Plastic(**keys)
    for cosine in (0.95, 0.6, 0.3):
        power = walks(cosine, 1.5, alpha, Lambert(albedo), 0.05, 3).power
        _, weight, _, _ = Material(spec).sample(direction(cosine), random_numbers(40_000, 3))
        error = np.hypot(power.std(1), weight.std(1)) / np.sqrt(40_000)
        difference = weight.mean(1) - power.mean(1)
        assert (np.abs(difference) < within + 3.5 * error).all(), (cosine, difference, error)


def test_light_is_shared_by_the_points_on_both_sides_of_its_place():
    places, light = np.array([[0.0, 1.75, 3.9, 4.0]]), np.array([[1.0, 2.0, 3.0, 4.0]])
    found = _shared(places, light, 5)
    np.testing.assert_allclose(found, [[1.0, 0.5, 1.5, 0.3, 2.7 + 4.0]])
