"""Shapes that float32 cannot hold as they are: too far from the origin for their size, too small.

Places are rounded to a part in 2^24 of their distance from the origin, whatever the size of what is
there; and the normal of a triangle is a product of its edges divided by its length, whose square
leaves the range of float32 before the edges do.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from alight.compiled.shapes import CompiledShapes
from alight.scene.flatten import NO_GEOMETRY, FlatScene

#: Spacing of float32 at a shape, over its longest side, from which on it is deformed to be seen.
COARSE = 1e-3

#: Longest sides, metres, of meshes whose normals are exact.
SMALLEST, LARGEST = 1e-8, 1e9


def warnings_of_sizes(flat: FlatScene, shapes: CompiledShapes) -> tuple[str, ...]:
    """Warn of shapes that are deformed where they are, and of meshes without exact normals."""
    if not shapes.extents:
        return ()
    sources = np.array([shapes.rows[index].source for index, _, _ in shapes.extents])
    low = np.concatenate([low for _, low, _ in shapes.extents]).reshape(-1, 3)
    high = np.concatenate([high for _, _, high in shapes.extents]).reshape(-1, 3)
    size = (high.astype(np.float64) - low).max(axis=1)
    away = np.maximum(np.abs(low), np.abs(high)).max(axis=1)
    apart = np.spacing(away.astype(np.float32)).astype(np.float64)
    far = (size > 0.0) & (apart > COARSE * size)
    of_mesh = np.array([placed.geometry != NO_GEOMETRY for placed in flat.shapes])[sources]
    found = _rounded_meshes(flat)
    far &= ~np.isin(sources, [number for number, _ in found])
    lost = of_mesh & (((size > 0.0) & (size < SMALLEST)) | (size > LARGEST))
    told = [text for _, text in found[:1]]
    if far.any():
        at = int(far.argmax())
        told.append(
            f"{named(flat, sources[far])} {away[at]:.2g} m from the origin, where numbers of "
            f"float32 are {100.0 * apart[at] / size[at]:.2g} % of its size apart: move the scene "
            "to the origin"
        )
    if lost.any():
        told.append(
            f"{named(flat, sources[lost])} {size[lost.argmax()]:.2g} m across: normals of "
            f"triangles are exact from {SMALLEST:g} m to {LARGEST:g} m only; scale the scene"
        )
    return tuple(told)


def _rounded_meshes(flat: FlatScene) -> list[tuple[int, str]]:
    """Meshes whose own vertices are too far from the origin of the mesh, with the warnings."""
    found = []
    for number, placed in enumerate(flat.shapes):
        if placed.geometry == NO_GEOMETRY:
            continue
        away, size = flat.geometries[placed.geometry].extent
        share = float(np.spacing(np.float32(away))) / size if size > 0.0 else 0.0
        if share > COARSE:
            text = (
                f"{placed.name}: its vertices lie {away:.2g} m from the origin of the mesh, where "
                f"numbers of float32 are {100.0 * share:.2g} % of its size apart: subtract their "
                "middle, and move the node there"
            )
            found.append((number, text))
    return found


def named(flat: FlatScene, sources: NDArray[np.int64]) -> str:
    """The first shape, and how many others there are."""
    others = np.unique(sources).size - 1
    return flat.shapes[sources[0]].name + (f" (and {others} more):" if others else ":")
