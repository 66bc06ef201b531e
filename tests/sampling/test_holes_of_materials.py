"""Paths and shadow rays agree on which part of a surface is not there."""

import pytest

from alight.bsdfs.adapters.blend import Blend
from alight.bsdfs.adapters.mask import Mask
from alight.bsdfs.adapters.two_sided import TwoSided
from alight.bsdfs.dielectrics.null import Null
from alight.bsdfs.dielectrics.thin_dielectric import ThinDielectric
from alight.bsdfs.matte.diffuse import Diffuse
from alight.laws import bsdfs as laws
from alight.laws.materials import Material

MIXED = {
    "pane and hole": Blend(weight=0.3, bsdfs=(Null(), ThinDielectric())),
    "pane with holes": Mask(opacity=0.6, bsdf=ThinDielectric(specular_transmittance=0.5)),
    "deep": Mask(opacity=0.5, bsdf=Blend(weight=0.25, bsdfs=(Null(), TwoSided(bsdf=Diffuse())))),
}


@pytest.mark.parametrize("cosine", [0.7, -0.3])
@pytest.mark.parametrize("spec", MIXED.values(), ids=MIXED)
def test_holes_of_mixtures_are_as_likely_as_they_are_open(spec, cosine):
    material = Material(spec)
    assert 0.0 < material.open_share() < 1.0
    laws.holes_are_as_likely_as_they_are_open(material, cosine)
