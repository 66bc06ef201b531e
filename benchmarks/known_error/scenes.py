"""The scenes of the campaigns, 64x64 pixels, and a way to render them again and again."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from alight.compiled.scene import compile_scene
from alight.films.fixed_point import to_float
from alight.formats import load
from alight.integrators.walk import make_settings
from alight.rendering.tiles.tile import Scratch, make_kernels, render_tile
from alight.rendering.tiles.tile_kernel import Tile
from alight.scene import Scene, content_hash, flatten

SIDE, REPLICATES = 64, 4

_ROOM = """
bsdfs:
  grey: {type: diffuse, reflectance: 0.7}
  red: {type: diffuse, reflectance: [0.6, 0.2, 0.15]}
  green: {type: diffuse, reflectance: [0.2, 0.5, 0.25]}
  black: {type: diffuse, reflectance: 0}
nodes:
  room:
    bsdf: grey
    children:
      floor: {transform: [{rotate: {axis: x, angle: -90}}, {translate: [0, -1, 0]}],
          shape: rectangle}
      ceiling: {transform: [{rotate: {axis: x, angle: 90}}, {translate: [0, 1, 0]}],
          shape: rectangle}
      back: {transform: {translate: [0, 0, -1]}, shape: rectangle}
      left: {transform: [{rotate: {axis: y, angle: 90}}, {translate: [-1, 0, 0]}],
          shape: rectangle, bsdf: red}
      right: {transform: [{rotate: {axis: y, angle: -90}}, {translate: [1, 0, 0]}],
          shape: rectangle, bsdf: green}
"""

_AHEAD = "camera: {fov: 40, transform: {look_at: {origin: [0, 0, 3.9], target: [0, 0, 0]}}}\n"
_INTEGRATOR = "integrator: {type: path, max_depth: 8, rr_depth: 5}\n"

TEXTS: dict[str, str | None] = {
    "furnace-box": """
camera: {type: pinhole, fov: 60, transform: [{look_at: {origin: [0.2, 0.1, 0.3], target: [1,
    0.5, -1]}}]}
integrator: {type: path}
nodes:
  box:
    shape: {type: cube, flip_normals: true}
    bsdf: {type: diffuse, reflectance: 0.5}
    light: {type: area, radiance: [1, 2, 3]}
""",
    "sphere-light": _AHEAD
    + _INTEGRATOR
    + _ROOM
    + """
  lamp:
    shape: {type: sphere, center: [0.3, 0.4, 0.1], radius: 0.25}
    bsdf: black
    light: {type: area, radiance: [4, 3, 2]}
  ball: {shape: {type: sphere, center: [-0.35, -0.55, 0.1], radius: 0.45}, bsdf: grey}
""",
    "cornell-box": None,
    "glass": """
camera: {fov: 30, transform: {look_at: {origin: [0, 1.4, 4.2], target: [0, 0.55, 0]}}}
integrator: {type: path, max_depth: 12}
environment: {type: constant, radiance: [0.9, 1.0, 1.2]}
nodes:
  ground:
    transform: [{scale: [4, 4, 1]}, {rotate: {axis: x, angle: -90}}]
    shape: rectangle
    bsdf: {type: diffuse, reflectance: [0.5, 0.4, 0.3]}
  ball: {shape: {type: sphere, center: [-0.45, 0.6, 0], radius: 0.6}, bsdf: {type: dielectric}}
  small: {shape: {type: sphere, center: [0.7, 0.35, 0.5], radius: 0.35}, bsdf: {type: diffuse,
      reflectance: [0.2, 0.5, 0.7]}}
""",
    "many-lights": _AHEAD
    + _INTEGRATOR
    + "environment: {type: constant, radiance: 0.2}\n"
    + _ROOM
    + """
  light:
    transform: [{scale: 0.3}, {rotate: {axis: x, angle: 90}}, {translate: [0, 0.99, 0]}]
    shape: rectangle
    bsdf: black
    light: {type: area, radiance: 2}
  disk:
    transform: [{scale: 0.2}, {rotate: {axis: y, angle: 40}}, {translate: [-0.6, 0.5, -0.5]}]
    shape: disk
    bsdf: black
    light: {type: area, radiance: [0.5, 1, 3]}
  lamp:
    shape: {type: sphere, center: [0.5, 0.3, 0.2], radius: 0.1}
    bsdf: black
    light: {type: area, radiance: [12, 8, 5]}
  bulb: {transform: {translate: [-0.5, -0.5, 0.6]}, light: {type: point, intensity: [0.05, 0.1,
      0.05]}}
  ball: {shape: {type: sphere, center: [0.1, -0.6, 0.0], radius: 0.35}, bsdf: grey}
""",
    "environment": """
camera: {fov: 50, fov_axis: diagonal, transform: {look_at: {origin: [2, 2.6, 4], target: [0,
    0.35, 0]}}}
integrator: {type: path, max_depth: 8, rr_depth: 5}
environment: {type: constant, radiance: [0.7, 0.9, 1.2]}
nodes:
  ground:
    transform: [{scale: [3, 3, 1]}, {rotate: {axis: x, angle: -90}}]
    shape: rectangle
    bsdf: {type: diffuse, reflectance: [0.5, 0.45, 0.4]}
  ball: {shape: {type: sphere, center: [-0.5, 0.7, 0], radius: 0.7}, bsdf: {type: diffuse,
      reflectance: [0.8, 0.4, 0.3]}}
  small: {shape: {type: sphere, center: [0.8, 0.35, 0.6], radius: 0.35}, bsdf: {type: diffuse,
      reflectance: [0.3, 0.6, 0.4]}}
""",
    # A white floor that shines (1) and sees, by BSDF sampling only, a disk of radiance 99 that
    # takes a thousandth of its cosine-weighted hemisphere: sin^2 = 0.001.
    "rare-spike": """
camera: {fov: 20, transform: {look_at: {origin: [0, 3, 0], target: [0, 0, 0], up: [0, 0, 1]}}}
sampler: independent
integrator: {type: path, light_sampling: bsdf, max_depth: 2, russian_roulette: none}
nodes:
  floor:
    transform: [{scale: 2}, {rotate: {axis: x, angle: -90}}]
    shape: rectangle
    bsdf: {type: diffuse, reflectance: 1}
    light: {type: area, radiance: 1}
  sun:
    transform: [{scale: 31.638585}, {rotate: {axis: x, angle: 90}}, {translate: [0, 1000, 0]}]
    shape: disk
    bsdf: {type: diffuse, reflectance: 0}
    light: {type: area, radiance: 99}
""",
    # Walls that shine, and a rough mirror ball in which a small lamp is seen.
    "glossy-ball": """
camera: {fov: 60, transform: {look_at: {origin: [0.6, 0.1, 0.9], target: [-0.4, 0, -1]}}}
integrator: {type: path, max_depth: 4, light_sampling: bsdf}
nodes:
  walls:
    shape: {type: cube, flip_normals: true}
    bsdf: {type: diffuse, reflectance: 0}
    light: {type: area, radiance: 1}
  lamp:
    shape: {type: sphere, center: [0.5, 0.8, 0.8], radius: 0.1}
    bsdf: {type: diffuse, reflectance: 0}
    light: {type: area, radiance: 60}
  ball:
    shape: {type: sphere, center: [-0.4, -0.2, -0.5], radius: 0.25}
    bsdf: {type: rough_conductor, alpha: 0.5}
""",
    "zero-variance": """
camera: {fov: 40, transform: {look_at: {origin: [0, 0, 3], target: [0, 0, 0]}}}
integrator: {type: path, max_depth: 1}
environment: {type: constant, radiance: [0.5, 1, 2]}
nodes:
  behind:
    shape: {type: sphere, center: [0, 0, 9]}
    bsdf: {type: diffuse, reflectance: 0}
""",
}
#: Where adaptive sampling has something to do, scenes of the package first; and one where it has
#: not.
UNEVEN = (
    "soft-shadows", "blurred-foreground", "lamp-and-glass", "environment-map", "rough-glass",
    "cornell-box", "glossy-ball", "many-lights",
)  # fmt: skip

ORDINARY = ("furnace-box", "sphere-light", "cornell-box", "glass", "many-lights", "environment")


def load_scene(name: str, changes: Sequence[str] = ()) -> Scene:
    """Load one of the scenes here, or of the package, at 64x64 pixels."""
    text = TEXTS.get(name)
    changes = [f"film.size=[{SIDE}, {SIDE}]", *changes]
    if text is None:
        return load(name, changes)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{name}.yaml"
        path.write_text("alight: 1\n" + text, "utf-8")
        return load(path, changes)


class Runner:
    """A compiled scene that gives sums of samples for any seed, without a main loop.

    Parameters
    ----------
    scene : Scene or str
        Or the name of one of the scenes here or of the package, at 64x64 pixels.
    changes : sequence of str
        For a named scene, as ``--set`` takes them.
    """

    def __init__(self, scene: Scene | str, changes: Sequence[str] = ()) -> None:
        flat = flatten(load_scene(scene, changes) if isinstance(scene, str) else scene)
        self.scene = compile_scene(flat, content_hash(flat), threads=1)
        self.kernels = make_kernels(self.scene)
        self.settings = make_settings(self.scene.integrator, seed=0, replicates=REPLICATES)
        self.scratch, self.tile = Scratch(), Tile(0, 0, *flat.film.size)

    def sums(
        self,
        seed: int,
        first: int | np.ndarray,
        count: int | np.ndarray,
        replicates: int = REPLICATES,
    ) -> np.ndarray:
        """Sums by replicate, shape (h, w, R, 3), of samples first to first + count - 1.

        `first` and `count` are numbers, or one for each 8x8 cell.
        """
        cells = -(-self.tile.y1 // 8), -(-self.tile.x1 // 8)
        ranges = np.zeros((*cells, 2), np.int64)
        ranges[..., 0], ranges[..., 1] = first, count
        settings = self.settings._replace(seed=seed, replicates=replicates)
        partial, _ = render_tile(
            self.kernels, self.scene, settings, self.tile, ranges, self.scratch
        )
        return to_float(partial.sums)

    def rays(self, spp: int) -> np.ndarray:
        """Rays that the samples of each cell take, shape (8, 8): what they cost."""
        side, samples = SIDE // 8, np.array([[[0, spp]]], np.int64)
        found = np.zeros((side, side))
        for y, x in np.ndindex(side, side):
            cell = Tile(8 * x, 8 * y, 8 * x + 8, 8 * y + 8)
            found[y, x] = render_tile(
                self.kernels, self.scene, self.settings, cell, samples, self.scratch
            )[1]
        return found

    def means(self, seed: int, spp: int, replicates: int = REPLICATES) -> np.ndarray:
        """Means of the replicates, float64, shape (h, w, R, 3)."""
        return self.sums(seed, 0, spp, replicates) / (spp / replicates)
