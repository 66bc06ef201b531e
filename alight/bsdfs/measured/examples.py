"""Small measurements of surfaces that are known: rough metals of one colour.

With D of GGX and masking that does not know of shadowing, f cos theta_i is
F D G_1(wo) G_1(wi) / (4 cos theta_o); sigma is cos theta_o / G_1(wo), and what is left is
s = F G_1(wi).

Source: Walter et al. 2007 for D and G_1, stretched along the axes as by Heitz 2014.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from alight.bsdfs.measured.measurement import Measurement
from alight.bsdfs.measured.warp import Viewed, Warp, sample_warp, warp_tables
from lanewise.view import View

#: Texels of a side: of the directions of facets, and of the square that colours lie in.
COARSE, FINE = (16, 8), (64, 24)

Array = NDArray[np.float64]


def satin(texels: tuple[int, int] = COARSE) -> Measurement:
    """A surface without a grain."""
    elevations = np.linspace(0.0, 1.5, 5 if texels == COARSE else 16)
    return _measurement((0.4, 0.4), np.zeros(1), elevations, (0.7, 0.5, 0.3), texels)


def brushed(texels: tuple[int, int] = COARSE) -> Measurement:
    """A surface with a grain, the same in all quarters."""
    azimuths = np.linspace(-np.pi, -0.5 * np.pi, 3 if texels == COARSE else 10)
    elevations = np.linspace(0.0, 1.5, 4 if texels == COARSE else 16)
    return _measurement((0.25, 0.6), azimuths, elevations, (0.5, 0.6, 0.65), texels)


#: Those that are computed where a scene names them as files.
BUILTIN: dict[str, Callable[[tuple[int, int]], Measurement]] = {
    "builtin:brushed": brushed,
    "builtin:satin": satin,
}


def _measurement(
    alphas: tuple[float, float],
    azimuths: Array,
    elevations: Array,
    color: tuple[float, float, float],
    texels: tuple[int, int],
) -> Measurement:
    side, colors = texels
    u = np.linspace(0.0, 1.0, side)
    facets = _direction(u[None, :], u[:, None])
    ndf, sigma = _ndf(facets, *alphas), _seen(facets, *alphas)
    rows = len(azimuths), len(elevations)
    viewers = _polar(elevations[None, :], azimuths[:, None]).reshape(3, -1)
    # From facets to the square: 2 pi^2 u sin theta.
    area = u[None, :] * np.sqrt(np.maximum(1.0 - facets[2] ** 2, 0.0))
    visible = np.maximum(np.tensordot(viewers, facets, (0, 0)), 0.0) * ndf * area
    vndf = visible.reshape(*rows, side, side).astype(np.float32)
    # What the square's texels are, of each viewer.
    viewer = np.repeat(np.arange(viewers.shape[1], dtype=np.uint32), colors * colors)
    at = np.linspace(0.0, 1.0, colors, dtype=np.float32)
    x, y = (np.tile(c.ravel(), viewers.shape[1]) for c in np.meshgrid(at, at))
    (u_x, u_y), _ = sample_warp(
        _warp(vndf), Viewed(viewer, 0 * viewer, 0 * viewer, 0 * x, 0 * x), (x, y)
    )
    wm, wo = _direction(u_x, u_y), viewers[:, viewer]
    wi = 2.0 * (wo * wm).sum(axis=0) * wm - wo
    light = np.where(wi[2] > 0.0, np.maximum(wi[2], 0.0) / _seen(wi, *alphas), 0.0)
    light = light.reshape(*rows, colors, colors)
    arrays = {
        "theta_i": elevations, "phi_i": azimuths, "ndf": ndf, "sigma": sigma, "vndf": vndf,
        "luminance": light, "rgb": light[:, :, None] * np.array(color)[:, None, None],
    }  # fmt: skip
    return Measurement({name: array.astype(np.float32) for name, array in arrays.items()})


def _warp(vndf: NDArray[np.float32]) -> Warp:
    tables = warp_tables(vndf)
    curves, size = View(tables.ravel().astype(np.float32)), np.uint32(tables.shape[2])
    return Warp(curves, np.uint32(0), size, np.float32(vndf.shape[2]), np.float32(vndf.shape[3]))


def _polar(theta: Array, phi: Array) -> Array:
    sine = np.sin(theta)
    x, y = np.cos(phi) * sine, np.sin(phi) * sine
    return np.array(np.broadcast_arrays(x, y, np.cos(theta)))


def _direction(u_x: Array, u_y: Array) -> Array:
    """Directions of points of the square."""
    return _polar(0.5 * np.pi * u_x * u_x, (2.0 * u_y - 1.0) * np.pi)


def _ndf(w: Array, alpha_x: float, alpha_y: float) -> Array:
    slopes = (w[0] / alpha_x) ** 2 + (w[1] / alpha_y) ** 2 + w[2] ** 2
    return 1.0 / (np.pi * alpha_x * alpha_y * slopes**2)


def _seen(w: Array, alpha_x: float, alpha_y: float) -> Array:
    """Area of facets: cos theta (1 + Lambda)."""
    length = np.sqrt((w[0] * alpha_x) ** 2 + (w[1] * alpha_y) ** 2 + w[2] ** 2)
    return 0.5 * (w[2] + length)
