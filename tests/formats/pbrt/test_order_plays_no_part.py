"""What pbrt sorts, and what is read once for several places."""

import numpy as np
import pytest

from alight.core.errors import SceneError
from alight.meshes import ply
from alight.meshes.triangles import MeshArrays
from alight.scene.flatten import flatten
from tests.formats.pbrt.reading import read


@pytest.mark.parametrize("kind", ["sphere", "cylinder"])
@pytest.mark.parametrize(("low", "high"), [(-0.25, 0.5), (0.125, 0.75)])
def test_the_ends_of_a_shape_may_change_places(kind, low, high):
    scenes, said = [], ""
    try:
        for a, b in ((low, high), (high, low)):
            scenes.append(flatten(read(f'Shape "{kind}" "float zmin" {a} "float zmax" {b}')))
    except SceneError as error:
        said = str(error)
    assert said == ""
    one, other = (scene.shapes[0] for scene in scenes)
    assert one.shape == other.shape
    np.testing.assert_array_equal(one.to_world, other.to_world)
    if kind == "sphere":
        heights = scenes[0].geometries[0].vertices[:, 2]
        assert (heights.min(), heights.max()) == pytest.approx((low, high))


@pytest.mark.parametrize("first", ["", "ReverseOrientation\n"])
def test_a_file_that_stands_twice_may_be_turned_in_one_place(first, tmp_path):
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
    arrays = MeshArrays(corners, np.array([[0, 1, 2]], np.int32), None, None, None)
    ply.save(tmp_path / "a.ply", arrays)
    shape = 'Shape "plymesh" "string filename" "a.ply"\n'
    second = "ReverseOrientation\n" if not first else ""
    text = (
        f"AttributeBegin\n{first}{shape}AttributeEnd\nAttributeBegin\n{second}{shape}AttributeEnd"
    )
    flat = flatten(read(text, folder=tmp_path))
    assert [placed.shape.flip_normals for placed in flat.shapes] == [bool(first), not first]
