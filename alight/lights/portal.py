r"""Portal: a window through which directions to the surroundings are sampled.

A rectangle without substance, which itself sends nothing. Where a scene has portals, a direction to
the surroundings is drawn through one of them, uniform in the solid angle :math:`\Omega` that it
covers, as often as from the surroundings' own densities; what it brings is the light of the
surroundings, with the density of the mixture of all,

.. math::
    p(\omega) = \sum_k P_k p_k(\omega) + \sum_j P_j \frac{[\omega \in \Omega_j]}{|\Omega_j|}

So no light is lost where there is a way in that has no portal, and a portal placed elsewhere
costs samples and nothing else.

Source: Veach and Guibas, Optimally combining sampling techniques for Monte Carlo rendering,
SIGGRAPH 1995 (a mixture as one technique); Urena, Fajardo, King, An area-preserving parametrization
for spherical rectangles, EGSR 2013. The product of map and window of Bitterli, Novak, Jarosz,
Portal-masked environment map sampling, EGSR 2015, is not formed.
"""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from alight.core.field_types import Triple
from alight.core.spec import Light
from alight.core.vec import cross, dot, length_squared, row_vec3
from alight.core.warps import (
    spherical_rectangle,
    spherical_rectangle_pdf,
    square_to_spherical_rectangle,
)
from alight.lights.tables import from_infinity, row_of
from lanewise.jit import kernel
from lanewise.simd import absolute, is_finite, lanes_vec3, rsqrt, where

#: Numbers of the light's row: a corner and two edges.
CORNER, EDGE_X, EDGE_Y = 4, 7, 10


class Portal(Light):
    """Window to the surroundings: the rectangle of x and y from -1 to 1 of its node."""

    placement: ClassVar[Literal["node", "shape", "environment"]] = "environment"
    has_place: ClassVar[bool] = True
    type: Literal["portal"] = "portal"

    @property
    def is_black(self) -> bool:
        """It sends nothing by itself."""
        return True


EXAMPLES = (Portal(),)

#: A ray that leaves the scene may go through it.
DELTA = False


def place(spec: Portal, to_world: np.ndarray) -> tuple[Triple, np.ndarray]:
    """No colour; the rectangle in the world."""
    x, y, corner = 2.0 * to_world[:3, 0], 2.0 * to_world[:3, 1], to_world[:3, 3]
    return (0.0, 0.0, 0.0), np.concatenate([corner - 0.5 * (x + y), x, y])


def window(numbers: np.ndarray) -> float:
    """Of a portal in m^2, by the numbers of `place`."""
    return float(np.linalg.norm(numbers[3:6]) * np.linalg.norm(numbers[6:9]))


def power(luminance: float, area: float, radius: float) -> float:
    """None; how often it is chosen is for `alight.compiled.lights` to say."""
    return 0.0


@kernel
def seen_from(scene, back, p):
    """The portal as `alight.core.warps` describes it."""
    data, k, one = scene.lights.data, row_of(scene, back), lanes_vec3(1.0)
    corner = row_vec3(data, k + CORNER)
    x, y = one * row_vec3(data, k + EDGE_X), one * row_vec3(data, k + EDGE_Y)
    return spherical_rectangle(one * corner, x, y, p)


@kernel
def sample(scene, back, p, u, u2):
    """Choose a direction; see `alight.lights.environment.sample`."""
    seen = seen_from(scene, back, p)
    through = square_to_spherical_rectangle(seen, u2)
    wi = through * rsqrt(length_squared(through))
    return from_infinity(wi, lanes_vec3(0.0), usable(spherical_rectangle_pdf(seen, through)))


@kernel
def usable(density):
    """0 where p lies in the portal's plane, and sees nothing of it."""
    return where(is_finite(density) & (density > 0.0), density, 0.0)


@kernel
def pdf(scene, back, p, d):
    """Density of `sample` per solid angle, at p for the unit direction d."""
    seen = seen_from(scene, back, p)
    towards = dot(d, seen.z)
    # The plane lies z0 ahead along z.
    ahead = towards > 0.0
    t = seen.z0 / where(ahead, towards, 1.0)
    x, y = t * dot(d, seen.x), t * dot(d, seen.y)
    inside = (x >= seen.x0) & (x <= seen.x1) & (y >= seen.y0) & (y <= seen.y1)
    density = usable(spherical_rectangle_pdf(seen, t * d))
    return where(ahead & inside, density, 0.0)


# ---------------------------------------------------------------- emission


@kernel
def edges_of(scene, back):
    """Corner and two edges, in the world."""
    data, k, one = scene.lights.data, row_of(scene, back), lanes_vec3(1.0)
    corner, x = one * row_vec3(data, k + CORNER), one * row_vec3(data, k + EDGE_X)
    return corner, x, one * row_vec3(data, k + EDGE_Y)


@kernel
def window_point(scene, back, u2):
    """A point of it, all alike."""
    corner, x, y = edges_of(scene, back)
    return corner + u2[0] * x + u2[1] * y


@kernel
def window_pdf(scene, back, o, d):
    """Density, per square metre across d, of the line through o among those through its points."""
    corner, x, y = edges_of(scene, back)
    # o + t d = corner + a x + b y by Cramer's rule: in its plane a square metre is |d . n|.
    n = dot(cross(x, y), d)
    crosses = absolute(n) > 0.0
    per_n, to_o = 1.0 / where(crosses, n, 1.0), o - corner
    a, b = dot(cross(to_o, y), d) * per_n, dot(cross(x, to_o), d) * per_n
    inside = crosses & (a >= 0.0) & (a <= 1.0) & (b >= 0.0) & (b <= 1.0)
    return where(inside, absolute(per_n), 0.0)
