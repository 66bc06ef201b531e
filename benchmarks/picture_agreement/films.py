"""Renders the pictures of the campaign, many seeds of each, once; pairs are formed from files.

python benchmarks/picture_agreement/films.py FOLDER [SCENE ...] [--first 0] [--kinds 2]

One file of pictures a scene, sampler and number of replicates: means and standard errors of all
pictures, and those of a twin whose albedos are 1 % lower. Files that exist are left as they are.
"""

from __future__ import annotations

import argparse
import time
import zlib
from pathlib import Path

import numpy as np
from scenes import SAMPLERS, load_scene, names

from alight.rendering import render
from alight.scene import Scene

#: Pictures of each number of samples, and of the twin; the last means a reference.
SPP = {4: 12, 16: 12, 64: 8, 1024: 3}
REFERENCES, MOST = 2, 1 << 12
SIZES = ((32, 32), (48, 32), (40, 28), (64, 64))
REPLICATES = (4, 4, 4, 2, 8, 16)


def pictures(scene: Scene, spp: int, count: int, seed: int) -> dict[str, np.ndarray]:
    """Means, shape (count, h, w, 3), and their standard errors."""
    films = [render(scene, spp=spp, seed=seed + i, threads=1) for i in range(count)]
    return {
        "mean": np.stack([film.image for film in films]),
        "error": np.stack([film.standard_error for film in films]),
    }


def seconds(scene: Scene, seed: int, levels: dict[int, int]) -> float:
    """Processor time that the pictures and those of the twin will take, about."""
    spp = max(min(levels), 4)
    render(scene, spp=spp, seed=seed, threads=1)
    start = time.process_time()
    render(scene, spp=64, seed=seed + 1, threads=1)
    each = (time.process_time() - start) / 64
    return each * (2 * sum(s * n for s, n in levels.items()) + REFERENCES * 1024)


def reference_spp(scene: Scene, seed: int) -> int:
    """Samples for a relRMSE of 1 %, as `alight reference` would find them, within reason."""
    found = render(scene, spp=256, seed=seed, threads=1).relmse_estimate(literature=False).relrmse
    if not found.value > 0.0:
        return 1024
    return int(min(max(256 * (found.value / 0.01) ** 2, 64), MOST)) // 16 * 16


def main() -> None:
    """Render what is missing."""
    parser = argparse.ArgumentParser(description="Pictures for the campaign on agreement.")
    parser.add_argument("folder", type=Path)
    parser.add_argument("scenes", nargs="*", help="names or files; by default those of scenes.py")
    parser.add_argument("--first", type=int, default=0, help="number of the first of each kind")
    parser.add_argument("--kinds", type=int, default=2, help="how many of each kind")
    parser.add_argument("--seconds", type=float, default=60.0, help="processor time of a scene")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    for name in options.scenes or names(options.first, options.kinds):
        rng = np.random.default_rng([options.seed, zlib.crc32(name.encode())])
        sampler, size = str(rng.choice(SAMPLERS)), SIZES[int(rng.integers(len(SIZES)))]
        replicates = int(rng.choice(REPLICATES))
        stem = f"{Path(name).stem.replace(':', '-')}-{sampler}-{replicates}"
        path = options.folder / f"{stem}.npz"
        if path.exists():
            continue
        start = time.perf_counter()
        seed = int(rng.integers(1 << 30))
        arrays: dict[str, np.ndarray] = {}
        try:
            for twin, darker in (("", 1.0), ("dark-", 0.99)):
                scene = load_scene(name, size, sampler, replicates, darker)
                levels = {s: n for s, n in SPP.items() if s >= replicates}
                if not twin:
                    if (cost := seconds(scene, seed, levels)) > options.seconds:
                        raise ValueError(f"would take {cost:.0f} s")
                    spp = reference_spp(scene, seed + 999)
                    levels[spp] = max(levels.get(spp, 0), REFERENCES)
                    arrays["reference"] = np.array(spp)
                for i, (spp, count) in enumerate(levels.items()):
                    first = seed + 1000 * i + (100_000 if twin else 0)
                    found = pictures(scene, spp, count, first)
                    arrays |= {f"{twin}{key}-{spp}": value for key, value in found.items()}
        except Exception as problem:
            print(f"{name}: {type(problem).__name__}: {problem}", flush=True)
            continue
        np.savez(path, **arrays)
        mean = float(arrays["mean-64"].mean())
        print(
            f"{path.stem}: reference {arrays['reference']} spp, mean {mean:.4g}, "
            f"{time.perf_counter() - start:.1f} s",
            flush=True,
        )


if __name__ == "__main__":
    main()
