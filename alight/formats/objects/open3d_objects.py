"""Objects of Open3D: triangle meshes and point clouds, old and new (``open3d.t``)."""

from __future__ import annotations

from typing import Any

import numpy as np

from alight.formats.objects.pieces import Content, Look, Piece, display_colors, wrong
from alight.formats.objects.points import balls
from alight.textures.images import as_image


def read(value: Any, look: Look) -> Content:
    """Read a ``TriangleMesh`` or a ``PointCloud``."""
    value = value.to_legacy() if hasattr(value, "to_legacy") else value
    if hasattr(value, "triangles") and hasattr(value, "vertices"):
        return Content([_mesh(value)])
    if hasattr(value, "points") and hasattr(value, "colors") and not hasattr(value, "lines"):
        colors = display_colors(np.asarray(value.colors)) if value.has_colors() else None
        return Content([balls(np.asarray(value.points), look, colors, None)])
    raise wrong("", f"a {type(value).__name__} has no surface: give a TriangleMesh or PointCloud")


def _mesh(mesh: Any) -> Piece:
    piece = Piece(np.asarray(mesh.vertices), np.asarray(mesh.triangles))
    if len(piece.faces) == 0:
        raise wrong("triangles", "must hold at least one triangle, got an empty mesh")
    if mesh.has_vertex_normals():
        piece.normals = np.asarray(mesh.vertex_normals)
    if mesh.has_textures() and mesh.has_triangle_uvs() and np.asarray(mesh.textures[0]).size:
        # Coordinates of corners, so that every corner becomes a vertex of its own.
        corners = piece.faces.reshape(-1)
        piece.vertices = piece.vertices[corners]
        piece.normals = None if piece.normals is None else piece.normals[corners]
        piece.faces = np.arange(len(corners)).reshape(-1, 3)
        # Rows of its pictures count from the bottom.
        texels = np.ascontiguousarray(np.flipud(np.asarray(mesh.textures[0]))[..., :3])
        texels.setflags(write=False)
        piece.picture, piece.uvs = as_image(texels), np.asarray(mesh.triangle_uvs)
    elif mesh.has_vertex_colors():
        piece.colors = display_colors(np.asarray(mesh.vertex_colors))
    return piece
