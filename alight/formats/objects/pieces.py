"""What the readers of objects have in common: pieces of surface, points, and how to show them."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from alight.core.errors import Issue, OptionError, SceneError, show_value, unknown_name
from alight.formats.objects.color_maps import OWN, names_of_maps
from alight.formats.reading.report import Report
from alight.meshes.triangles import srgb_to_linear
from alight.scene.transform import Matrix

Array = NDArray[Any]

#: Degrees between two faces up to which their common edge is shaded smooth.
SMOOTH = 30.0


@dataclass(frozen=True)
class Look:
    """How objects are shown; see `alight.load`.

    Raises
    ------
    OptionError
        For a value that does not exist or is out of range.
    """

    up: str | None = None
    smooth: float = SMOOTH
    color_map: str = "viridis"
    color_range: tuple[float, float] | None = None
    point_radius: float | None = None

    def __post_init__(self) -> None:
        """Check the values."""
        if self.up is not None and not (isinstance(self.up, str) and self.up in ("y", "z")):
            raise OptionError(f'must be "y" or "z", got {show_value(self.up)}', "up")
        if not _is_number(self.smooth) or not 0.0 <= self.smooth <= 180.0:
            raise OptionError(f"must be in [0, 180], got {show_value(self.smooth)}", "smooth")
        # Matplotlib is slow to import: only for maps of its own.
        if not isinstance(self.color_map, str):
            raise OptionError(f"must be a name, got {show_value(self.color_map)}", "color_map")
        if self.color_map not in OWN and self.color_map not in (known := names_of_maps()):
            raise OptionError(unknown_name("colour map", self.color_map, known), "color_map")
        if self.color_range is not None:
            object.__setattr__(self, "color_range", _checked_range(self.color_range))
        radius = self.point_radius
        if radius is not None and not (_is_number(radius) and 0.0 < radius < np.inf):
            raise OptionError(f"must be above 0, got {show_value(radius)}", "point_radius")

    @property
    def given(self) -> list[str]:
        """Names of what differs from the defaults."""
        default = Look()
        return [name for name, value in vars(self).items() if value != getattr(default, name)]


def _is_number(value: object) -> bool:
    return isinstance(value, int | float | np.number) and not isinstance(value, bool)


def _checked_range(value: Any) -> tuple[float, float]:
    try:
        low, high = (float(x) for x in value)
    except (TypeError, ValueError):
        low = high = np.nan
    if not (np.isfinite([low, high]).all() and low < high):
        text = f"must be (lowest, highest), got {show_value(value)}"
        raise OptionError(text, "color_range")
    return low, high


@dataclass
class Piece:
    """A part of an object with one material.

    Attributes
    ----------
    vertices : (n, 3) array
    faces : (m, 3) array of int
    normals : (n, 3) array or None
    uvs : (n, 2) array or None
        Of `picture`.
    colors : (n, 3) or (m, 3) float array or None
        Linear, of vertices or of faces.
    values : (n,) or (m,) array or None
        Numbers that are shown by the colour map, in place of `colors`.
    by_faces : bool
        Whether `colors` or `values` are those of faces.
    core : dict
        What the material has beside its colour: keys of `principled`.
    picture : Image or None
        Base colour.
    to_world : (4, 4) float64
    name : str
    """

    vertices: Array
    faces: Array
    normals: Array | None = None
    uvs: Array | None = None
    colors: Array | None = None
    values: Array | None = None
    by_faces: bool = False
    core: dict[str, Any] = field(default_factory=dict)
    picture: Any = None
    to_world: Matrix = field(default_factory=lambda: np.eye(4))
    name: str = "mesh"


@dataclass(frozen=True)
class PlacedView:
    """The camera of an object: description of the native format, camera to world, width : height.

    It looks along -z of its own space.
    """

    camera: dict[str, Any]
    to_world: Matrix
    aspect: float


@dataclass
class Content:
    """Everything that an object shows."""

    pieces: list[Piece] = field(default_factory=list)
    view: PlacedView | None = None
    report: Report = field(default_factory=Report)


def wrong(path: str, message: str) -> SceneError:
    """Make the error of an object; the caller adds its name."""
    return SceneError([Issue(path, message)])


def table(value: Any, columns: tuple[int, ...], path: str) -> Array:
    """Take an array of numbers with as many columns as allowed.

    Raises
    ------
    SceneError
        If it is none; the path is its name.
    """
    array: Any = np.zeros((), object)
    with suppress(ValueError):
        array = np.asarray(value)
    is_table = array.dtype.kind in "fiu" and array.ndim == 2
    if not is_table or array.shape[-1] not in columns:
        shown = f"shape {array.shape} of {array.dtype}" if array.ndim else type(value).__name__
        width = " or ".join(f"(n, {n})" for n in columns)
        raise wrong(path, f"must be a table of numbers, shape {width}, got {shown}")
    return array


def display_colors(value: Any, path: str = "colors") -> Array:
    """Take colours as displays show them, whole numbers to 255 or parts of 1; alpha is left out.

    Returns
    -------
    (n, 3) float32, linear
    """
    array = table(value, (3, 4), path)[:, :3]
    most = np.iinfo(array.dtype).max if array.dtype.kind in "u" else 1
    if array.dtype.kind == "i":
        most = 255
    part = array.astype(np.float32) / np.float32(most)
    if part.size and not (part.min() >= 0.0 and part.max() <= 1.0 + 1e-6):
        row = int(np.argmax(~((part >= 0.0) & (part <= 1.0 + 1e-6)).all(axis=1)))
        wanted = "in [0, 1]" if most == 1 else f"in [0, {most}]"
        shown = ", ".join(f"{x:g}" for x in array[row])
        raise wrong(path, f"must be {wanted}, got ({shown}) in row {row}")
    return srgb_to_linear(np.minimum(part, 1.0))


def triangles(value: Any, path: str = "faces") -> Array:
    """Take triangles, or quadrilaterals cut in two, (m, 3) int64."""
    faces = table(value, (3, 4), path)
    if (
        faces.dtype.kind == "f"
        and not ((faces == np.floor(faces)) & (np.abs(faces) < 2.0**31)).all()
    ):
        raise wrong(path, "must index vertices by whole numbers, got fractions")
    faces = faces.astype(np.int64)
    if faces.shape[1] == 4:
        faces = np.stack([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]], axis=1).reshape(-1, 3)
    return faces
