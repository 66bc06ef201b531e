"""Primitives of meshes -> arrays of triangles.

Source: Khronos Group, glTF 2.0 specification, section 3.7; KHR_mesh_quantization.
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from alight.core.errors import SceneError
from alight.formats.gltf.accessors import read_accessor
from alight.formats.gltf.container import Document
from alight.formats.gltf.skins import skinned
from alight.formats.gltf.values import Item
from alight.formats.gltf.vertex_colors import OPACITY_SET, opacity_coordinates, vertex_colors
from alight.meshes.triangles import MeshArrays, joined_sets
from alight.scene.meshes import mesh_of
from alight.shapes.arrays import TriangleShape

POINTS, TRIANGLES, STRIP, FAN = 0, 4, 5, 6
_MODES = {0: "points", 1: "lines", 2: "line loops", 3: "line strips"}
_JOINTS = re.compile(r"JOINTS_\d+")


def read_primitive(
    document: Document,
    primitive: Item,
    weights: list[float],
    sets: tuple[int, ...],
    joints: NDArray[np.float64] | None = None,
) -> TriangleShape | None:
    """Read a primitive.

    Parameters
    ----------
    document : Document
    primitive : Item
    weights : list of float
        Of the morph targets.
    sets : tuple of int
        Which sets of texture coordinates its material asks for; the first becomes the own one.
        `OPACITY_SET` stands for the opacity of its colours.
    joints : (n, 4, 4) float64, optional
        Matrices of the joints of its skin.

    Returns
    -------
    TriangleShape or None
        None for points and lines, which have no surface.

    Raises
    ------
    SceneError
        If the arrays make no mesh.
    """
    mode = primitive.integer("mode", TRIANGLES, 0, FAN)
    if mode in _MODES:
        document.report.drop(f"{_MODES[mode]} have no surface")
        return None
    attributes = primitive.object("attributes")
    if attributes is None or not attributes.has("POSITION"):
        document.report.drop("primitives without POSITION")
        return None
    _say_what_is_dropped(document, attributes, sets or (0,))
    vertices = _table(document, attributes, "POSITION", 3)
    assert vertices is not None
    count = len(vertices)
    faces = _faces(document, primitive, mode, count)
    if len(faces) == 0:
        document.report.drop("primitives without triangles")
        return None
    normals = _table(document, attributes, "NORMAL", 3, count)
    uvs, more_uvs = _coordinates(document, primitive, attributes, sets, count)
    colors = vertex_colors(document, attributes, count)
    vertices, normals = _morphed(document, primitive, weights, vertices, normals)
    if joints is not None:
        # Each set holds four further joints.
        names = sorted(name for name in attributes.value if _JOINTS.fullmatch(name))
        tables = [
            tuple(_table(document, attributes, one, 4, count) for one in (name, _weights_of(name)))
            for name in names
            if attributes.has(_weights_of(name))
        ]
        if tables:
            held, shares = (np.concatenate(part, axis=1) for part in zip(*tables, strict=True))
            vertices, normals = skinned(primitive, held, shares, joints, vertices, normals)
    try:
        return mesh_of(MeshArrays(vertices, faces, normals, uvs, colors, more_uvs))
    except SceneError as error:
        raise primitive.fatal("", error.issues[0].sentence) from None


def morph_weights(node: Item, mesh: Item) -> list[float]:
    """Weights of the morph targets of a mesh: those of its node, or its own."""
    owner = node if node.has("weights") else mesh
    found = owner.value.get("weights", [])
    length = len(found) if isinstance(found, list) else 1
    weights = list(owner.numbers("weights", (0.0,) * length))
    counts = [len(primitive.objects("targets")) for primitive in mesh.objects("primitives")]
    targets = max(counts, default=0)
    if owner.has("weights") and len(weights) != targets:
        rest = "the others count as 0" if len(weights) < targets else "the rest is left out"
        text = f"{owner.at('weights')}: has {len(weights)} for {targets} morph targets: {rest}"
        owner.report.approximate(text)
    return weights


def _index(document: Document, owner: Item, key: str) -> int | None:
    return owner.index(key, len(document.list("accessors")), "accessors")


def _table(
    document: Document, attributes: Item, key: str, columns: int, count: int | None = None
) -> NDArray[np.float32] | None:
    """An attribute as float32, or None where there is none."""
    index = _index(document, attributes, key)
    if index is None:
        if attributes.has(key):
            raise SceneError(document.report.issues)
        return None
    table = read_accessor(document, index)
    if table.shape[1] != columns:
        raise attributes.fatal(key, f"must have {columns} components, got {table.shape[1]}")
    if count is not None and len(table) != count:
        raise attributes.fatal(key, f"must have {count} rows as POSITION, got {len(table)}")
    return np.ascontiguousarray(table, np.float32)


def _coordinates(
    document: Document, primitive: Item, attributes: Item, sets: tuple[int, ...], count: int
) -> tuple[NDArray[np.float32] | None, NDArray[np.float32] | None]:
    """The own set of texture coordinates, and the others in one array; v upwards."""
    tables = [_table(document, attributes, f"TEXCOORD_{n}", 2, count) for n in sets or (0,)]
    named = [(n, t) for n, t in zip(sets, tables, strict=False) if n != OPACITY_SET]
    lacking = [f"TEXCOORD_{n}" for n, t in named if t is None]
    if lacking:
        has_others = len(lacking) < len(named)
        instead = "other coordinates of the mesh are" if has_others else "barycentric ones are"
        document.report.approximate(
            f"{primitive.pointer}: it lacks {' and '.join(lacking)}, which its material asks for; "
            f"{instead} taken"
        )
    up = np.float32(1.0)
    upwards = [None if t is None else np.column_stack([t[:, 0], up - t[:, 1]]) for t in tables]
    if OPACITY_SET in sets:
        upwards[sets.index(OPACITY_SET)] = opacity_coordinates(document, attributes, count)
    return joined_sets(upwards)


def _faces(document: Document, primitive: Item, mode: int, count: int) -> NDArray[np.int32]:
    index = _index(document, primitive, "indices")
    if index is None:
        corners = np.arange(count, dtype=np.int64)
    else:
        table = read_accessor(document, index)
        if table.shape[1] != 1 or table.dtype.kind != "u":
            raise primitive.fatal("indices", "must be scalars of unsigned whole numbers")
        corners = table[:, 0]
        if corners.size and int(corners.max()) >= count:
            text = f"must be below the number of vertices, {count}, got {int(corners.max())}"
            raise primitive.fatal("indices", text)
    if mode == TRIANGLES:
        return corners[: len(corners) // 3 * 3].reshape(-1, 3).astype(np.int32)
    if len(corners) < 3:
        return np.zeros((0, 3), np.int32)
    first, second, third = corners[:-2], corners[1:-1], corners[2:]
    if mode == FAN:
        faces = np.stack([second, third, np.full_like(second, corners[0])], axis=1)
    else:
        odd = np.arange(len(first)) % 2 == 1
        faces = np.stack([first, np.where(odd, third, second), np.where(odd, second, third)], 1)
    return faces.astype(np.int32)


def _morphed(
    document: Document,
    primitive: Item,
    weights: list[float],
    vertices: NDArray[np.float32],
    normals: NDArray[np.float32] | None,
) -> tuple[NDArray[np.float32], NDArray[np.float32] | None]:
    """Add the morph targets, each with its weight."""
    for target, weight in zip(primitive.objects("targets"), weights, strict=False):
        if weight == 0.0:
            continue
        for name in target.value:
            if name not in ("POSITION", "NORMAL", "TANGENT"):
                document.report.approximate(f"{target.pointer}: {name} of a morph target stays")
        moved = _table(document, target, "POSITION", 3, len(vertices))
        turned = _table(document, target, "NORMAL", 3, len(vertices))
        with np.errstate(over="ignore", invalid="ignore"):
            if moved is not None:
                vertices = (vertices + weight * moved).astype(np.float32)
            if normals is not None and turned is not None:
                normals = (normals + weight * turned).astype(np.float32)
    return vertices, normals


def _weights_of(joints: str) -> str:
    """Name of the attribute with the shares of a set of joints."""
    return joints.replace("JOINTS", "WEIGHTS")


def _say_what_is_dropped(document: Document, attributes: Item, sets: tuple[int, ...]) -> None:
    used = {"POSITION", "NORMAL", "COLOR_0"}
    for name in filter(_JOINTS.fullmatch, attributes.value):
        used |= {name, _weights_of(name)}
    used |= {f"TEXCOORD_{number}" for number in sets}
    reasons: dict[str, Any] = {
        "TANGENT": "tangents follow from the texture coordinates",
    }
    for name in attributes.value:
        if name not in used:
            document.report.drop(f"{name}: {reasons.get(name, 'not used by the material')}")
