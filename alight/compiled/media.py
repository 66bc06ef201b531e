"""Media, and the shapes that bound them -> tables for kernels (`alight.media.tables`)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from alight.compiled.shapes import CompiledShapes
from alight.media.coefficients import Coefficients, extinction, scattering_albedo, shines
from alight.media.model import MEDIA
from alight.media.tables import (
    ALBEDO,
    ALBEDOS,
    CHROMATIC,
    DENSITIES,
    EMISSION,
    EMISSIONS,
    EMISSIVE,
    EXTINCTION,
    INFO,
    KEEP,
    KIND,
    PARAMETER,
    PHASE,
    STRIDE,
    MediaTables,
)
from alight.phases.model import PHASES
from alight.scene.flatten import FlatScene
from lanewise.view import View


@dataclass
class MediumPacker:
    """Puts one medium into its rows.

    Attributes
    ----------
    info : (INFO,) uint32
    data : (STRIDE,) float32
    voxels : list of (n,) float32
        Values of the grids of the whole scene.
    """

    info: np.ndarray
    data: np.ndarray
    voxels: list[np.ndarray]

    def grid(self, word: int, values: np.ndarray) -> None:
        """Put a grid of shape (nz, ny, nx, c) into the table, and where it is from a word on."""
        nz, ny, nx, _ = values.shape
        self.info[word : word + 4] = sum(v.size for v in self.voxels), nx, ny, nz
        self.voxels.append(np.ascontiguousarray(values, np.float32).reshape(-1))


def compile_media(
    flat: FlatScene, shapes: CompiledShapes
) -> tuple[MediaTables, tuple[str, ...], tuple[str, ...]]:
    """Make the tables of a scene that has media.

    Returns
    -------
    tables : MediaTables
    media, phases : tuple of str
        For `Program`: models in use in the order of the registries, and features of the media.
    """
    voxels = [np.zeros(1, np.float32)]
    rows = [_blank(), *(_packed(spec, voxels) for spec in flat.media)]
    borders = np.full((len(shapes.rows) + 1, 2), KEEP, np.uint32)
    for index, row in enumerate(shapes.rows):
        border = flat.shapes[row.source].border
        if border is not None:
            borders[index] = border
    tables = MediaTables(
        View(np.stack([info for info, _ in rows])),
        View(np.stack([data for _, data in rows])),
        View(np.concatenate(voxels)),
        View(borders),
        View(np.array([flat.start_medium], np.uint32)),
    )
    media = {spec.type_name() for spec in flat.media}
    phases = {spec.phase.type_name() for spec in flat.media}
    features = {
        CHROMATIC: any(len(set(extinction(spec))) > 1 for spec in flat.media),
        EMISSIVE: any(shines(spec) for spec in flat.media),
    }
    return (
        tables,
        (
            *(name for name in MEDIA if name in media),
            *(name for name, occurs in features.items() if occurs),
        ),
        tuple(name for name in PHASES if name in phases),
    )


def _blank() -> tuple[np.ndarray, np.ndarray]:
    """Rows from which every model finds valid indices: grids of one cell."""
    info, data = np.zeros(INFO, np.uint32), np.zeros(STRIDE, np.float32)
    for word in (DENSITIES, ALBEDOS, EMISSIONS):
        info[word + 1 : word + 4] = 1
    return info, data


def _packed(spec: Coefficients, voxels: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    info, data = _blank()
    kind, phase = spec.type_name(), spec.phase.type_name()
    info[KIND], info[PHASE] = MEDIA[kind].number, PHASES[phase].number
    data[EXTINCTION : EXTINCTION + 3] = extinction(spec)
    data[ALBEDO : ALBEDO + 3] = scattering_albedo(spec)
    data[EMISSION : EMISSION + 3] = spec.emission
    data[PARAMETER] = PHASES[phase].parameter(spec.phase)
    MEDIA[kind].pack(spec, MediumPacker(info, data, voxels))
    return info, data
