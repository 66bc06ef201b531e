"""Curved shapes as fine meshes: parts of spheres, disks and cylinders, bilinear patches.

Whole spheres, disks and cylinders are shapes of their own; a mesh takes the place of those that are
cut, or whose texture coordinates differ from ours.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

Array = np.ndarray
#: Points and normals at the parameters u and v in [0, 1].
Formula = Callable[[Array, Array], tuple[Array, Array]]

#: Steps of a full circle, and of a bilinear patch that is not flat.
AROUND, ACROSS = 256, 24


def grid(formula: Formula, columns: int, rows: int) -> dict[str, Array]:
    """The keys of a mesh over the unit square of (u, v); u and v turn as the normal says."""
    u, v = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1), indexing="ij")
    points, normals = formula(u.ravel(), v.ravel())
    first = (np.arange(columns)[:, None] * (rows + 1) + np.arange(rows)).ravel()
    right, up = first + rows + 1, first + 1
    faces = np.concatenate(
        [np.stack([first, right, right + 1], 1), np.stack([first, right + 1, up], 1)]
    )
    uvs = np.stack([u.ravel(), v.ravel()], axis=1)
    return {"vertices": points, "faces": faces, "normals": normals, "uvs": uvs}


def sphere(radius: float, low: float, high: float, phi: float) -> dict[str, Array]:
    """The part of a sphere between two heights and up to an angle in radians."""
    bottom, top = np.arccos(low / radius), np.arccos(high / radius)

    def formula(u: Array, v: Array) -> tuple[Array, Array]:
        theta = bottom + v * (top - bottom)
        sine = np.sin(theta)
        n = np.stack([sine * np.cos(u * phi), sine * np.sin(u * phi), np.cos(theta)], axis=1)
        return radius * n, n

    return grid(formula, _steps(phi), max(2, _steps(bottom - top)))


def disk(radius: float, inner: float, height: float, phi: float) -> dict[str, Array]:
    """A ring, or a part of it."""

    def formula(u: Array, v: Array) -> tuple[Array, Array]:
        r = radius + v * (inner - radius)
        flat = np.zeros_like(u)
        points = np.stack([r * np.cos(u * phi), r * np.sin(u * phi), flat + height], axis=1)
        return points, np.stack([flat, flat, flat + 1.0], axis=1)

    # Texture coordinates are not linear on long triangles.
    return grid(formula, _steps(phi), 16)


def cylinder(radius: float, low: float, high: float, phi: float) -> dict[str, Array]:
    """A cylinder, or a part of it."""

    def formula(u: Array, v: Array) -> tuple[Array, Array]:
        x, y = np.cos(u * phi), np.sin(u * phi)
        z = low + v * (high - low)
        return np.stack([radius * x, radius * y, z], 1), np.stack([x, y, 0.0 * z], 1)

    return grid(formula, _steps(phi), 1)


def _steps(angle: float) -> int:
    return max(3, int(np.ceil(AROUND * abs(angle) / (2.0 * np.pi))))


def patch(corners: Array, uvs: Array, normals: Array | None) -> tuple[dict[str, Array], bool]:
    """A bilinear patch, p(u, v) between p00, p10, p01 and p11.

    Parameters
    ----------
    corners : (4, 3) float64
    uvs : (4, 2) float64
        Texture coordinates of the corners.
    normals : (4, 3) float64, optional
        Of the corners; those of the surface by default.

    Returns
    -------
    keys : dict of arrays
        Of a mesh.
    is_exact : bool
        Whether the patch is a parallelogram, which two triangles are.
    """
    twist = corners[0] - corners[1] - corners[2] + corners[3]
    size = float(np.abs(corners - corners[0]).max())
    bent = np.abs(uvs[0] - uvs[1] - uvs[2] + uvs[3]).max() > 1e-9 * max(1.0, np.abs(uvs).max())
    is_exact = bool(np.abs(twist).max() <= 1e-6 * size) and not bent

    def formula(u: Array, v: Array) -> tuple[Array, Array]:
        weights = np.stack([(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v], axis=1)
        if normals is not None:
            return weights @ corners, _unit(weights @ normals)
        along_u = (1 - v)[:, None] * (corners[1] - corners[0]) + v[:, None] * (
            corners[3] - corners[2]
        )
        along_v = (1 - u)[:, None] * (corners[2] - corners[0]) + u[:, None] * (
            corners[3] - corners[1]
        )
        return weights @ corners, _unit(np.cross(along_u, along_v))

    count = 1 if is_exact else ACROSS
    keys = grid(formula, count, count)
    u, v = keys["uvs"].T
    weights = np.stack([(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v], axis=1)
    keys["uvs"] = weights @ uvs
    if is_exact and normals is None:
        del keys["normals"]
    return keys, is_exact


def _unit(vectors: Array) -> Array:
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.where(lengths > 0.0, lengths, 1.0)


def joined(parts: list[dict[str, Array]]) -> dict[str, Array]:
    """One mesh of several that have the same keys."""
    starts = np.cumsum([0, *(len(part["vertices"]) for part in parts)])
    faces = [part["faces"] + start for part, start in zip(parts, starts, strict=False)]
    keys = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    return keys | {"faces": np.concatenate(faces)}


def facing_normals(vertices: Array, faces: Array, normals: Array) -> Array:
    """Turn triangles whose corners run against their vertex normals: pbrt believes the normals."""
    a, b, c = (vertices[faces[:, i]].astype(np.float64) for i in range(3))
    across = np.cross(b - a, c - a)
    wrong = (across * normals[faces].sum(axis=1)).sum(axis=1) < 0.0
    if not wrong.any():
        return faces
    return np.where(wrong[:, None], faces[:, [0, 2, 1]], faces)


def own_corners(keys: dict[str, Array]) -> dict[str, Array]:
    """Give each triangle its own corners with pbrt's texture coordinates (0,0), (1,0), (1,1)."""
    faces = keys["faces"]
    result = {name: keys[name][faces.ravel()] for name in keys if name != "faces"}
    result["faces"] = np.arange(faces.size).reshape(-1, 3)
    result["uvs"] = np.tile([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], (len(faces), 1))
    return result
