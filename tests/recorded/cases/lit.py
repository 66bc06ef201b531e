"""Lights: what arrives from them, and how light sets out, for given random numbers."""

from functools import partial

import numpy as np

from alight.compiled.scene import compile_scene
from alight.formats import loads
from alight.laws.emission import rays_of_lights
from alight.laws.lights import light_of_points
from alight.scene import flatten
from lanewise.jit import instantiate
from lanewise.view import View
from tests.recorded.cases.zoo_lights import SCENES

N = 256
NAMES = (
    "points", "beams", "profiles", "projectors", "shapes", "map", "map-all", "map-uniform", "sky",
    "sun", "clear-day", "windows", "many-tree", "many-power", "many-uniform", "caustics",
)  # fmt: skip


def rays(name: str, kernel, rows: int, emits: bool) -> dict[str, np.ndarray]:
    """Some of the rows, and of all the means and the means of their sizes."""
    flat = flatten(loads(SCENES[name], "zoo.yaml"))
    scene = compile_scene(flat, structure="list", emits=emits)
    random = np.random.default_rng(5)
    u = View(random.random((5, N), np.float32))
    points = View(random.uniform(-1.5, 1.5, (3, N)).astype(np.float32))
    out = View(np.zeros((rows, N), np.float32))
    run = instantiate(kernel, scene.program, compiled=False, lanes=N)
    with np.errstate(all="ignore"):
        run(scene.tables, *((u,) if emits else (points, u)), out, N)
    found = np.where(np.isfinite(out.shaped), out.shaped, -1.0).astype(float)
    return {"samples": found[:, ::16].T, "means": found.mean(1), "sizes": np.abs(found).mean(1)}


CASES = {
    f"{way}/{name}": partial(rays, name, kernel, rows, emits)
    for name in NAMES
    for way, kernel, rows, emits in (
        ("arrives", light_of_points, 8, False), ("sets-out", rays_of_lights, 11, True),
    )
}  # fmt: skip
