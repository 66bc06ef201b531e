"""A `Trace` as a table of text: one vertex a line, 100 columns wide if the names allow it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from alight.rendering.tracing.traced_path import Trace, Vertex

WIDTH = 100

#: Columns that may be cut when a line is too long, and how short.
_LEAST = {"shape": 8, "bsdf": 7}

#: Title and whether its numbers are aligned to the right.
_COLUMNS = (
    "#", "position", "shape", "bsdf", "beta", "p_b", "w_b", "p_l", "w_l", "contribution",
)  # fmt: skip
_TEXTS = {"shape", "bsdf"}

LEGEND = (
    "beta: throughput up to here; p_b: density of the direction that led here, 1/sr (d: camera ray",
    "or delta lobe); w_b: MIS weight of the light found there; p_l, w_l: the same of the light",
    "sample (x: nothing of it arrives); contribution: what the vertex adds. Triples are r g b.",
)


def table_of(trace: Trace) -> Iterator[str]:
    """Lines of the table, with a head and the sum."""
    x, y = trace.pixel
    yield (
        f"{trace.scene}: pixel {x},{y}, sample {trace.sample} (replicate {trace.replicate}), "
        f"seed {trace.seed}"
    )
    yield (
        f"{trace.integrator}, {trace.sampler}, {trace.filter} filter of weight "
        f"{trace.weight:.6g}, {trace.rays} rays"
    )
    yield ""
    digits = _digits_of_places([v.position for v in trace.vertices if v.position is not None])
    rows = [_row(vertex, digits) for vertex in trace.vertices]
    yield from _aligned([_COLUMNS, *rows])
    yield ""
    sums = [math.fsum(v.contribution[i] for v in trace.vertices) for i in range(3)]
    yield f"sum    {_exact(sums)}"
    if trace.valid:
        yield f"value  {_exact(trace.value)}  (what the film adds)"
    else:
        yield "value  0 0 0  (the film adds nothing: the sample is not a finite number)"
    yield ""
    yield from LEGEND


def _digits_of_places(places: Sequence[Sequence[float]]) -> int:
    """Enough to tell vertices apart, however far from the origin they are."""
    if not places:
        return 3
    extent = max(max(side) - min(side) for side in zip(*places, strict=True))
    largest = max(abs(c) for place in places for c in place)
    if not 0.0 < extent < largest:
        return 3
    return 3 + min(math.floor(math.log10(largest / extent)), 12)


def _row(vertex: Vertex, digits: int) -> tuple[str, ...]:
    emission, light = vertex.emission, vertex.light
    return (
        str(vertex.depth),
        "" if vertex.position is None else _triple(vertex.position, digits),
        vertex.shape or ("(left the scene)" if vertex.position is None else "(in a medium)"),
        vertex.bsdf or "",
        _triple(vertex.beta, 2),
        "d" if vertex.delta else _short(vertex.pdf),
        "" if emission is None or emission.weight is None else _short(emission.weight),
        "" if light is None else _short(light.pdf) + ("" if light.visible else "x"),
        "" if light is None or light.weight is None else _short(light.weight),
        _triple(vertex.contribution, 3),
    )


def _aligned(rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """Rows as lines; shapes and materials are cut where a line would be too long."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(_COLUMNS))]
    too_much = sum(widths) + len(widths) - 1 - WIDTH
    for name, least in _LEAST.items():
        i = _COLUMNS.index(name)
        less = min(max(too_much, 0), max(widths[i] - least, 0))
        widths[i] -= less
        too_much -= less
    for row in rows:
        cells = []
        for title, cell, width in zip(_COLUMNS, row, widths, strict=True):
            text = cell if len(cell) <= width else "…" + cell[len(cell) - width + 1 :]
            cells.append(text.ljust(width) if title in _TEXTS else text.rjust(width))
        yield " ".join(cells).rstrip()


def _triple(values: Sequence[float], digits: int) -> str:
    """Three numbers with as many digits as the largest needs; one, if they are equal."""
    largest = max(map(abs, values))
    if len(set(values)) == 1:
        return _short(values[0])
    if not 1e-4 <= largest < 1e6:
        return " ".join(_short(value, max(digits - 1, 2)) for value in values)
    places = max(digits - 1 - math.floor(math.log10(largest)), 0)
    return " ".join(f"{value:.{places}f}" for value in values)


def _short(value: float, digits: int = 3) -> str:
    if not math.isfinite(value):
        return str(value)
    return f"{value:.{digits}g}".replace("e-0", "e-").replace("e+0", "e")


def _exact(values: Sequence[float]) -> str:
    return "  ".join(f"{value:.7g}" for value in values)
