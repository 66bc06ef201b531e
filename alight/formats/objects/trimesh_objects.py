"""Objects of trimesh: meshes with their colours, materials and pictures, scenes, point clouds."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from alight.formats.objects.pieces import (
    Content,
    Look,
    Piece,
    PlacedView,
    display_colors,
    wrong,
)
from alight.formats.objects.points import balls
from alight.formats.reading.report import Report
from alight.scene.transform import Matrix
from alight.textures.images import as_image


def read(value: Any, look: Look) -> Content:
    """Read a ``Trimesh``, a ``Scene`` or a ``PointCloud``."""
    content = Content()
    if hasattr(value, "graph") and hasattr(value, "geometry"):
        made: dict[str, Piece] = {}
        for node in sorted(value.graph.nodes_geometry):
            matrix, name = value.graph[node]
            if name in made:
                again = replace(made[name], to_world=np.asarray(matrix, np.float64))
                content.pieces.append(again)
                continue
            before = len(content.pieces)
            geometry = value.geometry[name]
            _add(content, geometry, look, np.asarray(matrix, np.float64), str(name))
            if len(content.pieces) > before:
                made[name] = content.pieces[-1]
        # Asked for a camera that it lacks, a scene makes one up; one without a place shows nothing.
        if value.has_camera and value.camera.name in value.graph.nodes:
            content.view = _view(value)
    else:
        _add(content, value, look, np.eye(4), "mesh")
    return content


def _add(content: Content, geometry: Any, look: Look, to_world: Matrix, name: str) -> None:
    if hasattr(geometry, "faces"):
        piece = _mesh(geometry, content.report)
    elif hasattr(geometry, "colors") and hasattr(geometry, "vertices"):
        colors = np.asarray(geometry.colors)
        has_colors = colors.ndim == 2 and len(colors) == len(geometry.vertices)
        paint = display_colors(colors) if has_colors else None
        piece = balls(np.asarray(geometry.vertices), look, paint, None)
    else:
        content.report.approximate(f"{name}: a {type(geometry).__name__} is left out: no surface")
        return
    piece.to_world, piece.name = to_world, name
    content.pieces.append(piece)


def _mesh(mesh: Any, report: Report) -> Piece:
    if len(mesh.faces) == 0:
        raise wrong("faces", "must hold at least one triangle, got an empty mesh")
    piece = Piece(np.asarray(mesh.vertices), np.asarray(mesh.faces))
    visual = mesh.visual
    if visual.kind == "vertex":
        piece.colors = display_colors(visual.vertex_colors)
    elif visual.kind == "face":
        piece.colors, piece.by_faces = display_colors(visual.face_colors), True
    elif visual.kind == "texture":
        _dress(piece, visual, report)
    if visual.kind in ("vertex", "face") and visual.transparency:
        report.approximate("colours are taken as opaque")
    return piece


def _dress(piece: Piece, visual: Any, report: Report) -> None:
    """Take the material of a mesh with texture coordinates: one with two colours, or glTF's."""
    material = visual.material
    color = _first(material, "baseColorFactor", "diffuse")
    if color is not None:
        part = np.atleast_2d(np.asarray(color))
        given = display_colors(part, "material")[0].tolist()
        if hasattr(material, "baseColorFactor"):
            # Of glTF's materials: a linear multiplier, stored as bytes.
            most = 255.0 if part.dtype.kind in "iu" else 1.0
            given = (part[0, :3] / most).tolist()
        piece.core["base_color"] = given
        if part.shape[1] == 4 and part[0, 3] not in (255, 1.0):
            report.approximate("materials are taken as opaque")
    for name, key in (("metallicFactor", "metallic"), ("roughnessFactor", "roughness")):
        number = getattr(material, name, None)
        if number is not None:
            piece.core[key] = float(np.clip(number, 0.0, 1.0))
    picture = _first(material, "baseColorTexture", "image")
    if picture is not None and visual.uv is not None:
        texels = np.ascontiguousarray(np.asarray(picture.convert("RGB")))
        texels.setflags(write=False)
        piece.picture, piece.uvs = as_image(texels), np.asarray(visual.uv)[:, :2]
    for name in ("metallicRoughnessTexture", "normalTexture", "emissiveTexture"):
        if getattr(material, name, None) is not None:
            report.approximate(f"{name} is left out: save the scene as .glb to keep it")


def _first(material: Any, *names: str) -> Any:
    found = (getattr(material, name, None) for name in names)
    return next((value for value in found if value is not None), None)


def _view(scene: Any) -> PlacedView:
    across, upwards = (float(angle) for angle in scene.camera.fov)
    tangents = np.tan(np.radians([0.5 * across, 0.5 * upwards]))
    camera = {"type": "pinhole", "fov": upwards, "fov_axis": "y"}
    matrix = np.asarray(scene.camera_transform, np.float64)
    return PlacedView(camera, matrix, float(tangents[0] / tangents[1]))
