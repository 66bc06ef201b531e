r"""Triangle: the watertight intersection of a ray with it.

A shear that takes the ray to the z axis turns the question into a flat one: does the projected
triangle a, b, c contain the origin? With edge functions

.. math:: U = c_x b_y - c_y b_x, \quad V = a_x c_y - a_y c_x, \quad W = b_x a_y - b_y a_x

it does if none is negative or none is positive. Then :math:`b_1 = V / (U + V + W)`,
:math:`b_2 = W / (U + V + W)`, and t is the same mixture of the three depths.

Why nothing leaks: the projected corners are float32 numbers that depend on the ray and the corner
only, so neighbours share them; an edge function is accurate to 1.5 units in the last place
(`difference_of_products`), so its sign is the exact one; and zero counts as inside. So every
triangle that contains the origin exactly is hit, and no other.

That no other is hit matters too. In plain float32 a needle, or a triangle seen edge-on, is also
"hit" by rays that pass it at a distance, in the prolongation of its edges, where all three
functions are nothing but rounding; whether such a hit is found then depends on the boxes around it.

Source: Woop, Benthin, Wald 2013, Watertight Ray/Triangle Intersection, JCGT 2(1), which asks double
precision where a function is zero; Kahan's algorithm makes that superfluous. We form t
as a_z + b_1 (b_z - a_z) + b_2 (c_z - a_z), not as (U a_z + V b_z + W c_z) / (U + V + W), which
overflows a million times earlier and is not exact on a wall at right angles to an axis.
"""

from __future__ import annotations

from collections import namedtuple

from alight.core.vec import Vec3
from lanewise.jit import kernel
from lanewise.simd import absolute, fma, mask_bits, maximum, minimum, where
from lanewise.wide import gather_near

#: What the test needs of a ray, once: kx, ky, kz are the axes in cyclic order, kz the one along
#: which |d| is largest (lane of u32 or whole numbers); sx, sy, sz the shear.
Shear = namedtuple("Shear", "kx ky kz sx sy sz")


@kernel(strict=True)
def component(v, k):
    """Component number k (0, 1, 2) of a Vec3; k may differ between lanes."""
    return where(k == 0, v.x, where(k == 1, v.y, v.z))


@kernel(strict=True)
def largest_axis(d):
    """0, 1 or 2: where |d| is largest; the last one of equals."""
    x, y, z = absolute(d.x), absolute(d.y), absolute(d.z)
    return where((x > y) & (x > z), 0, where(y > z, 1, 2))


@kernel(strict=True)
def shear_of(d):
    """The `Shear` of rays with direction d (scalars or lanes); not finite if d is zero."""
    kz = largest_axis(d)
    kx = where(kz == 2, 0, kz + 1)
    ky = where(kx == 2, 0, kx + 1)
    along = component(d, kz)
    return Shear(kx, ky, kz, component(d, kx) / along, component(d, ky) / along, 1.0 / along)


@kernel(strict=True)
def rotated(v, shear):
    """v with its components in the order kx, ky, kz."""
    return Vec3(component(v, shear.kx), component(v, shear.ky), component(v, shear.kz))


@kernel(strict=True)
def difference_of_products(a, b, c, d):
    """A b - c d to within 1.5 units in the last place, so with the exact sign (Kahan).

    Source: Jeannerod, Louvet, Muller 2013, Further analysis of Kahan's algorithm for the accurate
    computation of 2 x 2 determinants, Math. Comp. 82.
    """
    cd = c * d
    error = fma(-c, d, cd)
    return fma(a, b, -cd) + error


@kernel(strict=True)
def sheared(p, shear):
    """Where the shear takes a corner: (x, y)."""
    # Fused: fewer instructions, and one rounding less for the corners.
    return fma(-shear.sx, p.z, p.x), fma(-shear.sy, p.z, p.y)


@kernel(strict=True)
def edge_functions(a, b, c):
    """The functions (U, V, W) of three points in the plane, and whether the origin is inside."""
    (ax, ay), (bx, by), (cx, cy) = a, b, c
    wa = difference_of_products(cx, by, cy, bx)
    wb = difference_of_products(ax, cy, ay, cx)
    wc = difference_of_products(bx, ay, by, ax)
    inside = (minimum(minimum(wa, wb), wc) >= 0.0) | (maximum(maximum(wa, wb), wc) <= 0.0)
    return Vec3(wa, wb, wc), inside


@kernel(strict=True)
def where_met(w, az, ab, ac, shear):
    """(t, u, v) of a triangle: edge functions; depth of a; how much deeper b and c are."""
    reciprocal = 1.0 / (w.x + w.y + w.z)
    u, v = w.y * reciprocal, w.z * reciprocal
    return fma(v, ac, fma(u, ab, az)) * shear.sz, u, v


@kernel(strict=True)
def sheared_hit(a, b, c, shear):
    """The test itself, elementwise: one ray and many triangles, or one triangle and many rays.

    Parameters
    ----------
    a, b, c : Vec3
        Corners relative to the ray's origin, components in the order kx, ky, kz, metres.
    shear : Shear
        Of the ray.

    Returns
    -------
    t : float
        Distance in units of |d|; NaN or infinite where the triangle is degenerate seen along d.
    u, v : float
        Barycentrics b1, b2.
    inside : bool
        True where the ray's line meets the triangle. The caller compares t, which rejects NaN.
    """
    w, inside = edge_functions(sheared(a, shear), sheared(b, shear), sheared(c, shear))
    t, u, v = where_met(w, a.z, b.z - a.z, c.z - a.z, shear)
    return t, u, v, inside


@kernel(strict=True)
def rotated_corner(data, k, shear):
    """The corner at data[k], components in the order kx, ky, kz of each lane."""
    return Vec3(
        gather_near(data, k, shear.kx),
        gather_near(data, k, shear.ky),
        gather_near(data, k, shear.kz),
    )


@kernel(strict=True)
def intersect(data, k, origin, shear, t_max):
    """One triangle against a packet of rays.

    Parameters
    ----------
    data : View of float32
        At k: the corners a, b, c, nine numbers, metres; one more number must follow.
    k : int
        Uniform.
    origin : Vec3
        Ray origins with components in the order kx, ky, kz (`rotated`), metres.
    shear : Shear
        Of the rays.
    t_max : float
        Largest t that counts.

    Returns
    -------
    t, u, v, hit
        As of `sheared_hit`; hit requires 0 < t <= t_max.
    """
    a = rotated_corner(data, k, shear) - origin
    b = rotated_corner(data, k + 3, shear) - origin
    c = rotated_corner(data, k + 6, shear) - origin
    t, u, v, inside = sheared_hit(a, b, c, shear)
    return t, u, v, inside & (t > 0.0) & (t <= t_max)


@kernel(strict=True)
def intersect_pair(data, k, origin, shear, t_max):
    """Two triangles a, b, c and a, c, d against a packet of rays: the nearer hit of each lane.

    The same numbers as from `intersect`, of two equal hits the first one. Two triangles that make a
    flat quadrilateral are hardly ever hit both, so one division serves both, and that is half of
    what a triangle costs.

    Parameters
    ----------
    data : View of float32
        At k: the corners a, b, c, d, twelve numbers, metres; one more number must follow.
    k, origin, shear, t_max
        As of `intersect`.

    Returns
    -------
    t, u, v, hit
        As of `intersect`.
    is_second : mask
        True where the triangle a, c, d is hit.
    """
    a = rotated_corner(data, k, shear) - origin
    b = rotated_corner(data, k + 3, shear) - origin
    c = rotated_corner(data, k + 6, shear) - origin
    d = rotated_corner(data, k + 9, shear) - origin
    flat_a, flat_c = sheared(a, shear), sheared(c, shear)
    w1, inside1 = edge_functions(flat_a, sheared(b, shear), flat_c)
    w2, inside2 = edge_functions(flat_a, flat_c, sheared(d, shear))
    ab, ac, ad = b.z - a.z, c.z - a.z, d.z - a.z
    second = inside2 & ~inside1
    w = Vec3(where(second, w2.x, w1.x), where(second, w2.y, w1.y), where(second, w2.z, w1.z))
    t, u, v = where_met(w, a.z, where(second, ac, ab), where(second, ad, ac), shear)
    hit = (inside1 | inside2) & (t > 0.0) & (t <= t_max)
    if mask_bits(inside1 & inside2) != 0:
        t2, u2, v2 = where_met(w2, a.z, ac, ad, shear)
        hit2 = inside1 & inside2 & (t2 > 0.0) & (t2 <= t_max)
        nearer = hit2 & ~(hit & (t <= t2))
        t, u, v = where(nearer, t2, t), where(nearer, u2, u), where(nearer, v2, v)
        hit, second = hit | nearer, second | nearer
    return t, u, v, hit, second
