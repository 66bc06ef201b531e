r"""Sheen: fibres that stand on a surface and shine towards its rim, as velvet and dusty cloth do.

.. math::
    f = \frac{D(\theta_h)}{4 (\cos\theta_o + \cos\theta_i - \cos\theta_o \cos\theta_i)\, s}, \qquad
    D = \frac{(2 + 1/\alpha) \sin^{1/\alpha}\theta_h}{2 \pi}, \qquad \alpha = \text{roughness}^2

s >= 1 is the largest albedo of the lobe alone, where that is larger than 1. What lies below gets
the part 1 - E(o), with the directional albedo E from a table made by our own quadrature. A row
holds E at `STEPS` cosines (j / (STEPS - 1))^2 and s; rows lie at equal steps of the roughness.

Source: Estevez and Kulla 2017, Production Friendly Microfacet Sheen BRDF; Ashikhmin and Premoze
2007, Distribution-based BRDFs for the denominator; KHR_materials_sheen of glTF for both together.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from alight.bsdfs.rows import read_row
from alight.core.constants import INV_TWO_PI
from alight.core.maths import exp, log
from alight.core.vec import dot
from lanewise.jit import kernel
from lanewise.simd import lanes_u32, maximum, minimum, sqrt, to_float, to_uint

#: Cosines of a row, its length, and rows where the roughness is textured.
STEPS = 48
ROW = STEPS + 1
ROWS = 32
#: Below this roughness the lobe is a line along the rim.
LEAST_ROUGHNESS = 0.15


# ---------------------------------------------------------------- on the host


def _albedo(mu: NDArray[np.float64], alpha: float) -> NDArray[np.float64]:
    """∫ f cos theta_i over the hemisphere, s = 1, for directions with the cosines mu."""
    nodes, weights = np.polynomial.legendre.leggauss(96)
    # Dense near the horizon, and around the azimuth of the viewer.
    t = 0.5 * (nodes + 1.0)
    z, dz = t * t, 0.5 * weights * 2.0 * t
    phi, dphi = np.pi * t**2, 0.5 * weights * 2.0 * np.pi * t
    o, i, p = mu[:, None, None], z[None, :, None], phi[None, None, :]
    along = np.sqrt(1.0 - o * o) * np.sqrt(1.0 - i * i) * np.cos(p)
    cos2 = np.minimum((o + i) ** 2 / np.maximum(2.0 + 2.0 * (o * i + along), 1e-12), 1.0)
    d = (2.0 + 1.0 / alpha) * (1.0 - cos2) ** (0.5 / alpha) / (2.0 * np.pi)
    value = d * i / (4.0 * (o + i - o * i))
    # Both halves of the circle are alike.
    return 2.0 * np.einsum("oip,i,p->o", value, dz, dphi)


@lru_cache(maxsize=64)
def _row(roughness: float) -> NDArray[np.float32]:
    mu = np.maximum(np.linspace(0.0, 1.0, STEPS) ** 2, 1e-6)
    albedo = _albedo(mu, roughness * roughness)
    scale = max(1.0, float(albedo.max()))
    return np.append(albedo / scale, scale).astype(np.float32)


@lru_cache(maxsize=16)
def sheen_rows(roughness: float | None) -> NDArray[np.float32]:
    """Rows of the sheen: one, or where its roughness is textured `ROWS`.

    Parameters
    ----------
    roughness : float or None
        In [0, 1]; None where it is textured.

    Returns
    -------
    (ROW,) or (ROWS * ROW,) float32
        Within 1e-3.
    """
    if roughness is not None:
        return _row(max(roughness, LEAST_ROUGHNESS))
    steps = np.linspace(0.0, 1.0, ROWS)
    return np.concatenate([_row(max(float(r), LEAST_ROUGHNESS)) for r in steps])


# ---------------------------------------------------------------- in kernels


@kernel
def sheen_albedo(rows, cosine):
    """E at a cosine."""
    x = sqrt(minimum(maximum(cosine, 0.0), 1.0)) * (STEPS - 1.0)
    i = to_uint(minimum(x, STEPS - 2.0))
    a, b = read_row(rows, i), read_row(rows, i + 1)
    return a + (x - to_float(i)) * (b - a)


@kernel
def sheen_f_cos(rows, roughness, wo, wi):
    """f cos theta_i of white sheen, for two directions above the surface."""
    roughness = maximum(roughness, LEAST_ROUGHNESS)
    exponent = 1.0 / (roughness * roughness)
    # The squared cosine of the half vector, without its root.
    upper = wo.z + wi.z
    cos2 = upper * upper / maximum(2.0 + 2.0 * dot(wo, wi), 1e-6)
    sin2 = maximum(1.0 - cos2, 1e-18)
    d = (2.0 + exponent) * INV_TWO_PI * exp(0.5 * exponent * log(sin2))
    below = 4.0 * maximum(upper - wo.z * wi.z, 1e-6)
    return d * wi.z / (below * read_row(rows, lanes_u32(STEPS)))
