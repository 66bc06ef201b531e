"""What passes through a surface has its tint, and from inside its layers are not seen."""

import numpy as np
import pytest

from alight.bsdfs.dielectrics.dielectric import Dielectric
from alight.bsdfs.dielectrics.rough_dielectric import RoughDielectric
from alight.bsdfs.dielectrics.thin_dielectric import ThinDielectric
from alight.bsdfs.disney.burley import Burley
from alight.bsdfs.disney.burley_thin import BurleyThin
from alight.bsdfs.disney.principled import Principled
from alight.bsdfs.matte.diffuse_transmission import DiffuseTransmission
from alight.core.registry import modules
from alight.laws.materials import Material, direction, random_numbers
from alight.laws.statistics import unit_vectors

N = 2000
TINT = (0.9, 0.5, 0.2)
GLASS = Principled(base_color=1.0, transmission=1.0, roughness=0.5)
#: (a white material, the field of its tint, the power of the tint in what passes)
TINTED = {
    "glass": (GLASS, "base_color", 1.0),
    "sheet": (GLASS.replaced(thin=True), "base_color", 1.0),
    "half a sheet": (GLASS.replaced(thin=True, transmission=0.6), "base_color", 1.0),
    "sheet with a film": (GLASS.replaced(thin=True, iridescence=1.0), "base_color", 1.0),
    "brushed sheet": (GLASS.replaced(thin=True, anisotropy=0.7), "base_color", 1.0),
    "lacquered sheet": (
        GLASS.replaced(thin=True, clearcoat=0.8, sheen_color=0.3),
        "base_color",
        1.0,
    ),
    "plain sheet": (GLASS.replaced(thin=True, compensation=False), "base_color", 1.0),
    "glass with a film": (GLASS.replaced(iridescence=1.0), "base_color", 1.0),
    "some metal": (GLASS.replaced(metallic=0.4), "base_color", 1.0),
    "plain glass": (GLASS.replaced(compensation=False), "base_color", 1.0),
    "ground glass": (RoughDielectric(alpha=0.4), "specular_transmittance", 1.0),
    "polished glass": (Dielectric(), "specular_transmittance", 1.0),
    "pane": (ThinDielectric(), "specular_transmittance", 1.0),
    "paper": (DiffuseTransmission(transmittance=1.0, reflectance=0.0), "transmittance", 1.0),
    "Burley's glass": (Burley(base_color=1.0, spec_trans=1.0), "base_color", 0.5),
    "Burley's sheet": (BurleyThin(base_color=1.0, spec_trans=1.0), "base_color", 1.0),
}
#: Not tinted: what is simply open, and what is made of others.
UNTINTED = {"null", "mask", "blend", "two_sided", "normal_map", "bump_map", "hair", "subsurface"}


def values_through(spec, cosine):
    """f cos theta of what comes through to a viewer, (3, N)."""
    wi = unit_vectors(N, 1)
    wi[2] = -np.copysign(wi[2], cosine)
    return Material(spec).evaluate(direction(cosine), wi)[0]


def mean_through(spec, cosine):
    """Mean weight of samples that pass, three channels."""
    wi, weight, _, _ = Material(spec).sample(direction(cosine), random_numbers(20_000, 3))
    return (weight * (wi[2] * cosine < 0.0)).mean(axis=1)


@pytest.mark.parametrize("cosine", [0.8, -0.85])
@pytest.mark.parametrize("name", TINTED)
def test_what_passes_has_the_tint(name, cosine):
    spec, field, power = TINTED[name]
    tint = np.array(TINT)[:, None] ** power
    tinted = spec.replaced(**{field: TINT})
    white = values_through(spec, cosine)
    np.testing.assert_allclose(values_through(tinted, cosine), white * tint, rtol=1e-4, atol=1e-7)
    mean = mean_through(spec, cosine)
    assert np.all(mean > 0.02)
    # The tint may change how often samples pass, not what they bring on the whole.
    np.testing.assert_allclose(mean_through(tinted, cosine), mean * tint[:, 0], rtol=0.06)


def test_all_models_that_let_light_through_are_here():
    through = {
        type(spec).type_name()
        for model in modules("bsdfs")
        for spec in model.EXAMPLES
        if type(spec).transmissive is not False
    }
    assert through <= {type(spec).type_name() for spec, _, _ in TINTED.values()} | UNTINTED


#: What lies on the outer side of a body of glass, and only there.
OUTSIDE = {
    "film": {"iridescence": 1.0, "iridescence_thickness": 350.0},
    "coat": {"clearcoat": 1.0, "clearcoat_roughness": 0.4},
    "sheen": {"sheen_color": (0.3, 0.5, 0.9)},
    "strength": {"specular": 0.3},
    "tinted reflection": {"specular_color": (0.2, 0.9, 0.5)},
    "all": {"iridescence": 0.7, "clearcoat": 0.6, "sheen_color": 0.4, "specular": 0.5},
}


@pytest.mark.parametrize("metallic", [0.0, 0.3])
@pytest.mark.parametrize("name", OUTSIDE)
def test_from_inside_of_glass_nothing_of_its_outer_side_is_seen(name, metallic):
    plain = GLASS.replaced(base_color=TINT, metallic=metallic, transmission=0.8)
    layered = plain.replaced(**OUTSIDE[name])
    wo, wi = unit_vectors(N, 4), unit_vectors(N, 5)
    wo[2] = -np.abs(wo[2])
    for found, expected in zip(
        Material(layered).evaluate(wo, wi), Material(plain).evaluate(wo, wi), strict=True
    ):
        np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-6)
    u = random_numbers(N, 6)
    for found, expected in zip(
        Material(layered).sample(wo, u), Material(plain).sample(wo, u), strict=True
    ):
        np.testing.assert_allclose(found, expected, rtol=2e-4, atol=1e-5)
    # From outside it is.
    above = np.float32([[1.0], [1.0], [-1.0]]) * wo
    there, _ = Material(layered).evaluate(above, wi)
    without, _ = Material(plain).evaluate(above, wi)
    assert np.abs(there - without).max() > 0.01
