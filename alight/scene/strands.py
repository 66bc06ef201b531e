"""Strands from files: NPZ archives with their arrays."""

from __future__ import annotations

import tokenize
import zipfile
import zlib
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any, overload

import numpy as np

from alight.core.errors import Issue, SceneError, nearest, quote
from alight.core.spec import Shape
from alight.scene.description import Node
from alight.scene.files import Files
from alight.scene.meshes import unreadable
from alight.scene.transform import Matrix
from alight.shapes.strand_rows import area, overlap, rows_of
from alight.shapes.strands import Basis, StrandShape

#: Arrays that a file holds; the last one may be missing.
NAMES = ("points", "radii", "counts")

#: Part of the area of strands that shine that may lie within them: it would shine outwards too.
MOST_OVERLAP = 1e-3

#: What NumPy raises at a file that is no archive of arrays: one of another kind, a header that is
#: no Python, bytes that cannot be unpacked, a way of packing that is not known, a password.
_BROKEN = (
    *(ValueError, TypeError, AttributeError, EOFError, KeyError, MemoryError),
    *(NotImplementedError, RuntimeError, SyntaxError),
    *(tokenize.TokenError, zipfile.BadZipFile, zlib.error),
)


@overload
def with_arrays(shape: StrandShape, files: Files) -> StrandShape: ...
@overload
def with_arrays(shape: Shape, files: Files) -> Shape: ...
def with_arrays(shape: Shape, files: Files) -> Shape:
    """A shape of strands with the arrays of the file that it names, the same for the same; else it.

    Raises
    ------
    SceneError
        If the file is missing or broken, or its arrays make no strands; the path is ``file``.
    """
    if not isinstance(shape, StrandShape) or shape.file is None:
        return shape
    return files.read(_reader_of(type(shape), shape.basis), shape.file)


def strand_problems(node: Node, path: str, to_world: Matrix, files: Files) -> list[Issue]:
    """List what is wrong with a node whose shape is made of strands; of another one nothing.

    Parameters
    ----------
    node : Node
        With a shape.
    path : str
        Its key path.
    to_world : (4, 4) float64
    files : Files
        Reads what the shape names.
    """
    if not isinstance(node.shape, StrandShape):
        return []
    text = "strands are met from outside only: they bound no media"
    borders = (side for side in ("interior", "exterior") if getattr(node, side) is not None)
    issues = [Issue(f"{path}.{side}", text) for side in borders]
    try:
        found = with_arrays(node.shape, files)
    except SceneError as error:
        return issues + [issue.under(f"{path}.shape") for issue in error.issues]
    rows = rows_of(found, to_world) if node.light is not None else None
    if rows is not None and not area(rows) > 0.0:
        issues.append(Issue(f"{path}.light", "its shape must have an area > 0, got 0 m^2"))
    elif rows is not None and overlap(rows) > MOST_OVERLAP:
        text = "linear strands that bend overlap at their joints and cannot shine: take b_spline"
        issues.append(Issue(f"{path}.light", text))
    return issues


@lru_cache(maxsize=16)
def _reader_of(kind: type[StrandShape], basis: Basis) -> Callable[[Path, str], StrandShape]:
    """What makes strands of a file: the same function for the same question."""

    def read(path: Path, name: str) -> StrandShape:
        arrays: dict[str, Any] = read_arrays(path, name)
        try:
            return kind(basis=basis, **arrays)
        except SceneError as error:
            issues = [Issue("file", f"{quote(name)}: {issue.sentence}") for issue in error.issues]
            raise SceneError(issues) from None

    return read


def read_arrays(path: Path, name: str = "") -> dict[str, np.ndarray]:
    """Read the arrays of an NPZ file.

    Parameters
    ----------
    path : Path
    name : str, optional
        How messages call it.

    Raises
    ------
    SceneError
        If it is missing, no such file, or lacks an array; the path is ``file``.
    """
    name = name or str(path)
    if path.suffix.lower() != ".npz":
        raise _error(f"must be an .npz file, got {quote(name)}")
    try:
        with np.load(path, allow_pickle=False) as archive:
            found = {key: archive[key] for key in archive.files if key in NAMES}
            others = [key for key in archive.files if key not in NAMES]
    except OSError as error:
        raise _error(unreadable(path, name, error, (".npz",))) from None
    except _BROKEN:
        raise _error(f"{quote(name)}: is no NPZ file of numbers, or broken") from None
    for key in NAMES[:2]:
        if key not in found:
            near = nearest(key, others)
            hint = f"; is it {quote(near)}?" if near else ""
            raise _error(f"{quote(name)}: must hold the arrays points and radii, lacks {key}{hint}")
    return found


def _error(message: str) -> SceneError:
    return SceneError([Issue("file", message)])
