"""The lights of a scene as leaves of a tree, and the tables of its choice."""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from alight.compiled.area_maps import AreaMap
from alight.compiled.light_gain import even_groups, points_on_surfaces
from alight.compiled.shapes import CompiledShapes
from alight.core.constants import PI
from alight.core.distributions import cumulative
from alight.core.field_types import Triple
from alight.core.spec import Light
from alight.core.vec import luminance
from alight.lights.bright_disk import Disk
from alight.lights.tree.build import build_tree
from alight.lights.tree.split import Leaves
from alight.lights.tree.traversal import LEAVES, OUTER_CDF
from alight.scene.motion import Motion
from alight.shapes.hit import FLIP, PRIMITIVES
from alight.shapes.hit import INFO as SHAPE_INFO
from alight.shapes.model import SHAPES
from lanewise.vec3 import Vec3

#: Shares of the samples that lights without a place get, if there are others: their power counts
#: the whole scene, of which one point sees little.
LEAST_OUTER, MOST_OUTER = 0.15, 0.85

#: Of an equal share, the part that each light gets at least which is chosen by its power. The power
#: of a sun counts miles of ground; a lamp would never be chosen against it.
LEAST_SHARE = 0.01


class LightRow(NamedTuple):
    """A light before it is a row of the tables.

    Attributes
    ----------
    kind : str
    color : triple
    numbers : (n,) float64
        Its own.
    mean : triple
        Mean colour, for its power.
    texture : int
        Number of the texture of its radiance + 1, 0 if there is none.
    shape : int
        Row of its shape, -1 if there is none.
    areas : (n,) float64, m^2
        Of its triangles, or of its shape.
    cone : ((3,) float64, float, float) or None
        Of a lamp at a point: its axis, and the angles of `Leaves` in radians.
    motion : Motion or None
        While the shutter is open.
    dark : float
        Of a shape that shines: the angle from its normal at which it is dark, radians.
    light : Light or None
        Its description, of a light at a point.
    table : (n,) float32 or None
        Further numbers of it, such as a picture: they start where its `LightTables.info` says.
    disk : Disk or None
        Of a light around the scene: what paths may aim at.
    spread : AreaMap or None
        Of a textured light on a shape: where its light comes from.
    """

    kind: str
    color: Triple
    numbers: NDArray[np.float64]
    mean: Triple
    texture: int = 0
    shape: int = -1
    areas: NDArray[np.float64] = np.zeros(0)
    cone: tuple[NDArray[np.float64], float, float] | None = None
    motion: Motion | None = None
    dark: float = 0.5 * PI
    table: NDArray[np.float32] | None = None
    disk: Disk | None = None
    light: Light | None = None
    spread: AreaMap | None = None

    @property
    def brightness(self) -> float:
        """Luminance of the mean colour."""
        return float(luminance(Vec3(*self.mean)))

    @property
    def strengths(self) -> NDArray[np.float64]:
        """Luminance times area of its triangles, or of its shape, m^2."""
        return self.areas * (self.brightness if self.spread is None else self.spread.brightness)

    @property
    def by_triangle(self) -> NDArray[np.float32]:
        """The distribution of the triangles of its mesh: by their light, where a texture tells."""
        return cumulative(self.areas if self.spread is None else self.strengths)


class Choosing(NamedTuple):
    """How a light is chosen.

    Attributes
    ----------
    tables : list of (n,) float32
        To be joined to `LightTables.cdf`.
    starts : (lights,) uint32
        Where the triangles of each light begin in them.
    probabilities : (lights,) float
        Of each light; in a program with a tree only of those outside it.
    """

    tables: list[NDArray[np.float32]]
    starts: NDArray[np.uint32]
    probabilities: NDArray[np.floating]


def by_power(powers: NDArray[np.float64]) -> NDArray[np.float32]:
    """The distribution of lights of some powers, as of `alight.core.distributions.cumulative`."""
    shining = powers > 0.0
    least = LEAST_SHARE * powers.sum() / max(np.count_nonzero(shining), 1)
    return cumulative(np.where(shining, np.maximum(powers, least), 0.0))


def find_leaves(
    rows: list[LightRow], powers: NDArray[np.float64], shapes: CompiledShapes
) -> Leaves:
    """All lights that have a place and shine, triangle by triangle.

    What moves is known by the whole of its way: a box around it, and a cone around the directions
    that it faces at any time.

    Parameters
    ----------
    rows : list of LightRow
    powers : (n,) float64, W
    shapes : CompiledShapes
    """
    boxes = {index: (low, high) for index, low, high in shapes.boxes()}
    boxes |= {moving.shape: (moving.low, moving.high) for moving in shapes.moving}
    parts = [_no_leaf()]
    for number, (row, power) in enumerate(zip(rows, powers, strict=True)):
        if power <= 0.0:
            continue
        if row.shape >= 0:
            parts.append(_on_shape(number, row, shapes, boxes))
        elif row.cone is not None:
            parts.append(_at_point(number, row, float(power)))
    joined = [np.concatenate(columns) for columns in zip(*parts, strict=True)]
    return Leaves(*joined)


def _no_leaf() -> Leaves:
    vectors, numbers, words = np.zeros((0, 3)), np.zeros(0), np.zeros(0, np.uint32)
    return Leaves(
        low=vectors,
        high=vectors,
        axis=vectors,
        spread=numbers,
        dark=numbers,
        behind=numbers,
        intensity=numbers,
        row=words,
        prim=words,
    )


def _on_shape(number: int, row: LightRow, shapes: CompiledShapes, boxes: dict) -> Leaves:
    model = SHAPES[shapes.rows[row.shape].kind]
    info = shapes.tables.info.array[row.shape * SHAPE_INFO :][:SHAPE_INFO]
    if not model.has_formula:
        return _triangles(number, row, shapes, info)
    low, high = (np.array([bound], float) for bound in boxes[row.shape])
    axis, spread = model.facing(shapes.tables.data.array[info[3] :])
    axis = axis.reshape(1, 3)
    # What faces all directions is no brighter than its largest shadow.
    strength = model.PROJECTION * row.strengths
    word = np.array([number], np.uint32)
    half = 0.5 * np.linalg.norm(high - low, axis=1)
    # What is flat has its middle in its plane.
    behind, spreads, dark = np.zeros(1), np.array([spread]), np.array([row.dark])
    if row.motion is not None and spread < PI:
        axis, turn = row.motion.turned(axis)
        spreads = np.minimum(spread + turn, PI)
    if row.motion is not None or spread:
        behind = half
    return Leaves(
        low=low,
        high=high,
        axis=axis,
        spread=spreads,
        dark=dark,
        behind=behind,
        intensity=strength,
        row=word,
        prim=word * 0,
    )


def _triangles(number: int, row: LightRow, shapes: CompiledShapes, info: np.ndarray) -> Leaves:
    first, count = int(info[5]), int(info[7])
    faces = shapes.tables.faces.array.reshape(-1, 3)[first : first + count]
    corners = shapes.tables.vertices.array.reshape(-1, 3)[faces].astype(float)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    # Triangles without area cannot be hit, nor chosen.
    kept = row.areas > 0.0
    corners, normal = corners[kept], normal[kept]
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    normal = -normal if info[4] & FLIP else normal
    n, low, high = len(normal), corners.min(axis=1), corners.max(axis=1)
    middle, spread = 0.5 * (low + high)[:, None], np.zeros(n)
    behind = np.max(np.sum((middle - corners) * normal[:, None], axis=2), axis=1)
    if row.motion is not None:
        low, high = row.motion.swept(corners)
        normal, spread = row.motion.turned(normal)
        behind = 0.5 * np.linalg.norm(high - low, axis=1)
    return Leaves(
        low=low,
        high=high,
        axis=normal,
        spread=spread,
        dark=np.full(n, row.dark),
        behind=behind,
        intensity=row.strengths[kept],
        row=np.full(n, number, np.uint32),
        prim=np.flatnonzero(kept).astype(np.uint32),
    )


def _at_point(number: int, row: LightRow, power: float) -> Leaves:
    assert row.cone is not None
    axis, spread, dark = row.cone
    solid_angle = 2.0 * PI * (1.0 - np.cos(min(spread + dark, PI)))
    place, word = np.reshape(row.numbers[:3], (1, 3)), np.array([number], np.uint32)
    low, high, axes, cone = place, place, np.reshape(axis, (1, 3)), np.array([spread])
    if row.motion is not None:
        low, high = row.motion.swept(place[:, None])
        axes, turn = row.motion.turned(axes)
        cone = np.minimum(cone + turn, PI)
    return Leaves(
        low=low,
        high=high,
        axis=axes,
        spread=cone,
        dark=np.array([dark]),
        behind=0.5 * np.linalg.norm(high - low, axis=1),
        intensity=np.array([power / max(solid_angle, 1e-9)]),
        row=word,
        prim=word * 0,
    )


def chosen_by_tree(
    rows: list[LightRow],
    powers: NDArray[np.float64],
    leaves: Leaves,
    shapes: CompiledShapes,
    *,
    walked: bool,
) -> Choosing:
    """The tree, the lights outside it, and for each triangle the way to its leaf.

    Parameters
    ----------
    rows : list of LightRow
    powers : (n,) float64, W
    leaves : Leaves
    shapes : CompiledShapes
    walked : bool
        It is looked at where the lights are, not at their intensities alone.
    """
    inner = np.zeros(len(rows))
    np.add.at(inner, leaves.row, 1.0)
    outer = np.where(inner > 0.0, 0.0, powers)
    # Dark rows are in neither; nor are shapes without area.
    outer[[row.shape >= 0 for row in rows]] = 0.0
    total = float(powers.sum())
    share = float(outer.sum()) / total if total > 0.0 else 1.0
    if 0.0 < share < 1.0:
        share = min(max(share, LEAST_OUTER), MOST_OUTER)
    cdf = by_power(outer) if rows else np.zeros(2, np.float32)
    start = OUTER_CDF + cdf.size
    if walked:
        points = points_on_surfaces(shapes, shining_shapes(rows, shapes))
        tree = build_tree(leaves, start, partial(even_groups, points))
    else:
        tree = build_tree(leaves, start)._replace(far=-1.0)
    at = start + tree.top.size + tree.nodes.size
    header = np.array([share, len(rows), start, 0.0, *tree.middle, tree.far], np.float32)
    header.view(np.uint32)[LEAVES] = at
    words = [tree.nodes.ravel(), tree.table]
    tables = [header, cdf, tree.top.ravel(), *(part.view(np.float32) for part in words)]
    starts, at = np.zeros(len(rows), np.uint32), at + tree.table.size
    for number, row in enumerate(rows):
        if row.shape < 0:
            continue
        mine = leaves.row == number
        strands = int(shapes.tables.info.array[row.shape * SHAPE_INFO + 4]) >> PRIMITIVES
        ways = np.zeros((max(len(row.areas), strands, 1), 2), np.uint32)
        ways[leaves.prim[mine]] = np.stack([tree.ways[mine], tree.numbers[mine]], axis=1)
        # Strands are one leaf, whichever of their primitives is met.
        ways[:strands] = ways[0]
        tables.append(ways.ravel().view(np.float32))
        starts[number] = at
        at += ways.size
    return Choosing(tables, starts, np.float32(share) * np.diff(cdf)[: len(rows)])


def shining_shapes(rows: list[LightRow], shapes: CompiledShapes) -> NDArray[np.bool_]:
    """Which shapes are lights."""
    shining = np.zeros(len(shapes.rows), bool)
    shining[[row.shape for row in rows if row.shape >= 0]] = True
    return shining
