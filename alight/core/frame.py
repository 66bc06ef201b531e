"""Orthonormal frames: from world space to the space of a surface and back.

The local z axis is the normal; (s, t, n) is right-handed: s x t = n.
"""

from __future__ import annotations

from alight.core.vec import Vec3, cross, dot
from lanewise.jit import kernel
from lanewise.simd import copysign, sqrt, where


@kernel
def frame_from_normal(n):
    """Two tangents (s, t) that make a right-handed frame with the unit vector n.

    Source: Duff et al. 2017, Building an Orthonormal Basis, Revisited (JCGT 6:1), listing 3.
    """
    sign = copysign(1.0, n.z)
    a = -1.0 / (sign + n.z)
    b = n.x * n.y * a
    s = Vec3(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x)
    t = Vec3(b, sign + n.y * n.y * a, -n.y)
    return s, t


@kernel
def frame_from_tangent(n, tangent):
    """Tangents (s, t), s as near to `tangent` as the unit normal n allows.

    Where `tangent` is zero or along n (within 1e-3), an arbitrary frame.
    """
    along = dot(n, tangent)
    flat = tangent - along * n
    squared = dot(flat, flat)
    usable = squared > 1e-6 * dot(tangent, tangent)
    s0, t0 = frame_from_normal(n)
    s = where(usable, flat * (1.0 / sqrt(where(usable, squared, 1.0))), s0)
    # The subtraction left s off the plane by rounding / sin(angle): once more makes it exact.
    s = s - dot(n, s) * n
    s = where(usable, s * (1.0 / sqrt(dot(s, s))), s0)
    return s, where(usable, cross(n, s), t0)


@kernel
def mirrored_if(mask, w):
    """The local vector w with its height turned over where the mask holds."""
    return Vec3(w.x, w.y, where(mask, -w.z, w.z))


@kernel
def to_local(s, t, n, w):
    """The world vector w in the frame (s, t, n)."""
    return Vec3(dot(w, s), dot(w, t), dot(w, n))


@kernel
def to_world(s, t, n, w):
    """The local vector w in world space."""
    return w.x * s + w.y * t + w.z * n
