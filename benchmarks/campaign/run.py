"""Random scenes, as many as wanted, against what must hold of every scene, in one command.

python benchmarks/campaign/run.py [--seeds 0-99] [--parts robustness,laws,...] [--kinds room,...]
    [--side 16] [--spp 4] [--edge 0.02] [--save FILE]

``robustness``: the scene is valid, comes back from its text, and is rendered without an exception
or a warning, with every gather inside its table and every sample finite. ``laws``: materials,
lights, random numbers and paths of the scene obey the laws of ``alight check``. ``integrators``:
`path` and `volpath` give one picture where both see all there is. All of these run in the NumPy
twin. ``machine``: machine code gives the twin's picture. ``modes``: light sampling, BSDF sampling
and both together give one picture, with and without roulette (compiles five kernels a scene).

Constants and repairs are tried on even seeds; verdicts are on odd ones, drawn afterwards. Both are
printed. Each problem is a line that begins with the seed and the kind, by which
``alight scene random`` makes the scene again. ``--edge`` is the probability that a parameter is at
an end of its range; that command knows only the usual one.
"""

from __future__ import annotations

import argparse
import collections
import faulthandler
import json
import time
import traceback
import warnings
from pathlib import Path
from typing import Any

from parts import PARTS

from alight.core.errors import AlightError
from alight.lab.random_scenes import KINDS, descriptions, random_scene


def numbers(text: str) -> range:
    """Seeds as ``7`` or ``0-99``, both ends included."""
    first, _, last = text.partition("-")
    return range(int(first), int(last or first) + 1)


def problems(part: str, seed: int, kind: str, side: int, spp: int) -> list[str]:
    """What is wrong with one scene, in words; an exception is one problem."""
    try:
        return PARTS[part](random_scene(seed, kind, (side, side)), seed, spp)
    except AlightError as error:
        return [f"refused: {error}"]
    except Exception as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        name = f"{Path(place.filename).parent.name}/{Path(place.filename).name}:{place.lineno}"
        return [f"{type(error).__name__}: {error} ({name})"]


def show(part: str, results: list[dict[str, Any]]) -> None:
    """Print how many scenes of each half had a problem, and of which kinds they were."""
    for name, parity in (("even seeds (to choose by)", 0), ("odd seeds (the verdict)", 1)):
        own = [r for r in results if r["part"] == part and r["seed"] % 2 == parity]
        bad = collections.Counter(r["kind"] for r in own if r["problems"])
        if own:
            where = ", ".join(f"{kind} {count}" for kind, count in bad.items()) or "none"
            print(f"{part}, {name}: {len(own)} scenes, with problems {sum(bad.values())}: {where}")


def main() -> int:
    """Run what the command line asks for; 1 if anything was wrong."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=numbers, default=numbers("0-9"))
    parser.add_argument("--parts", default="robustness,laws,integrators,machine")
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--side", type=int, default=16)
    parser.add_argument("--spp", type=int, default=4)
    parser.add_argument("--edge", type=float, default=descriptions.EDGE)
    parser.add_argument("--save", type=Path)
    options = parser.parse_args()
    descriptions.EDGE = options.edge
    faulthandler.enable()
    # NumPy's warnings would stand between a user's lines: they are defects, too.
    warnings.simplefilter("error")
    results: list[dict[str, Any]] = []
    parts, kinds = options.parts.split(","), options.kinds.split(",")
    for part in parts:
        begin = time.monotonic()
        for seed in options.seeds:
            for kind in kinds:
                found = problems(part, seed, kind, options.side, options.spp)
                results.append({"part": part, "seed": seed, "kind": kind, "problems": found})
                for text in found:
                    print(f"{seed} {kind}: {part}: {text}", flush=True)
        print(f"{part}: {time.monotonic() - begin:.0f} s", flush=True)
    for part in parts:
        show(part, results)
    if options.save:
        options.save.write_text(json.dumps(results, indent=1))
    return int(any(result["problems"] for result in results))


if __name__ == "__main__":
    raise SystemExit(main())
