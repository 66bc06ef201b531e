"""What cases are made with: answers of any objects, films without a renderer, runs by the twin."""

from __future__ import annotations

import contextlib
import dataclasses
import math
import os
import re
import tempfile
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

from alight.core.errors import AlightError
from alight.films import Film, PartialFilm
from alight.films.fixed_point import to_limbs
from alight.rendering.tiles.tile import make_kernels

#: Arrays of more numbers are summed up.
FEW = 48


def described(value: Any, few: int = FEW) -> Any:
    """All that an object holds, as an answer; arrays of more than `few` numbers summed up."""
    told = partial(described, few=few)
    if isinstance(value, np.ndarray):
        return summed_up(value) if value.size > few else told(value.tolist())
    if value is None or isinstance(value, (bool, int, float, np.number, np.bool_)):
        return value
    if isinstance(value, str):
        return masked(value)
    if isinstance(value, os.PathLike):
        return masked(str(value))
    if isinstance(value, BaseException):
        return f"{type(value).__name__}: {masked(str(value))}"
    if isinstance(value, Mapping):
        return {masked(str(key)): told(one) for key, one in value.items()}
    if isinstance(value, tuple) and hasattr(value, "_asdict"):
        return told(value._asdict())
    if isinstance(value, (set, frozenset)):
        return told(sorted(value, key=str))
    if isinstance(value, (list, tuple, Iterator)):
        return [told(one) for one in value]
    if isinstance(value, (bytes, memoryview)):
        return summed_up(np.frombuffer(value, np.uint8))
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: told(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, type) or callable(value):
        return getattr(value, "__name__", type(value).__name__)
    return masked(re.sub(r" at 0x[0-9a-f]+", "", str(value)))


def summed_up(array: np.ndarray) -> dict[str, Any]:
    """A large array by a few numbers, which change if any of its own does."""
    flat = array.ravel().astype(np.float64)
    finite = np.isfinite(flat)
    kept = flat[finite]
    # Weights that are no pattern of a picture.
    weights = np.cos(1.3 * np.arange(flat.size) + 0.2) + 0.1
    return {
        "shape": list(array.shape),
        "type": "integer" if array.dtype.kind in "iu" else array.dtype.kind,
        "not finite": int((~finite).sum()),
        "numbers": [
            float(kept.min(initial=math.inf)),
            float(kept.max(initial=-math.inf)),
            float(kept.mean()) if kept.size else 0.0,
            float(np.sqrt(np.mean(kept**2))) if kept.size else 0.0,
            float(np.mean(weights[finite] * kept)) if kept.size else 0.0,
        ],
    }


def outcome(function: Callable[..., Any], *values: Any, **words: Any) -> Any:
    """What a call gives, or the error that it raises."""
    try:
        return described(function(*values, **words))
    except (AlightError, ValueError, TypeError, KeyError) as error:
        return described(error)


def briefly(data: Any) -> Any:
    """Plain data whose long tables of numbers are summed up; numbers alone are a line."""
    if isinstance(data, Mapping):
        return {key: briefly(value) for key, value in data.items()}
    if not isinstance(data, (list, tuple)):
        return described(data)
    try:
        table = np.array(data, np.float64)
    except (TypeError, ValueError):
        return [briefly(value) for value in data]
    return summed_up(table) if table.size > FEW else described(data)


def rows(function: Callable[..., Any], inputs: Mapping[str, Any] | list[Any]) -> dict[str, Any]:
    """The outcomes of a function of one argument, or of tuples of them."""
    named = inputs.items() if isinstance(inputs, Mapping) else ((repr(one), one) for one in inputs)
    return {
        name: outcome(function, *(one if isinstance(one, tuple) else (one,))) for name, one in named
    }


#: What differs from run to run and from machine to machine, and what stands in its place.
MASKS = (
    (r"(?<![\w.])/[\w./+-]*alight-record\w+/(?=[\w.+-])", ""),
    (r"(?<![\w.])/[\w./+-]*alight-record\w+", "FOLDER"),
    (r"\b\d+(?:\.\d+)?(?:e[+-]\d+)? (ms|s|seconds|min|h)\b", r"# \1"),
    (r"\bseconds \d[\d.e+-]*", "seconds #"),
    (r"\b\d+(?:\.\d+)? Msamples/s", "# Msamples/s"),
    (r"\b\d+(?:\.\d+)? (MB|kB|GB)\b", r"# \1"),
    (r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d[\d.+:Z]*", "DATE"),
    (r"\b[0-9a-f]{16,}\b", "DIGEST"),
)


#: Numbers in texts with more digits than are the same on every machine.
LONG = re.compile(r"(?<![\w.])-?\d+\.\d{6,}(?:e[+-]?\d+)?")


def masked(text: str) -> str:
    """A text without folders of this run, times, speeds, memory, dates, digests and last digits."""
    text = LONG.sub(lambda found: f"{float(found[0]):.5g}", text.replace(f"{Path.cwd()}/", ""))
    for pattern, instead in MASKS:
        text = re.sub(pattern, instead, text)
    return text


@contextlib.contextmanager
def in_folder(files: Mapping[str, str | bytes] | None = None) -> Iterator[Path]:
    """An empty folder to work in, with some files."""
    before = Path.cwd()
    with tempfile.TemporaryDirectory(prefix="alight-record") as name:
        folder = Path(name).resolve()
        for path, content in (files or {}).items():
            target = folder / path
            target.parent.mkdir(parents=True, exist_ok=True)
            if isinstance(content, str):
                target.write_text(content, "utf-8")
            else:
                target.write_bytes(content)
        os.chdir(folder)
        try:
            yield folder
        finally:
            os.chdir(before)


def command(*words: str, columns: int = 100) -> dict[str, Any]:
    """The transcript of a command: its exit code and what it says."""
    from typer.testing import CliRunner

    from alight.cli.main import app

    env = {"COLUMNS": str(columns), "NO_COLOR": "1", "TERM": "dumb", "FORCE_COLOR": None}
    done = CliRunner().invoke(app, list(map(str, words)), env=env)
    if done.exception and not isinstance(done.exception, SystemExit):
        raise done.exception
    return {"exit": done.exit_code, "says": masked(done.stdout), "warns": masked(done.stderr)}


#: Modules that render by machine code.
RENDERING = (
    "rendering.job", "laws.scene.pictures", "lab.replicates.measure", "lab.guide.incidence",
    "view.movable",
)  # fmt: skip


@contextlib.contextmanager
def by_twin() -> Iterator[None]:
    """Renders of this block are those of the NumPy reading of kernels."""
    twins = partial(make_kernels, compiled=False)
    with contextlib.ExitStack() as stack:
        for module in RENDERING:
            stack.enter_context(mock.patch(f"alight.{module}.make_kernels", twins))
        yield


def film_of(
    size: tuple[int, int] = (21, 13),
    crop: tuple[int, int, int, int] | None = None,
    *,
    replicates: int = 4,
    spp: int = 8,
    seed: int = 1,
    spread: float = 0.5,
    aovs: Mapping[str, tuple[str, ...]] | None = None,
    **words: Any,
) -> Film:
    """A film of noise around an uneven picture with a dark corner and three channels unlike."""
    film = Film(*size, crop=crop, replicates=replicates, aovs=aovs, seed=seed, **words)
    if spp:
        add_samples(film, 0, spp, spread)
    return film


def add_samples(film: Film, first: int, count: int, spread: float = 0.5) -> None:
    """Add the samples first to first + count - 1 of each pixel."""
    x, y, w, h = film.crop
    across, down = np.arange(x, x + w) / film.width, np.arange(y, y + h)[:, None] / film.height
    truth = np.stack(
        np.broadcast_arrays(0.9 * across * down + 0.01, 0.3 + 0.4 * across, 1.7 * down**2), -1
    )
    draw = np.random.default_rng([film.seed, first])
    noise = draw.random((count, h, w, 3)) ** 2 + 0.5 * draw.random((count, h, w, 1))
    values = truth * (1.0 + spread * (4.0 * noise - 2.3))
    add_values(film, values.astype(np.float32), first)


def add_values(film: Film, values: np.ndarray, first: int) -> None:
    """Add the values of samples, shape (count, h, w, 3)."""
    x, y, w, h = film.crop
    count = len(values)
    limbs, invalid, saturated = to_limbs(values)
    sums = np.zeros((h, w, film.replicates, 3, 2), np.int64)
    counts = np.zeros((h, w, film.replicates), np.int64)
    for i in range(count):
        sums[:, :, (first + i) % film.replicates] += limbs[i]
        counts[:, :, (first + i) % film.replicates] += 1
    whole = limbs.sum(axis=0)
    aovs = {
        name: np.ascontiguousarray(whole[:, :, : len(names)])
        for name, names in film.aov_channels.items()
    }
    film.add_tile(
        PartialFilm(
            x,
            y,
            sums,
            counts,
            int(invalid.any(axis=-1).sum()),
            int(saturated.sum()),
            (first, count),
            aovs,
        )
    )
