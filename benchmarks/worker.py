"""A renderer in a process of its own: commands as JSON lines on stdin, answers on stdout.

    {"spp": 64, "seed": 1, "threads": 2, "save": "picture.npy"}     (save is optional)
 -> {"seconds": 3.51, "compile": 0.0, "samples": 16777216, "cpu_seconds": 7.02,
     "peak_rss_mb": 160.1}

`seconds` is from the call to the finished picture in a NumPy array, without what a renderer does
once a scene (loading, tree, compiling): Mitsuba does that when it loads, alight reports it apart.
`cpu_seconds` is the processor time of the whole call, of all threads.
"""

import argparse
import json
import os
import resource
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import files
import numpy as np
import scenes

Render = Callable[[int, int, int], tuple[np.ndarray, dict[str, Any]]]


def alight_renderer(arguments: argparse.Namespace) -> Render:
    """Load the scene in alight."""
    import alight

    if arguments.scene in scenes.NAMES:
        scene = scenes.alight_scene(
            arguments.scene, arguments.size, arguments.sampler, arguments.subdivisions
        )
    else:
        scene = files.alight_file(Path(arguments.scene), arguments.size, arguments.sampler)

    def render(spp: int, seed: int, threads: int) -> tuple[np.ndarray, dict[str, Any]]:
        start = time.perf_counter()
        film = alight.render(scene, spp=spp, seed=seed, threads=threads)
        image = film.image
        seconds = time.perf_counter() - start
        phases = film.stats["seconds"]
        # What is kept from the render before takes no time.
        once = {name: phases.get(name, 0.0) for name in ("load", "bvh", "compile")}
        return image, {"seconds": seconds - sum(once.values()), **once}

    return render


def mitsuba_renderer(arguments: argparse.Namespace) -> Render:
    """Load the scene in Mitsuba."""
    import drjit
    import mitsuba

    mitsuba.set_variant(arguments.variant)
    if arguments.scene in scenes.NAMES:
        scene = scenes.mitsuba_scene(
            mitsuba, arguments.scene, arguments.size, arguments.sampler, arguments.subdivisions
        )
    else:
        scene = files.mitsuba_file(
            mitsuba, Path(arguments.scene), arguments.size, arguments.sampler
        )

    def render(spp: int, seed: int, threads: int) -> tuple[np.ndarray, dict[str, Any]]:
        drjit.set_thread_count(threads)
        start = time.perf_counter()
        # The conversion waits for the kernels.
        image = np.array(mitsuba.render(scene, spp=spp, seed=seed))[..., :3]
        return image, {"seconds": time.perf_counter() - start}

    return render


RENDERERS = {"alight": alight_renderer, "mitsuba": mitsuba_renderer}


def main() -> None:
    """Answer commands until stdin ends."""
    parser = argparse.ArgumentParser()
    parser.add_argument("renderer", choices=RENDERERS)
    parser.add_argument("scene", help="one of scenes.NAMES, or a Mitsuba file")
    parser.add_argument("--size", type=int, default=512, help="rows of the picture")
    parser.add_argument("--sampler")
    parser.add_argument("--variant", default="llvm_ad_rgb")
    parser.add_argument("--subdivisions", type=int, default=8)
    arguments = parser.parse_args()

    # What the renderers print must not mix with the answers.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    render = RENDERERS[arguments.renderer](arguments)
    for line in sys.stdin:
        command = json.loads(line)
        start = time.process_time()
        image, answer = render(command["spp"], command["seed"], command["threads"])
        answer["cpu_seconds"] = time.process_time() - start
        if command.get("save"):
            np.save(command["save"], image)
        answer["samples"] = image.shape[0] * image.shape[1] * command["spp"]
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print(json.dumps({**answer, "peak_rss_mb": round(peak, 1)}), file=answers, flush=True)


if __name__ == "__main__":
    main()
