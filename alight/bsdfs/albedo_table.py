r"""How much light facets send back or let through after one bounce, in tables over the cosine.

Single scattering reflects and transmits the parts W (of white facets), R and T of the light, and of
the part V there is a refracted direction (`alight.bsdfs.visible_facets`). What W and R + T lack to
1 met a second facet; dividing by them gives it back. Any Fresnel term of the form a + b F has the
albedos a W + b R and V - a V - b (V - T).

A row holds these at `STEPS` cosines (j / (STEPS - 1))^4, dense where masking changes quickly: W, R,
T, V from outside, then R, T, V from inside, and last the means 2 ∫ W mu dmu and 2 ∫ R mu dmu. Rows
stand at equal steps of the root of alpha, and are interpolated linearly both ways.

Source: Turquin 2019, Practical multiple scattering compensation for microfacet models.
"""

from __future__ import annotations

from collections import namedtuple
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from alight.bsdfs.rows import read_row
from alight.bsdfs.visible_facets import LATTICE, bounce, see_facets
from alight.core.jit import kernel
from alight.core.microfacet import Facets
from alight.core.simd import lanes_u32, maximum, minimum, sqrt, to_float, to_uint

Array = NDArray[np.float64]

#: Cosines of a row, and its length: seven curves and two means.
STEPS = 64
ROW = 7 * STEPS + 2
#: Numbers of the curves, and where the means stand.
WHITE, REFLECTED, REFRACTED, PASSED, INNER = 0, 1, 2, 3, 3
MEANS = 7 * STEPS
#: Rows where the roughness varies, and points and generator of the lattice for each of them.
ROWS = 48
FEWER = 987, 610
#: Smoother facets are mirrors to float32.
LEAST_ALPHA = 1e-3


# ---------------------------------------------------------------- on the host


def _cosines() -> Array:
    return np.maximum(np.linspace(0.0, 1.0, STEPS) ** 4, 1e-7)


def _mean(curve: Array) -> float:
    """2 ∫ E mu dmu of a curve that is linear between its points in the fourth root of mu."""
    nodes, weights = np.polynomial.legendre.leggauss(128)
    y = 0.5 * (nodes + 1.0)
    value = np.interp(y, np.linspace(0.0, 1.0, STEPS), curve)
    return float(np.sum(0.5 * weights * 8.0 * y**7 * value))


@lru_cache(maxsize=256)
def albedo_row(
    alpha: float, eta: float, refracts: bool, lattice: tuple[int, int] = LATTICE
) -> NDArray[np.float32]:
    """Numbers of GGX facets.

    Parameters
    ----------
    alpha : float
        Roughness, the same in all directions.
    eta : float
        Index inside over that outside.
    refracts : bool
        Whether the curves of light that passes are needed; else they are 0.
    lattice : (int, int)
        Points and generator of the facets' lattice.

    Returns
    -------
    (ROW,) float32
        Within 1e-4.
    """
    seen = see_facets(Facets(alpha, alpha, 0.0), _cosines(), lattice=lattice)
    outside = bounce(seen, eta, refracts)
    inside = bounce(seen, 1.0 / eta)[1:] if refracts else [np.zeros(STEPS)] * 3
    row = [*outside, *inside, [_mean(outside.white), _mean(outside.reflected)]]
    return np.concatenate(row).astype(np.float32)


@lru_cache(maxsize=16)
def albedo_rows(alpha: float | None, eta: float, refracts: bool) -> NDArray[np.float32]:
    """Rows of facets: one, or where their roughness varies (None) `ROWS`.

    Row i of many holds alpha = (i / (ROWS - 1))^2, at least `LEAST_ALPHA`.
    """
    if alpha is not None:
        return albedo_row(alpha, eta, refracts)
    roots = np.linspace(0.0, 1.0, ROWS)
    return np.concatenate(
        [albedo_row(max(float(r * r), LEAST_ALPHA), eta, refracts, FEWER) for r in roots]
    )


# ---------------------------------------------------------------- in kernels

#: A cosine's place in a row: number of the point before it, and the part of the next one.
Place = namedtuple("Place", "index part")


@kernel
def place_of(cosine):
    """The `Place` of a cosine, in curves over its fourth root."""
    x = sqrt(sqrt(minimum(maximum(cosine, 0.0), 1.0))) * (STEPS - 1.0)
    i = to_uint(minimum(x, STEPS - 2.0))
    return Place(i, x - to_float(i))


@kernel
def read_bounced(rows, place):
    """(W, R) from outside at a place."""
    white = read_curve(rows, lanes_u32(WHITE), place)
    return white, read_curve(rows, lanes_u32(REFLECTED), place)


@kernel
def read_curve(rows, curve, place):
    """Curve number `curve` at a place."""
    i = place.index + curve * STEPS
    a, b = read_row(rows, i), read_row(rows, i + 1)
    return a + place.part * (b - a)
