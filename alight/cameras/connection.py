r"""Points and directions of the scene as cameras see them: the ends of light paths.

A pixel shows the mean of the radiance L over its square of the film, :math:`I = \int L\,dx\,dy` in
units of pixels. A ray through (x, y) is along v = F + x R + y D, with the viewing axis F and the
steps R and D of one pixel, so that

.. math:: dx\,dy = \frac{|v|^3}{|F \cdot (R \times D)|}\, d\omega

for perspective cameras, and :math:`|F \cdot (R \times D)|^{-1}` per square metre across F for
parallel rays. That is the importance of a connection, per steradian or per square metre.

Source: PBR4 section 16.1.1; Veach 1997, Robust Monte Carlo methods for light transport simulation,
section 8.3.2.
"""

from __future__ import annotations

from collections import namedtuple

from alight.cameras.table import (
    DOWN,
    FOCUS,
    FORWARD,
    HALF_HEIGHT,
    HALF_WIDTH,
    METRES_DOWN,
    METRES_RIGHT,
    ORIGIN,
    RIGHT,
    vector,
)
from alight.core.vec import cross, dot, length, normalize
from lanewise.jit import kernel
from lanewise.simd import absolute, lanes, lanes_mask, lanes_vec3, where

#: o: a point of the camera; w: unit direction to it; distance: m; x, y: pixels of the full film;
#: importance: see above, over the squared distance where it is per steradian, so that irradiance of
#: the camera by a lit point is radiance times its cosine times this; visible: mask.
Connection = namedtuple("Connection", "o w distance x y importance visible")


@kernel
def components(v, a, b, c):
    """Coordinates of v along three vectors, and their determinant."""
    across = cross(b, c)
    determinant = dot(a, across)
    scale = 1.0 / determinant
    return (
        scale * dot(v, across),
        scale * dot(v, cross(c, a)),
        scale * dot(v, cross(a, b)),
        determinant,
    )


@kernel
def film_point(table, lens, d):
    """(x, y, importance per steradian, mask) of rays from a lens point along d of any length.

    lens: from the middle of the lens.
    """
    forward, right, down = vector(table, FORWARD), vector(table, RIGHT), vector(table, DOWN)
    ahead, across, below, determinant = components(d, forward, right, down)
    _, lens_x, lens_y, _ = components(lens, forward, right, down)
    visible = ahead > 0.0
    per_ahead = 1.0 / where(visible, ahead, 1.0)
    # The ray meets the plane of focus where that from the middle of the lens does.
    x = table[HALF_WIDTH] + across * per_ahead + lens_x / table[FOCUS]
    y = table[HALF_HEIGHT] + below * per_ahead + lens_y / table[FOCUS]
    stretch = length(d) * per_ahead
    return x, y, stretch * stretch * stretch / absolute(determinant), visible


@kernel
def connect_point(table, lens, p):
    """The `Connection` of points p with lens points of a perspective camera."""
    o = vector(table, ORIGIN) + lens
    d = p - o
    distance = length(d)
    apart = distance > 0.0
    x, y, per_steradian, visible = film_point(table, lens, d)
    scale = 1.0 / where(apart, distance, 1.0)
    return Connection(
        o=o,
        w=d * -scale,
        distance=distance,
        x=x,
        y=y,
        importance=per_steradian * (scale * scale),
        visible=visible & apart,
    )


@kernel
def connect_far_point(table, lens, d):
    """The `Connection` of a perspective camera with what lies infinitely far along the unit d."""
    x, y, per_steradian, visible = film_point(table, lens, d)
    return Connection(
        o=lanes_vec3(0.0) + vector(table, ORIGIN) + lens,
        w=-d,
        distance=lanes(1e30),
        x=x,
        y=y,
        importance=per_steradian,
        visible=visible,
    )


@kernel
def connect_parallel(table, p):
    """The `Connection` of points p with a camera of parallel rays."""
    forward = vector(table, FORWARD)
    to_p = p - vector(table, ORIGIN)
    right, down = vector(table, METRES_RIGHT), vector(table, METRES_DOWN)
    distance, x, y, determinant = components(to_p, forward, right, down)
    w = lanes_vec3(0.0) - normalize(lanes_vec3(0.0) + forward)
    return Connection(
        o=p + distance * w,
        w=w,
        distance=distance,
        x=table[HALF_WIDTH] + x,
        y=table[HALF_HEIGHT] + y,
        importance=lanes(0.0) + 1.0 / absolute(determinant),
        visible=(distance > 0.0) & lanes_mask(True),
    )
