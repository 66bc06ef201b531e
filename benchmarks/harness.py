"""What the benchmarks share: renderers in processes of their own, medians, tables.

Timings of two renderers are comparable only if they alternate on one machine, so every script here
runs A, B, A, B ... and reports the median of each and the median of the ratios of neighbours.
"""

from __future__ import annotations

import json
import platform
import statistics
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

HERE = Path(__file__).parent


class Worker:
    """A renderer with one scene in a long-lived process; see `worker`.

    Parameters
    ----------
    renderer : str
        ``alight`` or ``mitsuba``.
    scene : str
        A name of `scenes.NAMES`, or the path of a Mitsuba file.
    options : sequence of str
        Further arguments of the worker's command line.
    """

    def __init__(self, renderer: str, scene: str, options: Sequence[str] = ()) -> None:
        command = [sys.executable, str(HERE / "worker.py"), renderer, scene, *options]
        self.name = renderer
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def render(
        self, spp: int, seed: int, threads: int = 2, save: Path | None = None
    ) -> dict[str, Any]:
        """Render once and return the worker's answer.

        Raises
        ------
        RuntimeError
            If the worker has died (its message is on stderr).
        """
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        command = {"spp": spp, "seed": seed, "threads": threads}
        if save is not None:
            command["save"] = str(save)
        try:
            self._process.stdin.write(json.dumps(command) + "\n")
            self._process.stdin.flush()
            answer = self._process.stdout.readline()
        except BrokenPipeError:
            answer = ""
        if not answer:
            raise RuntimeError(f"{self.name} stopped with code {self._process.wait()}")
        return json.loads(answer)

    def __enter__(self) -> Self:
        """Return the worker itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End the process."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()


def alternate(actions: Mapping[str, Callable[[int], float]], repeats: int) -> dict[str, Any]:
    """Run all actions in turn, `repeats` times, after one warm-up each.

    Parameters
    ----------
    actions : mapping of str to callable
        Each takes the number of the round (0 is the warm-up) and returns a figure.
    repeats : int
        Rounds that count.

    Returns
    -------
    dict of str to list of float
        The figures of each action, warm-up left out.
    """
    figures: dict[str, list[float]] = {name: [] for name in actions}
    for number in range(repeats + 1):
        for name, action in actions.items():
            figure = action(number)
            if number > 0:
                figures[name].append(figure)
    return figures


def median_ratio(numerators: Sequence[float], denominators: Sequence[float]) -> float:
    """Median of the ratios within each round."""
    return statistics.median(a / b for a, b in zip(numerators, denominators, strict=True))


def print_json(**line: Any) -> None:
    """Print one result as a line of JSON, floats to four digits."""
    rounded = {k: float(f"{v:.4g}") if isinstance(v, float) else v for k, v in line.items()}
    print(json.dumps(rounded), flush=True)


def print_table(rows: Sequence[Mapping[str, Any]]) -> None:
    """Print results as a Markdown table whose columns are the keys of the first row."""
    if not rows:
        return
    columns = list(rows[0])
    print("\n| " + " | ".join(columns) + " |")
    print("|" + "---|" * len(columns))
    for row in rows:
        cells = (f"{v:.4g}" if isinstance(v, float) else str(v) for v in row.values())
        print("| " + " | ".join(cells) + " |")
    print(f"\n{machine()}", flush=True)


def machine() -> str:
    """Name the processor, for the foot of a table."""
    model = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        names = [line for line in info.read_text().splitlines() if line.startswith("model name")]
        model = names[0].split(":")[1].strip() if names else model
        model += f", {len(names)} logical processors"
    return f"{model}; Python {platform.python_version()}"
