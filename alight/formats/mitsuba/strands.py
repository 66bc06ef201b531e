"""Curves from text files: a control point a line, x y z radius; empty lines divide strands.

Source: the documentation of Mitsuba 3, plug-ins ``bsplinecurve`` and ``linearcurve``.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from alight.core.errors import Issue, SceneError, quote, show_value
from alight.formats.mitsuba.draft import Draft
from alight.formats.mitsuba.meshes import MOST_BYTES
from alight.formats.mitsuba.transforms import Step, matrix_of
from alight.formats.reading.packed import content_of
from alight.formats.reading.reach import OutOfReachError
from alight.shapes.curves import Curves

#: Plug-in -> our basis, and the fewest points of a strand.
BASES = {"bsplinecurve": ("b_spline", 4), "linearcurve": ("linear", 2)}


def load_strands(draft: Draft, steps: list[Step]) -> Curves | None:
    """Read the strands that a shape names; None after a problem.

    A transform moves the points and leaves the radii as they are.
    """
    p, context = draft.properties, draft.context
    p.ignore("curves are met from outside only", "flip_normals", "silhouette_sampling_weight")
    found = p.value("filename", "string")
    if found is None:
        if not p.has("filename"):
            context.report.error(draft.element, 'needs <string name="filename" .../>')
        return None
    element, name = found
    basis, fewest = BASES[draft.element.type]
    try:
        rows, counts = context.meshes.read(_READERS[fewest], name, context.reach.find(name))
        growth = np.cbrt(abs(np.linalg.det(matrix_of(steps)[:3, :3])))
        radii = rows[:, 3] / growth if growth > 0.0 else rows[:, 3]
        return Curves(points=rows[:, :3], radii=radii, counts=counts, basis=basis)
    except OutOfReachError as error:
        context.report.lacks(element, error, "the shape is left out")
    except SceneError as error:
        for issue in error.issues:
            context.report.error(element, f"{quote(name)}: {issue.sentence}")
    return None


def _read_strands(path: Path, fewest: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows (n, 4) of all strands, and how many rows each has."""
    lines = content_of(path, MOST_BYTES).decode("utf-8", "replace").splitlines()
    rows, counts, count = [], [], 0
    for number, line in enumerate([*lines, ""], 1):
        words = line.split()
        if words:
            rows.append(_row(words, number))
            count += 1
            continue
        if 0 < count < fewest:
            raise _error(f"line {number - 1}: a strand has at least {fewest} points, got {count}")
        counts += [count] if count else []
        count = 0
    if not counts:
        raise _error("must hold at least one strand")
    return np.array(rows), np.array(counts, np.int32)


def _row(words: list[str], number: int) -> list[float]:
    try:
        row = [float(word) for word in words]
    except ValueError:
        row = []
    if len(row) != 4 or not np.isfinite(row).all() or row[3] < 0.0:
        shown = show_value(" ".join(words)[:60])
        raise _error(f"line {number}: must be four numbers, x y z and a radius >= 0, got {shown}")
    return row


def _cubic(path: Path, name: str) -> tuple[np.ndarray, np.ndarray]:
    return _read_strands(path, 4)


def _straight(path: Path, name: str) -> tuple[np.ndarray, np.ndarray]:
    return _read_strands(path, 2)


_READERS = {4: _cubic, 2: _straight}


def _error(message: str) -> SceneError:
    return SceneError([Issue("", message)])
