"""STL meshes, binary and text: bare triangles.

Corners with equal coordinates become one vertex, so that the mesh is connected. Facet normals are
ignored, as the corners give them, and so are the two spare bytes of a binary facet, in which a few
programs put a colour.

Source: 3D Systems, StereoLithography interface specification (1989); Burns, Automated fabrication
(1993), section 6.5.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from alight.core.errors import quote
from alight.meshes.triangles import MeshArrays, broken

#: A binary file: 80 bytes of anything, a count, and a facet: normal, three corners, two bytes.
_HEADER, _FIRST = 80, 84
_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("spare", "<u2")])


def read(data: bytes) -> MeshArrays:
    """Read an STL file.

    Parameters
    ----------
    data : bytes
        Content of the file.

    Returns
    -------
    MeshArrays

    Raises
    ------
    SceneError
        If the file is broken; messages of text files name the line.
    """
    count = int.from_bytes(data[_HEADER:_FIRST], "little") if len(data) >= _FIRST else 0
    needed = _FIRST + count * _FACET.itemsize
    # Binary files may begin with the word "solid" too; their length gives them away.
    if len(data) >= _FIRST and len(data) == needed:
        corners = np.frombuffer(data, _FACET, count, _FIRST)["corners"].reshape(-1, 3)
    elif data[:_HEADER].lstrip().lower().startswith(b"solid"):
        corners = _corners_of_text(data)
    elif len(data) < _FIRST:
        raise broken(f"must be an STL file, got {len(data)} bytes and no word solid")
    else:
        raise broken(f"must hold {needed} bytes for its {count} triangles, got {len(data)}")
    return _joined(np.ascontiguousarray(corners, np.float32))


def _corners_of_text(data: bytes) -> NDArray[np.float32]:
    """Corners (n, 3) of all facets, metres."""
    corners: list[list[float]] = []
    in_facet = 0
    for number, line in enumerate(data.splitlines(), 1):
        words = line.lower().split()
        if not words:
            continue
        if words[0] == b"vertex":
            corners.append(_point(words, number))
            in_facet += 1
        elif words[0] == b"endfacet":
            if in_facet != 3:
                raise broken(f"line {number}: a facet must have 3 vertices, got {in_facet}")
            in_facet = 0
    if in_facet:
        raise broken("the last facet does not end: endfacet is missing")
    return np.array(corners, np.float32).reshape(-1, 3)


def _point(words: list[bytes], number: int) -> list[float]:
    if len(words) != 4:
        raise broken(f"line {number}: vertex needs 3 numbers, got {len(words) - 1}")
    try:
        return [float(word) for word in words[1:]]
    except ValueError:
        shown = quote(b" ".join(words[1:]).decode("utf-8", "replace"))
        raise broken(f"line {number}: vertex needs 3 numbers, got {shown}") from None


def _joined(corners: NDArray[np.float32]) -> MeshArrays:
    """One vertex for equal corners, in the order in which they appear."""
    # 0 and -0 are one place.
    corners = corners + np.float32(0.0)
    keys = corners.view(np.dtype((np.void, 12))).reshape(-1)
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    place = np.argsort(np.argsort(first))
    faces = place[inverse.reshape(-1)].astype(np.int32).reshape(-1, 3)
    return MeshArrays(corners[np.sort(first)], faces)
