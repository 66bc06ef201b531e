"""Paths that wait between the halves of a step: which packet they are in must not matter."""

from __future__ import annotations

import numpy as np
import pytest

from alight.compiled.scene import compile_scene
from alight.formats import loads
from alight.integrators.walk import make_settings
from alight.rendering.tiles.tile import TileFilm
from alight.rendering.tiles.tile_kernel import RAYS, Tile
from alight.rendering.tiles.tile_loop import render_step_by_step, render_tile_kernel
from alight.scene import flatten
from lanewise.jit import instantiate
from lanewise.view import View

#: A ball above a disk in the open: rays leave the scene at every depth.
SCENE = """alight: 1
film: {size: [8, 8]}
sampler: {type: independent}
integrator: {type: path, max_depth: 6, rr_depth: 2}
environment: {type: constant}
camera: {fov: 45, transform: {look_at: {origin: [0, 0, 4], target: [0, 0, 0]}}}
nodes:
  ball: {shape: {type: sphere, radius: 0.8}, bsdf: {type: diffuse, reflectance: 0.8}}
  mirror:
    shape: disk
    bsdf: {type: mirror, reflectance: 0.9}
    transform: [{scale: 2}, {rotate: {axis: x, angle: -70}}, {translate: [0, -1, 0]}]
"""
BODY = SCENE.replace(
    "{type: diffuse, reflectance: 0.8}", "{type: subsurface, radius: [0.4, 0.2, 0.1]}"
)


def sums_of(root, scene, spp):
    settings = make_settings(scene.integrator, seed=3, replicates=4)
    film = TileFilm(*(View(np.zeros(n, np.int64)) for n in (8 * 8 * 4 * 6, 8 * 8 * 4, 1, 4)))
    ranges = View(np.array([[[0, spp]]], np.int64))
    with np.errstate(all="ignore"):
        instantiate(root, scene.program, compiled=False)(
            scene.tables, settings, Tile(0, 0, 8, 8), ranges, film
        )
    return film


@pytest.mark.parametrize(
    ("text", "spp"), [(SCENE, 1), (SCENE, 7), (BODY, 2)], ids=["1", "7", "bodies"]
)
def test_stages_give_the_bits_of_whole_steps(text, spp):
    scene = compile_scene(flatten(loads(text, "scene.yaml")), structure="list")
    staged, whole = (
        sums_of(root, scene, spp) for root in (render_tile_kernel, render_step_by_step)
    )
    assert staged.counts.array.sum() == 64 * spp
    assert staged.tally.array[RAYS] == whole.tally.array[RAYS] > 0
    for a, b in zip(staged, whole, strict=True):
        np.testing.assert_array_equal(a.array, b.array)
