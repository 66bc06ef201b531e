"""A turntable of half a million triangles: seconds a frame of alight and of a loop with Mitsuba.

    python benchmarks/turntable_vs_mitsuba.py [--frames 120] [--size 320x240] [--spp 16]

Both keep the scene and write a PNG of each frame; the frames are divided among rounds, each a
whole turn, in which the two alternate. alight is `alight.animate`; the loop sets `to_world` of
Mitsuba's sensor and calls `mi.render`. Both: a height field of 500 000 triangles, matte, in a sky
of one colour and a lamp, path integrator, depth 8, roulette from depth 5, box filter; Mitsuba with
its independent sampler. Needs ``make peers`` and a libLLVM for Mitsuba. Run it on a quiet machine,
or with ``--cpu``, which counts processor time: what a frame costs if no thread is ever idle.
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from harness import median_ratio, print_json, print_table

#: Vertices along a side: 2 (side - 1)^2 triangles.
SIDE = 501
TARGET, RADIUS, HEIGHT = (0.0, 0.0, 0.0), 3.2, 1.6


def mesh() -> tuple[np.ndarray, np.ndarray]:
    """Hills on a square of side 2."""
    x, z = np.meshgrid(np.linspace(-1, 1, SIDE), np.linspace(-1, 1, SIDE))
    y = 0.15 * np.sin(9.0 * x) * np.cos(7.0 * z) + 0.01 * np.sin(90.0 * x) * np.sin(80.0 * z)
    numbers = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    a, b, c, d = (
        part.ravel()
        for part in (numbers[:-1, :-1], numbers[1:, :-1], numbers[1:, 1:], numbers[:-1, 1:])
    )
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return np.stack([x, y, z], -1).reshape(-1, 3).astype(np.float32), faces.astype(np.uint32)


def origin(share: float) -> tuple[float, float, float]:
    """Where the camera stands after a share of the turn."""
    angle = 2.0 * math.pi * share
    return RADIUS * math.sin(angle), HEIGHT, RADIUS * math.cos(angle)


class Ours:
    """`alight.animate`, whose scene is kept from frame to frame."""

    def __init__(self, folder: Path, options: argparse.Namespace) -> None:
        import alight

        vertices, faces = mesh()
        lamp = {"look_at": {"origin": [-2, 4, 2], "target": [-4, 8, 4]}}
        self.scene = alight.load({
            "alight": 1,
            "camera": {"type": "pinhole", "fov": 35, "transform": {
                "look_at": {"origin": list(origin(0.0)), "target": list(TARGET)}}},
            "film": {"size": list(options.size)},
            "integrator": {"type": "path", "max_depth": 8, "rr_depth": 5},
            "environment": {"type": "constant", "radiance": 0.4},
            "nodes": {
                "hills": {"shape": {"type": "mesh", "vertices": vertices, "faces": faces},
                          "bsdf": {"type": "diffuse", "reflectance": [0.6, 0.5, 0.4]}},
                "lamp": {"shape": "rectangle", "light": {"type": "area", "radiance": 12.0},
                         "bsdf": {"type": "diffuse", "reflectance": 0}, "transform": lamp},
            },
        })  # fmt: skip
        self.folder, self.options = folder, options

    def render(self, turn: int, count: int) -> None:
        """A turn of so many frames."""
        import alight

        alight.animate(
            self.scene, frames=(0, count), turntable=True, spp=self.options.spp,
            threads=self.options.threads, output=self.folder / f"ours_{turn}_####.png",
        )  # fmt: skip


class Theirs:
    """The loop that a user of Mitsuba writes."""

    def __init__(self, folder: Path, options: argparse.Namespace) -> None:
        import drjit
        import mitsuba as mi

        mi.set_variant(options.variant)
        drjit.set_thread_count(options.threads)
        self.mi, self.folder, self.options = mi, folder, options
        vertices, faces = mesh()
        material = mi.load_dict(
            {"type": "twosided", "b": {"type": "diffuse",
             "reflectance": {"type": "rgb", "value": [0.6, 0.5, 0.4]}}}
        )  # fmt: skip
        kept = mi.Properties()
        kept["bsdf"] = material
        hills = mi.Mesh("hills", len(vertices), len(faces), props=kept)
        values = mi.traverse(hills)
        values["vertex_positions"], values["faces"] = vertices.ravel(), faces.ravel()
        values.update()
        place = mi.ScalarTransform4f().look_at(origin=[-2, 4, 2], target=[-4, 8, 4], up=[0, 1, 0])
        width, height = options.size
        self.scene = mi.load_dict({
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 8, "rr_depth": 5},
            "sensor": {
                "type": "perspective", "fov": 35, "fov_axis": "y", "to_world": self._placed(0.0),
                "film": {"type": "hdrfilm", "width": width, "height": height,
                         "pixel_format": "rgb", "rfilter": {"type": "box"}},
                "sampler": {"type": "independent", "sample_count": options.spp},
            },
            "sky": {"type": "constant", "radiance": {"type": "rgb", "value": 0.4}},
            "hills": hills,
            "lamp": {"type": "rectangle", "to_world": place,
                     "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 12.0}}},
        })  # fmt: skip
        self.values = mi.traverse(self.scene)

    def _placed(self, share: float) -> Any:
        at = list(origin(share))
        return self.mi.ScalarTransform4f().look_at(origin=at, target=list(TARGET), up=[0, 1, 0])

    def render(self, turn: int, count: int) -> None:
        """A turn of so many frames."""
        for number in range(count):
            self.values["sensor.to_world"] = self._placed(number / count)
            self.values.update()
            image = self.mi.render(self.scene, spp=self.options.spp, seed=number)
            path = self.folder / f"theirs_{turn}_{number:04}.png"
            self.mi.util.write_bitmap(str(path), image, write_async=False)


def serve(options: argparse.Namespace) -> None:
    """Render the turns that come on stdin; the seconds of each are the answer."""
    kind = Ours if options.serve == "alight" else Theirs
    clock = time.process_time if options.cpu else time.perf_counter
    with TemporaryDirectory() as folder:
        made = kind(Path(options.keep or folder), options)
        for line in sys.stdin:
            turn, count = json.loads(line)
            start = clock()
            made.render(turn, count)
            sys.stdout.write(f"{clock() - start}\n")
            sys.stdout.flush()


def seconds(process: subprocess.Popen[str], turn: int, count: int) -> float:
    """How long a process takes for a turn."""
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write(f"{json.dumps([turn, count])}\n")
    process.stdin.flush()
    return float(process.stdout.readline())


def main() -> None:
    """Measure, and print a table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--frames", type=int, default=120, help="of all turns")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--size", default="320x240")
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--variant", default="llvm_ad_rgb", help="of Mitsuba")
    parser.add_argument("--cpu", action="store_true", help="processor time, of all threads")
    parser.add_argument("--keep", help="folder for the frames, to look at them")
    parser.add_argument("--serve", choices=["alight", "mitsuba"], help=argparse.SUPPRESS)
    options = parser.parse_args()
    options.size = tuple(int(side) for side in options.size.split("x"))
    if options.serve:
        serve(options)
        return
    names = ("alight", "mitsuba")
    words = [sys.executable, *sys.argv, "--serve"]
    processes = {
        name: subprocess.Popen(
            [*words, name], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        for name in names
    }
    step = max(1, options.frames // options.rounds)
    found: dict[str, list[float]] = {name: [] for name in names}
    for name in names:
        # Compiles, and builds the tree: once in an animation, and not of its frames.
        seconds(processes[name], 0, 1)
    for number in range(options.rounds):
        for name in names:
            taken = seconds(processes[name], number + 1, step)
            found[name].append(taken / step)
    for process in processes.values():
        assert process.stdin is not None
        process.stdin.close()
        process.wait()
    rows: list[dict[str, Any]] = [
        {"what": f"{name}, a frame", "value": 1000.0 * float(np.median(found[name])), "unit": "ms"}
        for name in names
    ]
    ratio = median_ratio(found["mitsuba"], found["alight"])
    rows.append({"what": "alight over Mitsuba's loop", "value": ratio, "unit": ""})
    for row in rows:
        print_json(**row)
    print_table(rows)


if __name__ == "__main__":
    main()
