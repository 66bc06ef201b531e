"""The algebra of `Vec3`: dot and cross products, lengths, reflection."""

from __future__ import annotations

from alight.core.constants import LUMINANCE
from lanewise.jit import kernel
from lanewise.simd import absolute, gather_row, maximum, minimum, rsqrt, sqrt, where
from lanewise.vec3 import Vec3 as Vec3


@kernel
def dot(a, b):
    """a . b = |a| |b| cos(angle)."""
    return a.x * b.x + a.y * b.y + a.z * b.z


@kernel
def cross(a, b):
    """a x b: at right angles to both, length |a| |b| sin(angle), right-handed."""
    return Vec3(
        a.y * b.z - a.z * b.y,
        a.z * b.x - a.x * b.z,
        a.x * b.y - a.y * b.x,
    )


@kernel
def length_squared(a):
    """|a|^2."""
    return dot(a, a)


@kernel
def length(a):
    """|a|."""
    return sqrt(dot(a, a))


@kernel
def normalize(a):
    """a / |a|; NaN for the zero vector."""
    return a * rsqrt(dot(a, a))


@kernel
def renormalize(a):
    """a / |a| for a length within 1e-4 of 1: one step of Newton's method."""
    return a * (1.5 - 0.5 * dot(a, a))


@kernel
def max_component(a):
    """The largest of the three."""
    return maximum(a.x, maximum(a.y, a.z))


@kernel
def min_component(a):
    """The smallest of the three."""
    return minimum(a.x, minimum(a.y, a.z))


@kernel
def absolute_vec3(a):
    """(|x|, |y|, |z|)."""
    return Vec3(absolute(a.x), absolute(a.y), absolute(a.z))


@kernel
def luminance(a):
    """Relative luminance Y of linear sRGB (Rec. 709 primaries, D65)."""
    return LUMINANCE[0] * a.x + LUMINANCE[1] * a.y + LUMINANCE[2] * a.z


@kernel
def reflect(w, n):
    """Mirror image of w about the unit vector n: 2 (w . n) n - w (both point away)."""
    return (2.0 * dot(w, n)) * n - w


@kernel
def lerp(t, a, b):
    """a at t = 0, b at t = 1."""
    return (1.0 - t) * a + t * b


@kernel
def quotient(a, b):
    """The Vec3 a over the number b >= 0; 0 where b is 0."""
    return a * where(b > 0.0, 1.0 / where(b > 0.0, b, 1.0), 0.0)


@kernel
def is_black(a):
    """True where all three are zero."""
    return (a.x == 0.0) & (a.y == 0.0) & (a.z == 0.0)


@kernel
def gather_vec3(view, index):
    """Three neighbours of a table, from `index` on, in each lane."""
    x, y, z = gather_row(view, index, 3)
    return Vec3(x, y, z)


@kernel
def row_vec3(view, i):
    """Three neighbours of a table, from the uniform `i` on: a Vec3 of scalars."""
    return Vec3(view[i], view[i + 1], view[i + 2])
