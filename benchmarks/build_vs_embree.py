"""Time to build the tree over 1.3 M triangles: alight on 2 threads and on 1, Embree's default.

    python benchmarks/build_vs_embree.py [--subdivisions 8] [--threads 2]

Embree's time is that of committing geometry and scene at medium quality, its default. Both start
from arrays of vertices and faces in memory. Needs ``make peers``.
"""

import argparse
import statistics
import time

import alight_rays
import meshes
from embree import EmbreeScene
from harness import alternate, median_ratio, print_json, print_table


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="BVH build against Embree.")
    parser.add_argument("--subdivisions", type=int, default=8, help="of the icosphere")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--repeats", type=int, default=5)
    arguments = parser.parse_args()
    vertices, faces = meshes.displaced_icosphere(arguments.subdivisions)

    def alight(threads: int) -> float:
        start = time.perf_counter()
        alight_rays.build(vertices, faces, threads)
        return time.perf_counter() - start

    def embree() -> float:
        scene = EmbreeScene(vertices, faces, arguments.threads, robust=False)
        scene.close()
        return scene.build_seconds

    figures = alternate(
        {
            "many": lambda _: alight(arguments.threads),
            "embree": lambda _: embree(),
            "one": lambda _: alight(1),
        },
        arguments.repeats,
    )
    row = {
        "triangles": len(faces),
        "threads": arguments.threads,
        "alight s": statistics.median(figures["many"]),
        "alight, 1 thread s": statistics.median(figures["one"]),
        "Embree s": statistics.median(figures["embree"]),
        "time over Embree's": median_ratio(figures["many"], figures["embree"]),
        "speed-up over 1 thread": median_ratio(figures["one"], figures["many"]),
    }
    print_json(benchmark="build", **row)
    print_table([row])


if __name__ == "__main__":
    main()
