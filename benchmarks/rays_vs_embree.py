"""Closest hits one ray after another on one core: alight's tree against Embree's `rtcIntersect1`.

    python benchmarks/rays_vs_embree.py [--meshes terrain torus-knot hairball] [--side 1024]

Embree runs with its robust flag (watertight, as ours always is), in the same process, called from a
compiled loop. The three meshes were used for no tuning. Needs ``make peers``.
"""

import argparse
import statistics
import time
from collections.abc import Callable

import alight_rays
import numpy as np
from embree import EmbreeScene
from harness import alternate, median_ratio, print_json, print_table
from meshes import RAY_MESHES
from rays import Intersect, ray_sets


def rate(intersect: Intersect, origins: np.ndarray, directions: np.ndarray) -> float:
    """Mrays/s of one run."""
    start = time.perf_counter()
    intersect(origins, directions)
    return len(origins) / (time.perf_counter() - start) / 1e6


def timed(intersect: Intersect, rays: tuple[np.ndarray, np.ndarray]) -> Callable[[int], float]:
    """Wrap one run for `alternate`."""
    return lambda _: rate(intersect, *rays)


def disagreement(rays: tuple[np.ndarray, np.ndarray], ours: Intersect, theirs: Intersect) -> float:
    """Find the part of the rays whose hits differ: one misses, or the distance is 0.1 % off."""
    t, triangle = ours(*rays)
    other_t, other_triangle = theirs(*rays)
    hit, other_hit = triangle >= 0, other_triangle >= 0
    both = hit & other_hit
    wrong = int((hit != other_hit).sum())
    wrong += int((np.abs(t[both] - other_t[both]) > 1e-3 * other_t[both]).sum())
    return wrong / len(t)


def measure(name: str, side: int, repeats: int) -> list[dict[str, object]]:
    """Compare on one mesh."""
    vertices, faces = RAY_MESHES[name]()
    theirs = EmbreeScene(vertices, faces)
    ours = alight_rays.intersector(alight_rays.build(vertices, faces, threads=2))
    rows = []
    for kind, rays in ray_sets(vertices, faces, theirs.intersect, side).items():
        figures = alternate(
            {"alight": timed(ours, rays), "embree": timed(theirs.intersect, rays)}, repeats
        )
        rows.append(
            {
                "mesh": name,
                "triangles": len(faces),
                "rays": kind,
                "alight Mrays/s": statistics.median(figures["alight"]),
                "Embree Mrays/s": statistics.median(figures["embree"]),
                "ratio": median_ratio(figures["alight"], figures["embree"]),
                "other hits": disagreement(rays, ours, theirs.intersect),
            }
        )
        print_json(benchmark="rays", **rows[-1])
    theirs.close()
    return rows


def main() -> None:
    """Measure every mesh asked for."""
    parser = argparse.ArgumentParser(description="Closest hits on one core against Embree.")
    parser.add_argument("--meshes", nargs="+", choices=RAY_MESHES, default=list(RAY_MESHES))
    parser.add_argument("--side", type=int, default=1024, help="side * side rays of a set")
    parser.add_argument("--repeats", type=int, default=5)
    arguments = parser.parse_args()
    rows = []
    for name in arguments.meshes:
        rows += measure(name, arguments.side, arguments.repeats)
    print_table(rows)


if __name__ == "__main__":
    main()
