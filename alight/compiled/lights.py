"""Lights -> tables for kernels, with the probability of choosing each."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from alight.compiled.shapes import CompiledShapes
from alight.core.distributions import cumulative
from alight.core.spec import Light, Texture, Triple
from alight.core.vec import luminance
from alight.core.vec3 import Vec3
from alight.core.view import View
from alight.lights import area
from alight.lights.environment import Environment, make_map
from alight.lights.environment_map import EMPTY, EnvironmentMap
from alight.lights.sampling import KINDS, LIGHTS
from alight.lights.tables import INFO, STRIDE, TEXTURED, LightTables
from alight.scene.flatten import FlatScene
from alight.shapes.hit import INFO as SHAPE_INFO

Selection = Literal["uniform", "power"]


class CompiledLights(NamedTuple):
    """All lights of a scene.

    Attributes
    ----------
    tables : LightTables
    kinds : tuple of str
        For `Program.lights`: the models in use, then `TEXTURED` where a light has a texture.
    shapes : tuple of str
        For `Program.light_shapes`.
    is_dark : bool
        No light emits anything.
    """

    tables: LightTables
    kinds: tuple[str, ...]
    shapes: tuple[str, ...]
    is_dark: bool


class _Row(NamedTuple):
    """A light: model, colour, its own numbers, mean colour for its power, texture + 1, shape."""

    kind: str
    color: Triple
    numbers: np.ndarray
    mean: Triple
    texture: int = 0
    shape: int = -1
    areas: np.ndarray = np.zeros(0)


def light_textures(flat: FlatScene) -> list[Texture]:
    """The textures of area lights, each once, in the order of the shapes."""
    lights = (shape.light for shape in flat.shapes if shape.light is not None)
    return list(dict.fromkeys(found for light in lights if (found := _texture_of(light))))


def compile_lights(
    flat: FlatScene,
    shapes: CompiledShapes,
    selection: Selection = "power",
    *,
    compensated: bool = False,
) -> CompiledLights:
    """Make the tables of all lights, and enter area lights into the tables of shapes.

    Parameters
    ----------
    flat : FlatScene
    shapes : CompiledShapes
        Its ``tables.info`` is completed in place.
    selection : {"uniform", "power"}, default "power"
        Each light that shines is equally likely, or as likely as its share of the power.
    compensated : bool, default False
        Light sampling is combined with BSDF sampling, which finds what the compensated map of an
        environment leaves out.
    """
    rows, environment = _rows(flat, shapes), _environment(flat, compensated)
    if environment is not None:
        rows.append(environment[0])
    weights = _weights(rows, shapes.radius, selection)
    cdf = cumulative(weights) if rows else np.zeros(2)
    info = np.zeros((len(rows), INFO), np.uint32)
    data = np.zeros((len(rows), STRIDE), np.float32)
    tables, map_table = [cdf], EMPTY
    for i, row in enumerate(rows):
        info[i] = KINDS[row.kind], max(row.shape, 0), row.texture, 0
        data[i, :3], data[i, 3] = row.color, cdf[i + 1] - cdf[i]
        data[i, 4 : 4 + len(row.numbers)] = row.numbers
        if row.shape >= 0:
            shapes.tables.info.array[row.shape * SHAPE_INFO + 2] = i + 1
            if shapes.rows[row.shape].kind == "mesh":
                info[i, 3] = sum(table.size for table in tables)
                tables.append(cumulative(row.areas))
    if environment is not None and environment[1] is not None:
        info[-1, 3], map_table = sum(table.size for table in tables), environment[1].table
        tables.append(environment[1].cdf)
    return CompiledLights(
        LightTables(
            View(info),
            View(data),
            View(np.concatenate(tables).astype(np.float32)),
            View(map_table),
        ),
        _names(rows),
        _shining(rows, shapes),
        not np.any(weights > 0.0),
    )


def _names(rows: list[_Row]) -> tuple[str, ...]:
    found = {row.kind for row in rows}
    textured = (TEXTURED,) if any(row.texture for row in rows) else ()
    return (*(name for name in LIGHTS if name in found), *textured)


def _shining(rows: list[_Row], shapes: CompiledShapes) -> tuple[str, ...]:
    kinds = {shapes.rows[row.shape].kind for row in rows if row.shape >= 0}
    return tuple(name for name in area.SHAPES if name in kinds)


def _rows(flat: FlatScene, shapes: CompiledShapes) -> list[_Row]:
    """All lights but the environment."""
    textures, rows = light_textures(flat), []
    for index, shape in enumerate(shapes.rows):
        light = flat.shapes[shape.source].light
        if light is not None:
            row, texture = _row(light, np.eye(4)), _texture_of(light)
            number = 0 if texture is None else textures.index(texture) + 1
            rows.append(row._replace(texture=number, shape=index, areas=shape.areas))
    return rows + [_row(placed.light, placed.to_world) for placed in flat.lights]


def _environment(flat: FlatScene, compensated: bool) -> tuple[_Row, EnvironmentMap | None] | None:
    """The row of the environment, and its map where it has one."""
    if flat.environment is None:
        return None
    light, to_world = flat.environment.light, flat.environment.to_world
    row = _row(light, to_world)
    if not isinstance(light, Environment):
        return row, None
    made = make_map(light, to_world, compensated)
    red, green, blue = (a * b for a, b in zip(row.color, made.mean, strict=True))
    return row._replace(mean=(red, green, blue)), made


def _row(light: Light, to_world: np.ndarray) -> _Row:
    kind = light.type_name()
    model = LIGHTS[kind]
    color, numbers = model.place(light, to_world)
    mean = model.mean_color(light) if hasattr(model, "mean_color") else color
    return _Row(kind, color, numbers, mean)


def _texture_of(light: Light) -> Texture | None:
    return area.texture(light) if isinstance(light, area.Area) else None


def _weights(rows: list[_Row], radius: float, selection: Selection) -> np.ndarray:
    brightness = [float(luminance(Vec3(*row.mean))) for row in rows]
    powers = np.array(
        [
            LIGHTS[row.kind].power(bright, float(row.areas.sum()), radius)
            for row, bright in zip(rows, brightness, strict=True)
        ]
    )
    return powers if selection == "power" else (powers > 0.0).astype(np.float64)
