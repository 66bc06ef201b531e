"""Meshes of polygons with any number of corners: Catmull-Clark subdivision, and triangles.

**Subdivision.** Each face becomes one quadrilateral a corner. With F the mean of a face's corners,
an edge gets (v0 + v1 + F0 + F1) / 4, and a vertex of n faces moves to (Q + 2 R + (n - 3) v) / n, Q
being the mean of the F and R that of the middles of its edges. Along borders and creases an edge
gets its middle and a vertex (a + 6 v + b) / 8, a and b being its neighbours on them; corners stay.
A crease of sharpness s is one for s levels. What is given by corners (texture coordinates) is
interpolated linearly.

Source: Catmull and Clark 1978, "Recursively generated B-spline surfaces on arbitrary topological
meshes"; DeRose, Kass and Truong 1998, "Subdivision surfaces in character animation", section 3.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from alight.meshes.concave import cut_polygons

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True)
class Polygons:
    """A mesh.

    Attributes
    ----------
    points : (n, 3) float64
    counts : (f,) int64
        Corners of each face, at least 3.
    corners : (c,) int64
        Vertices of all faces, one face after the other.
    values : dict of str to (c, k) float64
        What is given by corners.
    origin : (f,) int64
        Face of the file that each face comes from.
    creases : (e, 2) int64
        Edges that are sharper than smooth.
    sharpness : (e,) float64
        How many levels they stay so.
    pinned : (p,) int64
        Vertices that are corners.
    """

    points: Floats
    counts: Integers
    corners: Integers
    values: dict[str, Floats] = field(default_factory=dict)
    origin: Integers = field(default_factory=lambda: np.zeros(0, np.int64))
    creases: Integers = field(default_factory=lambda: np.zeros((0, 2), np.int64))
    sharpness: Floats = field(default_factory=lambda: np.zeros(0))
    pinned: Integers = field(default_factory=lambda: np.zeros(0, np.int64))

    @property
    def starts(self) -> Integers:
        """Index of each face's first corner."""
        return np.cumsum(self.counts) - self.counts

    @property
    def face_of_corner(self) -> Integers:
        """Face of each corner."""
        return np.repeat(np.arange(len(self.counts)), self.counts)

    @property
    def next_corner(self) -> Integers:
        """Index of the corner after each one, around its face."""
        following = np.arange(1, len(self.corners) + 1)
        following[self.starts + self.counts - 1] = self.starts
        return following


def subdivided(mesh: Polygons, levels: int) -> Polygons:
    """Subdivide by the rules of Catmull and Clark.

    Parameters
    ----------
    mesh : Polygons
    levels : int >= 0
        Each makes about four times the faces.
    """
    for _ in range(levels):
        mesh = _once(mesh)
    return mesh


def _once(mesh: Polygons) -> Polygons:
    n, f, c = len(mesh.points), len(mesh.counts), len(mesh.corners)
    following = mesh.next_corner
    face = mesh.face_of_corner
    face_points = _means(mesh.points[mesh.corners], face, mesh.counts)
    # Edge i of a face leads from its corner i to the next one.
    ends = np.sort(np.stack([mesh.corners, mesh.corners[following]], axis=1), axis=1)
    keys, edge_of_corner = np.unique(ends[:, 0] * n + ends[:, 1], return_inverse=True)
    edges = np.stack([keys // n, keys % n], axis=1)
    users = np.bincount(edge_of_corner, minlength=len(edges))
    middles = mesh.points[edges].mean(axis=1)
    sharpness = _sharpness_of(edges, mesh)
    is_sharp = (users != 2) | (sharpness > 0.0)
    around = np.zeros((len(edges), 3))
    np.add.at(around, edge_of_corner, face_points[face])
    smooth = 0.5 * middles + 0.25 * around
    edge_points = np.where(is_sharp[:, None], middles, smooth)
    vertex_points = _vertices(mesh, face_points, face, edges, middles, is_sharp)
    points = np.concatenate([vertex_points, edge_points, face_points])
    before = np.zeros(c, np.int64)
    before[following] = np.arange(c)
    quads = np.stack(
        [mesh.corners, n + edge_of_corner, n + len(edges) + face, n + edge_of_corner[before]],
        axis=1,
    )
    values = {}
    for name, table in mesh.values.items():
        middle = 0.5 * (table + table[following])
        center = _means(table, face, mesh.counts)[face]
        values[name] = np.stack([table, middle, center, middle[before]], axis=1).reshape(4 * c, -1)
    sharper = np.flatnonzero(sharpness > 1.0)
    halves = np.concatenate(
        [np.stack([edges[sharper, side], n + sharper], axis=1) for side in (0, 1)]
    )
    return replace(
        mesh,
        points=points,
        counts=np.full(c, 4, np.int64),
        corners=quads.ravel(),
        values=values,
        origin=mesh.origin[face] if len(mesh.origin) == f else face,
        creases=halves,
        sharpness=np.tile(sharpness[sharper] - 1.0, 2),
    )


def _means(table: Floats, face: Integers, counts: Integers) -> Floats:
    """Mean of the rows of each face's corners."""
    columns = [np.bincount(face, column, len(counts)) for column in table.T]
    return np.stack(columns, axis=1) / counts[:, None]


def _sharpness_of(edges: Integers, mesh: Polygons) -> Floats:
    """Sharpness of each edge; 0 for smooth ones."""
    found = np.zeros(len(edges))
    if len(mesh.creases):
        n = len(mesh.points)
        keys = edges[:, 0] * n + edges[:, 1]
        ends = np.sort(mesh.creases, axis=1)
        wanted = ends[:, 0] * n + ends[:, 1]
        place = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
        known = keys[place] == wanted
        np.maximum.at(found, place[known], mesh.sharpness[known])
    return found


def _vertices(
    mesh: Polygons,
    face_points: Floats,
    face: Integers,
    edges: Integers,
    middles: Floats,
    is_sharp: NDArray[np.bool_],
) -> Floats:
    """Where the vertices move."""
    n = len(mesh.points)
    faces = np.bincount(mesh.corners, minlength=n)
    q = np.zeros((n, 3))
    np.add.at(q, mesh.corners, face_points[face])
    r, neighbours = np.zeros((n, 3)), np.zeros((n, 3))
    edge_count, sharp_count = np.zeros(n, np.int64), np.zeros(n, np.int64)
    for this, other in ((0, 1), (1, 0)):
        np.add.at(r, edges[:, this], middles)
        np.add.at(edge_count, edges[:, this], 1)
        np.add.at(sharp_count, edges[is_sharp, this], 1)
        np.add.at(neighbours, edges[is_sharp, this], mesh.points[edges[is_sharp, other]])
    valence = np.maximum(faces, 1)[:, None]
    q, r = q / valence, r / np.maximum(edge_count, 1)[:, None]
    smooth = (q + 2.0 * r + (valence - 3) * mesh.points) / valence
    crease = (neighbours + 6.0 * mesh.points) / 8.0
    moved = np.where((sharp_count == 2)[:, None], crease, smooth)
    # More than two creases meet, a lone face's corner, or a vertex that no face uses.
    stays = (sharp_count > 2) | (faces == 0) | ((faces == 1) & (sharp_count == 2))
    stays[mesh.pinned] = True
    return np.where(stays[:, None], mesh.points, moved)


def vertex_normals(mesh: Polygons) -> Floats:
    """Normals at the vertices: those of the faces around, weighted by area; (n, 3) float64."""
    p, following = mesh.points, mesh.next_corner
    # Newell: the sum of the cross products of a face's edges is twice its area times its normal.
    crosses = np.cross(p[mesh.corners], p[mesh.corners[following]])
    face = mesh.face_of_corner
    areas = np.stack([np.bincount(face, x, len(mesh.counts)) for x in crosses.T], axis=1)
    normals = np.zeros_like(p)
    np.add.at(normals, mesh.corners, areas[face])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return normals / np.where(length > 0.0, length, 1.0)


@dataclass(frozen=True)
class Triangles:
    """Triangles that share vertices wherever all values agree.

    Attributes
    ----------
    vertices : (n, 3) float64
    faces : (t, 3) int64
    values : dict of str to (n, k) float64
    origin : (t,) int64
        Face of the file that each triangle comes from.
    """

    vertices: Floats
    faces: Integers
    values: dict[str, Floats]
    origin: Integers


def triangulated(mesh: Polygons) -> Triangles:
    """Cut faces into triangles."""
    corner, face = cut_polygons(mesh.points[mesh.corners], mesh.counts)
    # A vertex is a point with all its values.
    rows = np.concatenate([mesh.corners[:, None].astype(np.float64), *mesh.values.values()], axis=1)
    unique, index = _unique_rows(rows)
    values, column = {}, 1
    for name, table in mesh.values.items():
        values[name] = unique[:, column : column + table.shape[1]]
        column += table.shape[1]
    origin = mesh.origin if len(mesh.origin) == len(mesh.counts) else np.arange(len(mesh.counts))
    points = mesh.points[unique[:, 0].astype(np.int64)]
    return Triangles(points, index[corner], values, origin[face])


def _unique_rows(rows: Floats) -> tuple[Floats, Integers]:
    """`np.unique` of rows in any order, by a hash of each: ten times as fast."""
    factors = np.random.default_rng(1).integers(1, 2**63, rows.shape[1], np.uint64) * 2 + 1
    bits = np.ascontiguousarray(rows + 0.0).view(np.uint64)
    mixed = bits ^ (bits >> np.uint64(29))
    _, first, index = np.unique(
        (mixed * factors).sum(axis=1, dtype=np.uint64), return_index=True, return_inverse=True
    )
    if np.array_equal(rows[first][index], rows):
        return rows[first], index
    # Two rows with one hash: never seen.
    unique, index = np.unique(rows, axis=0, return_inverse=True)
    return unique, index.reshape(-1)
