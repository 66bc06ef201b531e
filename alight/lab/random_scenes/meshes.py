"""Small meshes: lumps, rings, crystals and hills, with or without normals, (u, v) and colours."""

from __future__ import annotations

import numpy as np

from alight.core.fields import Interval
from alight.lab.random_scenes.chance import Chance
from alight.lab.random_scenes.descriptions import any_texture
from alight.shapes.mesh import EXAMPLES, Mesh
from alight.textures.nesting import reads_uv


def any_mesh(chance: Chance) -> Mesh:
    """A mesh of about 1 m around the origin."""
    make = chance.choose((_lump, _ring, _crystal, _example))
    return _displaced(chance.named("displacement"), make(chance))


def closed_mesh(chance: Chance) -> Mesh:
    """A mesh of about 1 m without holes, which faces outwards."""
    make = chance.choose((_lump, _ring, _crystal))
    return _displaced(chance.named("displacement"), make(chance))


def hills(chance: Chance, side: float, height: float, steps: int = 9) -> Mesh:
    """Rolling ground around the origin, nearly level in the middle.

    Parameters
    ----------
    chance : Chance
    side : float, metres
        Of the square in x and z.
    height : float, metres
        Of the highest hill; y is up.
    steps : int
        Vertices along a side.
    """
    grid = np.linspace(-0.5, 0.5, steps)
    x, z = np.meshgrid(grid, grid, indexing="ij")
    away = np.minimum(1.0, (x * x + z * z) / 0.12)
    y = height * away * chance.numbers(steps, steps)
    vertices = np.stack([side * x, y, side * z], axis=2).reshape(-1, 3)
    uvs = np.stack([x + 0.5, z + 0.5], axis=2).reshape(-1, 2)
    return _mesh(chance, vertices, _grid_faces(steps, steps), uvs)


def _lump(chance: Chance) -> Mesh:
    """A sphere with bumps."""
    rows, columns = chance.whole(4, 7), chance.whole(5, 11)
    theta = np.linspace(0.0, np.pi, rows)[:, None]
    phi = np.linspace(0.0, 2.0 * np.pi, columns)[None, :]
    bumps = 1.0 - chance.within(0.0, 0.4) * chance.numbers(rows, columns)
    # Each pole, and the seam, is one place.
    bumps[0], bumps[-1], bumps[:, -1] = bumps[0, 0], bumps[-1, 0], bumps[:, 0]
    ones = np.ones_like(phi)
    directions = np.stack(
        [np.sin(theta) * np.cos(phi), np.cos(theta) * ones, -np.sin(theta) * np.sin(phi)], axis=2
    )
    u, v = np.broadcast_to(phi / (2.0 * np.pi), bumps.shape), (1.0 - theta / np.pi) * ones
    uvs = np.stack([u, v], axis=2).reshape(-1, 2)
    vertices = (bumps[..., None] * directions).reshape(-1, 3)
    return _mesh(chance, vertices, _grid_faces(rows, columns)[:, ::-1], uvs)


def _ring(chance: Chance) -> Mesh:
    """A torus of few corners."""
    rows, columns = chance.whole(4, 7), chance.whole(5, 12)
    tube = chance.within(0.1, 0.4)
    a = np.linspace(0.0, 2.0 * np.pi, rows)[:, None]
    b = np.linspace(0.0, 2.0 * np.pi, columns)[None, :]
    radius = 1.0 - tube + tube * np.cos(a)
    vertices = np.stack(
        [radius * np.cos(b), tube * np.sin(a) * np.ones_like(b), radius * np.sin(b)], axis=2
    )
    u, v = np.broadcast_arrays(b / (2.0 * np.pi), a / (2.0 * np.pi))
    uvs = np.stack([u, v], axis=2).reshape(-1, 2)
    return _mesh(chance, vertices.reshape(-1, 3), _grid_faces(rows, columns)[:, ::-1], uvs)


def _crystal(chance: Chance) -> Mesh:
    """A double pyramid with flat faces."""
    corners = chance.whole(3, 8)
    angle = 2.0 * np.pi * np.arange(corners) / corners
    waist = chance.within(0.3, 1.0)
    rim = np.stack([waist * np.cos(angle), np.zeros(corners), waist * np.sin(angle)], axis=1)
    vertices = np.concatenate([rim, [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]])
    i, j = np.arange(corners), (np.arange(corners) + 1) % corners
    top, bottom = np.full(corners, corners), np.full(corners, corners + 1)
    faces = np.concatenate([np.stack([j, i, top], 1), np.stack([i, j, bottom], 1)])
    return Mesh(vertices=_short(vertices), faces=faces, face_normals=True)


def _example(chance: Chance) -> Mesh:
    return chance.choose(EXAMPLES)


def _displaced(chance: Chance, mesh: Mesh) -> Mesh:
    """Now and then with hills and hollows."""
    texture = any_texture(chance, Interval(0.0, 1.0)) if chance.happens(0.2) else None
    if texture is None or (mesh.uvs is None and reads_uv(texture, {})):
        return mesh
    return mesh.replaced(
        displacement=texture,
        displacement_scale=chance.scaled(0.02, 0.3) * chance.choose((-1.0, 1.0)),
        displacement_midlevel=chance.choose((0.0, 0.5)),
        displacement_edge=chance.scaled(0.08, 0.5),
    )


def _grid_faces(rows: int, columns: int) -> np.ndarray:
    """Two triangles for each square of a grid of vertices, (m, 3)."""
    i = np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)[None, :]
    corner = i.ravel()
    first = np.stack([corner, corner + 1, corner + columns + 1], axis=1)
    second = np.stack([corner, corner + columns + 1, corner + columns], axis=1)
    return np.concatenate([first, second])


def _mesh(chance: Chance, vertices: np.ndarray, faces: np.ndarray, uvs: np.ndarray) -> Mesh:
    """A mesh without triangles of no area, and with some of what a mesh may carry."""
    sides = vertices[faces]
    crosses = np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0])
    faces = faces[np.linalg.norm(crosses, axis=1) > 1e-9]
    more = {}
    if chance.happens(0.6):
        more["normals"] = _short(_vertex_normals(vertices, faces))
    if chance.happens(0.8):
        more["uvs"] = _short(uvs)
        if chance.happens(0.2):
            more["more_uvs"] = _short(2.0 * uvs[None])
    if chance.happens(0.3):
        more["colors"] = chance.numbers(len(vertices), 3)
    flat = chance.happens(0.2)
    return Mesh(vertices=_short(vertices), faces=faces, face_normals=flat, **more)


def _vertex_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Means of the faces' normals, by their areas; +y where no face is."""
    sides = vertices[faces]
    crosses = np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0])
    sums = np.zeros_like(vertices)
    for corner in range(3):
        np.add.at(sums, faces[:, corner], crosses)
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    return np.where(lengths > 1e-9, sums / np.maximum(lengths, 1e-9), [0.0, 1.0, 0.0])


def _short(values: np.ndarray) -> np.ndarray:
    return np.round(values, 4) + 0.0
