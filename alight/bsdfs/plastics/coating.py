r"""A matte base under a clear coat: what `plastic` and `rough_plastic` share.

Light that enters the coat scatters at the base, is partly thrown back by the coat from inside, and
scatters again. With the internal reflectance R (for diffuse light) the sum over all rounds is

.. math:: \rho' = \rho\,(1 + \rho R + \rho^2 R^2 + \dots) = \frac{\rho}{1 - \rho R},

where each round colours the light again. The linear version keeps the colour of one round:
rho / (1 - R).

For a rough coat the part T(mu) that enters at the cosine mu, and

.. math:: R = \frac{2}{64} \sum_{k=0}^{63} \mu_k R(\mu_k),

reflected on the inner side, are integrals over its facets
(`alight.bsdfs.microfacets.visible_facets`). The sum over 64 equally spaced cosines is what
Mitsuba's ``roughplastic`` computes in place of the integral over mu, found by experiment; it is 1
to 2 % smaller. Tables of T have 64 of them too, and are interpolated linearly.

Source: the plug-ins ``plastic`` and ``roughplastic`` of Mitsuba 3.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from alight.bsdfs.microfacets.visible_facets import bounce, see_facets
from alight.bsdfs.rows import read_row, rows_at
from alight.core.constants import INV_PI
from alight.core.fresnel import fresnel_dielectric
from alight.core.microfacet import Facets
from alight.core.vec import luminance
from lanewise.jit import kernel
from lanewise.simd import (
    lanes_u32,
    lanes_vec3,
    maximum,
    minimum,
    sqrt,
    to_float,
    to_uint,
    where,
)

#: Cosines in a table of transmittances.
STEPS = 64
#: Numbers of a row: the transmittances and the internal reflectance.
ROW = STEPS + 1
#: Rows for textured roughness, at equal steps of its root.
ROWS = 33


# ---------------------------------------------------------------- on the host


def diffuse_reflectance(eta: float) -> float:
    r"""Part of diffuse light that a smooth interface reflects: ∫ 2 mu F(mu) d mu; within 1e-6."""
    # Total internal reflection below the critical angle's cosine: all of it. Above, in steps of the
    # refracted ray's cosine, in which F has no root: mu^2 = c^2 + (1 - c^2) t^2.
    critical = max(0.0, 1.0 - eta * eta)
    nodes, weights = np.polynomial.legendre.leggauss(64)
    t, dt = 0.5 * (nodes + 1.0), 0.5 * weights
    f, _ = fresnel_dielectric(np.sqrt(critical + (1.0 - critical) * t * t), eta)
    return float(critical + (1.0 - critical) * np.sum(dt * 2.0 * t * f))


@lru_cache(maxsize=256)
def coat_row(distribution: str, alpha: float, eta: float) -> NDArray[np.float32]:
    """Numbers of a rough coat.

    Returns
    -------
    (ROW,) float32
        T at `STEPS` cosines from 0 to 1, from outside; then R, from inside. Within 1e-4.
    """
    facets = Facets(alpha, alpha, float(distribution == "beckmann"))
    mu = np.maximum(np.linspace(0.0, 1.0, STEPS), 1e-6)
    seen = see_facets(facets, mu)
    transmittance = bounce(seen, eta).refracted
    internal = 2.0 * np.mean(mu * bounce(seen, 1.0 / eta, refracts=False).reflected)
    return np.append(transmittance, internal).astype(np.float32)


@lru_cache(maxsize=32)
def coat_table(distribution: str, alpha: float | None, eta: float) -> NDArray[np.float32]:
    """Rows of a rough coat: one, or where its roughness is textured `ROWS`.

    Row i of many holds alpha = (i / (ROWS - 1))^2.
    """
    if alpha is not None:
        return coat_row(distribution, alpha, eta)
    roots = np.maximum(np.linspace(0.0, 1.0, ROWS), 0.01)
    return np.concatenate([coat_row(distribution, float(r * r), eta) for r in roots])


# ---------------------------------------------------------------- in kernels


@kernel
def base_reflectance(reflectance, internal, nonlinear):
    """Reflectance of the base with all rounds inside the coat, as if seen from there."""
    colored = where(nonlinear > 0.0, reflectance, 1.0)
    return reflectance / (lanes_vec3(1.0) - colored * internal)


@kernel
def base_f_cos(reflectance, through, eta, cos_i):
    """f cos theta_i of the base: `through` is the product of both ways through the coat."""
    # Radiance that leaves the denser coat falls by 1 / eta^2.
    return reflectance * (through * (INV_PI * cos_i) / (eta * eta))


@kernel
def chance_of_coat(reflected, specular, matte):
    """Probability of sampling the coat: its part of the reflected light, by luminance."""
    coat = reflected * luminance(specular)
    base = (1.0 - reflected) * luminance(matte)
    both = coat + base
    return where(both > 0.0, coat / where(both > 0.0, both, 1.0), 0.0)


@kernel
def coat_at(table, alpha):
    """The `Rows` of a coat of this roughness."""
    return rows_at(table, sqrt(alpha), ROW)


@kernel
def coat_transmittance(coat, cosine):
    """T at a cosine."""
    x = minimum(maximum(cosine, 0.0), 1.0) * (STEPS - 1.0)
    i = to_uint(minimum(x, STEPS - 2.0))
    a, b = read_row(coat, i), read_row(coat, i + 1)
    return a + (x - to_float(i)) * (b - a)


@kernel
def coat_internal(coat):
    """R of a rough coat."""
    return read_row(coat, lanes_u32(STEPS))
