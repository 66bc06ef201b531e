r"""What pbrt 4's random walks between a coat and a matte base come to, in terms of our plastics.

pbrt's layers are `thickness` apart, and what lies between them takes exp(-thickness / cosine) of
the light on each crossing even where nothing scatters; the walk ends at `maxdepth`. Our plastics
have a clear coat and all rounds. Under both, a matte base is seen through a coat whose angles are
alike, so one base looks like the other: with the part T of light from all sides that gets down, the
part R of diffuse light that gets back and N bounces, pbrt's base sends out

.. math:: B = T^2 \rho (1 + \rho R + \dots + (\rho R)^{N - 1}),

ours with T' and R' the light T'^2 rho' / (1 - rho' R'), which is solved for rho'.

Source: PBR4 section 14.3; `alight.bsdfs.microfacets.layered` for T and R.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from alight.bsdfs.microfacets.albedo_rows import LEAST_ALPHA as LEAST_ALPHA
from alight.bsdfs.microfacets.layered import matte_rounds
from alight.bsdfs.plastics.coating import STEPS, coat_row, diffuse_reflectance


class Coat(NamedTuple):
    """A coat of pbrt over a matte base.

    Attributes
    ----------
    alpha : float
    eta : float
    thickness : float
        Optical thickness at right angles.
    bounces : int
        How many times light may meet the base.
    """

    alpha: float
    eta: float
    thickness: float
    bounces: int


def base_of_walk(reflectance: Sequence[float], coat: Coat) -> list[float]:
    """The base of our plastic with `nonlinear` that looks like pbrt's; 3 numbers in [0, 1]."""
    alpha, eta = max(coat.alpha, LEAST_ALPHA), min(max(coat.eta, 1.01), 5.0)
    walked = matte_rounds(eta, alpha, coat.thickness)
    passed, internal = _plastic(coat.alpha, eta)
    found = []
    for rho in reflectance:
        again = rho * walked.internal
        rounds = sum(again**i for i in range(coat.bounces))
        base = rho * (walked.passed / passed) ** 2 * rounds
        found.append(min(base / (1.0 + base * internal), 1.0))
    return found


def _plastic(alpha: float, eta: float) -> tuple[float, float]:
    """T and R of `plastic`, or of `rough_plastic`."""
    if alpha < LEAST_ALPHA:
        return 1.0 - diffuse_reflectance(eta), diffuse_reflectance(1.0 / eta)
    row = coat_row("ggx", alpha, eta)
    mu = np.linspace(0.0, 1.0, STEPS)
    return float(np.trapezoid(2.0 * mu * row[:STEPS], mu)), float(row[STEPS])
