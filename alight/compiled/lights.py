"""Lights -> tables for kernels, with the probability of choosing each."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal, NamedTuple

import numpy as np

from alight.compiled.area_maps import Textures, area_map
from alight.compiled.casters import boxes_by_shape
from alight.compiled.displacement import displaced
from alight.compiled.kept import Kept
from alight.compiled.light_emission import Emits, emitting
from alight.compiled.light_gain import gain_of_tree
from alight.compiled.light_targets import targets
from alight.compiled.light_tree import (
    Choosing,
    LightRow,
    by_power,
    chosen_by_tree,
    find_leaves,
    shining_shapes,
)
from alight.compiled.shapes import CompiledShapes, compile_shapes
from alight.core.spec import Light, Texture
from alight.core.uv_sets import UV_SETS
from alight.lights.environment_map import EMPTY, EnvironmentMap
from alight.lights.model import LIGHTS
from alight.lights.tables import (
    INFO,
    IS_LIST,
    MAP_START,
    MAPPED,
    STRIDE,
    TEXTURED,
    EmittingLights,
    LightTables,
)
from alight.lights.tree.split import Leaves
from alight.scene.flatten import FlatScene, PlacedLight
from alight.shapes.hit import INFO as SHAPE_INFO
from alight.shapes.model import SHAPES
from lanewise.view import View

Selection = Literal["auto", "power", "uniform", "tree"]

#: By default more lights than this (triangles of shining meshes counted) may be chosen by a tree.
MOST_WITHOUT_TREE = 16

#: By default they are, if so much can be gained (`gain_of_tree`), and a tree that is asked for is
#: walked then: else only intensity counts in it. A walk takes up to twice the time (decision 20).
LEAST_GAIN = 2.0

#: Above it, by default, the tree would take long to build.
MOST_IN_TREE = 1 << 20


class CompiledLights(NamedTuple):
    """All lights of a scene.

    Attributes
    ----------
    tables : LightTables or EmittingLights
    kinds : tuple of str
        For `Program.lights`: the models in use, then `TEXTURED` where a light has a texture, and
        `MAPPED` where points are chosen by it.
    shapes : tuple of str
        For `Program.light_shapes`.
    is_dark : bool
        No light emits anything.
    has_tree : bool
        Lights are chosen by a tree, for `Program.light_tree`.
    environments : tuple of str
        For `Program.environments`.
    """

    tables: LightTables | EmittingLights
    kinds: tuple[str, ...]
    shapes: tuple[str, ...]
    is_dark: bool
    has_tree: bool
    environments: tuple[str, ...]


def light_textures(flat: FlatScene) -> list[Texture]:
    """The textures of shapes that shine, each once, in the order of the shapes."""
    lights = (shape.light for shape in flat.shapes if shape.light is not None)
    return list(dict.fromkeys(found for light in lights if (found := _texture_of(light))))


def compile_lights(
    flat: FlatScene,
    shapes: CompiledShapes,
    selection: Selection = "auto",
    *,
    compensated: bool = False,
    emits: Emits = "never",
    aims: bool = False,
    kept: Kept | None = None,
    textures: Textures | None = None,
) -> CompiledLights:
    """Make the tables of all lights, and enter area lights into the tables of shapes.

    Parameters
    ----------
    flat : FlatScene
    shapes : CompiledShapes
        Its ``tables.info`` is completed in place.
    selection : {"auto", "power", "uniform", "tree"}, default "auto"
        Each light that shines is equally likely, as likely as its share of the power (see
        `alight.compiled.light_tree.by_power`), or as likely as a tree says at the lit point; "auto"
        takes the tree for many lights where it gains, else the power.
    compensated : bool, default False
        Light sampling is combined with BSDF sampling, which finds what the compensated map of an
        environment leaves out.
    emits : {"never", "if possible", "always"}, default "never"
        Whether light paths start at the lights, which takes the tables of
        `alight.lights.emission.sampling`.
    aims : bool, default False
        Whether paths aim at lamps, which takes the tables of `alight.lights.targets`.
    kept : Kept, optional
        Of the compilation before: maps of environments are taken from there.
    textures : Textures, optional
        The scene's, which begin with those of `light_textures`: points of textured lamps are chosen
        by them. Without them lamps are taken to shine evenly.

    Raises
    ------
    SceneError
        If they always do, and there is a light at which none can start.
    """
    rows, kept = _rows(flat, shapes, textures), kept or Kept()
    around = [_environment(p, compensated, kept, aims) for p in flat.environments]
    rows += [row for row, _ in around]
    powers = _powers(rows, shapes.radius)
    weights = _weights(rows, powers, selection)
    leaves, gains = None, False
    if selection == "tree" or (selection == "auto" and _are_many(rows)):
        leaves = find_leaves(rows, weights, shapes)
        gains = _gain(rows, leaves, shapes) >= LEAST_GAIN
    if leaves is None or (selection == "auto" and not gains):
        leaves, choice = None, _chosen_by_table(rows, weights, shapes)
    else:
        choice = chosen_by_tree(rows, weights, leaves, shapes, walked=gains)
    info, data = np.zeros((len(rows), INFO), np.uint32), np.zeros((len(rows), STRIDE), np.float32)
    for i, row in enumerate(rows):
        info[i] = LIGHTS[row.kind].number, max(row.shape, 0), row.texture, choice.starts[i]
        data[i, :3], data[i, 3] = row.color, choice.probabilities[i]
        data[i, 4 : 4 + len(row.numbers)] = row.numbers
        if row.shape >= 0:
            shapes.tables.info.array[row.shape * SHAPE_INFO + 2] = i + 1
    tables, maps = choice.tables, []
    for i, row in enumerate(rows):
        if _is_mapped(row):
            assert row.spread is not None
            is_list, at = _has_triangles(row, shapes), sum(table.size for table in tables)
            data[i, IS_LIST] = is_list
            data.view(np.uint32)[i, MAP_START] = at
            tables.append(row.spread.table(is_list, at))
    for i, row in enumerate(rows):
        if row.table is not None:
            info[i, 3] = sum(table.size for table in tables)
            tables.append(row.table)
    for i, (_, made) in enumerate(around, len(rows) - len(around)):
        if made is not None:
            info[i, 1], info[i, 3] = sum(m.size for m in maps), sum(t.size for t in tables)
            maps.append(made.table)
            tables.append(made.cdf)
    aimed_at = np.zeros(0, np.float32)
    if aims:
        aimed_at = targets(rows, powers, shapes, _casters(flat, shapes))
    all_tables = LightTables(
        View(info), View(data), View(np.concatenate(tables)), _joined(maps), View(aimed_at)
    )
    return CompiledLights(
        all_tables if emits == "never" else emitting(all_tables, rows, powers, shapes, emits),
        _names(rows),
        _shining(rows, shapes),
        not np.any(weights > 0.0),
        leaves is not None,
        tuple(row.kind for row, _ in around) if len(around) > 1 else (),
    )


def emitting_lights(flat: FlatScene, textures: Textures) -> EmittingLights | None:
    """Tables of lights at which light paths start, for scenes that were compiled without.

    Parameters
    ----------
    flat : FlatScene
    textures : Textures
        The scene's.

    Returns
    -------
    EmittingLights or None
        None where there is a light at which none can start.
    """
    flat = displaced(flat)
    shapes = compile_shapes(flat, uv_sets=UV_SETS in textures.names)
    made = compile_lights(flat, shapes, "power", emits="if possible", textures=textures)
    found = made.tables
    return found if isinstance(found, EmittingLights) else None


def _casters(flat: FlatScene, shapes: CompiledShapes) -> np.ndarray:
    """Boxes of what casts caustics at rest, and the numbers of their motions: (n, 7) float64."""
    boxes, numbers = boxes_by_shape(flat)
    motions = {row.source: motion for row, motion in zip(shapes.rows, shapes.motions, strict=True)}
    return np.column_stack([boxes, [motions[number] for number in numbers]])


def _joined(maps: list[np.ndarray]) -> View:
    return View(np.concatenate(maps) if maps else EMPTY)


def _chosen_by_table(rows: list[LightRow], weights: np.ndarray, shapes: CompiledShapes) -> Choosing:
    """One distribution of all lights, and one of the triangles of each mesh."""
    cdf = by_power(weights) if rows else np.zeros(2, np.float32)
    tables, starts = [cdf], np.zeros(len(rows), np.uint32)
    for i, row in enumerate(rows):
        if _has_triangles(row, shapes):
            starts[i] = sum(table.size for table in tables)
            tables.append(row.by_triangle)
    return Choosing(tables, starts, np.diff(cdf)[: len(rows)])


def _is_mapped(row: LightRow) -> bool:
    """Whether its light is spread unevenly over its shape, or over a triangle of it."""
    return row.spread is not None and any(part is not None for part in row.spread.parts)


def _has_triangles(row: LightRow, shapes: CompiledShapes) -> bool:
    return row.shape >= 0 and not SHAPES[shapes.rows[row.shape].kind].has_formula


def _are_many(rows: list[LightRow]) -> bool:
    """Whether a tree may pay for the lights that have a place."""
    count = sum(max(len(row.areas), 1) for row in rows if row.shape >= 0 or row.cone is not None)
    return MOST_WITHOUT_TREE < count <= MOST_IN_TREE


def _gain(rows: list[LightRow], leaves: Leaves, shapes: CompiledShapes) -> float:
    return gain_of_tree(leaves, shapes, shining_shapes(rows, shapes))


def _names(rows: list[LightRow]) -> tuple[str, ...]:
    found = {row.kind for row in rows}
    textured = (TEXTURED,) if any(row.texture for row in rows) else ()
    mapped = (MAPPED,) if any(map(_is_mapped, rows)) else ()
    return (*(name for name in LIGHTS if name in found), *textured, *mapped)


def _shining(rows: list[LightRow], shapes: CompiledShapes) -> tuple[str, ...]:
    kinds = {shapes.rows[row.shape].kind for row in rows if row.shape >= 0}
    return tuple(name for name in SHAPES if name in kinds)


def _rows(flat: FlatScene, shapes: CompiledShapes, textures: Textures | None) -> list[LightRow]:
    """All lights but the environments."""
    known, rows = light_textures(flat), []
    for index, shape in enumerate(shapes.rows):
        light = flat.shapes[shape.source].light
        if light is not None:
            row, texture = _row(light, np.eye(4)), _texture_of(light)
            row = row._replace(motion=flat.shapes[shape.source].motion)
            number = 0 if texture is None else known.index(texture) + 1
            row = row._replace(texture=number, shape=index, areas=shape.areas)
            if texture is not None and textures is not None and LIGHTS[row.kind].IS_MAPPED:
                spread = area_map(texture, number, shapes, index, textures)
                # What the map has not met may shine nevertheless.
                if spread is not None and any(spread.mean):
                    row = row._replace(spread=spread, mean=spread.mean)
            rows.append(row)
    return rows + [
        _row(placed.light, placed.to_world)._replace(motion=placed.motion) for placed in flat.lights
    ]


def _environment(
    placed: PlacedLight, compensated: bool, kept: Kept, aims: bool
) -> tuple[LightRow, EnvironmentMap | None]:
    """The row of an environment, and its map where it has one."""
    light, to_world = placed.light, placed.to_world
    row, model = _row(light, to_world), LIGHTS[light.type_name()]
    if aims and model.disk_of is not None:
        row = row._replace(disk=model.disk_of(light, to_world))
    if model.map_of is None:
        return row, None
    # What differs by its map only is a light of the first kind with the same kernels.
    kind = next(name for name, other in LIGHTS.items() if other.sample is model.sample)
    made = kept(f"map of {placed.name}", _mapped, model.map_of, light, to_world, compensated)
    aside = model.beside_the_map(light)
    red, green, blue = (a * (b + c) for a, b, c in zip(row.color, made.mean, aside, strict=True))
    return row._replace(kind=kind, mean=(red, green, blue)), made


def _mapped(map_of: Callable[..., EnvironmentMap], *of: Any) -> EnvironmentMap:
    """The function is one of the arguments: a model may be registered anew under its name."""
    return map_of(*of)


def _row(light: Light, to_world: np.ndarray) -> LightRow:
    kind = light.type_name()
    model = LIGHTS[kind]
    color, numbers = model.place(light, to_world)
    mean = model.mean_color(light) if model.mean_color else color
    cone = None
    if model.cone and not model.is_on_shape:
        axis = to_world[:3, 2] / np.linalg.norm(to_world[:3, 2])
        cone = (axis, *model.cone(light))
    table = model.table(light) if model.table else None
    dark = model.dark_beyond(light)
    row = LightRow(kind, color, numbers, mean, cone=cone, table=table, dark=dark)
    return row._replace(light=light)


def _texture_of(light: Light) -> Texture | None:
    return LIGHTS[light.type_name()].texture(light)


def _powers(rows: list[LightRow], radius: float) -> np.ndarray:
    """Of each light, W."""
    return np.array(
        [LIGHTS[row.kind].power(row.brightness, float(row.areas.sum()), radius) for row in rows]
    )


def _weights(rows: list[LightRow], powers: np.ndarray, selection: Selection) -> np.ndarray:
    """What light sampling chooses the lights by."""
    weights = (powers > 0.0).astype(np.float64) if selection == "uniform" else powers
    windows = np.array([LIGHTS[row.kind].window(row.numbers) for row in rows])
    if windows.any():
        # Half of what is drawn from the surroundings, their suns left aside.
        taken = weights * [0.5 * _share_all_around(row) for row in rows]
        weights = weights - taken + taken.sum() * windows / windows.sum()
    return weights


def _share_all_around(row: LightRow) -> float:
    """Share of the samples of a light that go to its surroundings."""
    model = LIGHTS[row.kind]
    return model.share_all_around(row.numbers) if model.is_around else 0.0
