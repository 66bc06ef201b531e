r"""Curves -> round strands, and ribbons of triangles.

pbrt's "flat" curves turn their width to every ray, and "cylinder" ones are shaded as if they were
round: both become round strands, as wide from everywhere; those that move, tubes of triangles with
`SIDES` sides. "ribbon" ones keep the normals of the file.

A curve is a row of cubic (or quadratic) Bezier segments, or a B-spline; its width goes linearly
from one end to the other.

Source: pbrt-v4, documentation of the file format, "Shapes"; Wang et al., Computation of rotation
minimizing frames, ACM Transactions on Graphics 27(1), 2008, for frames that do not twist.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from alight.core.errors import quote
from alight.formats.pbrt.context import Data
from alight.formats.pbrt.directives import Directive
from alight.formats.pbrt.placed import Placed, mesh_of
from alight.meshes.surfaces import joined
from alight.shapes.curves import Curves
from alight.shapes.mesh import Mesh
from alight.shapes.strands import StrandShape

Array = np.ndarray
#: Sides of a tube, and pieces of a segment.
SIDES, PIECES = 4, 5
MOST_POINTS = 10_000
#: Triangles or control points of the curves of one material.
MOST = 2**26
_KINDS = ("flat", "cylinder", "ribbon")
#: From four control points in a row of a B-spline to those of Bezier's; and from three.
_CUBIC = np.array([[1, 4, 1, 0], [0, 4, 2, 0], [0, 2, 4, 0], [0, 1, 4, 1]]) / 6.0
#: From Bezier's control points of a quadratic to those of the same as a cubic.
_ELEVATED = np.array([[3, 0, 0], [1, 2, 0], [0, 2, 1], [0, 0, 3]]) / 3.0
_QUADRATIC = np.array([[1, 1, 0], [0, 2, 0], [0, 1, 1]]) / 2.0


@dataclass
class Bundle:
    """Curves of one material in one place: one shape.

    Attributes
    ----------
    directive : Directive
        Of the first one.
    node : dict
        All of it but the shape.
    shapes : list of Mesh or of Curves
    size : int
        Triangles, or control points.
    """

    directive: Directive
    node: Data
    shapes: list[Mesh | StrandShape] = field(default_factory=list)
    size: int = 0

    def add(self, shape: Mesh | StrandShape) -> bool:
        """Add a curve; False if there are too many."""
        counted = shape.faces if isinstance(shape, Mesh) else shape.points
        assert counted is not None
        self.size += len(counted)
        self.shapes.append(shape)
        return self.size <= MOST

    def tied(self) -> Data:
        """The node of all."""
        return {"shape": self.whole(), **self.node}

    def whole(self) -> Mesh | Curves:
        """One shape of all."""
        meshes = [shape for shape in self.shapes if isinstance(shape, Mesh)]
        if meshes:
            names = ("vertices", "normals", "uvs", "faces")
            parts = [{name: getattr(mesh, name) for name in names} for mesh in meshes]
            return Mesh(**joined(parts), flip_normals=meshes[0].flip_normals)
        points = [shape.points for shape in self.shapes if isinstance(shape, StrandShape)]
        radii = [shape.radii for shape in self.shapes if isinstance(shape, StrandShape)]
        return Curves(
            points=np.concatenate([part for part in points if part is not None]),
            radii=np.concatenate([part for part in radii if part is not None]),
            counts=[len(part) for part in points if part is not None],
            basis="bezier",
        )


def has_strands(prototypes: Data, name: str) -> bool:
    """Whether a prototype, or one within it, holds strands."""

    def holds(node: Data) -> bool:
        inner = node.get("instance")
        return (
            isinstance(node.get("shape"), StrandShape)
            or (inner is not None and holds(prototypes[inner]))
            or any(holds(child) for child in node.get("children", {}).values())
        )

    return holds(prototypes[name])


def curve(placed: Placed) -> Mesh | Curves | None:
    """Convert a curve; None after a problem."""
    p = placed.p
    points = p.table("P", "point")
    kind = p.text("type", "flat", _KINDS)
    basis = p.text("basis", "bezier", ("bezier", "bspline"))
    degree = p.integer("degree", 3)
    width = p.number("width", 1.0)
    widths = [p.number("width0", width), p.number("width1", width)]
    normals = p.table("N", "normal")
    p.ignore("curves are cut into pieces of their own", "splitdepth")
    p.find("alpha")
    if points is None or degree not in (2, 3) or min(widths) < 0.0:
        placed.fail('needs "point3 P", a degree of 2 or 3, and widths >= 0')
        return None
    segments = _segments(points, degree, basis)
    if segments is None or len(points) > MOST_POINTS:
        text = f"of {quote(basis)} and degree {degree} needs other numbers of points"
        placed.fail(f"{text}, at most {MOST_POINTS}, got {len(points)}")
        return None
    if kind != "ribbon" and not placed.moves:
        return _strand(segments, widths)
    if kind != "ribbon":
        p.report.warn(p.directive, "moves: triangles are taken")
    t = np.linspace(0.0, 1.0, PIECES * len(segments) + 1)
    center, along = _bezier(segments, t, degree)
    width_at = widths[0] + t * (widths[1] - widths[0])
    if kind == "ribbon" and normals is not None and len(normals) == len(segments) + 1:
        keys = _ribbon(center, along, width_at, _between(normals, t))
        return mesh_of(placed, keys, placed.reverse)
    if kind == "ribbon":
        placed.fail(f"as a ribbon needs {len(segments) + 1} normals N")
        return None
    return mesh_of(placed, _tube(center, along, 0.5 * width_at), placed.reverse)


def _strand(segments: Array, widths: list[float]) -> Curves:
    """A round strand; radii are linear from end to end, as pbrt's widths are."""
    if segments.shape[1] == 3:
        segments = _ELEVATED @ segments
    points = np.concatenate([segments[:, :3].reshape(-1, 3), segments[-1:, 3]])
    t = np.linspace(0.0, 1.0, len(points))
    return Curves(
        points=points, radii=0.5 * (widths[0] + t * (widths[1] - widths[0])), basis="bezier"
    )


def _segments(points: Array, degree: int, basis: str) -> Array | None:
    """Control points of Bezier segments, (n, degree + 1, 3); None where their number is wrong."""
    if basis == "bezier":
        count, rest = divmod(len(points) - 1, degree)
        if count < 1 or rest:
            return None
        return np.stack([points[degree * i : degree * i + degree + 1] for i in range(count)])
    if len(points) <= degree:
        return None
    rows = np.stack([points[i : i + degree + 1] for i in range(len(points) - degree)])
    return (_CUBIC if degree == 3 else _QUADRATIC) @ rows


def _bezier(segments: Array, t: Array, degree: int) -> tuple[Array, Array]:
    """Points and unit tangents at parameters in [0, 1] of the whole row."""
    at = np.minimum((t * len(segments)).astype(int), len(segments) - 1)
    s = (t * len(segments) - at)[:, None]
    rows = [segments[at, i] for i in range(degree + 1)]
    while len(rows) > 2:
        rows = [a + s * (b - a) for a, b in pairwise(rows)]
    along = rows[1] - rows[0]
    # A doubled control point leaves no direction: that of the chord is taken.
    chord = np.gradient(rows[0] + s * along, axis=0)
    lengths = np.linalg.norm(along, axis=1, keepdims=True)
    along = np.where(lengths > 1e-9 * np.abs(segments).max(), along, chord)
    return rows[0] + s * (rows[1] - rows[0]), _unit(along)


def _unit(vectors: Array) -> Array:
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(lengths > 0.0, lengths, 1.0)


def _frames(along: Array) -> Array:
    """A direction across the curve at each point, which turns about it as little as can be."""
    across = np.empty_like(along)
    across[0] = _unit(np.cross(along[0], np.eye(3)[int(np.argmin(np.abs(along[0])))]))
    for i in range(1, len(along)):
        straight = across[i - 1] - (across[i - 1] @ along[i]) * along[i]
        across[i] = _unit(straight)
    return across


def _tube(center: Array, along: Array, radius: Array) -> dict[str, Array]:
    across = _frames(along)
    turn = np.arange(SIDES) * (2.0 * np.pi / SIDES)
    normals = (
        np.cos(turn)[None, :, None] * across[:, None]
        + np.sin(turn)[None, :, None] * np.cross(along, across)[:, None]
    )
    points = center[:, None] + radius[:, None, None] * normals
    first = (SIDES * np.arange(len(center) - 1)[:, None] + np.arange(SIDES)).ravel()
    side = (SIDES * np.arange(len(center) - 1)[:, None] + (np.arange(SIDES) + 1) % SIDES).ravel()
    faces = np.concatenate(
        [
            np.stack([first, side, side + SIDES], 1),
            np.stack([first, side + SIDES, first + SIDES], 1),
        ]
    )
    t = np.linspace(0.0, 1.0, len(center))
    uvs = np.stack(np.meshgrid(turn / (2.0 * np.pi), t), axis=-1).reshape(-1, 2)
    flat = normals.reshape(-1, 3)
    return {"vertices": points.reshape(-1, 3), "faces": faces, "normals": flat, "uvs": uvs}


def _ribbon(center: Array, along: Array, width: Array, normals: Array) -> dict[str, Array]:
    across = _unit(np.cross(along, normals)) * 0.5 * width[:, None]
    points = np.stack([center - across, center + across], axis=1).reshape(-1, 3)
    first = 2 * np.arange(len(center) - 1)
    faces = np.concatenate(
        [np.stack([first, first + 1, first + 3], 1), np.stack([first, first + 3, first + 2], 1)]
    )
    t = np.repeat(np.linspace(0.0, 1.0, len(center)), 2)
    uvs = np.stack([np.tile([0.0, 1.0], len(center)), t], axis=1)
    both = np.repeat(_unit(normals), 2, axis=0)
    return {"vertices": points, "faces": faces, "normals": both, "uvs": uvs}


def _between(normals: Array, t: Array) -> Array:
    places = np.linspace(0.0, 1.0, len(normals))
    return np.stack([np.interp(t, places, normals[:, i]) for i in range(3)], axis=1)
