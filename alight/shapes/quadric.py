"""What the quadrics share: error-free steps, and the matrices of their rows.

Source: Ogita, Rump and Oishi 2005, Accurate Sum and Dot Product, for the error-free steps.
"""

from __future__ import annotations

from alight.core.vec import Vec3, dot, gather_vec3
from lanewise.jit import kernel
from lanewise.simd import fma, gather


@kernel(strict=True)
def two_sum(a, b):
    """a + b as the rounded sum and its exact error."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


@kernel(strict=True)
def excess(f, low, radius):
    """|f + low|^2 - radius^2 with a relative error near 1e-14 of its largest term."""
    xx, yy, zz, rr = f.x * f.x, f.y * f.y, f.z * f.z, radius * radius
    s1, e1 = two_sum(xx, -rr)
    s2, e2 = two_sum(s1, yy)
    s3, e3 = two_sum(s2, zz)
    # What the four squares lost to rounding, and the mixed terms with `low`.
    lost = fma(f.x, f.x, -xx) + fma(f.y, f.y, -yy) + fma(f.z, f.z, -zz)
    lost = lost - fma(radius, radius, -rr)
    return s3 + (e1 + e2 + e3 + lost + 2.0 * dot(f, low))


@kernel(strict=True)
def from_center(p, center):
    """p - center as a rounded difference and its exact error."""
    x, ex = two_sum(p.x, -center.x)
    y, ey = two_sum(p.y, -center.y)
    z, ez = two_sum(p.z, -center.z)
    return Vec3(x, y, z), Vec3(ex, ey, ez)


@kernel(strict=True)
def times(data, k, v):
    """The 3 x 3 matrix at k times v."""
    return Vec3(
        dot(gather_vec3(data, k), v),
        dot(gather_vec3(data, k + 3), v),
        dot(gather_vec3(data, k + 6), v),
    )


@kernel(strict=True)
def transposed_times(data, k, v):
    """The transpose of the 3 x 3 matrix at k times v."""
    along = v.x * gather_vec3(data, k) + v.y * gather_vec3(data, k + 3)
    return along + v.z * gather_vec3(data, k + 6)


@kernel
def column(data, k):
    """A column of the 3 x 3 matrix whose first number is at k."""
    return Vec3(gather(data, k), gather(data, k + 3), gather(data, k + 6))
