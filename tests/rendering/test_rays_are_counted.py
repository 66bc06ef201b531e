"""How many rays a picture took, where that follows from the scene."""

import numpy as np
import pytest

import alight
from alight.compiled.scene import compile_scene
from alight.formats import loads
from alight.integrators.walk import make_settings
from alight.rendering.tiles.tile import make_kernels, render_tile
from alight.rendering.tiles.tile_kernel import Tile
from alight.scene import flatten

SIDE, SPP = 8, 4

#: A grey room without windows, lit by a point in its middle.
ROOM = f"""
alight: 1
film: {{size: [{SIDE}, {SIDE}]}}
sampler: independent
camera: {{type: pinhole, fov: 60, transform: {{look_at: {{origin: [.2, .1, .3], target: [1, .5, -1]}}}}}}
nodes:
  room: {{shape: {{type: cube, flip_normals: true}}, bsdf: {{type: diffuse, reflectance: GREY}}}}
  lamp: {{light: {{type: point, intensity: 1}}}}
"""  # noqa: E501
GREY_ROOM, BLACK_ROOM = ROOM.replace("GREY", "0.5"), ROOM.replace("GREY", "0")
#: Behind the camera, so that it does not see the lamp.
LAMP_BEHIND = BLACK_ROOM.replace("type: point, intensity: 1}}", "type: point, intensity: 1}, "
                                 "transform: {translate: [-0.5, 0, 0.8]}}")  # fmt: skip
SHINING = GREY_ROOM.replace("reflectance: 0.5}", "reflectance: 0.5}, light: area").replace(
    "  lamp: {light: {type: point, intensity: 1}}\n", ""
)
#: Nothing but the sky.
OPEN = ROOM[: ROOM.index("nodes:")] + "environment: constant\n"

FULL = "russian_roulette: none, max_depth"

#: Scene, integrator, rays a sample.
CASES = {
    # Every edge is a ray, and every vertex but the last one asks the lamp.
    "path": (GREY_ROOM, f"{{type: path, {FULL}: 5}}", 5 + 4),
    "path, balanced": (GREY_ROOM, f"{{type: path, heuristic: balance, {FULL}: 3}}", 3 + 2),
    "paths that follow directions alone": (
        SHINING, f"{{type: path, light_sampling: bsdf, {FULL}: 6}}", 6,
    ),
    "paths in the open": (OPEN, f"{{type: path, {FULL}: 6}}", 1),
    "paths that end in the dark": (BLACK_ROOM, f"{{type: path, {FULL}: 6}}", 1),
    "volpath": (GREY_ROOM, f"{{type: volpath, {FULL}: 5}}", 5 + 4),
    "direct": (GREY_ROOM, "{type: direct}", 2 + 1),
    "occlusion": (GREY_ROOM, "{type: ambient_occlusion}", 2),
    "nothing to occlude": (OPEN, "{type: ambient_occlusion}", 1),
    "light": (LAMP_BEHIND, f"{{type: light, {FULL}: 4}}", 1),
}  # fmt: skip


def scene_of(name):
    """The room with its integrator."""
    text, integrator, _ = CASES[name]
    return loads(f"{text}integrator: {integrator}\n", "room.yaml")


@pytest.mark.parametrize("name", CASES)
def test_rays_are_as_many_as_the_edges_of_the_paths(name):
    scene = compile_scene(flatten(scene_of(name)), structure="list")
    settings = make_settings(scene.integrator, seed=0, replicates=SPP)
    kernels, ranges = make_kernels(scene, compiled=False), np.array([[[0, SPP]]])
    _, rays = render_tile(kernels, scene, settings, Tile(0, 0, SIDE, SIDE), ranges)
    assert rays == CASES[name][2] * SPP * SIDE * SIDE


def test_a_film_has_the_rays_of_all_tiles_and_passes():
    film = alight.render(scene_of("occlusion"), spp=SPP, spp_per_pass=1)
    assert film.stats["rays"] == CASES["occlusion"][2] * SPP * SIDE * SIDE
