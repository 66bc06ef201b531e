"""What waits between an edit and the first ray: another camera, and one moved instance.

    python benchmarks/edits.py [--instances 200] [--subdivisions 6] [--repeats 30] [--cpu]

A scene of many instances of a mesh is rendered once; then the camera, or one instance, is moved in
a scene made from it, again and again. Reported are the medians of the time from the call of the
renderer to its first ray and, within that of the moved instance, of the time in which the tree over
the instances is built; the tree of the mesh, which is kept, is timed for comparison. --cpu counts
processor time, for a machine that does other work too. Needs no peers.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import time
from typing import Any

import meshes
import numpy as np
from harness import print_json, print_table

import alight
from alight.accel.build import build_bvh
from alight.compiled import scene as compiled_scene
from alight.options.render import RenderOptions
from alight.rendering.main_loop import render_film

#: Seconds.
clock = time.process_time if "--cpu" in sys.argv else time.perf_counter


class FirstRayError(Exception):
    """Ends a render whose kernels are ready."""


def seconds_to_first_ray(scene: alight.Scene, threads: int) -> float:
    """From the call to the first ray."""
    start = clock()

    def tell(progress: Any) -> None:
        if progress.phase == "render":
            raise FirstRayError

    try:
        render_film(scene, RenderOptions(spp=1, threads=threads, progress=tell))
    except FirstRayError:
        return clock() - start
    raise RuntimeError("the renderer has told nothing")


def scene_of(instances: int, subdivisions: int) -> alight.Scene:
    """Balls of waves on a grid."""
    vertices, faces = meshes.displaced_icosphere(subdivisions)
    side = int(np.ceil(np.sqrt(instances)))
    nodes = {
        f"ball-{n}": {"instance": "ball", "transform": {
            "translate": [2.5 * (n % side), 0.0, -2.5 * (n // side)]}}
        for n in range(instances)
    }  # fmt: skip
    return alight.load({
        "alight": 1,
        "camera": {"type": "pinhole", "fov": 45, "transform": {
            "look_at": {"origin": [side, 6.0, 8.0], "target": [side, 0.0, -side]}}},
        "film": {"size": [320, 240]},
        "environment": {"type": "constant", "radiance": 1.0},
        "prototypes": {"ball": {"shape": {"type": "mesh", "vertices": vertices, "faces": faces}}},
        "nodes": nodes,
    })  # fmt: skip


def main() -> None:
    """Measure, and print a table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--instances", type=int, default=200)
    parser.add_argument("--subdivisions", type=int, default=6, help="of the icosphere")
    parser.add_argument("--repeats", type=int, default=30)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--cpu", action="store_true", help="processor time")
    options = parser.parse_args()
    scene = scene_of(options.instances, options.subdivisions)
    fresh = seconds_to_first_ray(scene, options.threads)
    found: dict[str, list[float]] = {"camera": [], "instance": [], "as it was": []}
    trees = timed_trees()
    for number in range(options.repeats):
        for what, change in (
            ("camera", {"camera.fov": 40.0 + 0.1 * number}),
            ("instance", {"nodes.ball-0.transform.translate": [0.0, 0.01 * (number + 1), 0.0]}),
        ):
            changed = alight.changed(scene, change)
            found[what].append(seconds_to_first_ray(changed, options.threads))
            # The next edit begins at the same scene.
            found["as it was"].append(seconds_to_first_ray(scene, options.threads))
    rows = [
        {"what": "camera alone to first ray", "value": median(found["camera"]), "unit": "ms"},
        {"what": "moved instance to first ray", "value": median(found["instance"]), "unit": "ms"},
        {"what": "of that, the tree over the instances", "value": median(trees), "unit": "ms"},
        {"what": "the tree of the mesh, which is kept",
         "value": 1000.0 * seconds_of_mesh(options.subdivisions, options.threads), "unit": "ms"},
        {"what": "the scene at first, compiled or read", "value": 1000.0 * fresh, "unit": "ms"},
    ]  # fmt: skip
    for row in rows:
        print_json(**row)
    print_table(rows)


def timed_trees() -> list[float]:
    """Note from now on how long trees over everything take."""
    seconds: list[float] = []
    build = compiled_scene.build_accelerator

    def timed(*words: Any, **named: Any) -> Any:
        start = clock()
        try:
            return build(*words, **named)
        finally:
            seconds.append(clock() - start)

    compiled_scene.build_accelerator = timed
    return seconds


def seconds_of_mesh(subdivisions: int, threads: int) -> float:
    """What the tree of the mesh takes."""
    vertices, faces = meshes.displaced_icosphere(subdivisions)
    start = clock()
    build_bvh(vertices, faces, threads=threads)
    return clock() - start


def median(seconds: list[float]) -> float:
    """In milliseconds."""
    return 1000.0 * statistics.median(seconds)


if __name__ == "__main__":
    main()
