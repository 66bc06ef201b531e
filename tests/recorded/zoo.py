"""Small scenes in general position: nothing grey, nothing along an axis, no two numbers alike.

Modules in `cases` whose names begin with ``zoo_`` have a dictionary ``SCENES`` of the text of
scenes by name. `test_zoo` demands that every model and every key of the project is in one of them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from alight.compiled.scene import compile_scene
from alight.films import fixed_point
from alight.formats import loads
from alight.rendering.tiles.tile_kernel import Tile
from alight.scene import Scene, flatten
from tests.recorded.answers import modules_of_cases
from tests.twin import film_of

SEED, REPLICATES, SPP = 20261127, 2, 4

#: What a scene is made of unless it says otherwise.
PARTS = {
    "camera": "{type: pinhole, fov: 41, transform: {look_at: "
    "{origin: [0.7, 2.1, 4.4], target: [0.05, 0.5, -0.2], up: [0.11, 1, 0.07]}}}",
    "film": "{size: [12, 8]}",
    "integrator": "{type: path, max_depth: 6}",
    "environment": "{type: constant, radiance: [0.21, 0.34, 0.55]}",
}
FLOOR = """
  floor:
    shape: rectangle
    bsdf: {type: diffuse, reflectance: [0.61, 0.47, 0.33]}
    transform: [{scale: [3.1, 2.7, 1]}, {rotate: {axis: x, angle: -88}}, {rotate: {axis: y, angle: 17}}]
"""  # noqa: E501
LAMP = """
  lamp:
    shape: disk
    bsdf: {type: diffuse, reflectance: [0.13, 0.05, 0.08]}
    light: {type: area, radiance: [23, 17, 11]}
    transform: [{scale: [0.6, 0.4, 1]}, {look_at: {origin: [-1.3, 3.2, 1.9], target: [-2.5, 5.9, 3.7]}}]
"""  # noqa: E501
STAGE = FLOOR + LAMP


def scene(nodes: str, **parts: str) -> str:
    """Text of a scene; what is empty is left out."""
    lines = [f"{key}: {value}" for key, value in (PARTS | parts).items() if value]
    return "\n".join(["alight: 1", *lines, "nodes:" + nodes])


def film_answer(text: str, spp: int = SPP, aovs: tuple[str, ...] = ()) -> dict[str, np.ndarray]:
    """What a film of the NumPy twin holds, as means over its samples (height, width, channels)."""
    described = flatten(loads(text, "zoo.yaml"))
    compiled = compile_scene(described, structure="list", aovs=aovs)
    x, y, width, height = compiled.crop or (0, 0, *compiled.size)
    film = film_of(compiled, spp, SEED, REPLICATES, Tile(x, y, x + width, y + height))
    counts = film.counts.sum(axis=2)
    answer = {
        "picture": fixed_point.to_float(film.sums).sum(axis=2) / spp,
        "counts": counts if (counts != spp).any() else spp,
        "invalid": film.invalid,
        "saturated": film.saturated,
    }
    for name, sums in film.aovs.items():
        answer[name] = fixed_point.to_float(fixed_point.carry(sums) or sums) / spp
    return answer


def films(scenes: Mapping[str, str], **options: object) -> dict[str, Callable[[], object]]:
    """A case for each scene."""
    return {name: partial(film_answer, text, **options) for name, text in scenes.items()}


def all_scenes() -> dict[str, Scene]:
    """The scenes of all modules."""
    found: dict[str, Scene] = {}
    for module, loaded in modules_of_cases():
        if module.startswith("zoo_"):
            for name, text in loaded.SCENES.items():
                found[f"{module}/{name}"] = loads(text, f"{name}.yaml")
    return found
