"""Shapes from files -> arrays as Mitsuba sees them.

Texture coordinates of OBJ files are turned over (v downwards), and meshes without vertex normals
get some unless they ask for face normals.
"""

from __future__ import annotations

from pathlib import Path

from alight.core.errors import SceneError, quote
from alight.formats.mitsuba.draft import Draft
from alight.formats.reading.packed import content_of
from alight.formats.reading.reach import OutOfReachError
from alight.meshes import obj, ply, serialized
from alight.meshes.normals import vertex_normals
from alight.meshes.serialized import SerializedMesh
from alight.meshes.triangles import MeshArrays
from alight.scene.files import Files
from alight.scene.meshes import checked
from alight.shapes.mesh import Mesh

MOST_BYTES = 2**30


def load_mesh(draft: Draft, mirrored: bool) -> Mesh | None:
    """Read the mesh that a shape names.

    Parameters
    ----------
    draft : Draft
        Of the shape; its `type` names the kind of file.
    mirrored : bool
        Whether its transform turns a right hand into a left one.

    Returns
    -------
    Mesh or None
        The same object for the same file and options; None after a problem.
    """
    p, context = draft.properties, draft.context
    kind = draft.element.type
    face_normals, flip_normals = p.flag("face_normals"), p.flag("flip_normals")
    flip_v = p.flag("flip_tex_coords", kind == "obj")
    index = (p.integer("shape_index", 0) or 0) if kind == "serialized" else 0
    found = p.value("filename", "string")
    if found is None:
        if not p.has("filename"):
            context.report.error(draft.element, 'needs <string name="filename" .../>')
        return None
    element, name = found
    try:
        path = context.reach.find(name)
        key = (path, index, face_normals, flip_v, flip_normals, mirrored)
        if key not in context.loaded:
            mesh = _read(context.meshes, path, name, kind, index)
            context.loaded[key] = _mesh(mesh, face_normals, flip_v, flip_normals, mirrored)
        return context.loaded[key]
    except OutOfReachError as error:
        context.report.lacks(element, error, "the shape is left out")
    except SceneError as error:
        for issue in error.issues:
            context.report.error(element, f"{quote(name)}: {issue.sentence}")
    return None


def _read(files: Files, path: Path, name: str, kind: str, index: int) -> SerializedMesh:
    if kind == "serialized":
        return serialized.read(files.read(_bytes, name, path), index)
    return SerializedMesh(files.read(_READERS[kind], name, path), False)


def _bytes(path: Path, name: str) -> bytes:
    return content_of(path, MOST_BYTES)


def _obj(path: Path, name: str) -> MeshArrays:
    # Mitsuba knows no colours in these files.
    return obj.read(_bytes(path, name))._replace(colors=None)


def _ply(path: Path, name: str) -> MeshArrays:
    return ply.read(_bytes(path, name))


_READERS = {"obj": _obj, "ply": _ply}


def _mesh(
    mesh: SerializedMesh, face_normals: bool, flip_v: bool, flip_normals: bool, mirrored: bool
) -> Mesh:
    arrays, colors = mesh.arrays._replace(colors=None), mesh.arrays.colors
    checked(arrays)
    if colors is not None and not ((colors >= 0.0) & (colors <= 1.0)).all():
        # No reflectances; a material that shows them is refused by the shape.
        colors = None
    uvs = arrays.uvs
    if uvs is not None and flip_v:
        uvs = uvs.copy()
        uvs[:, 1] = 1.0 - uvs[:, 1]
    normals = None if face_normals or mesh.face_normals else arrays.normals
    # Normals of the file tell the outer side even in a mirror. Otherwise the order of the corners
    # does, which a mirror turns over.
    turned_over = mirrored and normals is None
    if normals is None and not (face_normals or mesh.face_normals):
        normals = vertex_normals(arrays.vertices, arrays.faces)
    return Mesh(
        vertices=arrays.vertices,
        faces=arrays.faces,
        normals=normals,
        uvs=uvs,
        colors=colors,
        flip_normals=flip_normals != turned_over,
    )
