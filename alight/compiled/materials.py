"""Descriptions of materials and textures -> the tables that kernels read.

`info` holds (kind, flags) for each material: kind is the index of its model in
`alight.bsdfs.MODELS`, flags has the bits of `alight.bsdfs.switch`. Behind the materials that shapes
refer to come normal and bump maps, then those that they are made of; `layers` says which (see
`alight.bsdfs.dispatch`; without blends and masks nothing reads it). `data` holds `stride_of`
numbers for each material, laid out by the model's `SLOTS`. `texture` is as long as `data`: 0, or at
the first slot of a colour or number the index of its texture plus 1. The rest is described in
`alight.compiled.textures`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from alight.bsdfs.dispatch import LAYERED_NAME
from alight.bsdfs.flags import DELTA_AND_SMOOTH
from alight.bsdfs.model import BSDFS, stride_of
from alight.bsdfs.nesting import Leaf, Nested, leaves
from alight.bsdfs.specular import is_specular
from alight.bsdfs.switch import (
    BACK_ONLY,
    COATED_APART,
    FRONT_ONLY,
    MIXED,
    NORMALS,
    OPEN,
    OTHER_BACK,
    SAME_BACK,
    SPECULAR,
    SPREADS,
    TWO_SIDED,
)
from alight.compiled.packer import Packer, in_place
from alight.compiled.textures import TextureTable
from alight.core.spec import Bsdf, Texture
from alight.core.wavelengths import DISPERSIVE
from alight.shapes.hit import OWN_COAT
from lanewise.view import View


class MaterialTables(NamedTuple):
    """All materials of a scene; each a flat `View`."""

    info: View
    data: View
    texture: View
    texture_info: View
    texture_data: View
    texels: View
    layers: View
    curves: View


class PackedMaterials:
    """The materials of a scene, packed; tables of them are made once it is known where it lies.

    Parameters
    ----------
    bsdfs : sequence of Bsdf
        Names of nested materials and of textures resolved. The index is what shapes refer to.
    textures : sequence of Texture, optional
        Textures that are used elsewhere too, each once: they get the first numbers.

    Attributes
    ----------
    bsdf_names, texture_names : tuple of str
        For `Program`: the models in use in the order of the registries, then their features.
    """

    def __init__(self, bsdfs: Sequence[Bsdf], textures: Sequence[Texture] = ()) -> None:
        stride = stride_of(leaf.bsdf.type_name() for spec in bsdfs for leaf in leaves(spec))
        self._rows = rows = _Rows(stride)
        for texture in textures:
            rows.textures.number(texture)
        rows.reserve_normals(bsdfs)
        layers = [rows.add(spec) for spec in bsdfs]
        for normals in rows.normals:
            rows.put(normals, MIXED)
        rows.used |= {LAYERED_NAME} if any(len(layer) > 1 for layer in layers) else set()
        self._layers = rows.pack_layers(layers)
        models = [name for name in BSDFS if name in rows.used]
        self.bsdf_names = (*models, *sorted(rows.used - set(models)))
        self.texture_names = rows.textures.names()

    def tables(self, origin: np.ndarray | None = None) -> MaterialTables:
        """Build the tables; origin: where in the world that of rendering space is, metres."""
        rows, table = self._rows, self._rows.textures.compiled(origin)
        return MaterialTables(
            info=View(np.array(rows.info or [0, 0], np.uint32)),
            data=View(np.concatenate(rows.data or [np.zeros(rows.stride, np.float32)])),
            texture=View(np.concatenate(rows.texture or [np.zeros(rows.stride, np.uint32)])),
            texture_info=table.info,
            texture_data=table.data,
            texels=table.texels,
            layers=View(self._layers),
            curves=View(np.concatenate([*in_place(rows.curves), np.zeros(1, np.float32)])),
        )


def compile_materials(
    bsdfs: Sequence[Bsdf], textures: Sequence[Texture] = (), origin: np.ndarray | None = None
) -> tuple[MaterialTables, tuple[str, ...], tuple[str, ...]]:
    """Pack materials whose place is known, and build their tables.

    Returns
    -------
    tables : MaterialTables
    bsdf_names, texture_names : tuple of str
        As of `PackedMaterials`.
    """
    packed = PackedMaterials(bsdfs, textures)
    return packed.tables(origin), packed.bsdf_names, packed.texture_names


@dataclass
class _Rows:
    """The tables of materials while they grow."""

    stride: int
    info: list[int] = field(default_factory=list)
    data: list[np.ndarray] = field(default_factory=list)
    texture: list[np.ndarray] = field(default_factory=list)
    textures: TextureTable = field(default_factory=TextureTable)
    curves: list[np.ndarray] = field(default_factory=list)
    used: set[str] = field(default_factory=set)
    numbers: dict[tuple[Bsdf, int], int] = field(default_factory=dict)
    normals: dict[Bsdf, int] = field(default_factory=dict)

    def reserve_normals(self, bsdfs: Sequence[Bsdf]) -> None:
        """Number the rows of what bends normals: they follow those that shapes refer to."""
        for spec in bsdfs:
            for leaf in leaves(spec):
                if leaf.normals is not None:
                    self.normals.setdefault(leaf.normals, len(bsdfs) + len(self.normals))

    def add(self, spec: Bsdf) -> list[Leaf]:
        """Make the row that a shape refers to; returns the models of the material."""
        found = list(leaves(spec))
        if len(found) > 1:
            kinds = MIXED | SPREADS * any(map(_spreads, found))
            lobes = SPECULAR * any(map(_mirrors, found)) | OPEN * any(map(_is_open, found))
            weighing = _weighing(spec)
            row = self.put(weighing, kinds | lobes)
            # Its weight is read from there, too.
            self.numbers.setdefault((weighing, MIXED), row)
            self.used.add(DELTA_AND_SMOOTH)
        else:
            self.put(found[0].bsdf, self.flags(found[0]))
        return found

    def flags(self, leaf: Leaf) -> int:
        """Flags of a model, entered into what the program uses."""
        name = leaf.bsdf.type_name()
        features = BSDFS[name].features(leaf.bsdf)
        self.used |= {name, *features} | ({SAME_BACK} if leaf.two_sided else set())
        flags = TWO_SIDED * leaf.two_sided | MIXED * (DELTA_AND_SMOOTH in features)
        flags |= SPREADS * _spreads(leaf) | COATED_APART * (OWN_COAT in features)
        if leaf.side:
            self.used.add(OTHER_BACK)
            flags |= FRONT_ONLY if leaf.side == "front" else BACK_ONLY
        flags |= SPECULAR * _mirrors(leaf) | OPEN * _is_open(leaf)
        if leaf.normals is not None:
            self.used |= set(BSDFS[leaf.normals.type_name()].features(leaf.normals))
            flags |= (self.normals[leaf.normals] + 1) << NORMALS
        return flags

    def put(self, spec: Bsdf, flags: int) -> int:
        """Append a row; returns its number."""
        model = BSDFS[spec.type_name()]
        assert model.pack is not None
        packer = Packer(model.SLOTS, self.stride, self.textures, self.curves)
        model.pack(spec, packer)
        self.info += [model.number, flags]
        self.data.append(packer.row)
        self.texture.append(packer.textures)
        return self.numbers.setdefault((spec, flags), len(self.data) - 1)

    def number(self, spec: Bsdf, flags: int) -> int:
        """The row of a material inside others, made once."""
        key = spec, flags
        return self.numbers[key] if key in self.numbers else self.put(spec, flags)

    def pack_layers(self, layers: list[list[Leaf]]) -> np.ndarray:
        """Lists of models and their factors; see `alight.bsdfs.dispatch`."""
        heads: list[int] = []
        lists: list[list[int]] = []
        end = 2 * len(layers)
        for found in layers:
            heads += [end, len(found)]
            factors: list[int] = []
            first = end + 3 * len(found)
            for leaf in found:
                row = self.number(leaf.bsdf, self.flags(leaf))
                lists.append([row, first + len(factors), len(leaf.factors)])
                for owner, from_one in leaf.factors:
                    factors.append(2 * self.stride * self.number(owner, MIXED) + from_one)
            lists.append(factors)
            end = first + len(factors)
        return np.array([*heads, *(word for words in lists for word in words), 0, 0], np.uint32)


def _spreads(leaf: Leaf) -> bool:
    """Whether a model disperses light."""
    return DISPERSIVE in BSDFS[leaf.bsdf.type_name()].features(leaf.bsdf)


def _mirrors(leaf: Leaf) -> bool:
    """Whether a model is a mirror or clear glass, or has such a lobe."""
    return is_specular(leaf.bsdf)


def _is_open(leaf: Leaf) -> bool:
    """Whether light passes a model as if nothing was there."""
    return BSDFS[leaf.bsdf.type_name()].spec.unseen


def _weighing(spec: Bsdf) -> Bsdf:
    """The outermost material with a weight in its row; without one, a model."""
    while isinstance(spec, Nested) and not spec.weight_field:
        part = spec.parts[0]
        assert isinstance(part.bsdf, Bsdf)
        spec = part.bsdf
    return spec
