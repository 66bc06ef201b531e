r"""How much light facets reflect or transmit after one bounce, in tables over the cosine.

Single scattering reflects and transmits the parts W (of white facets), R and T of the light, and of
the part V there is a refracted direction (`alight.bsdfs.microfacets.visible_facets`). What W and R
+ T lack to 1 met a second facet; dividing by them gives it back. Any Fresnel term of the form a + b
F has the albedos a W + b R and V - a V - b (V - T).

A row holds these at `STEPS` cosines (j / (STEPS - 1))^4, dense where masking changes quickly: W, R,
T, V from outside, then R, T, V from inside, and last the means 2 ∫ W mu dmu and 2 ∫ R mu dmu. Rows
lie at equal steps of the root of alpha, and are interpolated linearly both ways.

Of facets whose roughness depends on the direction, rows lie along three axes: the root of the
lesser alpha, the anisotropy (`alpha_along`), and the root of the cosine between the azimuth and the
rougher direction, which changes first: grazing light across it sees a smooth surface. An axis along
which nothing varies has one row. The means are those over all azimuths.

What a film reflects is no a + b F. Four more curves hold the mean cosines of as many equal parts of
the light that facets without it let in (1 - F of what leaves white ones). With the film's term
there, :math:`E_\text{film} \approx W - (W - R) \langle (1 - F_\text{film}) / (1 - F) \rangle`, the
mean being over the four: within 0.01 where a film is white at the rim.

Source: Turquin 2019, Practical multiple scattering compensation for microfacet models.
"""

from __future__ import annotations

from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from alight.bsdfs.microfacets.visible_facets import LATTICE, Seen, bounce, entering, see_facets
from alight.core.microfacet import Facets
from lanewise.jit import kernel

Array = NDArray[np.float64]

#: Cosines of a curve; curves of a row; its length, with the means at its end.
STEPS = 64
WHITE, REFLECTED, REFRACTED, PASSED, INNER, FILM_COSINES = 0, 1, 2, 3, 3, 7
FILM_PARTS = 4
MEANS = (FILM_COSINES + FILM_PARTS) * STEPS
ROW = MEANS + 2
#: Rows where the roughness varies, and points and generator of the lattice for each of them.
ROWS = 48
FEWER = 987, 610
#: Rows along the root of alpha, the anisotropy and the azimuth where the last two vary with the
#: point, or the last one alone; lattice and cosines for each of them.
GRID = 12, 9, 9
TURNS = 17
FEWEST, COARSE = (377, 233), 32
#: Smoother facets are mirrors to float32.
LEAST_ALPHA = 1e-3


#: Where the last rows along the second and third axis are in `Grid.axes`.
ANISOTROPY_BIT, AZIMUTH_BIT = 6, 10


@kernel
def alpha_along(alpha, anisotropy):
    """The larger alpha, along the tangent."""
    return alpha + (1.0 - alpha) * (anisotropy * anisotropy)


def _cosines(steps: int = STEPS) -> Array:
    return np.maximum(np.linspace(0.0, 1.0, steps) ** 4, 1e-7)


@cache
def _weights_of_mean() -> Array:
    """Weights of a curve's points in 2 ∫ E mu dmu: it is linear in the fourth root of mu."""
    nodes, weights = np.polynomial.legendre.leggauss(128)
    y = 0.5 * (nodes + 1.0)
    ends = np.linspace(0.0, 1.0, STEPS)
    return np.array(
        [np.sum(weights * 4.0 * y**7 * np.interp(y, ends, hat)) for hat in np.eye(STEPS)]
    )


class Needs(NamedTuple):
    """What rows are for.

    Attributes
    ----------
    eta : float
        Index inside over that outside.
    refracts : bool, default False
        Whether the curves of light that passes are needed; else they are 0.
    film : bool, default False
        Whether those of a film are.
    """

    eta: float
    refracts: bool = False
    film: bool = False


def _curves(seen: Seen, needs: Needs) -> Array:
    """All curves, (curves, cosines)."""
    outside = bounce(seen, needs.eta, needs.refracts)
    inside = bounce(seen, 1.0 / needs.eta)[1:] if needs.refracts else [0.0 * outside.white] * 3
    nothing = np.zeros((FILM_PARTS, outside.white.size))
    film = _film_cosines(seen, needs.eta) if needs.film else nothing
    return np.array([*outside, *inside, *film])


def _film_cosines(seen: Seen, eta: float) -> Array:
    """Mean cosines of equal parts of the light that is let in, (parts, cosines)."""
    order = np.argsort(seen.cosine, axis=1)
    c = np.take_along_axis(seen.cosine, order, axis=1)
    weight = np.take_along_axis(entering(seen, eta), order, axis=1)
    # Integrals up to the end of each part, which may lie within a facet's share.
    ends = np.linspace(0.0, 1.0, FILM_PARTS + 1)
    found = []
    for light, moment in zip(np.cumsum(weight, 1), np.cumsum(weight * c, 1), strict=True):
        light, moment = np.append(0.0, light), np.append(0.0, moment)
        found.append(np.diff(np.interp(ends * light[-1], light, moment)) / light[-1])
    return np.array(found).T * FILM_PARTS


@lru_cache(maxsize=256)
def albedo_row(
    alpha: float, needs: Needs, lattice: tuple[int, int] = LATTICE
) -> NDArray[np.float32]:
    """Numbers of GGX facets of the same roughness in all directions.

    Parameters
    ----------
    alpha : float
    needs : Needs
    lattice : (int, int)
        Points and generator of the facets' lattice.

    Returns
    -------
    (ROW,) float32
        Within 1e-4.
    """
    curves = _curves(see_facets(Facets(alpha, alpha, 0.0), _cosines(), lattice=lattice), needs)
    means = curves[[WHITE, REFLECTED]] @ _weights_of_mean()
    return np.append(curves, means).astype(np.float32)


@lru_cache(maxsize=16)
def albedo_rows(root: float | None, needs: Needs) -> NDArray[np.float32]:
    """Rows of facets: one, or where their roughness varies (None) `ROWS`.

    Row i holds the root i / (ROWS - 1) of alpha, which is at least `LEAST_ALPHA`.
    """
    if root is not None:
        return albedo_row(_alpha(root), needs)
    roots = np.linspace(0.0, 1.0, ROWS)
    return np.concatenate([albedo_row(_alpha(float(r)), needs, FEWER) for r in roots])


def _alpha(root: float) -> float:
    return max(root * root, LEAST_ALPHA)


# ---------------------------------------------------------------- facets with a direction


class Grid(NamedTuple):
    """Rows along three axes.

    Attributes
    ----------
    rows : (n,) float32
    axes : int
        The last row along each axis: bits of the first, then of the second and the third.
    """

    rows: NDArray[np.float32]
    axes: int


@lru_cache(maxsize=16)
def facet_rows(root: float | None, anisotropy: float | None, needs: Needs) -> Grid:
    """All rows of a material's facets.

    Parameters
    ----------
    root : float or None
        Root of the lesser alpha, or nothing where it varies with the point.
    anisotropy : float or None
        In [0, 1], or nothing where it varies.
    needs : Needs
    """
    if anisotropy == 0.0:
        return Grid(albedo_rows(root, needs), 0 if root is not None else ROWS - 1)
    alike = root is not None and anisotropy is not None
    turns, lattice, steps = (TURNS, FEWER, STEPS) if alike else (GRID[2], FEWEST, COARSE)
    roots = np.linspace(0.0, 1.0, GRID[0]) if root is None else [root]
    strengths = np.linspace(0.0, 1.0, GRID[1]) if anisotropy is None else [anisotropy]
    rows = []
    for r in roots:
        for strength in strengths:
            facets = Facets(alpha_along(_alpha(r), strength), _alpha(r), 0.0)
            rows.append(_rows_around(facets, needs, turns, lattice, steps))
    last = len(roots) - 1, len(strengths) - 1, turns - 1
    axes = last[0] + (last[1] << ANISOTROPY_BIT) + (last[2] << AZIMUTH_BIT)
    return Grid(np.concatenate(rows), axes)


def _rows_around(
    facets: Facets, needs: Needs, turns: int, lattice: tuple[int, int], steps: int
) -> NDArray[np.float32]:
    """Rows for all azimuths."""
    places = np.linspace(0.0, 1.0, turns)
    fine, coarse = np.linspace(0.0, 1.0, STEPS), np.linspace(0.0, 1.0, steps)
    curves = np.zeros((turns, FILM_COSINES + FILM_PARTS, STEPS))
    for i, azimuth in enumerate(np.arccos(places**2)):
        found = _curves(see_facets(facets, _cosines(steps), float(azimuth), lattice), needs)
        curves[i] = [np.interp(fine, coarse, curve) for curve in found]
    # A mean over azimuths at equal steps; in between the rows are linear in the root of the cosine.
    angles = (np.arange(256) + 0.5) * (0.5 * np.pi / 256)
    roots = np.sqrt(np.cos(angles))
    weights = [np.interp(roots, places, hat).mean() for hat in np.eye(turns)]
    means = np.dot(weights, curves[:, [WHITE, REFLECTED]] @ _weights_of_mean())
    ends = np.broadcast_to(means, (turns, 2))
    return np.concatenate([curves.reshape(turns, -1), ends], axis=1).astype(np.float32).ravel()
