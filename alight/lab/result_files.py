"""Results of studies in files: JSON, with the pictures beside it."""

from __future__ import annotations

import json
import math
from dataclasses import fields, is_dataclass
from pathlib import Path
from types import UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

import numpy as np

from alight.core.errors import AlightError
from alight.lab.results import StudyResult
from alight.metrics.estimate import Estimate
from alight.outputs.atomic import replacing


def save(result: StudyResult, folder: str | Path, stem: str = "results") -> Path:
    """Write ``stem.json`` and ``stem.npz`` into a folder.

    Raises
    ------
    OutputError
        If a file cannot be written; the old files are then still there.
    """
    folder = Path(folder)
    arrays: dict[str, np.ndarray] = {}
    data = _plain(result, "", arrays)
    with replacing(folder / f"{stem}.npz") as beside, beside.open("wb") as file:
        np.savez_compressed(file, **arrays)
    target = folder / f"{stem}.json"
    with replacing(target) as beside:
        beside.write_text(json.dumps(data, indent=1, allow_nan=False) + "\n", "utf-8")
    return target


def load(path: str | Path) -> StudyResult:
    """Read what `save` wrote.

    Raises
    ------
    AlightError
        If it is not a result of a study.
    """
    path = Path(path)
    try:
        data = json.loads(path.read_text("utf-8"))
        with np.load(path.with_suffix(".npz"), allow_pickle=False) as stored:
            arrays = {name: stored[name] for name in stored.files}
        return _restored(StudyResult, data, arrays)
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise AlightError(f"{path}: is not a result of a study: {error}") from error


def _plain(value: Any, path: str, arrays: dict[str, np.ndarray]) -> Any:
    """JSON data of a value; arrays go to `arrays` under their path."""
    if is_dataclass(value):
        return {
            f.name: _plain(getattr(value, f.name), f"{path}/{f.name}", arrays)
            for f in fields(value)
        }
    if isinstance(value, np.ndarray):
        arrays[path.strip("/")] = value
        return path.strip("/")
    if isinstance(value, dict):
        return {str(key): _plain(item, f"{path}/{key}", arrays) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item, f"{path}/{i}", arrays) for i, item in enumerate(value)]
    if isinstance(value, np.generic):
        value = value.item()
    # JSON has no infinity; NaN means unknown.
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def _restored(kind: Any, data: Any, arrays: dict[str, np.ndarray]) -> Any:
    """A value of the annotated type from JSON data."""
    if get_origin(kind) in (Union, UnionType):
        if data is None:
            return None
        kind = next(option for option in get_args(kind) if option is not type(None))
    if isinstance(kind, type) and is_dataclass(kind):
        hints = get_type_hints(kind)
        names = [f.name for f in fields(kind)]
        return kind(**{name: _restored(hints[name], data[name], arrays) for name in names})
    if kind is Estimate:
        return Estimate(*(_number(item) for item in data))
    if kind is np.ndarray:
        return arrays[data]
    if kind is float:
        return _number(data)
    if get_origin(kind) is list:
        (item,) = get_args(kind)
        return [_restored(item, one, arrays) for one in data]
    if get_origin(kind) is dict and get_args(kind)[1] is not Any:
        _, item = get_args(kind)
        return {key: _restored(item, one, arrays) for key, one in data.items()}
    return data


def _number(value: float | None) -> float:
    return math.nan if value is None else float(value)
