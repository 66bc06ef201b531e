"""Grids of media, read from files where the description names one.

Formats: NPY, and the VOL files of Mitsuba (version 3, float32). ``builtin:cloud`` is computed.
"""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
from pydantic_core import PydanticCustomError

from alight.core.errors import Issue, SceneError, quote
from alight.core.fields import invalid
from alight.core.spec import Medium
from alight.media.volumes import Volume, as_volume, holds_volume, size_problem
from alight.outputs.npy import load_array
from alight.scene.builtin.clouds import builtin_values
from alight.scene.builtin.pictures import is_builtin
from alight.scene.files import Files
from alight.scene.meshes import unreadable

SUFFIXES = (".npy", ".vol")
#: Bytes of a VOL file that hold the corners of its box.
_BOX = slice(24, 48)

#: A VOL file begins with: "VOL", version, type (1: float32), cells along x, y, z, channels, a box.
_HEADER = struct.Struct("<3sBiiiii6f")


def loaded(spec: Medium, files: Files) -> Any:
    """Put the grid of a file into the place of its name; other descriptions stay.

    Raises
    ------
    SceneError
        If the file is missing or broken; its path is ``file``.
    """
    name = getattr(spec, "file", None) if holds_volume(spec) else None
    if name is None:
        return spec
    volume = files.read(read_volume, name)
    try:
        return spec.replaced(file=None, values=volume)
    except SceneError as error:
        # What is wrong with the numbers is wrong with the file.
        raise SceneError(
            [Issue("file", f"{quote(name)}: {i.message}") for i in error.issues]
        ) from None


def read_volume(path: Path, name: str = "") -> Volume:
    """Read a grid.

    Parameters
    ----------
    path : Path
        The file.
    name : str, optional
        How messages call it; ``builtin:cloud`` is a computed one.

    Raises
    ------
    SceneError
        If it is missing, broken, too large, or holds numbers that are no densities.
    """
    name = name or str(path)
    try:
        if is_builtin(name):
            return as_volume(builtin_values(name))
        return as_volume(_read_vol(path) if path.suffix.lower() == ".vol" else _read_npy(path))
    except OSError as error:
        text = unreadable(path, name, error, SUFFIXES)
    except PydanticCustomError as error:
        text = f"{quote(name)}: {error.message()}"
    except (ValueError, EOFError) as error:
        text = f"{quote(name)}: {' '.join(str(error).split())[:200] or 'is broken'}"
    raise SceneError([Issue("file", text)])


def _read_npy(path: Path) -> np.ndarray:
    if path.suffix.lower() != ".npy":
        with path.open("rb"):
            raise ValueError(f"must be a grid ({', '.join(SUFFIXES)})")
    array = load_array(path, mapped=True)
    if isinstance(array, np.ndarray) and array.ndim in (3, 4):
        _check_size(*array.shape[:3])
    return array


def _read_vol(path: Path) -> np.ndarray:
    with path.open("rb") as file:
        head = file.read(_HEADER.size)
        if len(head) < _HEADER.size or head[:3] != b"VOL":
            raise ValueError("is not a VOL file")
        _, version, kind, nx, ny, nz, channels, *_ = _HEADER.unpack(head)
        if version != 3 or kind != 1:
            raise ValueError(f"must have version 3 and float32 values, got {version} and {kind}")
        if channels not in (1, 3):
            raise ValueError(f"must have 1 or 3 channels, got {channels}")
        _check_size(nz, ny, nx)
        count = nx * ny * nz * channels
        data = file.read(4 * count + 1)
    if len(data) != 4 * count:
        raise ValueError(f"must hold {count} values after its header, got {len(data) // 4}")
    return np.frombuffer(data, "<f4").reshape(nz, ny, nx, channels)


def _check_size(nz: int, ny: int, nx: int) -> None:
    problem = size_problem(nz, ny, nx)
    if problem:
        raise invalid(problem)


def box_of(path: Path, name: str) -> np.ndarray:
    """From the unit cube to the box that a VOL file names, (4, 4) float64.

    Raises
    ------
    SceneError
        If the file names none.
    """
    result = np.eye(4)
    with path.open("rb") as file:
        start = file.read(_BOX.stop)
    if start[:3] != b"VOL" or len(start) < _BOX.stop:
        raise SceneError([Issue("", f"{quote(name)}: names no box, as VOL files do")])
    low, high = np.frombuffer(start[_BOX], "<f4").astype(np.float64).reshape(2, 3)
    if not (np.isfinite([low, high]).all() and (low < high).all()):
        raise SceneError([Issue("", f"{quote(name)}: its box must have a size")])
    result[:3, :3], result[:3, 3] = np.diag(high - low), low
    return result
