r"""Walks on the specular manifold: from a first direction to one whose chain leads to a lamp.

The last ray of a chain of a given type passes the middle c of a lamp by :math:`m(\omega)`, a
vector across the ray, in units of the lamp's radius. A walk looks for a direction with m = 0 by
Gauss-Newton steps in the plane :math:`\omega_0 + u s + v t`, with derivatives from differences of
rays and Broyden's updates; a step that does not lead nearer is halved. So the scene is only asked
what rays ask, whatever its shapes are.

Where a walk ends, directions of the ellipse :math:`|m| < 1` lead to the lamp's sphere, as far as m
is linear:

.. math:: q(\delta) = \delta^T J^T J\, \delta \le 1 .

A walk is a function of its first direction, of the type, and of the target. All the same nothing
is said about how good its result is: see `alight.integrators.caustics.manifold_sampling`.

Source: Jakob and Marschner, Manifold exploration, SIGGRAPH 2012; Hanika, Droske and Fascione,
Manifold next event estimation, EGSR 2015; Broyden 1965.
"""

from __future__ import annotations

from collections import namedtuple

from alight.core.constants import INV_PI
from alight.core.frame import frame_from_normal
from alight.core.vec import dot, length, normalize
from alight.core.warps import square_to_disk_concentric
from lanewise.jit import kernel
from lanewise.records import replace
from lanewise.simd import lanes, lanes_vec3, maximum, minimum, sqrt, where

#: A walk has arrived where the last ray passes the lamp's middle by so many radii.
NEAR = 1.0
#: Differences of directions, in units of the distance from the unit sphere's middle.
STEP = 1e-3
#: Longest step.
LONGEST = 0.3
#: Steps that are tried, and how short a share of a step may become.
MOST_TRIES, LEAST_SHARE = 25, 0.1
#: Ellipses as large as a disk of this radius are no caustics: paths find these lamps easily. Where
#: a caustic folds they are long and thin; the longer half axis may have this length.
WIDEST, LONGEST_AXIS = 0.3, 1.0
#: Damping, as a share of the mean square of the derivatives: steps exist where J is singular.
DAMPING = 1e-5
#: The ellipse that directions are drawn from is so much longer than the one that is covered.
MARGIN = 1.15

#: Where a walk is. middle: Vec3, unit direction in the middle of its chart; u, v: place; miss:
#: Vec3, m there; by_u, by_v: Vec3, its derivatives; du, dv: the next step, of which `share` is
#: tried; tries: float.
Walker = namedtuple("Walker", "middle u v miss by_u by_v du dv share tries")

#: Where one has ended. w: Vec3, unit direction; a, b, c: q = a u^2 + 2 b u v + c v^2 in the plane
#: across w; density: of directions drawn, per unit of area of that plane; 0 if there is none.
Solution = namedtuple("Solution", "w a b c density")


@kernel
def no_walker():
    """Walks that have not begun."""
    zero, none = lanes(0.0), lanes_vec3(0.0)
    return Walker(
        middle=lanes_vec3(1.0), u=zero, v=zero, miss=none, by_u=none, by_v=none, du=zero, dv=zero,
        share=lanes(1.0), tries=zero,
    )  # fmt: skip


@kernel
def no_solution():
    """Walks that have failed."""
    zero = lanes(0.0)
    return Solution(lanes_vec3(1.0), zero, zero, zero, zero)


@kernel
def starting_at(w, miss):
    """A walk at the direction w."""
    return replace(no_walker(), middle=w, miss=miss)


@kernel
def direction_at(walker, u, v):
    """The unit direction at a place of the chart."""
    s, t = frame_from_normal(walker.middle)
    return normalize(walker.middle + u * s + v * t)


@kernel
def _squares(walker):
    """J^T J, damped: a, b, c."""
    a, c = dot(walker.by_u, walker.by_u), dot(walker.by_v, walker.by_v)
    more = DAMPING * (a + c) + 1e-20
    return a + more, dot(walker.by_u, walker.by_v), c + more


@kernel
def step_from(walker):
    """(du, dv) of Gauss and Newton, at most `LONGEST`."""
    a, b, c = _squares(walker)
    x, y = dot(walker.by_u, walker.miss), dot(walker.by_v, walker.miss)
    scale = -1.0 / maximum(a * c - b * b, 1e-30)
    du, dv = scale * (c * x - b * y), scale * (a * y - b * x)
    shorter = minimum(LONGEST / maximum(sqrt(du * du + dv * dv), 1e-20), 1.0)
    return du * shorter, dv * shorter


@kernel
def updated(walker, du, dv, miss):
    """(by_u, by_v) by Broyden's update: the step (du, dv) has led to that miss."""
    scale = 1.0 / maximum(du * du + dv * dv, 1e-20)
    error = miss - walker.miss - du * walker.by_u - dv * walker.by_v
    return walker.by_u + (du * scale) * error, walker.by_v + (dv * scale) * error


@kernel
def solution_at(walker):
    """The `Solution` of a walk that is near one, by one more step; its chart is about itself."""
    a, b, c = _squares(walker)
    du, dv = step_from(walker)
    w = direction_at(walker, walker.u + du, walker.v + dv)
    determinant = a * c - b * b
    # Of the shorter half axis of q <= 1, which belongs to the smaller eigenvalue.
    mean, difference = 0.5 * (a + c), 0.5 * (a - c)
    least = mean - sqrt(maximum(difference * difference + b * b, 0.0))
    small = determinant * (WIDEST * WIDEST * WIDEST * WIDEST) > 1.0
    fine = small & (least * (LONGEST_AXIS * LONGEST_AXIS) > 1.0)
    density = INV_PI / (MARGIN * MARGIN) * sqrt(maximum(determinant, 0.0))
    return Solution(w, a, b, c, where(fine, density, 0.0))


@kernel
def draw_near(solution, u2):
    """A direction of the larger ellipse about a solution."""
    x, y = square_to_disk_concentric(u2)
    first = sqrt(maximum(solution.a, 1e-20))
    mixed = solution.b / first
    second = sqrt(maximum(solution.c - mixed * mixed, 1e-20))
    v = MARGIN * y / second
    u = (MARGIN * x - mixed * v) / first
    s, t = frame_from_normal(solution.w)
    return normalize(solution.w + u * s + v * t)


@kernel
def place_near(solution, w):
    """(q, density per steradian if it were drawn) of the unit direction w about a solution."""
    s, t = frame_from_normal(solution.w)
    z = dot(w, solution.w)
    ahead = z > 0.5
    scale = 1.0 / where(ahead, z, 1.0)
    u, v = dot(w, s) * scale, dot(w, t) * scale
    q = solution.a * u * u + 2.0 * solution.b * u * v + solution.c * v * v
    inside = ahead & (q <= MARGIN * MARGIN) & (solution.density > 0.0)
    # The plane's area fans out into the solid angle: dw = cos^3 dA.
    return where(inside, q, 2.0 * MARGIN * MARGIN), where(
        inside, solution.density * scale * scale * scale, 0.0
    )


@kernel
def is_nearer(walker, miss):
    """Mask: a step has led nearer to the target."""
    return length(miss) < 0.999 * length(walker.miss)


@kernel
def is_near(miss):
    """Mask: near enough."""
    return length(miss) <= NEAR
