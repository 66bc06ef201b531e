"""The value type `Vec3`: three components and their operators.

Points, directions, normals and linear RGB colours are all Vec3. Components are scalars, lanes or
NumPy arrays; every operation is component by component. The functions on it are in `vec`.
"""

from __future__ import annotations


class Vec3:
    """Three numbers x, y, z (also r, g, b). Products of two Vec3 are componentwise."""

    __array_ufunc__ = None  # so that ndarray * Vec3 comes to Vec3.__rmul__
    __slots__ = ("x", "y", "z")

    def __init__(self, x, y, z):
        self.x, self.y, self.z = x, y, z

    def __add__(self, other):
        o = _three(other)
        return Vec3(self.x + o[0], self.y + o[1], self.z + o[2])

    def __sub__(self, other):
        o = _three(other)
        return Vec3(self.x - o[0], self.y - o[1], self.z - o[2])

    def __mul__(self, other):
        o = _three(other)
        return Vec3(self.x * o[0], self.y * o[1], self.z * o[2])

    def __truediv__(self, other):
        o = _three(other)
        return Vec3(self.x / o[0], self.y / o[1], self.z / o[2])

    def __rsub__(self, other):
        o = _three(other)
        return Vec3(o[0] - self.x, o[1] - self.y, o[2] - self.z)

    def __rtruediv__(self, other):
        o = _three(other)
        return Vec3(o[0] / self.x, o[1] / self.y, o[2] / self.z)

    __radd__ = __add__
    __rmul__ = __mul__

    def __neg__(self):
        return Vec3(-self.x, -self.y, -self.z)

    def __repr__(self):
        return f"Vec3({self.x}, {self.y}, {self.z})"


def _three(v):
    return (v.x, v.y, v.z) if isinstance(v, Vec3) else (v, v, v)
