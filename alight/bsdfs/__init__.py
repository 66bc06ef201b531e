"""Scattering at surfaces, one model per file. A new model is one file and one line here."""

from alight.bsdfs.adapters import blend, bump_map, mask, normal_map, two_sided
from alight.bsdfs.conductors import coated_conductor, conductor, mirror, rough_conductor
from alight.bsdfs.dielectrics import dielectric, null, rough_dielectric, thin_dielectric
from alight.bsdfs.disney import burley, burley_thin, principled
from alight.bsdfs.fibres import hair
from alight.bsdfs.interiors import subsurface
from alight.bsdfs.matte import diffuse, diffuse_transmission, eon, oren_nayar, uniform_scatter
from alight.bsdfs.plastics import phong, plastic, rough_plastic

MODELS = (
    diffuse,
    uniform_scatter,
    mirror,
    phong,
    conductor,
    dielectric,
    rough_conductor,
    rough_dielectric,
    thin_dielectric,
    plastic,
    rough_plastic,
    oren_nayar,
    eon,
    diffuse_transmission,
    principled,
    burley,
    burley_thin,
    two_sided,
    null,
    blend,
    mask,
    normal_map,
    bump_map,
    coated_conductor,
    hair,
    subsurface,
)

#: Of shapes that name none.
DEFAULT = diffuse.Diffuse()
