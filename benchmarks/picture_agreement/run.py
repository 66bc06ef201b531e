"""Level and power of `alight compare`, on pairs of the pictures that films.py rendered.

python benchmarks/picture_agreement/run.py FOLDER ... [--pairs 39] [--seed 1]

True pairs are two pictures of one scene with different seeds; changed pairs have 2 % more light on
one side (its picture and errors times 1.02) or albedos that are 1 % lower (rendered). The z-score
of a change is that of the means of the whole picture, in the channel where it is largest: their
true difference over its true standard error, both from all pictures of the scene.
"""

from __future__ import annotations

import argparse
import collections
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from alight.metrics import Agreement, Measured, compare_measured

sys.path.append(str(Path(__file__).parents[1]))
from harness import print_table

#: Samples of the two pictures of a pair; 0 means the reference.
KINDS = (
    (4, 4), (16, 16), (64, 64), (4, 16), (4, 64), (16, 64), (4, 1024), (16, 1024), (64, 1024),
    (4, 0), (16, 0), (64, 0), (1024, 0),
)  # fmt: skip

LIGHT = 1.02


class Pair(NamedTuple):
    """Two pictures, the kind of the pair, and the z-score of the change between them."""

    kind: tuple[int, int]
    a: Measured
    b: Measured
    z: float


class Films:
    """All pictures of one scene."""

    def __init__(self, path: Path) -> None:
        with np.load(path) as stored:
            self.arrays = {name: stored[name] for name in stored.files}
        self.replicates = int(path.stem.rpartition("-")[2])
        self.reference = int(self.arrays["reference"])

    def count(self, spp: int, twin: str = "") -> int:
        """Pictures with the given number of samples."""
        return len(self.arrays.get(f"{twin}mean-{spp}", ()))

    def picture(self, spp: int, number: int, twin: str = "", light: float = 1.0) -> Measured:
        """One of them, with `light` times the light."""
        mean, error = (self.arrays[f"{twin}{key}-{spp}"][number] for key in ("mean", "error"))
        factor = np.float32(light)
        return Measured(factor * mean, factor * error, self.replicates, float(spp))

    def mean(self, twin: str = "") -> np.ndarray:
        """Channel means over all pictures, by their samples."""
        total, weight = np.zeros(3), 0.0
        for name, pictures in self.arrays.items():
            if name.startswith(f"{twin}mean-"):
                spp = int(name.rpartition("-")[2])
                total += spp * pictures.astype(np.float64).mean(axis=(1, 2)).sum(axis=0)
                weight += spp * len(pictures)
        return total / weight

    def variance(self, spp: int, twin: str = "") -> np.ndarray:
        """Of the channel means of one picture."""
        squares = self.arrays[f"{twin}error-{spp}"].astype(np.float64) ** 2
        return squares.sum(axis=(1, 2)).mean(axis=0) / (squares.shape[1] * squares.shape[2]) ** 2


def pairs(films: Films, change: str, count: int, rng: np.random.Generator) -> Iterator[Pair]:
    """Pairs of all kinds that the scene has pictures for."""
    twin = "dark-" if change == "albedo" else ""
    light = LIGHT if change == "light" else 1.0
    for k in range(count):
        kind = KINDS[k % len(KINDS)]
        few, many = (spp or films.reference for spp in kind)
        if not films.count(few, twin) or not films.count(many):
            continue
        i, j = int(rng.integers(films.count(few, twin))), int(rng.integers(films.count(many)))
        if few == many and not twin:
            if films.count(many) < 2:
                continue
            j = (i + 1 + int(rng.integers(films.count(many) - 1))) % films.count(many)
        difference = np.abs(light * films.mean(twin) - films.mean())
        variance = light**2 * films.variance(few, twin) + films.variance(many)
        with np.errstate(divide="ignore", invalid="ignore"):
            z = float(np.nanmax(difference / np.sqrt(variance))) if change else 0.0
        sides = films.picture(few, i, twin, light), films.picture(many, j)
        a, b = sides if rng.random() < 0.5 else sides[::-1]
        yield Pair(kind, a, b, z)


def verdict(pair: Pair) -> Agreement | None:
    """What is said; None where nothing varies."""
    try:
        return compare_measured(pair.a, pair.b)
    except ValueError:
        return None


def main() -> None:
    """Print a table of true pairs by kind, and of changed ones."""
    parser = argparse.ArgumentParser(description="Level and power of the agreement of pictures.")
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--pairs", type=int, default=39, help="of each scene and change")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    paths = sorted(path for folder in options.folders for path in folder.glob("*.npz"))
    level: dict[str, collections.Counter[str]] = collections.defaultdict(collections.Counter)
    power: dict[str, collections.Counter[str]] = collections.defaultdict(collections.Counter)
    for number, path in enumerate(paths):
        films = Films(path)
        for change in ("", "light", "albedo"):
            rng = np.random.default_rng([options.seed, number])
            for pair in pairs(films, change, options.pairs, rng):
                found = verdict(pair)
                differs = found is not None and not found.passed
                unsure = found is not None and bool(found.doubts)
                if change:
                    at = "z >= 5" if pair.z >= 5.0 else "z 3 to 5" if pair.z >= 3.0 else "z < 3"
                    row = power[f"{change}, {at}"]
                else:
                    few, many = pair.kind
                    row = level[f"{few} against {many or 'reference'}"]
                    if differs:
                        print(f"{path.stem} {pair.kind}: {found and found.reasons}", flush=True)
                row["pairs"] += 1
                row["different"] += differs
                row["cannot tell"] += unsure
    print(f"{len(paths)} files of pictures")
    for title, counts in (("spp", level), ("change", power)):
        if title == "spp":
            counts["all"] = sum(counts.values(), collections.Counter())
        rows = [{title: name, **{k: row[k] for k in ("pairs", "different", "cannot tell")}}
                for name, row in counts.items()]  # fmt: skip
        print_table(rows)


if __name__ == "__main__":
    main()
