"""The plane z = 0, on which laws look at materials and textures."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from alight.core.wavelengths import LINE_D
from alight.shapes.hit import Bend, Surface
from alight.shapes.surfaces import usual_bend, usual_wavelength
from lanewise.jit import kernel
from lanewise.simd import lanes, lanes_u32
from lanewise.vec3 import Vec3


@kernel
def plane_point(p, u, v, bsdf, color):
    """The `Surface` at a point of the plane, in kernels."""
    zero, one, none = lanes(0.0), lanes(1.0), lanes_u32(0)
    up = Vec3(zero, zero, one)
    return Surface(
        p=p,
        error=zero,
        ng=up,
        ns=up,
        s=Vec3(one, zero, zero),
        t=Vec3(zero, one, zero),
        u=u,
        v=v,
        shape=none,
        prim=none,
        bsdf=bsdf,
        light=none,
        color=color,
        chart=(),
        wavelength=usual_wavelength(),
        bend=usual_bend(),
    )


def _unbent(zero: NDArray[np.float32]) -> Bend:
    """The `Bend` of a surface without a map, for the twin."""
    one = zero + np.float32(1.0)
    axes = (Vec3(one, zero, zero), Vec3(zero, one, zero), Vec3(zero, zero, one))
    return Bend(*axes, zero > 0.0)


def plane_surface(
    u: NDArray[np.float32],
    v: NDArray[np.float32],
    bsdf: NDArray[np.uint32] | None = None,
    wavelength: float = LINE_D,
) -> Surface:
    """The surface at points of the plane, as the NumPy twin sees it.

    Parameters
    ----------
    u, v : (n,) float32
        Texture coordinates; the points are (u, v, 0), metres.
    bsdf : (n,) uint32, optional
        Rows of the materials; 0 by default.
    wavelength : float, default that of the line d
        Nanometres, of all points.
    """
    zero, none = np.zeros_like(u), np.zeros(len(u), np.uint32)
    one = zero + np.float32(1.0)
    black, up = Vec3(zero, zero, zero), Vec3(zero, zero, one)
    return Surface(
        p=Vec3(u, v, zero), error=zero, ng=up, ns=up,
        s=Vec3(one, zero, zero), t=Vec3(zero, one, zero), u=u, v=v,
        shape=none, prim=none, bsdf=none if bsdf is None else bsdf, light=none,
        color=black, chart=(), wavelength=zero + np.float32(wavelength), bend=_unbent(zero),
    )  # fmt: skip
