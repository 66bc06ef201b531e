"""Tables of lights that emit light paths: the choice among them, and on each."""

from __future__ import annotations

from typing import Literal

import numpy as np

from alight.compiled.light_tree import LightRow, by_power
from alight.compiled.shapes import CompiledShapes
from alight.core.errors import Issue, SceneError
from alight.lights.model import LIGHTS
from alight.lights.tables import EmittingLights, LightTables
from alight.shapes.model import SHAPES
from lanewise.view import View

#: Whether light paths start at the lights of a scene.
Emits = Literal["never", "if possible", "always"]


def emitting(
    tables: LightTables,
    rows: list[LightRow],
    powers: np.ndarray,
    shapes: CompiledShapes,
    emits: Emits,
) -> LightTables | EmittingLights:
    """Tables of lights with what `alight.lights.emission.sampling` needs besides.

    Parameters
    ----------
    tables : LightTables
    rows : list of LightRow
        One a light.
    powers : (n,) float64, W
    shapes : CompiledShapes
    emits : {"if possible", "always"}
        "if possible" leaves the tables as they are where a light cannot emit.

    Raises
    ------
    SceneError
        If the scene has a light at which no light path can start, and they always should.
    """
    issues = _issues(rows, shapes)
    if issues and emits == "always":
        raise SceneError(issues)
    if issues:
        return tables
    choice = by_power(powers) if rows else np.zeros(2, np.float32)
    parts = [np.array([*shapes.center, shapes.radius], np.float32), choice]
    starts = np.zeros(max(len(rows), 1), np.uint32)
    for i, row in enumerate(rows):
        own = _table(row, shapes)
        if own is not None:
            starts[i] = sum(part.size for part in parts)
            parts.append(own)
    emission, per_area = np.concatenate(parts).astype(np.float32), np.zeros(starts.size, np.float32)
    for i, row in enumerate(rows):
        if row.shape >= 0:
            per_area[i] = 1.0 / max(row.areas.sum(), np.finfo(np.float32).tiny)
    return EmittingLights(*tables, View(emission), View(starts), View(per_area))


def _table(row: LightRow, shapes: CompiledShapes) -> np.ndarray | None:
    """What is chosen on one light: a triangle, or by the light's own table."""
    if row.shape >= 0:
        formula = SHAPES[shapes.rows[row.shape].kind].has_formula
        return None if formula else row.by_triangle
    table = LIGHTS[row.kind].emission_table
    return table(row.light) if table and row.light is not None else None


def _issues(rows: list[LightRow], shapes: CompiledShapes) -> list[Issue]:
    """What cannot emit, each kind once."""
    without = {
        row.kind for row in rows
        if LIGHTS[row.kind].spec.placement == "node" and LIGHTS[row.kind].emit is None
    }  # fmt: skip
    dark = {
        kind for row in rows
        if row.shape >= 0 and SHAPES[kind := shapes.rows[row.shape].kind].sample_area is None
    }  # fmt: skip
    return [
        Issue(
            "lights", f"no light path can start at a light {where} {name}: it has no kernel {text}"
        )
        for names, where, text in (
            (without, "of type", "emit"),
            (dark, "on a shape of type", "sample_area"),
        )
        for name in sorted(names)
    ]
