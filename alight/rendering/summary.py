"""The summary of a finished render: on the terminal and as JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from alight.outputs.atomic import replacing

if TYPE_CHECKING:
    from alight.films import Film
    from alight.films.ledger import Bias
    from alight.metrics import ErrorEstimate, Estimate


def summary_lines(
    film: Film, error: ErrorEstimate, unsure: float, seconds: float, further: Sequence[Bias] = ()
) -> list[str]:
    """Say size, samples, time, rate, error and the share of unsure pixels in words.

    `seconds` are those of this process; what was rendered before a checkpoint is added to them.
    """
    _, _, w, h = film.crop
    rate, spent = film.stats["msamples_per_s"], film.stats["seconds"]
    whole = seconds + spent.get("resumed_at", 0.0)
    speed = f"{film.spp:g} spp in {spent['render']:.2f} s, {rate:.2f} Msamples/s"
    lines = [f"{w}x{h} pixels, {speed} ({whole:.2f} s in all)"]
    known = not math.isnan(error.relmse.value)
    doubts = unsure_lines(unsure) if known else []
    lines += [error_line(error), *doubts, *guide_lines(film)]
    return [*lines, *bias_lines(film, further), *verdict_lines(film)]


def guide_lines(film: Film) -> list[str]:
    """Say what a guide gains, if one was trained."""
    guide = film.stats.get("guide")
    return [guide["line"]] if guide else []


def bias_lines(film: Film, further: Sequence[Bias] = ()) -> list[str]:
    """Say what in the picture is biased, beyond the film too, and by how much."""
    return [f"bias: {bias.line}" for bias in (*film.biases, *further)]


def verdict_lines(film: Film) -> list[str]:
    """Say how the render ended, if an error was asked for."""
    verdict = film.stats.get("verdict", {})
    line = verdict.get("line", "")
    if verdict.get("word") == "not met" and verdict.get("factor"):
        seconds = (verdict["factor"] - 1.0) * film.stats["seconds"]["render"]
        line += f" (about {seconds:.3g} s)"
    return [line] if line else []


def error_line(error: ErrorEstimate) -> str:
    """Say how wrong the picture is."""
    return f"estimated error: {error.line}"


def unsure_lines(share: float) -> list[str]:
    """Say of how many pixels the error bars may be too short, if of any."""
    if share < 0.001:
        return []
    return [
        f"error bars of {100 * share:.3g} % of the pixels are unsure: few samples carry the noise"
    ]


def statistics_of(
    film: Film,
    error: ErrorEstimate,
    unsure: float,
    outputs: list[Path],
    warnings: list[str],
    further: Sequence[Bias] = (),
) -> dict[str, Any]:
    """Gather what ``--stats`` writes."""
    from alight.rendering.schedules.unseen import unseen_of

    literature = _estimate(error.relmse_literature)
    unseen = unseen_of(film)
    return {
        **film.stats,
        "relmse": {"epsilon": error.epsilon, **_estimate(error.relmse)},
        "relmse_literature": {"epsilon": 0.01, **literature},
        "relrmse": _estimate(error.relrmse),
        "interval_promised": error.promised,
        "unsure_pixels": unsure,
        "unseen": {
            "indicator": unseen.indicator,
            "bound": unseen.bound,
            "largest_sample": film.largest_sample,
        },
        "provenance": film.provenance,
        "biases": [bias.state() for bias in (*film.biases, *further)],
        "outputs": [str(path) for path in outputs],
        "warnings": warnings,
    }


def _estimate(estimate: Estimate) -> dict[str, float]:
    return {"value": estimate.value, "low": estimate.low, "high": estimate.high}


def write_json(path: Path, data: dict[str, Any]) -> None:
    """Write JSON, whole or not at all; what is not a finite number becomes null.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    text = json.dumps(_plain(data), indent=2, allow_nan=False)
    with replacing(path) as beside:
        beside.write_text(text + "\n", "utf-8")


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    # NumPy's numbers; anything else by its text.
    return _plain(value.item()) if hasattr(value, "item") else str(value)
