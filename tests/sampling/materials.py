"""Every registered BSDF and every example of it, through the tables and the dispatcher."""

from collections import namedtuple

import numpy as np
import pytest

from alight.bsdfs import MODELS
from alight.bsdfs.dispatch import evaluate_bsdf, sample_bsdf
from alight.bsdfs.flags import DELTA
from alight.bsdfs.two_sided import TwoSided
from alight.compiled.materials import compile_materials
from alight.compiled.program import Program
from alight.core.jit import instantiate
from alight.core.vec3 import Vec3
from alight.core.view import View

Scene = namedtuple("Scene", "materials shapes")
Shapes = namedtuple("Shapes", "info")
#: The fields of `alight.shapes.hit.Surface` that materials look at.
Surface = namedtuple("Surface", "u v shape bsdf color")

EXAMPLES = [example for model in MODELS for example in model.EXAMPLES]
NAMES = [f"{e.type_name()}-{i}" for model in MODELS for i, e in enumerate(model.EXAMPLES)]

#: Elevations of the viewer above (and below) the surface: overhead, slanted, grazing.
COSINES = (1.0, 0.7, 0.2, 0.02, -0.5)


def model_of(spec):
    """The module whose laws a description declares (of a wrapper, those of what it holds)."""
    inner = spec.bsdf if isinstance(spec, TwoSided) else spec
    return next(m for m in MODELS if type(m.EXAMPLES[0]) is type(inner)), inner


def is_lossless(spec):
    model, inner = model_of(spec)
    return model.is_lossless(inner)


def is_reciprocal(spec):
    model, inner = model_of(spec)
    return model.is_reciprocal(inner)


def has_back(spec):
    """Something happens to light that meets the surface from below."""
    return isinstance(spec, TwoSided) or spec.transmissive


def direction(cosine, azimuth=0.6):
    """A unit vector (3, 1)."""
    sine = np.sqrt(1.0 - cosine * cosine)
    return np.array([[sine * np.cos(azimuth)], [sine * np.sin(azimuth)], [cosine]], np.float32)


class Material:
    """One description in the NumPy twin; vectors are arrays (3, n)."""

    def __init__(self, *specs):
        tables, bsdfs, textures = compile_materials(specs)
        self.program = Program(bsdfs=bsdfs, textures=textures)
        self.scene = Scene(tables, Shapes(View(np.zeros(8, np.uint32))))

    def surface(self, n, bsdf=None):
        zeros = np.zeros(n, np.float32)
        bsdf = np.zeros(n, np.uint32) if bsdf is None else bsdf
        return Surface(zeros, zeros, np.zeros(n, np.uint32), bsdf, Vec3(zeros, zeros, zeros))

    def evaluate(self, wo, wi, bsdf=None):
        """(f_cos (3, n), pdf (n,))."""
        n = max(wo.shape[1], wi.shape[1])
        wo, wi = _lanes(wo, n), _lanes(wi, n)
        kernel = instantiate(evaluate_bsdf, self.program, compiled=False)
        with np.errstate(all="ignore"):
            f_cos, pdf = kernel(
                self.scene, self.surface(n, bsdf), Vec3(*wo), Vec3(*wi), np.ones(n, bool)
            )
        return _stack(f_cos, n), np.broadcast_to(pdf, n)

    def sample(self, wo, u, bsdf=None):
        """(wi (3, n), weight (3, n), pdf (n,), flags (n,)) from random numbers u (3, n)."""
        n = u.shape[1]
        wo = _lanes(wo, n)
        kernel = instantiate(sample_bsdf, self.program, compiled=False)
        with np.errstate(all="ignore"):
            wi, weight, pdf, flags = kernel(
                self.scene, self.surface(n, bsdf), Vec3(*wo), u[0], (u[1], u[2]), np.ones(n, bool)
            )
        return _stack(wi, n), _stack(weight, n), np.broadcast_to(pdf, n), np.broadcast_to(flags, n)

    def is_delta(self, wo):
        """All of the scattering is in single directions."""
        flags = self.sample(wo, random_numbers(1, 0))[3]
        return bool(flags[0] & DELTA)


def _lanes(v, n):
    return np.ascontiguousarray(np.broadcast_to(np.asarray(v, np.float32), (3, n)))


def _stack(v, n):
    return np.stack([np.broadcast_to(c, n) for c in (v.x, v.y, v.z)])


def random_numbers(n, seed):
    """(3, n) float32 in [0, 1)."""
    u = np.random.default_rng(seed).random((3, n), np.float32)
    assert u.max() < 1.0
    return u


def unit_interval(n):
    """(3, n) float32 whose first row steps evenly through [0, 1)."""
    u = random_numbers(n, 9)
    u[0] = (np.arange(n) + 0.5) / n
    return u


SMOOTH = [
    pytest.param(spec, cosine, id=f"{name} {cosine}")
    for spec, name in zip(EXAMPLES, NAMES, strict=True)
    if not Material(spec).is_delta(direction(0.7))
    for cosine in COSINES
]
ALL = [
    pytest.param(spec, cosine, id=f"{name} {cosine}")
    for spec, name in zip(EXAMPLES, NAMES, strict=True)
    for cosine in COSINES
]
#: For tests of ``(spec, cosine)``: all examples, those with densities, those without.
each_example = pytest.mark.parametrize(("spec", "cosine"), ALL)
each_smooth_example = pytest.mark.parametrize(("spec", "cosine"), SMOOTH)
each_delta_example = pytest.mark.parametrize(
    ("spec", "cosine"), [case for case in ALL if case.id not in {c.id for c in SMOOTH}]
)
