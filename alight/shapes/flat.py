r"""What plane, rectangle and disk share: affine images of the plane z = 0.

A point is :math:`p = c + x\,e_1 + y\,e_2`. A row of the table holds, in world space:

=======  ======================================================================
0-3      n, n0: unit normal on the outer side; n . p + n0 = 0 on the plane
4-11     a, a0, b, b0: x = a . p + a0, y = b . p + b0 (a, b lie in the plane)
12-15    c, and the constant part of the error bound
16-19    e1, and the part of the error bound that grows with \|x\|
20-23    e2, and the part that grows with \|y\|
24-27    1 / \|e1\|, \|e1\|, \|e2\|, area
28       1 if e1 and e2 are at right angles, else 0
=======  ======================================================================

Error bound. Let E be the sum over i of \|n_i\| (\|c_i\| + \|x e1_i\| + \|y e2_i\|); it also bounds
\|n0\| and the sum of \|n_i p_i\|. Along n, in units of the machine epsilon times E: rounding
of the row 3 (n, n0, and c with e1, e2), of p 4, of the moved origin 2, of n . o + n0 at that origin
3; together 12. The bound takes gamma(16) E. The sign of n . d is the same in `spawn_origin`.
"""

from __future__ import annotations

import numpy as np

from alight.core.constants import gamma
from alight.core.vec import Vec3, cross, dot, gather_vec3
from alight.shapes.hit import Geometry
from lanewise.jit import kernel
from lanewise.simd import absolute, fma, gather, lanes_vec3

STRIDE = 32
ERROR = gamma(16)
CENTER, E1, E2, AREA, IS_RECTANGLE = 12, 16, 20, 27, 28


def circle() -> np.ndarray:
    """Points (8, 3) of the unit circle in the plane z = 0."""
    angle = np.arange(8) * (np.pi / 4.0)
    return np.stack([np.cos(angle), np.sin(angle), np.zeros(8)], axis=1)


def pack_flat(matrix: np.ndarray, flip: bool, extent: float) -> np.ndarray:
    r"""The row of a flat shape.

    Parameters
    ----------
    matrix : (4, 4) float64
        Object to world; not singular.
    flip : bool
        Turn the outer side over.
    extent : float
        Largest \|x\| and \|y\|; 0 if the error bound is to be evaluated at each point.

    Returns
    -------
    (32,) float32
        With the area of the square \|x\|, \|y\| <= 1 in `AREA`.
    """
    e1, e2, c = (matrix[:3, i].astype(np.float32).astype(np.float64) for i in (0, 1, 3))
    across = np.cross(e1, e2)
    # The inverse transpose takes +z to e1 x e2, turned over by a mirror image.
    outward = np.sign(np.linalg.det(matrix[:3, :3])) * (-1.0 if flip else 1.0)
    n = (outward * across / np.linalg.norm(across)).astype(np.float32)
    a = np.cross(e2, across) / (across @ across)
    b = np.cross(across, e1) / (across @ across)
    row = np.zeros(STRIDE)
    row[0:3], row[3] = n, -(n.astype(np.float64) @ c)
    row[4:7], row[7] = a, -(a @ c)
    row[8:11], row[11] = b, -(b @ c)
    weights = [ERROR * (np.abs(n) @ np.abs(v)) for v in (c, e1, e2)]
    row[12:15], row[15] = c, weights[0] + extent * (weights[1] + weights[2])
    row[16:19], row[19] = e1, weights[1]
    row[20:23], row[23] = e2, weights[2]
    lengths = np.linalg.norm(e1), np.linalg.norm(e2)
    row[24:28] = 1.0 / lengths[0], *lengths, 4.0 * np.linalg.norm(across)
    row[28] = abs(e1 @ e2) <= 1e-6 * lengths[0] * lengths[1]
    return row.astype(np.float32)


@kernel(strict=True)
def meet_plane(data, k, o, d):
    """Where a ray meets the plane of a flat shape.

    Returns
    -------
    t, x, y : float
        Ray parameter and local coordinates; infinite or NaN for a parallel ray.
    """
    height = fma(data[k], o.x, fma(data[k + 1], o.y, fma(data[k + 2], o.z, data[k + 3])))
    rate = fma(data[k], d.x, fma(data[k + 1], d.y, data[k + 2] * d.z))
    t = -height / rate
    px, py, pz = fma(t, d.x, o.x), fma(t, d.y, o.y), fma(t, d.z, o.z)
    x = fma(data[k + 4], px, fma(data[k + 5], py, fma(data[k + 6], pz, data[k + 7])))
    y = fma(data[k + 8], px, fma(data[k + 9], py, fma(data[k + 10], pz, data[k + 11])))
    return t, x, y


@kernel(strict=True)
def local_coordinates(data, k, p):
    """Local coordinates (x, y) of a point of the plane."""
    x = dot(gather_vec3(data, k + 4), p) + gather(data, k + 7)
    y = dot(gather_vec3(data, k + 8), p) + gather(data, k + 11)
    return x, y


@kernel(strict=True)
def point_error(data, k, x, y):
    """The error bound at (x, y) for rows that were packed with extent 0."""
    grown = absolute(x) * gather(data, k + 19) + absolute(y) * gather(data, k + 23)
    return gather(data, k + 15) + grown


@kernel(strict=True)
def flat_point(data, k, x, y):
    """p = c + x e1 + y e2."""
    along = x * gather_vec3(data, k + E1) + y * gather_vec3(data, k + E2)
    return gather_vec3(data, k + CENTER) + along


@kernel
def flat_geometry(data, k, x, y, error, u, v):
    """`Geometry` at the local coordinates (x, y), tangent s along e1."""
    n = gather_vec3(data, k)
    s = gather_vec3(data, k + E1) * gather(data, k + 24)
    p = flat_point(data, k, x, y)
    return Geometry(
        p=p, error=error, ng=n, ns=n, s=s, t=cross(n, s), u=u, v=v, color=lanes_vec3(1.0)
    )


@kernel(strict=True)
def point_on_plane(data, k, n, t, o, d):
    """The hit o + t d brought back to the plane: four gathers where `flat_point` takes nine.

    The rounding of o + t d moves the point along the plane, by no more than the ray's own rounding,
    and off it; one step along n takes the second part back. What is left is the rounding of
    n . p + n0 and of the step, 6 units of the machine epsilon times E, within the bound of the row.
    """
    p = Vec3(fma(t, d.x, o.x), fma(t, d.y, o.y), fma(t, d.z, o.z))
    height = fma(n.x, p.x, fma(n.y, p.y, fma(n.z, p.z, gather(data, k + 3))))
    return Vec3(fma(-height, n.x, p.x), fma(-height, n.y, p.y), fma(-height, n.z, p.z))
