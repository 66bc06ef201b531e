"""A user's model, written as a script would: Lambert's law again, with things to get wrong."""

import sys
import types

LAMBERT = '''
from collections import namedtuple
from typing import Literal

from alight.bsdfs.flags import REFLECTION
from alight.core.constants import INV_PI
from lanewise.jit import kernel
from lanewise.simd import lanes_u32, where
from alight.core.field_types import ColorTexture, UnitInterval
from alight.core.spec import Bsdf
from alight.core.warps import square_to_cosine_hemisphere
from alight.textures.fetch import color


class Lambert(Bsdf):
    """Lambert's law."""

    type: Literal["lambert"] = "lambert"
    reflectance: ColorTexture = (0.5, 0.5, 0.5)
    gloss: UnitInterval = 0.0


EXAMPLES = (Lambert(), Lambert(reflectance=1.0))
SLOTS = {"reflectance": 3}
STRENGTH = 1.0
Params = namedtuple("LambertParams", "reflectance")


def is_lossless(spec):
    return spec.reflectance == (1.0, 1.0, 1.0)


def is_reciprocal(spec):
    return True


def pack(spec, packer):
    packer.color("reflectance", spec.reflectance)


@kernel
def load(scene, base, surface):
    return Params(color(scene, base, surface) * STRENGTH)


@kernel
def evaluate(params, wo, wi):
    pdf = where((wo.z > 0.0) & (wi.z > 0.0), INV_PI * wi.z, 0.0)
    return params.reflectance * pdf, pdf


@kernel
def sample(params, wo, u, u2):
    wi = square_to_cosine_hemisphere(u2)
    _, pdf = evaluate(params, wo, wi)
    return wi, where(pdf > 0.0, params.reflectance, 0.0), pdf, lanes_u32(REFLECTION)


@kernel
def albedo(params):
    return params.reflectance
'''

SCENE = """
alight: 1
camera: {type: pinhole, fov: 60, transform: {look_at: {origin: [0, 1, 4], target: [0, 1, 0]}}}
film: {size: [16, 16]}
sampler: independent
nodes:
  lamp: {light: {type: point, intensity: 20}, transform: {translate: [1, 4, 3]}}
  ball: {shape: {type: sphere, center: [0, 1, 0]}, bsdf: {type: %s, reflectance: [0.9, 0.5, 0.1]}}
"""


def module_of(text, name="users_lambert"):
    """A script's text as an imported module."""
    module = types.ModuleType(name)
    sys.modules[name] = module
    exec(compile(text, name, "exec"), module.__dict__)
    return module
