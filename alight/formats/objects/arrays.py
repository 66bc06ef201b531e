"""NumPy arrays: (vertices, faces), (vertices, faces, colours or numbers), or points alone."""

from __future__ import annotations

from typing import Any

import numpy as np

from alight.formats.objects.pieces import (
    Array,
    Content,
    Look,
    Piece,
    display_colors,
    table,
    triangles,
    wrong,
)
from alight.formats.objects.points import balls


def read(value: Any, look: Look) -> Content:
    """Read arrays.

    Parameters
    ----------
    value : array or tuple of arrays
        ``(vertices, faces)``, shapes (n, 3) and (m, 3) or (m, 4); a third one are colours of
        vertices or faces, shape (n or m, 3 or 4), or numbers, shape (n or m,), shown by the
        colour map. A single array (n, 3) is a cloud of points.
    """
    if isinstance(value, np.ndarray):
        return Content([balls(table(value, (3,), "points"), look, None, None)])
    if len(value) not in (2, 3):
        text = "must be (vertices, faces) or (vertices, faces, colours), got %d arrays"
        raise wrong("", text % len(value))
    vertices, faces = table(value[0], (3,), "vertices"), triangles(value[1])
    piece, given = Piece(vertices, faces), len(np.asarray(value[1]))
    if len(value) == 3:
        piece.colors, piece.values = paint_of(value[2], len(vertices), given)
        painted = piece.colors if piece.values is None else piece.values
        assert painted is not None
        piece.by_faces = len(painted) != len(vertices)
        if piece.by_faces and len(faces) != given:
            # Both halves of a quadrilateral are painted alike.
            piece.colors, piece.values = (
                part if part is None else np.repeat(part, 2, axis=0)
                for part in (piece.colors, piece.values)
            )
    return Content([piece])


def paint_of(value: Any, vertices: int, faces: int) -> tuple[Array | None, Array | None]:
    """Colours or numbers of vertices or of faces: (colours, numbers), one of them None."""
    array = np.asarray(value)
    if array.ndim not in (1, 2) or len(array) not in (vertices, faces):
        text = f"must have a row per vertex ({vertices}) or per face ({faces})"
        raise wrong("colors", f"{text}, got shape {array.shape}")
    if array.ndim == 2:
        return display_colors(array), None
    if array.dtype.kind not in "fiub":
        raise wrong("colors", f"must be colours or numbers, got an array of {array.dtype}")
    return None, array
