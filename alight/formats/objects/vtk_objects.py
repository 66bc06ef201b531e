"""Objects of PyVista and VTK: the surface of any data set, coloured by its active scalars."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from typing import Any

import numpy as np

from alight.formats.objects.pieces import (
    Array,
    Content,
    Look,
    Piece,
    display_colors,
    wrong,
)
from alight.formats.objects.points import balls
from alight.meshes.triangles import fan


def read(value: Any, look: Look) -> Content:
    """Read a data set, or a block of them.

    Only VTK's own methods are used, which PyVista's objects have too.
    """
    content = Content()
    for name, leaf in _leaves(value, "mesh"):
        piece = _piece(leaf, look)
        if piece is None:
            content.report.approximate(f"{name}: no surface and no points: left out")
        else:
            piece.name = name
            content.pieces.append(piece)
    return content


def _leaves(value: Any, name: str) -> Iterator[tuple[str, Any]]:
    if not hasattr(value, "GetNumberOfBlocks"):
        yield name, value
        return
    for number in range(value.GetNumberOfBlocks()):
        if value.GetBlock(number) is not None:
            yield from _leaves(value.GetBlock(number), f"{name}-{number}")


def _piece(data: Any, look: Look) -> Piece | None:
    if not hasattr(data, "GetPointData"):
        raise wrong("", f"a {type(data).__name__} is no data set: give a mesh or a grid")
    # Cells of volumes and curved surfaces become polygons.
    surface = data
    if not _is(data, "vtkPolyData"):
        surface = _filtered("vtkFiltersGeometry", "vtkGeometryFilter", data)
    if surface.GetNumberOfStrips():
        surface = _filtered("vtkFiltersCore", "vtkTriangleFilter", surface)
    if surface.GetPoints() is None:
        return None
    points = _array(surface.GetPoints().GetData())
    cells = surface.GetPolys()
    if cells is None or not cells.GetNumberOfCells():
        return _cloud(surface, points, look)
    corners = _array(cells.GetConnectivityArray()).astype(np.int64)
    cut, polygon = fan(np.diff(_array(cells.GetOffsetsArray()).astype(np.int64)))
    piece = Piece(points, corners[cut])
    # Cells are numbered through: points, lines, then polygons.
    polygon += surface.GetNumberOfVerts() + surface.GetNumberOfLines()
    normals = surface.GetPointData().GetNormals()
    piece.normals = None if normals is None else _array(normals)
    of_points, of_cells = (d.GetScalars() for d in (surface.GetPointData(), surface.GetCellData()))
    if of_points is not None:
        _paint(piece, _array(of_points))
    elif of_cells is not None:
        _paint(piece, _array(of_cells)[polygon])
        piece.by_faces = True
    return piece


def _cloud(surface: Any, points: Array, look: Look) -> Piece | None:
    if not len(points) or surface.GetNumberOfLines():
        return None
    piece = Piece(points, np.zeros((0, 3), int))
    scalars = surface.GetPointData().GetScalars()
    if scalars is not None:
        _paint(piece, _array(scalars))
    return balls(points, look, piece.colors, piece.values)


def _paint(piece: Piece, scalars: Array) -> None:
    """Bytes of three or four channels are colours; other vectors show their lengths."""
    if scalars.ndim == 2 and scalars.dtype == np.uint8 and scalars.shape[1] in (3, 4):
        piece.colors = display_colors(scalars)
    elif scalars.ndim == 2:
        piece.values = np.linalg.norm(scalars.astype(np.float64), axis=1)
    else:
        piece.values = scalars


def _filtered(module: str, name: str, data: Any) -> Any:
    """What a filter of VTK makes of an object of VTK: the package is there."""
    made = getattr(importlib.import_module(f"vtkmodules.{module}"), name)()
    made.SetInputData(data)
    made.Update()
    return made.GetOutput()


def _is(data: Any, name: str) -> bool:
    return any(base.__name__ == name for base in type(data).__mro__)


def _array(data: Any) -> Array:
    """The numbers of an array of VTK, a row for each of its tuples."""
    columns = data.GetNumberOfComponents()
    try:
        flat = np.asarray(memoryview(data)).reshape(-1)
    except TypeError:
        # Arrays that VTK computes when asked have no memory.
        count = range(data.GetNumberOfTuples())
        flat = np.array([data.GetTuple(i) for i in count]).reshape(-1)
    return flat if columns == 1 else flat.reshape(-1, columns)
