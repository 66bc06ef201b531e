"""Ways to choose among many lights: power, the light tree, and what `auto` makes of it.

    python benchmarks/light_choice.py [--scenes clusters ...] [--spp 64] [--seeds 8]

Efficiency is 1 / (relMSE * time) over that of choice by power. The error is the variance of a pixel
over independent seeds (no arm is biased) over mean^2 + (0.1 median)^2 of all arms' mean, averaged
over the picture; the median, as lamps that are seen would drown the rest in a mean. Time is
processor time on one thread, arms taking turns, the least over the seeds; what a call costs that
does not grow with the samples (loading, making trees, kernels from the cache) is measured by calls
of 1 sample, and taken off. Scenes where local lights differ (clusters, lamps, rooms) are what a
tree is for; the others, where far or even lights do not, are to show that it does no harm.
"""

import argparse
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import trimesh
from harness import print_json, print_table
from numpy.typing import NDArray

import alight
from alight import Scene
from alight.formats import loads
from alight.lights.area import Area
from alight.scene.description import Node
from alight.shapes.mesh import Mesh

ARMS = ("power", "tree", "auto")

OPEN = """
alight: 1
camera: {fov: 45, transform: {look_at: {origin: [0, 7, 17], target: [0, 0.5, 0]}}}
film: {size: [128, 96]}
integrator: {type: path, max_depth: DEPTH}
bsdfs: {grey: {type: diffuse, reflectance: 0.5}, black: {type: diffuse, reflectance: 0}}
nodes:
  floor:
    shape: rectangle
    bsdf: grey
    transform: [{scale: 20}, {rotate: {axis: x, angle: -90}}]
  block:
    shape: cube
    bsdf: grey
    transform: [{scale: 0.7}, {rotate: {axis: y, angle: 30}}, {translate: [1, 0.7, 2]}]
"""

#: A room of 6 m, seen from inside.
ROOM = """
alight: 1
camera: {fov: 60, transform: {look_at: {origin: [0, 0.3, 2.8], target: [0, -0.4, -3]}}}
film: {size: [128, 96]}
integrator: {type: path, max_depth: DEPTH}
bsdfs: {white: {type: diffuse, reflectance: 0.7}, black: {type: diffuse, reflectance: 0}}
nodes:
  walls:
    bsdf: white
    children:
      left:
        shape: rectangle
        transform: [{scale: 3}, {rotate: {axis: y, angle: 90}}, {translate: [-3, 0, 0]}]
      right:
        shape: rectangle
        transform: [{scale: 3}, {rotate: {axis: y, angle: -90}}, {translate: [3, 0, 0]}]
      back:
        shape: rectangle
        transform: [{scale: 3}, {rotate: {axis: y, angle: 0}}, {translate: [0, 0, -3]}]
      front:
        shape: rectangle
        transform: [{scale: 3}, {rotate: {axis: y, angle: 180}}, {translate: [0, 0, 3]}]
      ceiling:
        shape: rectangle
        transform: [{scale: 3}, {rotate: {axis: x, angle: 90}}, {translate: [0, 3, 0]}]
      floor:
        shape: rectangle
        transform: [{scale: 3}, {rotate: {axis: x, angle: -90}}, {translate: [0, -3, 0]}]
      block: {shape: cube, transform: [{scale: 0.8}, {translate: [1, -2.2, -1]}]}
"""


def with_lamps(text: str, lamps: Mapping[str, Node], depth: int = 3) -> Scene:
    """Hang lamps in a scene."""
    scene = loads(text.replace("DEPTH", str(depth)))
    return scene.replaced(nodes={**scene.nodes, **lamps})


def lamp(vertices: Any, faces: Any, radiance: float) -> Node:
    """A mesh that shines."""
    mesh = Mesh(vertices=np.asarray(vertices, np.float32), faces=np.asarray(faces, np.int32))
    return Node(shape=mesh, light=Area(radiance=(radiance,) * 3), bsdf="black")


def ball(radius: float, centre: tuple[float, float, float], cuts: int, radiance: float) -> Node:
    """A ball of 20 * 4^cuts triangles that shines."""
    sphere = trimesh.creation.icosphere(subdivisions=cuts, radius=radius)
    return lamp(sphere.vertices + centre, sphere.faces, radiance)


def panel(side: float, height: float, cells: int, radiance: float) -> Node:
    """A square of 2 cells^2 triangles that shines downwards."""
    x, z = np.meshgrid(*(np.linspace(-side / 2, side / 2, cells + 1),) * 2, indexing="ij")
    vertices = np.stack([x, np.full_like(x, height), z], -1).reshape(-1, 3)
    corner = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).reshape(-1, 1)
    quads = corner + np.array([0, cells + 1, cells + 2, 1])
    return lamp(vertices, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]), radiance)


def dome(radius: float, radiance: float) -> Node:
    """Half a sphere that shines inwards, without the triangles that reach below the floor."""
    sphere = trimesh.creation.icosphere(subdivisions=4, radius=radius)
    above = (sphere.vertices[:, 1] > 0.0)[sphere.faces].all(1)
    return lamp(sphere.vertices, sphere.faces[above][:, ::-1], radiance)


def hanging(count: int, low: float, high: float, unequal: float) -> dict[str, Node]:
    """Small square lamps at random above the floor, their radiances over a factor `unequal`."""
    rng = np.random.default_rng(17)
    lamps = {}
    for i in range(count):
        x, z = rng.uniform(-9, 9, 2)
        node = panel(0.1, rng.uniform(low, high), 1, 1e3 * unequal ** -rng.random())
        mesh = node.shape
        assert isinstance(mesh, Mesh)
        moved = np.asarray(mesh.vertices) + np.array([x, 0, z], np.float32)
        # One rectangle in two triangles: `count` lamps are `count` pairs of leaves.
        lamps[f"lamp{i}"] = node.replaced(shape=mesh.replaced(vertices=moved))
    return lamps


def clusters() -> dict[str, Node]:
    """125 little balls of 80 triangles in ten heaps, unequal by 1000."""
    rng = np.random.default_rng(5)
    lamps = {}
    for i in range(10):
        x, z = rng.uniform(-7, 7, 2)
        for j in range(13 if i < 5 else 12):
            dx, dy, dz = rng.uniform(-0.6, 0.6, 3)
            place = (x + dx, 1.3 + dy, z + dz)
            lamps[f"ball{i}-{j}"] = ball(0.03, place, 1, 1e3 * 1000.0 ** -rng.random())
    return lamps


def rooms() -> Scene:
    """Sixteen closed rooms in a row with sixteen lamps each, one of them seen."""
    rng = np.random.default_rng(3)
    lamps = {}
    for i in range(16):
        for j in range(16):
            x, y, z = rng.uniform(-2.5, 2.5, 3)
            lamps[f"lamp{i}-{j}"] = ball(0.05, (x + 6.1 * (i - 8), y, z), 0, 30.0)
    return with_lamps(ROOM, lamps)


SCENES: dict[str, Callable[[], Scene]] = {
    "clusters": lambda: with_lamps(OPEN, clusters()),
    "17 lamps": lambda: with_lamps(OPEN, hanging(17, 1, 2, 1000)),
    "128 lamps": lambda: with_lamps(OPEN, hanging(128, 1, 2, 1000)),
    "5000 lamps": lambda: with_lamps(OPEN, hanging(5000, 1, 2, 1000)),
    "many-lights": lambda: alight.load("many-lights", ["film.size=[128,96]"]),
    "rooms": rooms,
    "ball in a room": lambda: with_lamps(ROOM, {"ball": ball(0.4, (0.2, 0.5, -0.5), 3, 30.0)}),
    "far ball": lambda: with_lamps(OPEN, {"ball": ball(4.0, (5, 40, 0), 3, 30.0)}),
    "17 far lamps": lambda: with_lamps(OPEN, hanging(17, 40, 41, 1)),
    "128 far lamps": lambda: with_lamps(OPEN, hanging(128, 40, 41, 1)),
    "2000 far lamps": lambda: with_lamps(OPEN, hanging(2000, 40, 41, 1)),
    "far panel": lambda: with_lamps(OPEN, {"panel": panel(4.0, 40.0, 50, 30.0)}),
    "panel in a room": lambda: with_lamps(ROOM, {"panel": panel(3.0, 2.9, 50, 3.0)}),
    "lamp in a room, 8 edges": lambda: with_lamps(ROOM, {"panel": panel(1.0, 2.9, 10, 30.0)}, 8),
    "dome": lambda: with_lamps(OPEN, {"dome": dome(40.0, 1.0)}),
}


def timed(scene: Scene, spp: int, seed: int) -> tuple[float, NDArray[np.float32]]:
    """Processor time of a render on one thread, and its picture (h, w, 3)."""
    start = time.process_time()
    film = alight.render(scene, spp=spp, seed=seed, threads=1)
    return time.process_time() - start, film.image


def measure(name: str, options: argparse.Namespace) -> dict[str, object]:
    """Compare the arms on one scene."""
    scene = SCENES[name]()
    arms = {
        arm: scene.replaced(integrator=scene.integrator.replaced(light_choice=arm)) for arm in ARMS
    }
    pictures: dict[str, list[NDArray[np.float32]]] = {arm: [] for arm in ARMS}
    least = {arm: {1: np.inf, options.spp: np.inf} for arm in ARMS}
    for seed in range(options.seeds):
        for number, arm in enumerate(ARMS):
            seconds, picture = timed(arms[arm], options.spp, 1000 * number + seed)
            pictures[arm].append(picture)
            # The first round makes kernels and warms the caches.
            if seed > 0:
                least[arm][options.spp] = min(least[arm][options.spp], seconds)
                least[arm][1] = min(least[arm][1], timed(arms[arm], 1, seed)[0])
    mean = np.mean([np.mean(stack, 0, dtype=np.float64) for stack in pictures.values()], 0)
    scale = mean**2 + (0.1 * np.median(mean[mean > 0.0])) ** 2
    row: dict[str, object] = {"scene": name}
    errors, costs = {}, {}
    for arm, stack in pictures.items():
        relative = np.asarray(stack, np.float64).var(0, ddof=1) / scale
        errors[arm] = float(relative.mean())
        costs[arm] = least[arm][options.spp] - least[arm][1]
    for arm in ARMS[1:]:
        error, cost = errors[arm] / errors["power"], costs[arm] / costs["power"]
        row |= {f"{arm}: error": error, f"{arm}: time": cost}
        row[f"{arm}: efficiency"] = 1.0 / (error * cost)
    return row


def main() -> None:
    """Measure every scene asked for."""
    parser = argparse.ArgumentParser(description="Choice of lights: power, tree and auto.")
    parser.add_argument("--scenes", nargs="+", default=list(SCENES), choices=list(SCENES))
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--seeds", type=int, default=8, help="at least 2")
    options = parser.parse_args()
    rows = []
    for name in options.scenes:
        rows.append(measure(name, options))
        print_json(benchmark="light choice", spp=options.spp, seeds=options.seeds, **rows[-1])
    print_table(rows)


if __name__ == "__main__":
    main()
