"""Scenes of the campaign on the agreement of pictures: the package's, and four kinds by number.

The kinds were made to be hard: glossy balls under a sky whose sun is one texel, many tiny lamps, a
caustic that paths find by chance, and fog with two lamps. A number decides where things lie.
"""

from __future__ import annotations

import copy
import tempfile
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from alight.formats import builtin_names, load
from alight.lab.random_scenes import random_scene
from alight.scene import Scene
from alight.scene.dump import dump_scene

#: Parameters that are albedos; textures take their colours' names.
ALBEDOS = frozenset({
    "reflectance", "diffuse_reflectance", "base_color", "albedo", "color0", "color1",
})  # fmt: skip

#: Before the kinds of scenes that the laboratory draws.
RANDOM = "random-"

SAMPLERS = ("sobol", "independent", "stratified")


def _balls(rng: np.random.Generator, bsdf: str) -> dict[str, Any]:
    return {
        f"ball-{i}": {
            "shape": {
                "type": "sphere",
                "center": [float(rng.uniform(-2, 2)), 0.5, float(rng.uniform(-2, 1))],
                "radius": float(rng.uniform(0.25, 0.5)),
            },
            "bsdf": bsdf,
        }
        for i in range(5)
    }


def _floor() -> dict[str, Any]:
    turned = {"rotate": {"axis": "x", "angle": -90}}
    return {"shape": "plane", "bsdf": "floor", "transform": turned}


def _camera() -> dict[str, Any]:
    return {"fov": 45, "transform": {"look_at": {"origin": [0, 2.2, 5], "target": [0, 0.4, 0]}}}


def sunny(rng: np.random.Generator, folder: Path) -> dict[str, Any]:
    """Glossy balls under a sky whose sun is one texel."""
    sky = np.full((32, 64, 3), [0.3, 0.45, 0.7], np.float32)
    sky[int(rng.integers(5, 12)), int(rng.integers(0, 64))] = [900.0, 800.0, 650.0]
    np.save(folder / "sky.npy", sky)
    return {
        "camera": _camera(),
        "environment": {"type": "environment", "file": "sky.npy"},
        "bsdfs": {
            "floor": {"type": "diffuse", "reflectance": 0.5},
            "gloss": {"type": "rough_conductor", "metal": "gold", "alpha": 0.15},
        },
        "nodes": {"floor": _floor(), **_balls(rng, "gloss")},
    }


def lamps(rng: np.random.Generator, folder: Path) -> dict[str, Any]:
    """150 tiny lamps over a few balls."""
    nodes = {"floor": _floor(), **_balls(rng, "grey")}
    for i in range(150):
        x, y, z = rng.uniform([-3, 0.2, -3], [3, 2, 2])
        nodes[f"lamp-{i}"] = {
            "shape": {"type": "sphere", "center": [float(x), float(y), float(z)], "radius": 0.015},
            "bsdf": "black",
            "light": {"type": "area", "radiance": float(rng.uniform(10, 60))},
        }
    return {
        "camera": _camera(),
        "bsdfs": {
            "floor": {"type": "diffuse", "reflectance": 0.6},
            "grey": {"type": "diffuse", "reflectance": [0.7, 0.5, 0.3]},
            "black": {"type": "diffuse", "reflectance": 0},
        },
        "nodes": nodes,
    }


def caustic(rng: np.random.Generator, folder: Path) -> dict[str, Any]:
    """Glass balls under a small lamp: their caustics are found by chance."""
    return {
        "camera": _camera(),
        "integrator": {"type": "path", "max_depth": 7},
        "environment": {"type": "constant", "radiance": 0.05},
        "bsdfs": {
            "floor": {"type": "diffuse", "reflectance": 0.6},
            "glass": {"type": "dielectric"},
            "black": {"type": "diffuse", "reflectance": 0},
        },
        "nodes": {
            "floor": _floor(),
            **_balls(rng, "glass"),
            "lamp": {
                "shape": {
                    "type": "sphere",
                    "center": [float(rng.uniform(-1, 1)), 3.0, float(rng.uniform(-1, 1))],
                    "radius": float(rng.uniform(0.08, 0.2)),
                },
                "bsdf": "black",
                "light": {"type": "area", "radiance": 150},
            },
        },
    }


def fog(rng: np.random.Generator, folder: Path) -> dict[str, Any]:
    """Balls in fog, lit by a point and by a small sphere."""
    x = [float(v) for v in rng.uniform(-1.5, 1.5, 4)]
    return {
        "camera": _camera(),
        "integrator": {"type": "volpath", "max_depth": 10},
        "medium": "fog",
        "media": {"fog": {"type": "homogeneous", "sigma_t": 0.15, "albedo": [0.9, 0.93, 0.96]}},
        "bsdfs": {
            "floor": {"type": "diffuse", "reflectance": 0.5},
            "grey": {"type": "diffuse", "reflectance": [0.7, 0.5, 0.3]},
            "black": {"type": "diffuse", "reflectance": 0},
        },
        "nodes": {
            "floor": _floor(),
            **_balls(rng, "grey"),
            "bulb": {
                "transform": {"translate": [x[0], 1.8, x[1]]},
                "light": {"type": "point", "intensity": 6},
            },
            "lamp": {
                "shape": {"type": "sphere", "center": [x[2], 2.0, x[3]], "radius": 0.1},
                "bsdf": "black",
                "light": {"type": "area", "radiance": [80, 60, 40]},
            },
        },
    }


KINDS = {"sunny": sunny, "lamps": lamps, "caustic": caustic, "fog-lamps": fog}


def names(first: int, count: int) -> list[str]:
    """All scenes of the package, and `count` of each kind from number `first` on."""
    numbered = [f"{kind}:{first + i}" for i in range(count) for kind in KINDS]
    return [*numbered, *sorted(builtin_names())]


def load_scene(
    name: str, size: tuple[int, int], sampler: str, replicates: int, darker: float = 1.0
) -> Scene:
    """Load a scene by name, with every albedo times `darker`.

    A name is that of a file or of a scene of the package, one of `KINDS` with a number, or
    ``random-`` and a kind of `alight.lab.random_scenes` with its seed, ``random-room:7``.
    """
    folder = Path(_folder().name)
    kind, _, number = name.partition(":")
    if Path(name).suffix == ".yaml":
        data = yaml.safe_load(Path(name).read_text("utf-8"))
    elif kind.startswith(RANDOM):
        data = dump_scene(random_scene(int(number), kind.removeprefix(RANDOM), size))
    elif number:
        seed = [sorted(KINDS).index(kind), int(number)]
        data: Any = KINDS[kind](np.random.default_rng(seed), folder)
    else:
        file = resources.files("alight.scene.builtin").joinpath(f"{name}.yaml")
        data = yaml.safe_load(file.read_text("utf-8"))
    data = copy.deepcopy(data) | {"alight": 1}
    _darken(data, darker)
    data["film"] = data.get("film", {}) | {"size": list(size), "replicates": replicates}
    data["sampler"] = sampler
    path = folder / "scene.yaml"
    path.write_text(yaml.safe_dump(data), "utf-8")
    return load(path)


@cache
def _folder() -> tempfile.TemporaryDirectory[str]:
    """Where the scenes' files lie as long as the process lives."""
    return tempfile.TemporaryDirectory()


def _darken(data: Any, factor: float) -> None:
    for key, value in data.items() if isinstance(data, dict) else enumerate(data):
        if key in ALBEDOS and isinstance(value, (int, float)):
            data[key] = factor * value
        elif key in ALBEDOS and isinstance(value, list):
            data[key] = [factor * v for v in value]
        elif isinstance(value, (dict, list)):
            _darken(value, factor)
