"""Descriptions of materials and textures -> the tables that kernels read.

`info` holds (kind, flags) for each material: kind is the index of its model in
`alight.bsdfs.MODELS`, flags has the bit `TWO_SIDED`. `data` holds `STRIDE` numbers for each
material, laid out by the model's `SLOTS`. `texture` is as long as `data`: 0, or at the first slot
of a colour the index of its texture plus 1. `texture_info` holds (kind, start in `texture_data`)
for each texture.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from alight.bsdfs import MODELS as BSDFS
from alight.bsdfs.dispatch import STRIDE, TWO_SIDED, TWO_SIDED_NAME
from alight.bsdfs.two_sided import TwoSided
from alight.core.spec import Bsdf, Texture
from alight.core.view import View
from alight.textures import MODELS as TEXTURES
from alight.textures.constant import Constant


class MaterialTables(NamedTuple):
    """All materials of a scene; each a flat `View`."""

    info: View
    data: View
    texture: View
    texture_info: View
    texture_data: View


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
        Index + 1 of the texture that gives the colour starting there, or 0.
    all_textures : list of Texture
        Textures of the whole scene, each once.
    """

    slots: Mapping[str, int]
    size: int
    all_textures: list[Texture] = field(default_factory=list)

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

    def color(self, name: str, value: tuple[float, float, float] | Texture | str) -> None:
        """Put a colour: numbers, or a texture with its name resolved."""
        if isinstance(value, Constant):
            value = value.color
        if isinstance(value, tuple):
            self.numbers(name, *value)
            return
        if not isinstance(value, Texture):
            raise ValueError(f"the texture name {value!r} must be resolved before compiling")
        if value not in self.all_textures:
            self.all_textures.append(value)
        self.textures[self.starts[name]] = self.all_textures.index(value) + 1


def compile_materials(
    bsdfs: Sequence[Bsdf],
) -> tuple[MaterialTables, tuple[str, ...], tuple[str, ...]]:
    """Build the tables of a scene's materials.

    Parameters
    ----------
    bsdfs : sequence of Bsdf
        Names of nested materials and of textures resolved. The index is what shapes refer to.

    Returns
    -------
    tables : MaterialTables
    bsdf_names, texture_names : tuple of str
        For `Program`: the models in use in the order of the registries, then their features.
    """
    kinds = {model.EXAMPLES[0].type_name(): i for i, model in enumerate(BSDFS)}
    textures: list[Texture] = []
    info, data, texture, used = [], [], [], set()
    for spec in bsdfs:
        flags = 0
        if isinstance(spec, TwoSided):
            if not isinstance(spec.bsdf, Bsdf):
                raise ValueError(f"the name {spec.bsdf!r} must be resolved before compiling")
            spec, flags = spec.bsdf, TWO_SIDED
            used.add(TWO_SIDED_NAME)
        name = spec.type_name()
        model = BSDFS[kinds[name]]
        packer = Packer(model.SLOTS, STRIDE, textures)
        model.pack(spec, packer)
        used |= {name, *getattr(model, "features", _no_features)(spec)}
        info += [kinds[name], flags]
        data.append(packer.row)
        texture.append(packer.textures)
    texture_info, texture_data, texture_names = _compile_textures(textures)
    tables = MaterialTables(
        View(np.array(info or [0, 0], np.uint32)),
        View(np.concatenate(data or [np.zeros(STRIDE, np.float32)])),
        View(np.concatenate(texture or [np.zeros(STRIDE, np.uint32)])),
        texture_info,
        texture_data,
    )
    models = [name for name in kinds if name in used]
    return tables, (*models, *sorted(used - set(models))), texture_names


def _no_features(spec: Bsdf) -> tuple[str, ...]:
    return ()


def _compile_textures(textures: Sequence[Texture]) -> tuple[View, View, tuple[str, ...]]:
    kinds = {model.EXAMPLES[0].type_name(): i for i, model in enumerate(TEXTURES)}
    info, data = [], []
    for spec in textures:
        kind = kinds[spec.type_name()]
        slots = TEXTURES[kind].SLOTS
        packer = Packer(slots, sum(slots.values()))
        TEXTURES[kind].pack(spec, packer)
        info += [kind, len(data)]
        data += packer.row.tolist()
    used = {"constant", *(spec.type_name() for spec in textures)}
    return (
        View(np.array(info or [0, 0], np.uint32)),
        View(np.array(data or [0.0], np.float32)),
        tuple(name for name in kinds if name in used),
    )
