r"""Directions of a leaf, as its middle would see them.

A nearby lamp lies in another direction from each point of a leaf. So a leaf keeps directions not
from the point p but from a middle c, to the sphere of radius r around it on which most of the light
lies: the ray from p along w meets the sphere at x, and x is seen from c along

.. math:: w' = \frac{x - c}{r}, \qquad
    \frac{d\omega'}{d\omega} = \frac{|x - p|^2}{r^2\, w \cdot w'} .

For points within the sphere this is one to one.

Source: after Ruppert, Herholz and Lensch, Robust fitting of parallax-aware mixtures for path
guiding, SIGGRAPH 2020, who move each lobe by a distance of its own.
"""

from __future__ import annotations

from collections import namedtuple

from alight.core.vec import Vec3, dot, length, normalize
from alight.guiding.tables import FOCUS, LEAF_ROW
from lanewise.jit import kernel
from lanewise.simd import gather_row, sqrt, where

#: Where a point is in the sphere of its leaf. o: from the middle to the point; r: radius, metres; 0
#: where directions are left as they are.
Focus = namedtuple("Focus", "o r")

#: Points farther from the middle than this part of the radius keep their directions.
NEAR = 0.7


@kernel
def focus_at(guide, leaf, p):
    """The focus of the point p in a leaf."""
    x, y, z, r = gather_row(guide.leaves, leaf * LEAF_ROW + FOCUS, 4)
    o = p - Vec3(x, y, z)
    return Focus(o, where(dot(o, o) < NEAR * NEAR * r * r, r, 0.0))


@kernel
def from_middle(focus, w):
    """The unit directions w of a point as its middle sees them, and d omega' / d omega."""
    o, r = focus
    moved = r > 0.0
    b = dot(o, w)
    t = sqrt(where(moved, b * b + r * r - dot(o, o), 1.0)) - b
    seen = normalize(o + w * t)
    return where(moved, seen, w), where(moved, _jacobian(t, r, dot(w, seen)), 1.0)


@kernel
def from_point(focus, w):
    """The inverse of `from_middle`, with the same derivative."""
    o, r = focus
    moved = r > 0.0
    x = w * r - o
    t = where(moved, length(x), 1.0)
    seen = x * (1.0 / t)
    return where(moved, seen, w), where(moved, _jacobian(t, r, dot(w, seen)), 1.0)


@kernel
def _jacobian(t, r, cosine):
    return t * t / (where(r > 0.0, r * r, 1.0) * where(cosine > 0.0, cosine, 1.0))
