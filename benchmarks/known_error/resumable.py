"""Campaigns over random scenes whose rows are saved as they come: stopped, continued and shown."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from alight.core.errors import AlightError

Row = dict[str, Any]


def numbers(text: str) -> range:
    """Seeds as ``7``, ``0-99``, or ``1-99:2`` for every second one; both ends included."""
    ends, _, step = text.partition(":")
    first, _, last = ends.partition("-")
    return range(int(first), int(last or first) + 1, int(step or 1))


def parser_of(description: str | None, kinds: Iterable[str]) -> argparse.ArgumentParser:
    """The options that all campaigns have."""
    parser = argparse.ArgumentParser(description=(description or "").splitlines()[0])
    parser.add_argument("--seeds", type=numbers, default=numbers("0-1"))
    parser.add_argument("--kinds", default=",".join(kinds))
    parser.add_argument("--sides", default="32,48,64")
    parser.add_argument("--save", type=Path)
    parser.add_argument("--show", type=Path)
    return parser


def run(
    options: argparse.Namespace,
    measure: Callable[[int, str, int], Row],
    said: Callable[[Row], str],
    show: Callable[[Iterable[Row]], None],
) -> None:
    """Measure what is not saved yet, and show all of it.

    Parameters
    ----------
    options : Namespace
        Of `parser_of`.
    measure : callable
        Given seed, kind and side in pixels, a row with at least ``seed`` and ``kind``.
    said : callable
        A line about a row.
    show : callable
        Prints the tables.
    """
    if options.show:
        show(_rows(options.show))
        return
    done = _rows(options.save) if options.save and options.save.exists() else []
    known = {(row["seed"], row["kind"]) for row in done}
    sides, kinds = [int(side) for side in options.sides.split(",")], options.kinds.split(",")
    for seed in options.seeds:
        for number, kind in enumerate(kinds):
            if (seed, kind) in known:
                continue
            side = sides[(seed // 2 + number) % len(sides)]
            try:
                # As written and read again: keys that are numbers become text.
                row = json.loads(json.dumps(measure(seed, kind, side)))
            except AlightError as error:
                print(f"{seed} {kind}: refused: {error}", flush=True)
                continue
            done.append(row)
            print(f"{seed} {kind} {side}x{side}: {said(row)}", flush=True)
            if options.save:
                with options.save.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(row) + "\n")
    show(done)


def _rows(path: Path) -> list[Row]:
    return [json.loads(line) for line in path.read_text("utf-8").splitlines()]
