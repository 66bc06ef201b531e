"""One mesh in several places, each with its own displacement."""

import numpy as np

from alight.compiled.displacement import displaced
from alight.formats import loads
from alight.scene import flatten

HEAD = """alight: 1
camera: {type: pinhole}
textures: {ramp: {type: bitmap, pixels: [[0, 1]], color_space: linear, wrap: clamp}}
nodes:
"""
BOARD = """  {0}: {{shape: {{
    type: mesh, vertices: [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]],
    faces: [[0, 1, 2], [0, 2, 3]], uvs: [[0, 0], [1, 0], [1, 1], [0, 1]], displacement: ramp,
    displacement_midlevel: 0, displacement_edge: 1, displacement_scale: {1}}}}}
"""


def test_one_mesh_in_two_places_is_displaced_by_each_place_s_own_heights():
    text = HEAD + BOARD.format("low", 0.25) + BOARD.format("high", 0.5)
    before = flatten(loads(text, "scene.yaml"))
    first, second = before.shapes
    assert first.geometry == second.geometry
    after = displaced(before)
    highest = [after.geometries[one.geometry].vertices[:, 2].max() for one in after.shapes]
    np.testing.assert_allclose(highest, [0.25, 0.5])
