"""What directives change: the current transformation, material, textures and so on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from alight.formats.pbrt.directives import Directive, Parameter
from alight.formats.pbrt.making import MaterialItem
from alight.formats.pbrt.textures import TextureItem


@dataclass
class State:
    """The current values; `copied` ones are kept by ``AttributeBegin``.

    Attributes
    ----------
    matrix : (4, 4) float64
        When the shutter opens.
    ends : (4, 4) float64
        At the end time.
    changes_start, changes_end : bool
        Which of the two transformations change, see ``ActiveTransform``.
    reverse : bool
        Whether surfaces are turned inside out.
    material : MaterialItem
    light : Directive or None
        That shapes shine with.
    light_defaults : list of Parameter
    light_space : str
        Colour space of its RGB values.
    space : str
        Colour space.
    media : Directive or None
        ``MediumInterface``: names of the media inside and outside.
    textures : mapping
        By kind and name.
    defaults : mapping of str to list of Parameter
        Of ``Attribute``, by what they are for.
    """

    material: MaterialItem
    matrix: np.ndarray = field(default_factory=lambda: np.eye(4))
    ends: np.ndarray = field(default_factory=lambda: np.eye(4))
    changes_start: bool = True
    changes_end: bool = True
    reverse: bool = False
    light: Directive | None = None
    light_defaults: list[Parameter] = field(default_factory=list)
    light_space: str = "srgb"
    space: str = "srgb"
    media: Directive | None = None
    textures: Mapping[tuple[str, str], TextureItem] = field(default_factory=dict)
    defaults: Mapping[str, list[Parameter]] = field(default_factory=dict)

    def copied(self) -> State:
        """Copy it; matrices and mappings are replaced, never changed."""
        return replace(self)

    def set_matrix(self, matrix: np.ndarray) -> None:
        """Replace the active transformations."""
        if self.changes_start:
            self.matrix = matrix
        if self.changes_end:
            self.ends = matrix

    def append(self, matrix: np.ndarray) -> None:
        """Multiply the active transformations from the right."""
        with np.errstate(over="ignore", invalid="ignore"):
            if self.changes_start:
                self.matrix = self.matrix @ matrix
            if self.changes_end:
                self.ends = self.ends @ matrix

    @property
    def is_animated(self) -> bool:
        """Whether things move while the shutter is open."""
        return self.matrix is not self.ends and not np.array_equal(self.matrix, self.ends)
