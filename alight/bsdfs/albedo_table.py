r"""How much light facets send back or let through after one bounce, in tables over the cosine.

With a direction w at the cosine mu and the facets m seen from it (density p), single scattering
reflects and transmits the parts

.. math::
    W = \int p(m)\, G_1(w_r)\,dm, \quad R = \int p(m)\, F\, G_1(w_r)\,dm, \quad
    T = \int p(m)\, (1 - F)\, G_1(w_t)\,dm, \quad V = \int p(m)\, [w_t]\, G_1(w_t)\,dm

with w_r mirrored and w_t refracted at m, Fresnel's F, and [w_t] = 1 where there is a refracted
direction. What W and R + T lack to 1 met a second facet; dividing by them gives it back (Turquin
2019, Practical multiple scattering compensation for microfacet models). Any Fresnel term of the
form a + b F has the albedos a W + b R and V - a V - b (V - T).

A row holds these at `STEPS` cosines (j / (STEPS - 1))^4, dense where masking changes quickly: W, R,
T, V from outside, then R, T, V from inside, and last the means 2 ∫ W mu dmu and 2 ∫ R mu dmu. Rows
stand at equal steps of the root of alpha, and are interpolated linearly both ways.

Source: PBR4 section 9.7; Walter et al. 2007, Microfacet Models for Refraction through Rough
Surfaces; Heitz and d'Eon 2014 for p.
"""

from __future__ import annotations

from collections import namedtuple
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from alight.bsdfs.coating import ggx_facets
from alight.core.fresnel import fresnel_dielectric
from alight.core.jit import kernel, specialised
from alight.core.simd import gather, lanes, lanes_u32, maximum, minimum, sqrt, to_float, to_uint

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
#: What programs call it that a table has more than one row.
MANY_ROWS = "albedo:rows"


# ---------------------------------------------------------------- on the host


def _visible(cosine: Array, alpha: float) -> Array:
    """Smith's G1 of GGX; 0 below the horizon."""
    above = cosine > 0.0
    squared = np.where(above, np.minimum(cosine, 1.0), 1.0) ** 2
    tan2 = (1.0 - squared) / squared
    return np.where(above, 2.0 / (1.0 + np.sqrt(1.0 + alpha * alpha * tan2)), 0.0)


def _cosines() -> Array:
    return np.maximum(np.linspace(0.0, 1.0, STEPS) ** 4, 1e-7)


def _curves(alpha: float, eta: float, refracts: bool, lattice: tuple[int, ...]) -> list[Array]:
    """W, R, T and V seen from the side against which the other one has the index eta."""
    mu = _cosines()
    seen = ggx_facets(mu, alpha, *lattice)
    c, weight = seen.cosine, seen.weight
    fresnel, cos_t = fresnel_dielectric(c, eta)
    back = weight * _visible(2.0 * c * seen.z - mu[:, None], alpha)
    curves = [back.sum(1), (back * fresnel).sum(1)]
    if not refracts:
        return [*curves, np.zeros(STEPS), np.zeros(STEPS)]
    below = mu[:, None] / eta - (c / eta - cos_t) * seen.z
    through = weight * _visible(below, alpha) * (cos_t > 0.0)
    return [*curves, (through * (1.0 - fresnel)).sum(1), through.sum(1)]


def _mean(curve: Array) -> float:
    """2 ∫ E mu dmu of a curve that is linear between its points in the fourth root of mu."""
    nodes, weights = np.polynomial.legendre.leggauss(128)
    y = 0.5 * (nodes + 1.0)
    value = np.interp(y, np.linspace(0.0, 1.0, STEPS), curve)
    return float(np.sum(0.5 * weights * 8.0 * y**7 * value))


@lru_cache(maxsize=256)
def albedo_row(
    alpha: float, eta: float, refracts: bool, lattice: tuple[int, ...] = ()
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
    lattice : (points, generator), optional
        Of the facets; (4181, 2584) by default.

    Returns
    -------
    (ROW,) float32
        Within 1e-4.
    """
    curves = _curves(alpha, eta, refracts, lattice)
    inside = _curves(alpha, 1.0 / eta, True, lattice)[1:] if refracts else [np.zeros(STEPS)] * 3
    row = [*curves, *inside, [_mean(curves[0]), _mean(curves[1])]]
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

#: Rows of a table: where the first one starts, and the number of the last one (a float).
Table = namedtuple("Table", "curves start last")
#: One place between two rows: start of the first, distance to the second, part of that.
Rows = namedtuple("Rows", "curves row step part")
#: A cosine's place in a row: number of the point before it, and the part of the next one.
Place = namedtuple("Place", "index part")


@kernel
def load_table(scene, slot):
    """The `Table` whose start and last row stand in two slots."""
    data = scene.materials.data
    return Table(scene.materials.curves, to_uint(gather(data, slot)), gather(data, slot + 1))


@specialised
def rows_at(program):
    """``(table, root, size) -> Rows``.

    `root` is the coordinate in [0, 1] along which rows stand, `size` their length.
    """
    return _many_rows if MANY_ROWS in program.bsdfs else _one_row


@kernel
def _one_row(table, root, size):
    return Rows(table.curves, table.start, lanes_u32(0), lanes(0.0))


@kernel
def _many_rows(table, root, size):
    x = minimum(maximum(root, 0.0), 1.0) * table.last
    i = to_uint(minimum(x, maximum(table.last - 1.0, 0.0)))
    # A table of one row has no next one.
    step = to_uint(minimum(table.last, 1.0)) * size
    return Rows(table.curves, table.start + i * size, step, x - to_float(i))


@specialised
def read_row(program):
    """``(rows, i) -> number i`` of the row, between two rows interpolated."""
    return _read_two if MANY_ROWS in program.bsdfs else _read_one


@kernel
def _read_one(rows, i):
    return gather(rows.curves, rows.row + i)


@kernel
def _read_two(rows, i):
    a = gather(rows.curves, rows.row + i)
    b = gather(rows.curves, rows.row + rows.step + i)
    return a + rows.part * (b - a)


@kernel
def place_of(cosine):
    """The `Place` of a cosine, in curves over its fourth root."""
    x = sqrt(sqrt(minimum(maximum(cosine, 0.0), 1.0))) * (STEPS - 1.0)
    i = to_uint(minimum(x, STEPS - 2.0))
    return Place(i, x - to_float(i))


@kernel
def read_curve(rows, curve, place):
    """Curve number `curve` at a place."""
    i = place.index + curve * STEPS
    a, b = read_row(rows, i), read_row(rows, i + 1)
    return a + place.part * (b - a)
