"""Lights -> tables for kernels, with the probability of choosing each."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from alight.compiled.shapes import CompiledShapes
from alight.core.distributions import cumulative
from alight.core.spec import Light
from alight.core.vec import luminance
from alight.core.vec3 import Vec3
from alight.core.view import View
from alight.lights import area
from alight.lights.sampling import KINDS, LIGHTS
from alight.lights.tables import INFO, STRIDE, LightTables
from alight.scene.flatten import FlatScene
from alight.shapes.hit import INFO as SHAPE_INFO

Selection = Literal["uniform", "power"]


class CompiledLights(NamedTuple):
    """All lights of a scene.

    Attributes
    ----------
    tables : LightTables
    kinds, shapes : tuple of str
        For `Program.lights` and `Program.light_shapes`.
    """

    tables: LightTables
    kinds: tuple[str, ...]
    shapes: tuple[str, ...]


class _Row(NamedTuple):
    kind: str
    color: tuple[float, float, float]
    vector: np.ndarray
    shape: int
    areas: np.ndarray


def compile_lights(
    flat: FlatScene, shapes: CompiledShapes, selection: Selection = "power"
) -> CompiledLights:
    """Make the tables of all lights, and enter area lights into the tables of shapes.

    Parameters
    ----------
    flat : FlatScene
    shapes : CompiledShapes
        Its ``tables.info`` is completed in place.
    selection : {"uniform", "power"}, default "power"
        Each light that shines is equally likely, or as likely as its share of the power.
    """
    rows = _rows(flat, shapes)
    cdf = cumulative(_weights(rows, shapes.radius, selection)) if rows else np.zeros(2)
    info = np.zeros((len(rows), INFO), np.uint32)
    data = np.zeros((len(rows), STRIDE), np.float32)
    tables = [cdf]
    for i, row in enumerate(rows):
        info[i] = KINDS[row.kind], max(row.shape, 0), i * STRIDE, 0
        data[i, 0:3], data[i, 3], data[i, 4:7] = row.color, cdf[i + 1] - cdf[i], row.vector
        if row.shape >= 0:
            shapes.tables.info.array[row.shape * SHAPE_INFO + 2] = i + 1
            if shapes.rows[row.shape].kind == "mesh":
                info[i, 3] = sum(table.size for table in tables)
                tables.append(cumulative(row.areas))
    found = {row.kind for row in rows}
    shining = {shapes.rows[row.shape].kind for row in rows if row.shape >= 0}
    return CompiledLights(
        LightTables(View(info), View(data), View(np.concatenate(tables).astype(np.float32))),
        tuple(name for name in LIGHTS if name in found),
        tuple(name for name in area.SHAPES if name in shining),
    )


def _rows(flat: FlatScene, shapes: CompiledShapes) -> list[_Row]:
    """All lights; the environment, if there is one, is the last."""
    rows = []
    for index, shape in enumerate(shapes.rows):
        light = flat.shapes[shape.source].light
        if light is not None:
            rows.append(_row(light, np.eye(4), index, shape.areas))
    rows += [_row(placed.light, placed.to_world) for placed in flat.lights]
    if flat.environment is not None:
        rows.append(_row(flat.environment, np.eye(4)))
    return rows


def _row(
    light: Light, to_world: np.ndarray, shape: int = -1, areas: np.ndarray | None = None
) -> _Row:
    kind = light.type_name()
    color, vector = LIGHTS[kind].place(light, to_world)
    return _Row(kind, color, vector, shape, np.zeros(0) if areas is None else areas)


def _weights(rows: list[_Row], radius: float, selection: Selection) -> np.ndarray:
    brightness = [float(luminance(Vec3(*row.color))) for row in rows]
    powers = np.array(
        [
            LIGHTS[row.kind].power(bright, float(row.areas.sum()), radius)
            for row, bright in zip(rows, brightness, strict=True)
        ]
    )
    return powers if selection == "power" else (powers > 0.0).astype(np.float64)
