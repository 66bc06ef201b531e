"""One material in the NumPy twin, through the tables and the dispatcher of the renderer."""

from __future__ import annotations

from collections import namedtuple

import numpy as np

from alight.bsdfs.dispatch import evaluate_bsdf, open_share, sample_bsdf
from alight.bsdfs.flags import DELTA, NULL, TRANSMISSION
from alight.bsdfs.model import BSDFS, BsdfModel
from alight.bsdfs.nesting import leaves
from alight.compiled.materials import compile_materials
from alight.compiled.program import Program
from alight.core.registry import versions
from alight.core.spec import Bsdf
from alight.laws.plane import plane_surface
from alight.shapes.hit import INFO
from lanewise.jit import instantiate
from lanewise.vec3 import Vec3
from lanewise.view import View

#: What kernels of materials read of a scene.
Scene = namedtuple("Scene", "materials shapes")
Shapes = namedtuple("Shapes", "info")

#: Elevations of the viewer above (and below) the surface: overhead, slanted, grazing.
COSINES = (1.0, 0.7, 0.2, 0.02, -0.5)


class Material:
    """Descriptions in the NumPy twin; vectors are arrays (3, n) in the local frame.

    Parameters
    ----------
    *specs : Bsdf
        One is the usual case; `bsdf` then need not be given to the methods.
    uv : (float, float), default (0, 0)
        Where textures are looked up.
    """

    def __init__(self, *specs: Bsdf, uv: tuple[float, float] = (0.0, 0.0)) -> None:
        self.spec, self.uv = specs[0], uv
        tables, bsdfs, textures = compile_materials(specs)
        self.program = Program(bsdfs=bsdfs, textures=textures, registered=versions(specs))
        self.scene = Scene(tables, Shapes(View(np.zeros(INFO, np.uint32))))

    def surface(self, n, bsdf=None):
        """A surface in the plane z = 0, at n points."""
        u, v = (np.full(n, c, np.float32) for c in self.uv)
        return plane_surface(u, v, bsdf)

    def evaluate(self, wo, wi, bsdf=None):
        """(f_cos (3, n), pdf (n,))."""
        n = max(wo.shape[1], wi.shape[1])
        wo, wi = _lanes(wo, n), _lanes(wi, n)
        kernel = instantiate(evaluate_bsdf, self.program, compiled=False)
        with np.errstate(all="ignore"):
            f_cos, pdf = kernel(
                self.scene, self.surface(n, bsdf), Vec3(*wo), Vec3(*wi), np.ones(n, bool)
            )
        return stacked(f_cos, n), np.broadcast_to(pdf, n)

    def sample(self, wo, u, bsdf=None):
        """(wi (3, n), weight (3, n), pdf (n,), flags (n,)) from random numbers u (3, n)."""
        n = u.shape[1]
        wo = _lanes(wo, n)
        kernel = instantiate(sample_bsdf, self.program, compiled=False)
        with np.errstate(all="ignore"):
            wi, weight, pdf, flags = kernel(
                self.scene, self.surface(n, bsdf), Vec3(*wo), u[0], (u[1], u[2]), np.ones(n, bool)
            )
        return (
            stacked(wi, n),
            stacked(weight, n),
            np.broadcast_to(pdf, n),
            np.broadcast_to(flags, n),
        )

    def open_share(self):
        """What part of light continues as if nothing were there."""
        kernel = instantiate(open_share, self.program, compiled=False)
        return float(np.ravel(kernel(self.scene, self.surface(1), np.ones(1, bool)))[0])

    def is_delta(self, wo):
        """All of the scattering is in single directions."""
        return bool(np.all(self.sample(wo, unit_interval(256))[3] & DELTA))

    # ---- what the model's file declares

    def is_lossless(self) -> bool:
        """All parts of it say that all light leaves again."""
        # Bent normals take light away.
        lossless = [_model(leaf.bsdf).is_lossless(leaf.bsdf) for leaf in leaves(self.spec)]
        return all(lossless) and not self.is_bent()

    def is_reciprocal(self) -> bool | None:
        """All parts of it say that f(wo, wi) = f(wi, wo); None if one of them leaves it open."""
        said = [_model(leaf.bsdf).is_reciprocal(leaf.bsdf) for leaf in leaves(self.spec)]
        return None if self.is_bent() or None in said else all(said)

    def is_bent(self) -> bool:
        """Whether a part of it has a normal or bump map."""
        return any(leaf.normals is not None for leaf in leaves(self.spec))

    def is_one_sided(self) -> bool:
        """All parts of it say that only light from the viewer's side reaches them."""
        return all(leaf.bsdf.one_sided for leaf in leaves(self.spec)) and not self.is_bent()

    def has_back(self) -> bool:
        """Something happens to light that meets the surface from below."""
        return any(leaf.two_sided or leaf.bsdf.transmissive for leaf in leaves(self.spec))

    def is_lossless_from_behind(self) -> bool:
        """So do all of its parts for light that meets the surface from below."""
        through = all(leaf.two_sided or leaf.bsdf.transmissive for leaf in leaves(self.spec))
        return through and self.is_lossless()

    def radiance_scale(self, cosine, passes):
        """By what refracted radiance is multiplied to be power again: eta^2.

        Parameters
        ----------
        cosine : float
            Of the side that wo is on.
        passes : (n,) bool
            Where light goes through.
        """
        eta = 1.0
        for leaf in leaves(self.spec):
            ior = _model(leaf.bsdf).relative_ior
            if ior is not None:
                eta = ior(leaf.bsdf)
        eta = eta if cosine > 0.0 else 1.0 / eta
        return np.where(passes, eta * eta, 1.0)


def refracts(flags):
    """Where a sample changed to another medium: through, but not straight on."""
    return (flags & (TRANSMISSION | NULL)) == TRANSMISSION


def _model(spec: Bsdf) -> BsdfModel:
    return BSDFS[spec.type_name()]


def direction(cosine, azimuth=0.6):
    """A unit vector (3, 1)."""
    sine = np.sqrt(1.0 - cosine * cosine)
    return np.array([[sine * np.cos(azimuth)], [sine * np.sin(azimuth)], [cosine]], np.float32)


def _lanes(v, n):
    return np.ascontiguousarray(np.broadcast_to(np.asarray(v, np.float32), (3, n)))


def stacked(v, n):
    """A Vec3 of lanes as an array (3, n)."""
    return np.stack([np.broadcast_to(c, n) for c in (v.x, v.y, v.z)])


def random_numbers(n, seed):
    """(3, n) float32 in [0, 1)."""
    return np.random.default_rng(seed).random((3, n), np.float32)


def unit_interval(n):
    """(3, n) float32 whose first row steps evenly through [0, 1)."""
    u = random_numbers(n, 9)
    u[0] = (np.arange(n) + 0.5) / n
    return u
