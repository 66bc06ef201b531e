r"""Walks on the specular manifold: from a first direction to one whose chain leads to a lamp.

The last ray of a chain of a given type passes the middle c of a lamp by :math:`m(\omega)`, a
vector across the ray, in units of the lamp's radius. A walk looks for a direction with m = 0 by
Gauss-Newton steps in the plane :math:`\omega_0 + u s + v t`, with derivatives from differences of
rays and Broyden's updates; a step that does not lead nearer is halved. So the scene is only asked
what rays ask, whatever its shapes are.

Where a walk ends, directions of the ellipse :math:`|m| < 1` lead to the lamp's sphere, as far as m
is linear:

.. math:: q(\delta) = \delta^T J^T J\, \delta \le 1 .

Near a focus it is not: an observer there sees the lamp as a ring, or as long arcs of it, and a long
ellipse leaves the arc straight on. So along long ellipses m is looked at once more on either side.
With u along the longer axis and v across, the ellipse is bent to the parabola :math:`v = -\beta
u^2` on which m changes least; it has the same area. It ends where m goes astray all the same.

A walk is a function of its first direction, of the type, and of the target. All the same nothing
is said about how good its result is: see `alight.integrators.caustics.manifold_sampling`.

Source: Jakob and Marschner, Manifold exploration, SIGGRAPH 2012; Hanika, Droske and Fascione,
Manifold next event estimation, EGSR 2015; Broyden 1965.
"""

from __future__ import annotations

from collections import namedtuple

from alight.core.constants import INV_PI
from alight.core.frame import frame_from_normal
from alight.core.vec import Vec3, cross, dot, length, normalize
from alight.core.warps import square_to_disk_concentric
from lanewise.jit import kernel
from lanewise.records import replace
from lanewise.simd import absolute, lanes, lanes_vec3, maximum, minimum, sqrt, where

#: A walk has arrived where the last ray passes the lamp's middle by so many radii.
NEAR = 1.0
#: Differences of directions, in units of the distance from the unit sphere's middle.
STEP = 1e-3
#: Longest step.
LONGEST = 0.3
#: Steps that are tried, and how short a share of a step may become.
MOST_TRIES, LEAST_SHARE = 25, 0.1
#: Ellipses as large as a disk of this radius are no caustics: paths find these lamps easily. Where
#: a caustic folds they are long and thin; of longer ones the half axis ends at this length.
WIDEST, LONGEST_AXIS = 0.3, 1.0
#: Damping, as a share of the mean square of the derivatives: steps exist where J is singular.
DAMPING = 1e-5
#: The ellipse that directions are drawn from is so much longer than the one that is covered.
MARGIN = 1.15

#: By how much m may turn aside within an ellipse, in radii.
ASIDE = 0.5
#: An ellipse may be bent that is so many times as long as it is wide, if a circle of directions of
#: this radius, in radians, would turn aside by more within it.
SLENDER, TIGHT = 4.0, 0.1

#: Where a walk is. middle: Vec3, unit direction in the middle of its chart; u, v: place; miss:
#: Vec3, m there; by_u, by_v: Vec3, its derivatives; du, dv: the next step, of which `share` is
#: tried; tries: float; ahead: Vec3, m at the first place that `Axes.look` tells.
Walker = namedtuple("Walker", "middle u v miss by_u by_v du dv share tries ahead")

#: Of the ellipse |m| < 1 about a walk. x, y: of the chart, unit direction of its longer axis;
#: along, across: Vec3, derivatives of m in that direction and in (-y, x); slender: mask; look: how
#: far along the longer axis m is asked for, where it is.
Axes = namedtuple("Axes", "x y along across slender look")

#: How an ellipse is bent. bend: beta, its middle is at v = -beta u^2; reach: longest half axis.
Bent = namedtuple("Bent", "bend reach")

#: Where one has ended. w: Vec3, unit direction; axis: Vec3, unit vector across it, along which u is
#: measured, v is at right angles: q = along u^2 + across (v + bend u^2)^2; density: of directions
#: drawn, per unit of area of the plane across w; 0 if there is none.
Solution = namedtuple("Solution", "w axis along across bend density")


@kernel
def no_walker():
    """Walks that have not begun."""
    zero, none = lanes(0.0), lanes_vec3(0.0)
    return Walker(
        middle=lanes_vec3(1.0), u=zero, v=zero, miss=none, by_u=none, by_v=none, du=zero, dv=zero,
        share=lanes(1.0), tries=zero, ahead=none,
    )  # fmt: skip


@kernel
def no_solution():
    """Walks that have failed."""
    zero, one = lanes(0.0), lanes(1.0)
    x, z = Vec3(one, zero, zero), Vec3(zero, zero, one)
    return Solution(w=z, axis=x, along=one, across=one, bend=zero, density=zero)


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
def axes_of(walker):
    """The `Axes` of the ellipse about a walk."""
    by_u, by_v = walker.by_u, walker.by_v
    a, b, c = dot(by_u, by_u), dot(by_u, by_v), dot(by_v, by_v)
    half = 0.5 * (a - c)
    root = sqrt(half * half + b * b)
    # Where m changes fastest: across the longer axis.
    x, y = where(half > 0.0, half + root, b), where(half > 0.0, b, root - half)
    size = sqrt(x * x + y * y)
    alike = size < 1e-20
    scale = 1.0 / where(alike, 1.0, size)
    x, y = where(alike, 0.0, x * scale), where(alike, 1.0, y * scale)
    across, along = x * by_u + y * by_v, y * by_u - x * by_v
    wide = 1.0 / maximum(length(across), 1e-10)
    long = 1.0 / maximum(length(along), 1.0 / LONGEST_AXIS)
    return Axes(
        x=y, y=-x, along=along, across=across,
        slender=(long > SLENDER * wide) & (long * long > 2.0 * TIGHT * ASIDE * wide),
        look=sqrt(long * minimum(wide, LONGEST_AXIS)),
    )  # fmt: skip


@kernel
def straight():
    """The `Bent` of ellipses that are not."""
    return Bent(lanes(0.0), lanes(LONGEST_AXIS))


@kernel
def bent_by(walker, axes, behind, fine):
    """The `Bent` of slender ellipses about a walk.

    behind: Vec3, m where `look` is negative; fine: mask, it is known there and ahead. Of what is
    not linear, a bend takes that part which lies in the direction of m across; where the rest, or
    what no parabola follows (of a circle, beta^3 t^4), becomes too large, the ellipse ends.
    """
    aside = 0.5 * (walker.ahead + behind) - walker.miss
    square = maximum(dot(axes.across, axes.across), 1e-20)
    step = dot(aside, axes.across) / square
    rest = length(aside - step * axes.across)
    bend = step / (axes.look * axes.look)
    by_rest = axes.look * sqrt(ASIDE / maximum(rest, 1e-10))
    size = absolute(bend)
    by_bend = sqrt(sqrt(ASIDE / maximum(size * size * size * sqrt(square), 1e-10)))
    reach = minimum(minimum(by_rest, by_bend), LONGEST_AXIS)
    return Bent(where(fine, bend, 0.0), where(fine, reach, minimum(axes.look, LONGEST_AXIS)))


@kernel
def solution_at(walker, axes, bent):
    """The `Solution` of a walk that is near one, by one more step; its plane is across itself."""
    along = dot(axes.along, axes.along)
    across = maximum(dot(axes.across, axes.across), 1e-20)
    limited = along + 1.0 / (bent.reach * bent.reach)
    # The step along a short piece of a long ellipse ends within the piece.
    u = -dot(axes.along, walker.miss) / limited
    v = -dot(axes.across, walker.miss) / across
    far = maximum(sqrt(u * u + v * v) / LONGEST, 1.0)
    u, v = u / far, v / far
    s, t = frame_from_normal(walker.middle)
    first, second = axes.x * s + axes.y * t, axes.x * t - axes.y * s
    v = v - bent.bend * u * u
    at = walker.u * s + walker.v * t + u * first + v * second
    w = normalize(walker.middle + at)
    axis = first - (2.0 * bent.bend * u) * second
    axis = normalize(axis - dot(axis, w) * w)
    whole = along + 1.0 / (LONGEST_AXIS * LONGEST_AXIS)
    fine = whole * across * (WIDEST * WIDEST * WIDEST * WIDEST) > 1.0
    density = INV_PI / (MARGIN * MARGIN) * sqrt(limited * across)
    return Solution(w, axis, limited, across, bent.bend, where(fine, density, 0.0))


@kernel
def draw_near(solution, u2):
    """A direction of the larger ellipse about a solution."""
    x, y = square_to_disk_concentric(u2)
    u = MARGIN * x / sqrt(solution.along)
    v = MARGIN * y / sqrt(solution.across) - solution.bend * u * u
    return normalize(solution.w + u * solution.axis + v * cross(solution.w, solution.axis))


@kernel
def place_near(solution, w):
    """(q, density per steradian if it were drawn) of the unit direction w about a solution."""
    z = dot(w, solution.w)
    ahead = z > 0.5
    scale = 1.0 / where(ahead, z, 1.0)
    u = dot(w, solution.axis) * scale
    v = dot(w, cross(solution.w, solution.axis)) * scale + solution.bend * u * u
    q = solution.along * u * u + solution.across * v * v
    inside = ahead & (q <= MARGIN * MARGIN) & (solution.density > 0.0)
    # The plane's area fans out into the solid angle: dw = cos^3 dA; bending it leaves it as it is.
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
