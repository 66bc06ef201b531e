r"""Displacement: meshes whose vertices are moved along their normals by a texture.

.. math:: p' = p + s\, (h(u, v) - m)\, n

with the height h, its luminance if it is a colour, the scale s, the midlevel m and the normal n of
the smooth surface. The mesh is cut into triangles whose edges are short enough (`alight.meshes.
tessellation`); then it is a mesh like any other.

Vertices at one place move together, by the mean of their heights and along the sum of their
normals, so a surface without holes has none afterwards: seams of texture coordinates and edges
where normals jump do not open. New normals are those of the moved triangles around.

Source: Cook 1984, Shade trees, section 5; Cook, Carpenter and Catmull 1987, The Reyes image
rendering architecture, displace before shading.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from alight.compiled.kept import Kept
from alight.compiled.materials import MaterialTables
from alight.compiled.program import Program
from alight.compiled.textures import TextureTable
from alight.core.errors import Issue, SceneError
from alight.core.registry import versions
from alight.core.spec import Texture
from alight.core.uv_sets import MOST_SETS, NO_SET, Chart, Corners
from alight.core.vec import Vec3, luminance
from alight.meshes.normals import vertex_normals
from alight.meshes.tessellation import TooManyTrianglesError, tessellated, welded
from alight.meshes.triangles import MeshArrays
from alight.scene.flatten import FlatScene, PlacedShape
from alight.scene.meshes import Geometry, checked
from alight.shapes.arrays import TriangleShape, in_words
from alight.shapes.hit import COLORS, INFO, Surface
from alight.textures.fetch import texture_value
from lanewise.jit import instantiate
from lanewise.view import View

#: Triangles that one mesh is cut into at most: some 2 GB while its tree is built. A mesh whose
#: edges are short enough may have more.
MOST_TRIANGLES = 1 << 22

#: Where a mesh does not say how long edges may be: this share of its box's diagonal.
FINEST = 1 / 256

#: Vertices whose heights are found at a time.
_BAND = 1 << 16


class _Shapes(NamedTuple):
    """What they are given of its shapes: the mesh is the only one, its vertices the first."""

    info: View
    uvs: View
    uv_shifts: View


class _Scene(NamedTuple):
    """What textures are given of a scene."""

    materials: MaterialTables
    shapes: _Shapes


def displaced(flat: FlatScene, kept: Kept | None = None) -> FlatScene:
    """Put displaced meshes into the places of those that shall be; without any, the same scene.

    Those of the result are displaced, and shall not be any more. With `kept`, meshes that are as
    they were the last time are the same arrays, so their trees are kept as well.

    Raises
    ------
    SceneError
        If a mesh would have too many triangles.
    """
    geometries, kept = list(flat.geometries), kept or Kept()
    known: dict[tuple, int] = {}
    shapes = []
    for placed in flat.shapes:
        shape = placed.shape
        if isinstance(shape, TriangleShape) and shape.displacement is not None:
            described = [in_words(value) for _, value in shape if not isinstance(value, np.ndarray)]
            key = placed.geometry, *described
            if key not in known:
                known[key] = len(geometries)
                mesh = flat.geometries[placed.geometry]
                make = partial(_displaced, placed, shape, mesh)
                # The words, the digest and the versions decide what is made.
                says = described, mesh.digest, versions([shape])
                geometries.append(
                    kept(f"displaced {len(known)}", lambda *_, make=make: make(), *says)
                )
            done = shape.model_copy(update={"displacement": None})
            placed = placed._replace(geometry=known[key], shape=done)
        shapes.append(placed)
    return replace(flat, shapes=shapes, geometries=geometries) if known else flat


def told(before: FlatScene, after: FlatScene) -> dict[str, dict[str, int]]:
    """How many triangles displaced meshes have, and how many they had, by the path of the first."""
    found: dict[int, dict[str, int]] = {}
    names: dict[str, dict[str, int]] = {}
    for old, new in zip(before.shapes, after.shapes, strict=True):
        if old.geometry != new.geometry and new.geometry not in found:
            arrays = [a for a in vars(after.geometries[new.geometry]).values() if a is not None]
            found[new.geometry] = names[new.name] = {
                "triangles": len(after.geometries[new.geometry].faces),
                "before": len(before.geometries[old.geometry].faces),
                "bytes": sum(a.nbytes for a in arrays if isinstance(a, np.ndarray)),
            }
    return names


def _displaced(placed: PlacedShape, shape: TriangleShape, mesh: Geometry) -> Geometry:
    edge = shape.displacement_edge
    if edge is None:
        edge = FINEST * float(np.linalg.norm(np.ptp(mesh.vertices.astype(np.float64), axis=0)))
    arrays = MeshArrays(*(getattr(mesh, name) for name in MeshArrays._fields))
    arrays = arrays._replace(vertices=welded(arrays.vertices))
    try:
        fine = tessellated(arrays, edge, MOST_TRIANGLES)
    except TooManyTrianglesError:
        text = (
            f"displacement with edges of at most {edge:g} m makes more than {MOST_TRIANGLES} "
            "triangles; make displacement_edge larger"
        )
        raise SceneError([Issue(placed.name, text)]) from None
    assert shape.displacement is not None and not isinstance(shape.displacement, str)
    heights = heights_of(shape.displacement, fine) - shape.displacement_midlevel
    with np.errstate(over="ignore", invalid="ignore"):
        found = moved(fine, shape.displacement_scale * heights, shape.face_normals)
    try:
        return checked(found)
    except SceneError:
        farthest = abs(shape.displacement_scale) * float(np.abs(heights).max())
        text = f"displacement moves vertices by up to {farthest:g} m, which is too far"
        raise SceneError([Issue(placed.name, text)]) from None


def moved(mesh: MeshArrays, heights: np.ndarray, flat: bool) -> MeshArrays:
    """Move vertices along their smooth normals; those at one place together.

    Parameters
    ----------
    mesh : MeshArrays
    heights : (n,) float64, metres
    flat : bool
        Whether the result is shaded without vertex normals.
    """
    # Adding 0 makes one number of 0 and -0.
    rows = np.ascontiguousarray(mesh.vertices + np.float32(0.0))
    places = rows.view(np.dtype((np.void, rows.itemsize * 3))).ravel()
    _, first, which = np.unique(places, return_index=True, return_inverse=True)
    points, faces = rows[first], which[mesh.faces].astype(np.int32)
    count = np.bincount(which)
    normals = vertex_normals(points, faces).astype(np.float64)
    if mesh.normals is not None:
        lengths = np.linalg.norm(mesh.normals.astype(np.float64), axis=1, keepdims=True)
        unit = mesh.normals / np.where(lengths > 0.0, lengths, 1.0)
        total = np.stack([np.bincount(which, unit[:, i]) for i in range(3)], axis=1)
        size = np.linalg.norm(total, axis=1, keepdims=True)
        normals = np.where(size > 1e-6, total / np.where(size > 0.0, size, 1.0), normals)
    mean = np.bincount(which, heights) / count
    points = (points + mean[:, None] * normals).astype(np.float32)
    if flat:
        return mesh._replace(vertices=points[which], normals=None)
    new = vertex_normals(points, faces)
    # To the side of the old ones, which need not be that of the order of the vertices.
    new = np.where((new * normals).sum(axis=1, keepdims=True) < 0.0, -new, new)
    return mesh._replace(vertices=points[which], normals=new[which])


def heights_of(texture: float | Texture, mesh: MeshArrays) -> np.ndarray:
    """Values of a texture at all vertices, float64, shape (n,); the NumPy twin looks them up."""
    n = len(mesh.vertices)
    if not isinstance(texture, Texture):
        return np.full(n, float(texture))
    if not texture.varies:
        return np.full(n, float(luminance(Vec3(*texture.maximum()))))
    table = TextureTable()
    number = table.number(texture)
    compiled, blank = table.compiled(), View(np.zeros(2, np.uint32))
    tables = MaterialTables(
        info=blank, data=blank, texture=blank, texture_info=compiled.info,
        texture_data=compiled.data, texels=compiled.texels, layers=blank, curves=blank,
    )  # fmt: skip
    program = Program(textures=compiled.names, registered=versions([texture]))
    kernel = instantiate(texture_value, program, compiled=False)
    scene = _Scene(tables, _shapes_of(mesh))
    bands = [slice(start, start + _BAND) for start in range(0, n, _BAND)]
    with np.errstate(all="ignore"):
        found = [_looked_up(kernel, scene, number, mesh, band) for band in bands]
    return np.concatenate(found)


def _shapes_of(mesh: MeshArrays) -> _Shapes:
    n, info = len(mesh.vertices), np.zeros(INFO, np.uint32)
    info[4] = COLORS * (mesh.colors is not None)
    more = [] if mesh.more_uvs is None else list(mesh.more_uvs)
    sets = [np.zeros((1, 2), np.float32)] if mesh.uvs is None else [mesh.uvs, *more]
    shifts = np.full(MOST_SETS, NO_SET, np.uint32)
    shifts[: len(sets)] = n * np.arange(len(sets))
    return _Shapes(View(info), View(np.concatenate(sets)), View(shifts))


def _looked_up(kernel, scene: _Scene, number: int, mesh: MeshArrays, band: slice):
    p = mesh.vertices[band]
    n = len(p)
    zero, none = np.zeros(n, np.float32), np.zeros(n, np.uint32)
    u, v = (zero, zero) if mesh.uvs is None else np.ascontiguousarray(mesh.uvs[band].T)
    # Each vertex is a triangle of three times itself.
    itself = np.arange(band.start, band.start + n, dtype=np.uint32)
    chart = Chart(zero, zero, Corners(itself, itself, itself), none)
    white = np.ones((3, n), np.float32) if mesh.colors is None else mesh.colors[band].T
    nothing = Vec3(zero, zero, zero)
    surface = Surface(
        p=Vec3(*np.ascontiguousarray(p.T)), error=zero, ng=nothing, ns=nothing, s=nothing,
        t=nothing, u=u, v=v, shape=none, prim=none, bsdf=none, light=none,
        color=Vec3(*np.ascontiguousarray(white)), chart=chart, wavelength=(), bend=(),
    )  # fmt: skip
    value = luminance(kernel(scene, none + np.uint32(number), surface, nothing))
    return np.broadcast_to(value, n).astype(np.float64)
