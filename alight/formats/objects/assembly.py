"""Pieces of an object -> the plain data of a scene, with a studio and a camera around it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from alight.core.errors import Issue, SceneError
from alight.formats.materials.surfaces import Surface, plain_surface
from alight.formats.materials.textures import bitmap
from alight.formats.objects.color_maps import limits_of, places_in, strip
from alight.formats.objects.creases import are_of, creased
from alight.formats.objects.pieces import Array, Content, Look, Piece, PlacedView
from alight.formats.reading.names import free_name
from alight.formats.reading.reach import Reach
from alight.formats.scenes.model_scene import Data, ModelScene
from alight.formats.scenes.parsed import Parsed
from alight.meshes.triangles import MeshArrays
from alight.scene import transform
from alight.scene.meshes import mesh_of
from alight.shapes.arrays import TriangleShape
from alight.textures.images import as_image

#: Steps of the native format that put z up, and their matrix.
_UPRIGHT = {"rotate": {"axis": "x", "angle": -90.0}}


def assembled(content: Content, look: Look, name: str, up: str) -> Parsed:
    """Put the pieces of an object into a scene.

    Raises
    ------
    SceneError
        If there is none, or one makes no mesh.
    """
    if not content.pieces:
        raise SceneError(
            [Issue("", "holds no surface and no points: there is nothing to see", name)]
        )
    model = ModelScene(content.report, Reach(), {"": name})
    turned = transform.rotate("x", -90.0).matrix if up == "z" else np.eye(4)
    numbers = [piece.values for piece in content.pieces if piece.values is not None]
    found = limits_of(np.concatenate([np.ravel(part) for part in numbers])) if numbers else (0, 1)
    limits = look.color_range or found
    made: dict[int, TriangleShape] = {}
    for piece in content.pieces:
        key = id(piece.vertices)
        try:
            mesh = made[key] if key in made else _mesh(piece, look, limits)
        except SceneError as error:
            raise SceneError([Issue(i.path, i.message, name) for i in error.issues]) from None
        made[key] = mesh
        _place(model, piece, mesh, turned, look)
    if content.view is not None:
        _see(model, content.view, turned)
    if up == "z":
        model.nodes = {"object": {"transform": _UPRIGHT, "children": model.nodes}}
    return model.finish()


def _place(model: ModelScene, piece: Piece, mesh: TriangleShape, turned: Array, look: Look) -> None:
    model.report.count("meshes")
    surface = _surface(piece, look)
    name = model.name_of((id(mesh), repr(sorted(piece.core.items()))), surface, piece.name)
    node: Data = {"shape": mesh, "bsdf": name}
    if not np.array_equal(piece.to_world, np.eye(4)):
        node["transform"] = {"matrix": piece.to_world.tolist()}
    assert mesh.vertices is not None
    model.bounds.add(mesh.vertices, turned @ piece.to_world)
    model.nodes[free_name(piece.name, model.nodes, "mesh")] = node


def _see(model: ModelScene, view: PlacedView, turned: Array) -> None:
    name = free_name("camera", model.nodes, "camera")
    model.nodes[name] = {
        "camera": view.camera, "transform": {"matrix": view.to_world.tolist()}
    }  # fmt: skip
    model.add_camera(name, view.aspect, turned @ view.to_world)


def _surface(piece: Piece, look: Look) -> Surface:
    plain = plain_surface(piece.colors is not None)
    core: dict[str, Any] = {**plain.core, **piece.core}
    if piece.values is not None:
        texels = strip(look.color_map)
        core["base_color"] = {**bitmap(as_image(texels)), "wrap": "clamp"}
    elif piece.picture is not None:
        picture = bitmap(piece.picture)
        tint = piece.core.get("base_color", [1.0, 1.0, 1.0])
        white = tint == [1.0, 1.0, 1.0]
        core["base_color"] = picture if white else {"type": "multiply", "a": picture, "b": tint}
    return replace(plain, core=core)


def _mesh(piece: Piece, look: Look, limits: tuple[float, float]) -> TriangleShape:
    vertices = np.asarray(piece.vertices, np.float32)
    faces, normals, uvs = np.asarray(piece.faces), piece.normals, piece.uvs
    _check_indices(vertices, faces)
    if len(vertices) and not np.isfinite(vertices).all():
        # Told as any mesh's, before anything is computed of it.
        mesh_of(MeshArrays(vertices, faces.astype(np.int32)))
    origin = np.arange(len(vertices))
    if normals is not None and not are_of(normals, vertices, faces):
        normals = None
    if normals is None and look.smooth > 0.0:
        origin, faces, normals = creased(vertices, faces, look.smooth)
    colors, values = piece.colors, piece.values
    painted = colors if values is None else values
    if painted is not None and piece.by_faces:
        # A face of one colour shares no vertex with another.
        corner = faces.reshape(-1)
        origin, normals = origin[corner], None if normals is None else normals[corner]
        faces = np.arange(len(corner)).reshape(-1, 3)
        painted = np.repeat(painted, 3, axis=0)
    elif painted is not None:
        painted = painted[origin]
    if values is not None:
        uvs, colors = places_in(painted, limits), None
    else:
        uvs, colors = (None if uvs is None else uvs[origin]), painted
    arrays = MeshArrays(
        vertices[origin],
        faces.astype(np.int32),
        normals=None if normals is None else np.asarray(normals, np.float32),
        uvs=None if uvs is None else np.asarray(uvs, np.float32),
        colors=None if colors is None else np.asarray(colors, np.float32),
    )
    return mesh_of(arrays)


def _check_indices(vertices: Array, faces: Array) -> None:
    """Refuse faces of vertices that there are not."""
    if faces.size and not (faces.min() >= 0 and faces.max() < len(vertices)):
        mesh_of(MeshArrays(vertices, np.clip(faces, -(2**31), 2**31 - 1).astype(np.int32)))
