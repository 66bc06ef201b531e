r"""Loop's subdivision of triangle meshes, up to the limit surface.

Each level cuts every triangle into four. A vertex with n neighbours moves to
:math:`(1 - n \beta)\, v + \beta \sum v_j` with :math:`\beta = 3/16` for n = 3, else 3 / 8n; a new
one on an edge lies at 3/8 of its ends and 1/8 of the corners opposite. On a border the weights
are 3/4, 1/8, 1/8 and 1/2, 1/2. At last all vertices move to where infinitely many levels would
bring them, :math:`\gamma = 1 / (n + 3 / 8 \beta)` or on a border 2/3, 1/6, 1/6 as on any cubic
B-spline, and get the normal of the limit surface.

Source: Loop, Smooth Subdivision Surfaces Based on Triangles (1987); Hoppe et al., Piecewise Smooth
Surface Reconstruction, SIGGRAPH 1994, for limits and tangents; PBR3 section 3.8 for borders.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MOST_LEVELS = 12
MOST_TRIANGLES = 2**23


class NotManifoldError(ValueError):
    """Triangles that are no surface; the message says where."""


@dataclass(frozen=True)
class _Edges:
    """How triangles hang together.

    Attributes
    ----------
    of_face : (m, 3) int
        The edge from each corner to the next one.
    ends : (e, 2) int
    opposite : (e, 3) float
        Sum of the corners across, of one or two triangles.
    on_border : (e,) bool
    twin : (3 m,) int
        The same edge in the other triangle; -1 on the border.
    """

    of_face: Ints
    ends: Ints
    opposite: Floats
    on_border: NDArray[np.bool_]
    twin: Ints


def subdivide(vertices: Floats, faces: Ints, levels: int) -> tuple[Floats, Floats, Ints]:
    """Refine a mesh and move it to the limit surface.

    Parameters
    ----------
    vertices : (n, 3) float64
    faces : (m, 3) int64
        Counter-clockwise seen from outside.
    levels : int >= 0
        How often every triangle is cut into four.

    Returns
    -------
    vertices, normals : (k, 3) float64
        Normals point outwards, of any length; 0 where there is none.
    faces : (m 4^levels, 3) int64

    Raises
    ------
    NotManifoldError
        If three triangles meet at an edge, or neighbours are turned the other way round.
    """
    faces = np.asarray(faces, np.int64)
    for _ in range(levels):
        edges = _edges(vertices, faces)
        moved = _smoothed(vertices, edges)
        ends = vertices[edges.ends].sum(axis=1)
        inner = 0.375 * ends + 0.125 * edges.opposite
        middles = np.where(edges.on_border[:, None], 0.5 * ends, inner)
        faces = _quartered(faces, edges.of_face + len(vertices))
        vertices = np.concatenate([moved, middles])
    edges = _edges(vertices, faces)
    limit = _smoothed(vertices, edges, at_limit=True)
    return limit, _normals(vertices, faces, edges), faces


def _edges(vertices: Floats, faces: Ints) -> _Edges:
    count = len(vertices)
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    if (start == end).any():
        face = int((start == end).argmax()) // 3
        raise NotManifoldError(f"triangle {face} has the same corner twice")
    low, high = np.minimum(start, end), np.maximum(start, end)
    keys, which, uses = np.unique(low * count + high, return_inverse=True, return_counts=True)
    if (uses > 2).any():
        a, b = divmod(int(keys[(uses > 2).argmax()]), count)
        raise NotManifoldError(f"more than two triangles meet between the vertices {a} and {b}")
    turns = np.bincount(which, np.where(start < end, 1.0, -1.0))
    if (np.abs(turns) > 1.0).any():
        a, b = divmod(int(keys[(np.abs(turns) > 1.0).argmax()]), count)
        text = f"the triangles between the vertices {a} and {b} are turned different ways"
        raise NotManifoldError(text)
    order = np.argsort(which, kind="stable")
    pairs = np.cumsum(uses) - uses
    shared = pairs[uses == 2]
    twin = np.full(len(start), -1, np.int64)
    twin[order[shared]], twin[order[shared + 1]] = order[shared + 1], order[shared]
    across = vertices[np.roll(faces, -2, axis=1).ravel()]
    return _Edges(
        which.reshape(-1, 3),
        np.stack([keys // count, keys % count], axis=1),
        _gathered(which, across, len(keys)),
        uses == 1,
        twin,
    )


def _gathered(into: Ints, rows: Floats, count: int) -> Floats:
    """Sum of the rows that go into each of `count` places."""
    columns = [np.bincount(into, rows[:, i], count) for i in range(3)]
    return np.stack(columns, axis=1).astype(np.float64, copy=False)


def _quartered(faces: Ints, middles: Ints) -> Ints:
    """Triangles of the corners, then the one of the three middles."""
    (a, b, c), (ab, bc, ca) = faces.T, middles.T
    parts = [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
    return np.stack([np.stack(part, axis=1) for part in parts], axis=1).reshape(-1, 3)


def _smoothed(vertices: Floats, edges: _Edges, at_limit: bool = False) -> Floats:
    count = len(vertices)
    inside, valence = _neighbours(vertices, edges.ends, count)
    n = np.maximum(valence, 1.0)
    beta = np.where(valence == 3.0, 3.0 / 16.0, 3.0 / (8.0 * n))
    weight = 1.0 / (n + 3.0 / (8.0 * beta)) if at_limit else beta
    result = (1.0 - valence * weight)[:, None] * vertices + weight[:, None] * inside
    border, borders = _neighbours(vertices, edges.ends[edges.on_border], count)
    share = 1.0 / 3.0 if at_limit else 0.25
    # Two neighbours, or more where pieces of surface touch in a point.
    along = (1.0 - share) * vertices + border * (share / np.maximum(borders, 1.0))[:, None]
    result = np.where((borders > 0.0)[:, None], along, result)
    return np.where((valence > 0.0)[:, None], result, vertices)


def _neighbours(vertices: Floats, ends: Ints, count: int) -> tuple[Floats, Floats]:
    """Sum and number of the neighbours along edges."""
    into, other = ends.ravel(), ends[:, ::-1].ravel()
    numbers = np.bincount(into, minlength=count).astype(np.float64)
    return _gathered(into, vertices[other], count), numbers


def _normals(vertices: Floats, faces: Ints, edges: _Edges) -> Floats:
    """Normals of the limit surface: two tangents across, summed up going around each vertex."""
    count = len(vertices)
    corners, ends = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    last = np.roll(faces, -2, axis=1).ravel()
    valence = np.bincount(edges.ends.ravel(), minlength=count)
    on_border = np.zeros(count, bool)
    on_border[edges.ends[edges.on_border].ravel()] = True
    # Any edge that leaves a vertex will do; on a border the first one counter-clockwise.
    start = np.full(count, -1, np.int64)
    start[corners] = np.arange(len(corners))
    first = np.flatnonzero(edges.twin < 0)
    start[corners[first]] = first
    s, t = np.zeros((count, 3)), np.zeros((count, 3))
    here = np.flatnonzero(start >= 0)
    at = start[here]
    for k in range(int(valence.max(initial=0))):
        ws, wt = _weights(k, valence[here], on_border[here])
        neighbour = vertices[ends[at]] - vertices[here]
        s[here] += ws[:, None] * neighbour
        t[here] += wt[:, None] * neighbour
        before = at - at % 3 + (at + 2) % 3
        following = edges.twin[before]
        # The last neighbour on a border is no start of an edge.
        closing = (following < 0) & (valence[here] == k + 2)
        if closing.any():
            ends_here = here[closing]
            ws, wt = _weights(k + 1, valence[ends_here], on_border[ends_here])
            neighbour = vertices[last[at[closing]]] - vertices[ends_here]
            s[ends_here] += ws[:, None] * neighbour
            t[ends_here] += wt[:, None] * neighbour
        goes_on = (following >= 0) & (valence[here] > k + 1)
        here, at = here[goes_on], following[goes_on]
    return np.cross(s, t)


def _weights(k: int, valence: Ints, on_border: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Weights of the k-th neighbour, less the vertex itself, in the two tangents."""
    n = np.maximum(valence, 2).astype(np.float64)
    turn = 2.0 * np.pi * k / n
    is_first, is_last = k == 0, valence == k + 1
    along = np.where(is_last, -1.0, 1.0 if is_first else 0.0)
    step = np.pi / np.maximum(n - 1.0, 1.0)
    inner = (2.0 - 2.0 * np.cos(step)) * np.sin(k * step)
    # Borders with 2, 3 and 4 neighbours have weights of their own.
    across = np.where(is_first | is_last, -np.sin(step), inner)
    across = np.where(valence == 4, np.where(is_first | is_last, -1.0, 2.0), across)
    across = np.where(valence == 3, np.where(is_first | is_last, 0.0, 1.0), across)
    across = np.where(valence == 2, 1.0, across)
    s = np.where(on_border, along, np.cos(turn))
    t = np.where(on_border, across, np.sin(turn))
    return s, t
