"""What is cut out of surfaces, or half there, with the opacity of their vertices, in pictures."""

import json

import numpy as np
import pytest

import alight
from alight.core.errors import SceneError
from alight.formats.gltf.write import write
from alight.scene.flatten import flatten
from tests.formats.gltf.maker import Maker
from tests.twin import picture_of

#: Opacity 0 on the left, 1 on the right.
RAMP = np.array([[1, 1, 1, 0], [1, 1, 1, 1], [1, 1, 1, 1], [1, 1, 1, 0]], "<f4")
#: Holes at two of four corners.
HOLES = np.full((2, 2, 4), 255, np.uint8) * np.array([[[1, 1, 1, 1]]], np.uint8)
HOLES[0, 1, 3] = HOLES[1, 0, 3] = 0
UNLIT = {"KHR_materials_unlit": {}}
NEAREST = 9728


def written(m, tmp_path, **node):
    """The file of a maker, seen straight on by a camera that shows the unit square."""
    m.json["cameras"] = [
        {"type": "orthographic", "orthographic": {"xmag": 0.5, "ymag": 0.5, "znear": 0, "zfar": 9}}
    ]
    m.node(camera=0, translation=[0.5, 0.5, 3], **node)
    path = tmp_path / "a.gltf"
    path.write_bytes(m.gltf())
    return path


def seen(path, pixels, background, spp):
    """The picture's red channel in front of a constant background, in the twin."""
    sky = f"environment={{type: constant, radiance: {background}}}"
    size = f"film.size=[{pixels}, {pixels}]"
    scene = alight.load(path, [sky, size, "film.filter=box", "sampler.type=sobol"])
    return picture_of(scene, spp)[..., 0]


def veil(table, mode, factor=1.0, **accessor):
    m = Maker()
    white = {"baseColorFactor": [1, 1, 1, factor]}
    material = m.material(alphaMode=mode, pbrMetallicRoughness=white, extensions=UNLIT)
    m.node(mesh=m.square(material, COLOR_0=m.accessor(table, **accessor)))
    return m


def test_the_opacity_of_vertices_is_interpolated_and_multiplied(tmp_path):
    picture = seen(written(veil(RAMP, "BLEND", 0.8), tmp_path), 4, 0.0, 64)
    # Opacity is a probability: independent samples would give a standard error of 0.03.
    np.testing.assert_allclose(picture.mean(axis=0), [0.1, 0.3, 0.5, 0.7], atol=0.004)


def test_the_opacity_of_vertices_in_bytes_is_cut_where_a_mask_says_so(tmp_path):
    table = (RAMP * 255).astype("u1")
    path = written(veil(table, "MASK", normalized=True), tmp_path)
    np.testing.assert_array_equal(seen(path, 4, 0.0, 4)[1], [0, 0, 1, 1])


@pytest.mark.parametrize(("table", "mode"), [(RAMP, "OPAQUE"), (RAMP[[1, 1, 1, 1]], "BLEND")])
def test_opacity_that_plays_no_part_costs_nothing(table, mode, tmp_path):
    scene = alight.load(written(veil(table, mode), tmp_path))
    shape = next(node for _, _, node in scene.walk() if node.shape is not None).shape
    assert shape.more_uvs is None
    assert not any("opacity" in remark for remark in scene.warnings)


def test_textures_keep_their_coordinates_beside_the_opacity(tmp_path):
    m = veil(RAMP, "BLEND")
    pixels = np.array([[[0], [255]], [[0], [255]]], np.uint8).repeat(3, axis=2)
    m.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {
        "index": m.picture(pixels, magFilter=NEAREST)
    }
    picture = seen(written(m, tmp_path), 2, 0.0, 64)
    np.testing.assert_allclose(picture.mean(axis=0), [0.0, 0.75], atol=0.008)


@pytest.mark.parametrize("mode", ["MASK", "BLEND"])
@pytest.mark.parametrize("unlit", [True, False])
def test_holes_do_not_shine(mode, unlit, tmp_path):
    m = Maker()
    pbr = {"baseColorTexture": {"index": m.picture(HOLES, magFilter=NEAREST)}}
    more = {"extensions": UNLIT} if unlit else {"emissiveFactor": [1, 1, 1]}
    m.node(mesh=m.square(m.material(alphaMode=mode, pbrMetallicRoughness=pbr, **more)))
    picture = seen(written(m, tmp_path), 2, 0.0, 16)
    np.testing.assert_allclose(picture, [[1, 0], [0, 1]], atol=1e-6)


def test_half_of_what_shines_is_seen_where_half_is_there(tmp_path):
    m = Maker()
    half = {"baseColorFactor": [0, 0, 0, 0.25], "metallicFactor": 1.0}
    m.node(
        mesh=m.square(
            m.material(alphaMode="BLEND", emissiveFactor=[1, 1, 1], pbrMetallicRoughness=half)
        )
    )
    picture = seen(written(m, tmp_path), 4, 3.0, 64)
    # A quarter of what shines, and three quarters of the background.
    assert picture.mean() == pytest.approx(0.25 + 0.75 * 3.0, rel=0.005)


def test_colors_of_another_shape_are_refused(tmp_path):
    m = veil(RAMP[:3], "BLEND")
    with pytest.raises(SceneError, match="must have 4 rows of 3 or 4 components"):
        alight.load(written(m, tmp_path))


@pytest.mark.parametrize("holes", [True, False])
def test_what_shines_in_part_is_written_as_it_was(holes, tmp_path):
    m = Maker()
    pbr = {"baseColorTexture": {"index": m.picture(HOLES, magFilter=NEAREST)}} if holes else {}
    pbr["baseColorFactor"] = [1, 1, 1, 0.5]
    emission = [0.5, 1, 0.25]
    material = m.material(alphaMode="BLEND", emissiveFactor=emission, pbrMetallicRoughness=pbr)
    m.node(mesh=m.square(material))
    path = written(m, tmp_path)
    lost = write(flatten(alight.load(path)), tmp_path / "b.glb")
    assert not [line for line in lost if "environment" not in line]
    data = (tmp_path / "b.glb").read_bytes()
    made = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])["materials"][0]
    np.testing.assert_allclose(made["emissiveFactor"], emission, rtol=1e-6)
    assert made["pbrMetallicRoughness"]["baseColorFactor"][3] == 0.5
    np.testing.assert_allclose(
        seen(tmp_path / "b.glb", 2, 0.0, 64), seen(path, 2, 0.0, 64), atol=0.02
    )


@pytest.mark.parametrize("double", [True, False])
def test_that_backs_do_not_shine_is_said(double, tmp_path):
    m = Maker()
    m.node(mesh=m.square(m.material(emissiveFactor=[1, 1, 1], doubleSided=double)))
    said = any("outer side only" in line for line in alight.load(written(m, tmp_path)).warnings)
    assert said == double
