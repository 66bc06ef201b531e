"""Putting the parameters of one material or texture into its row of a table."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from alight.core.errors import AlightError
from alight.core.field_types import Triple
from alight.core.spec import Texture
from alight.core.vec import luminance
from lanewise.vec3 import Vec3

if TYPE_CHECKING:
    from alight.compiled.textures import TextureTable
    from alight.textures.images import Image


#: Tables start at multiples of this many numbers: rows of float32 hold where, and these hold
#: multiples of 64 exactly up to 2^30.
_ALIGNED = 64


def in_place(curves: Iterable[np.ndarray]) -> list[np.ndarray]:
    """Fill up each table, so that the next one starts where a row can say."""
    return [np.pad(curve, (0, _gap(curve))) for curve in curves]


def _gap(curve: np.ndarray) -> int:
    return -curve.size % _ALIGNED


@dataclass
class Packer:
    """Puts the parameters of one material or texture into its row.

    Attributes
    ----------
    slots : mapping of str to int
        Name -> how many numbers, in the order of the row.
    size : int
        Length of the row.
    row : (n,) float32
        Numbers; 0 where nothing was put.
    textures : (n,) uint32
        Index + 1 of the texture that gives the value starting there, or 0.
    table : TextureTable, optional
        Textures and texels of the whole scene; needed once a parameter is textured.
    all_curves : list of (n,) float32
        Tables of the whole scene, one after the other.
    origin : (3,) float64, metres
        Where in the world the origin of rendering space is.
    """

    slots: Mapping[str, int]
    size: int
    table: TextureTable | None = None
    all_curves: list[np.ndarray] = field(default_factory=list)
    origin: np.ndarray = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        """Start with an empty row."""
        self.row = np.zeros(self.size, np.float32)
        self.textures = np.zeros(self.size, np.uint32)
        ends = np.cumsum(list(self.slots.values()), dtype=int)
        self.starts = dict(zip(self.slots, [0, *ends.tolist()], strict=False))

    def numbers(self, name: str, *values: float) -> None:
        """Put as many numbers as the slot has."""
        if len(values) != self.slots[name]:
            raise ValueError(f"{name} has {self.slots[name]} slots, got {len(values)} numbers")
        start = self.starts[name]
        self.row[start : start + len(values)] = values

    def curve(self, name: str, values: np.ndarray) -> None:
        """Put a table into `MaterialTables.curves`, and where it starts into the slot."""
        before = [curve for curve in self.all_curves if curve is values]
        if not before:
            self.all_curves.append(values)
        index = next(i for i, curve in enumerate(self.all_curves) if curve is values)
        start = sum(curve.size + _gap(curve) for curve in self.all_curves[:index])
        if start >= 2**24 * _ALIGNED:
            raise AlightError("materials have more tables than numbers of 32 bits can tell apart")
        self.numbers(name, start)

    def color(self, name: str, value: Triple | Texture | str) -> None:
        """Put a colour: numbers, or a texture with its name resolved."""
        if isinstance(value, Texture) and not value.varies:
            value = value.maximum()
        if isinstance(value, tuple):
            self.numbers(name, *value)
        else:
            self._texture(name, value)

    def scalar(self, name: str, value: float | Texture | str) -> None:
        """Put a number, or a texture whose luminance is the number."""
        if isinstance(value, Texture) and not value.varies:
            value = float(luminance(Vec3(*value.maximum())))
        if isinstance(value, float | int):
            self.numbers(name, value)
        else:
            self._texture(name, value)

    def number(self, name: str) -> float | None:
        """The number that was put into a slot; None where it is textured."""
        at = self.starts[name]
        return None if self.textures[at] else float(self.row[at])

    def texels(self, name: str, image: Image, color_space: str) -> None:
        """Put where the texels of a picture are: the words of `TextureTable.texels`."""
        assert self.table is not None
        words = np.array(self.table.texels(image, color_space), np.uint32)
        start = self.starts[name]
        self.row[start : start + len(words)] = words.view(np.float32)

    def _texture(self, name: str, value: Texture | str) -> None:
        if not isinstance(value, Texture):
            raise ValueError(f"the texture name {value!r} must be resolved before compiling")
        assert self.table is not None
        self.textures[self.starts[name]] = self.table.number(value)
