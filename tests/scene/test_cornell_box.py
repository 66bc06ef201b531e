"""The built-in Cornell box has the published corners, normals, colours and camera."""

import numpy as np
import pytest

from alight.formats import load
from alight.scene import flatten

# (name, corners counter-clockwise seen from where the normal points, normal, material)
QUADS = {
    "light": ([[-0.23, 0.99, -0.18], [0.23, 0.99, -0.18], [0.23, 0.99, 0.2], [-0.23, 0.99, 0.2]],
              (0, -1, 0)),
    "floor": ([[-0.9999999, -1, 1], [0.9999999, -1, 1], [0.9999999, -1, -1],
               [-0.9999999, -1, -1]], (0, 1, 0)),
    "ceiling": ([[-0.9999999, 1, -1], [0.9999999, 1, -1], [0.9999999, 1, 1],
                 [-0.9999999, 1, 1]], (0, -1, 0)),
    "back": ([[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1]], (0, 0, 1)),
    "green-wall": ([[1, -0.9999999, -1], [1, -0.9999999, 1], [1, 0.9999999, 1],
                    [1, 0.9999999, -1]], (-1, 0, 0)),
    "red-wall": ([[-1, -0.9999999, 1], [-1, -0.9999999, -1], [-1, 0.9999999, -1],
                  [-1, 0.9999999, 1]], (1, 0, 0)),
    "small-box-z": ([[0.1358201, -1, 0.005397], [0.1358201, -0.4, 0.005397],
                     [0.709603, -0.4, 0.18082], [0.709603, -1, 0.18082]],
                    (0.2923717, 0, -0.9563048)),
    "large-box+x": ([[-0.1390394, -1.01, -0.6588589], [-0.1390394, 0.21, -0.6588589],
                     [0.0488589, 0.21, -0.0890394], [0.0488589, -1.01, -0.0890394]],
                    (0.9496991, 0, -0.3131638)),
}  # fmt: skip


@pytest.fixture(scope="module")
def flat():
    return flatten(load("cornell-box"))


@pytest.mark.parametrize("name", QUADS)
def test_quads_have_their_corners_in_order(flat, name):
    corners, normal = QUADS[name]
    (shape,) = (shape for shape in flat.shapes if shape.name == name)
    square = np.array([[-1, -1, 0, 1], [1, -1, 0, 1], [1, 1, 0, 1], [-1, 1, 0, 1]])
    np.testing.assert_allclose((square @ shape.to_world.T)[:, :3], corners, atol=6e-8)
    np.testing.assert_allclose(shape.to_world[:3, 2], normal, atol=2e-7)
    assert np.linalg.det(shape.to_world[:3, :3]) > 0.0


def test_all_boxes_are_closed_and_face_outwards(flat):
    for box in ("small-box", "large-box"):
        faces = [shape for shape in flat.shapes if shape.name.startswith(box)]
        assert len(faces) == 6
        # The area vectors of a closed surface add up to 0.
        total = sum(np.cross(f.to_world[:3, 0], f.to_world[:3, 1]) for f in faces)
        np.testing.assert_allclose(total, 0.0, atol=1e-7)
        centre = sum(f.to_world[:3, 3] for f in faces) / 6.0
        assert all((f.to_world[:3, 3] - centre) @ f.to_world[:3, 2] > 0.1 for f in faces)


def test_light_colours_camera_and_settings(flat):
    (light,) = (shape for shape in flat.shapes if shape.light is not None)
    assert light.name == "light"
    assert light.light.radiance == (18.387, 13.9873, 6.75357)
    colours = {shape.name: flat.bsdfs[shape.bsdf].reflectance for shape in flat.shapes}
    white = (0.885809, 0.698859, 0.666422)
    assert colours.pop("green-wall") == (0.105421, 0.37798, 0.076425)
    assert colours.pop("red-wall") == (0.570068, 0.0430135, 0.0443706)
    assert set(colours.values()) == {white}
    assert len(flat.shapes) == 18
    assert flat.camera.camera.fov == 39.3077
    np.testing.assert_array_equal(flat.camera.to_world[:3, 3], (0, 0, 3.9))
    np.testing.assert_array_equal(flat.camera.to_world[:3, :3], np.eye(3))
    assert (flat.integrator.max_depth, flat.integrator.rr_depth) == (8, 5)
    assert flat.film.size == (512, 512)
