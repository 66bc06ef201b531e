r"""Constant environment: the same radiance from every direction at infinity.

.. math:: L_e(\omega) = L

Source: PBR4 section 12.5.1.
"""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from alight.core.constants import INV_FOUR_PI, PI
from alight.core.field_types import Color, Triple
from alight.core.spec import Light
from alight.core.warps import square_to_uniform_sphere
from alight.lights.tables import from_infinity
from lanewise.jit import kernel
from lanewise.simd import lanes, lanes_vec3


class Constant(Light):
    """Uniform sky.

    Parameters
    ----------
    radiance : Color, W/(m^2 sr), default 1
        Radiance of every direction.
    """

    placement: ClassVar[Literal["node", "shape", "environment"]] = "environment"
    type: Literal["constant"] = "constant"
    radiance: Color = (1.0, 1.0, 1.0)

    def largest_radiance(self) -> float | None:
        """Bound of the radiance that it emits."""
        return max(self.radiance)


EXAMPLES = (Constant(), Constant(radiance=(0.3, 0.5, 0.9)), Constant(radiance=0.0))


#: A ray that leaves the scene finds it.
DELTA = False


def place(spec: Constant, to_world: np.ndarray) -> tuple[Triple, np.ndarray]:
    """Colour; there is no place."""
    return spec.radiance, np.zeros(3)


def power(luminance: float, area: float, radius: float) -> float:
    """W that enter a scene of bounding radius `radius`: 4 pi directions through pi r^2."""
    return 4.0 * PI * PI * radius * radius * luminance


@kernel
def sample(scene, back, p, u, u2):
    """Choose any direction; see `alight.lights.environment.sample`."""
    return from_infinity(square_to_uniform_sphere(u2), lanes_vec3(1.0), lanes(INV_FOUR_PI))


@kernel
def pdf(scene, back, p, d):
    """Density of `sample` per solid angle."""
    return lanes(INV_FOUR_PI)


@kernel
def radiance(scene, back, d):
    """Radiance that arrives from the unit direction d, without the light's colour."""
    return lanes_vec3(1.0)
