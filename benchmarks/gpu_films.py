"""Does a GPU render the processor's pictures, and how fast? To be run where there is a GPU.

    python benchmarks/gpu_films.py [--size 96x72] [--spp 256] [--processes 16] [SCENE ...]

For each built-in scene: two renders with other passes give the same bits; a film of another seed
agrees with the processor's by the test of `alight.compare`; the part of pixels that 4 samples of
the same seed give within 0.1 %; and the speed of the kernel. Kernels are compiled first, by so many
processes.
Exit code 1 if a scene disagrees or gives other bits, or none renders; refused ones are listed. With
``--speed``: millions of samples per second at 512x512 instead, on the GPU and on two threads.
"""

import argparse
import subprocess
import sys
from typing import Any

import numpy as np
from harness import print_table

import alight
from alight.core.errors import AlightError
from alight.formats.scene_text import builtin_names

WORDS = {"replicates": 4, "threads": 4}


def compile_kernels(scene: str) -> None:
    """Compile both kernels of a scene, and render next to nothing."""
    try:
        alight.render(scene, size=(8, 8), spp=1, device="gpu", **WORDS)
    except AlightError as error:
        print(f"{scene}: {error}", file=sys.stderr)


def row_of(scene: str, size: tuple[int, int], spp: int) -> dict[str, Any]:
    """What is found about a scene."""

    def render(**given: Any) -> alight.Film:
        return alight.render(scene, **{"size": size, "spp": spp, **WORDS, **given})

    first = render(seed=1, device="gpu")
    again = render(seed=1, device="gpu", spp_per_pass=37)
    test = alight.compare(first, render(seed=2)).found[0].agreement
    few, ours = (render(seed=1, spp=4, device=device).mean for device in ("gpu", "cpu"))
    near = np.isclose(few, ours, rtol=1e-3, atol=1e-6).all(axis=2).mean()
    rate = first.stats["samples"] / first.stats["gpu"]["seconds"] / 1e6
    return {
        "scene": scene, "agrees": test.passed, "same bits": np.array_equal(first.sums, again.sums),
        "rms z": max(test.rms), "largest z": test.largest, "same pixels": float(near),
        "Msamples/s": rate, "why not": "; ".join(test.reasons),
    }  # fmt: skip


def print_speed(scene: str) -> None:
    """Millions of samples per second of the whole render; kernels are compiled already."""
    for name, words in (
        ("GPU, 64 spp", {"spp": 64, "device": "gpu"}),
        ("GPU, 1024 spp", {"spp": 1024, "device": "gpu"}),
        ("two threads", {"spp": 16, "threads": 2}),
    ):
        stats = alight.render(scene, size=(512, 512), replicates=4, **words).stats
        print(f"{scene}, {name}: {stats['msamples_per_s']:.2f} Msamples/s, {stats.get('gpu', '')}")


def main() -> int:
    """Try the scenes that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="*")
    parser.add_argument("--size", default="96x72")
    parser.add_argument("--spp", type=int, default=256)
    parser.add_argument("--processes", type=int, default=16)
    parser.add_argument("--speed", action="store_true")
    parser.add_argument("--compile", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    scenes = given.scenes or list(builtin_names())
    if given.compile:
        for scene in scenes:
            compile_kernels(scene)
        return 0
    for i in range(0, len(scenes), given.processes):
        group = [
            subprocess.Popen([sys.executable, __file__, "--compile", scene])
            for scene in scenes[i : i + given.processes]
        ]
        for process in group:
            process.wait()
    if given.speed:
        for scene in scenes:
            print_speed(scene)
        return 0
    width, height = map(int, given.size.split("x"))
    rows = []
    for scene in scenes:
        try:
            rows.append(row_of(scene, (width, height), given.spp))
        except AlightError as error:
            print(f"{scene}: {error}", file=sys.stderr)
    print_table(rows)
    return int(not rows or not all(row["agrees"] and row["same bits"] for row in rows))


if __name__ == "__main__":
    sys.exit(main())
