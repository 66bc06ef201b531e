"""The numbers of a report as CSV (one file a kind of table) and as one JSON file."""

from __future__ import annotations

import csv
import io
import json
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from alight.lab.results import ArmResult, Point, SceneResult, StudyResult
from alight.metrics.estimate import Estimate
from alight.outputs.atomic import replacing


def write_data(result: StudyResult, folder: Path) -> list[Path]:
    """Write ``report.json``, ``arms.csv``, ``points.csv``, ``curves.csv`` and the tables.

    Raises
    ------
    OutputError
        If a file cannot be written; those that were there before are then whole.
    """
    text = json.dumps(numbers_of(result), indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    written = [_write(folder / "report.json", text)]
    if result.scenes:
        written += [
            _write_table(folder / "arms.csv", _arm_rows(result)),
            _write_table(folder / "points.csv", _point_rows(result)),
        ]
    if result.curves:
        written.append(_write_table(folder / "curves.csv", _curve_rows(result)))
    for table in result.tables:
        name = re.sub(r"[^\w-]+", "-", table.name).strip("-") or "table"
        rows = [
            {c: _cell(v) for c, v in zip(table.columns, row, strict=True)} for row in table.rows
        ]
        written.append(_write_table(folder / f"table-{name}.csv", rows))
    return written


def numbers_of(value: Any) -> Any:
    """JSON data of a result without its pictures; unknown numbers are null.

    An `Estimate` becomes an object with `value`, `low` and `high`.
    """
    if isinstance(value, Estimate):
        return {name: numbers_of(v) for name, v in value._asdict().items()}
    if is_dataclass(value):
        named = ((f.name, getattr(value, f.name)) for f in fields(value))
        return {name: numbers_of(v) for name, v in named if not isinstance(v, np.ndarray)}
    if isinstance(value, dict):
        return {str(k): numbers_of(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [numbers_of(v) for v in value]
    value = value.item() if isinstance(value, np.generic) else value
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _spread(name: str, estimate: Estimate | None) -> dict[str, Any]:
    """Three columns of an estimate."""
    value = estimate or Estimate(math.nan, math.nan, math.nan)
    return {name: value.value, f"{name}_low": value.low, f"{name}_high": value.high}


def _arm_rows(result: StudyResult) -> list[dict[str, Any]]:
    return [_arm_row(scene, arm) for scene in result.scenes for arm in scene.arms]


def _arm_row(scene: SceneResult, arm: ArmResult) -> dict[str, Any]:
    speedup = arm.speedup
    return {
        "scene": scene.name, "arm": arm.name, "label": arm.label,
        "baseline": int(arm.is_baseline), "declares_different": int(arm.declares_different),
        "options": json.dumps(numbers_of(arm.options), ensure_ascii=False),
        "replicates": arm.replicates, "verdict": arm.bias.verdict,
        **_spread("efficiency", arm.efficiency),
        **_spread("speedup", speedup and speedup.ratio),
        "speedup_p": speedup.p_value if speedup else math.nan,
        "speedup_p_holm": speedup.p_adjusted if speedup else math.nan,
        "bootstrap_low": speedup.bootstrap.low if speedup else math.nan,
        "bootstrap_high": speedup.bootstrap.high if speedup else math.nan,
        **_spread("slope_spp", arm.slope_spp), **_spread("slope_time", arm.slope_time),
        "expected_slope": arm.expected_slope,
        "z_rms": arm.bias.z_rms, "z_low": arm.bias.z_low, "z_high": arm.bias.z_high,
        "z_largest": arm.bias.z_largest, "bias_p": arm.bias.p_value,
        **_spread("microseconds_per_sample", arm.microseconds_per_sample),
        "compile_seconds": arm.compile_seconds, "load_seconds": arm.load_seconds,
        "invalid": arm.invalid, "seeds": " ".join(map(str, arm.seeds)),
    }  # fmt: skip


def _point_rows(result: StudyResult) -> list[dict[str, Any]]:
    rows = []
    for scene in result.scenes:
        for arm in scene.arms:
            for ladder, points in (("equal samples", arm.samples), ("equal time", arm.times)):
                rows += [_point_row(scene.name, arm.name, ladder, p) for p in points]
    return rows


def _point_row(scene: str, arm: str, ladder: str, point: Point) -> dict[str, Any]:
    row: dict[str, Any] = {"scene": scene, "arm": arm, "ladder": ladder, "spp": point.spp}
    told = {
        "seconds": point.seconds, **point.errors,
        "bias2": point.bias2, "variance": point.variance,
    }  # fmt: skip
    for name, estimate in told.items():
        row |= _spread(name, estimate)
    return row


def _curve_rows(result: StudyResult) -> list[dict[str, Any]]:
    return [
        {
            "diagram": diagram.name, "curve": curve.name, "x": x, "y": y, "low": low, "high": high,
            **_spread("slope", curve.slope), "expected_slope": curve.expected_slope,
        }
        for diagram in result.curves
        for curve in diagram.curves
        for x, y, low, high in zip(curve.x, curve.y, curve.low, curve.high, strict=True)
    ]  # fmt: skip


def _cell(value: Any) -> Any:
    """One cell of a study's own table: an interval becomes ``value [low, high]``."""
    if isinstance(value, list | tuple) and len(value) == 3:
        return f"{value[0]!r} [{value[1]!r}, {value[2]!r}]"
    return value


def _write_table(path: Path, rows: Sequence[dict[str, Any]]) -> Path:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    if rows:
        writer.writerow(rows[0])
    for row in rows:
        writer.writerow(list(_csv_values(row.values())))
    return _write(path, text.getvalue())


def _csv_values(values: Iterable[Any]) -> Iterable[Any]:
    """Full precision; nothing where a number is unknown."""
    for value in values:
        value = value.item() if isinstance(value, np.generic) else value
        unknown = value is None or (isinstance(value, float) and math.isnan(value))
        yield "" if unknown else value


def _write(path: Path, text: str) -> Path:
    with replacing(path) as beside:
        beside.write_text(text, encoding="utf-8")
    return path
