"""Pictures in other formats, and data that the file holds without compression, too."""

import io
import json

import numpy as np
import pytest
from PIL import Image

from alight.core.errors import SceneError
from alight.formats.gltf.scene import parse
from alight.outputs.texels import ORIENTATION
from tests.formats.gltf.maker import POINTS, Maker
from tests.formats.gltf.reading import core, parsed

WEBP = "EXT_texture_webp"
PIXELS = np.arange(64 * 3, dtype=np.uint8).reshape(8, 8, 3)


def textured(**texture):
    m = Maker()
    file = io.BytesIO()
    Image.fromarray(PIXELS).save(file, "WEBP", lossless=True)
    m.json["images"].append({"bufferView": m.view(file.getvalue()), "mimeType": "image/webp"})
    m.json["textures"].append(texture)
    painted = {"baseColorTexture": {"index": 0}}
    m.node(mesh=m.square(m.material(name="it", pbrMetallicRoughness=painted)))
    return m


def color_of(found):
    return core(found.data["bsdfs"]["it"])["base_color"]


def test_webp_pictures_are_read():
    m = textured(extensions={WEBP: {"source": 0}})
    m.json["extensionsUsed"] = m.json["extensionsRequired"] = [WEBP]
    found = parsed(m)
    np.testing.assert_array_equal(color_of(found)["pixels"].texels, PIXELS)
    assert not any(WEBP in line for line in (*found.notes, *found.warnings))


def test_packed_photos_stand_upright_and_it_is_told():
    m, file, exif = textured(source=0), io.BytesIO(), Image.Exif()
    exif[ORIENTATION] = 3
    Image.fromarray(PIXELS).save(file, "PNG", exif=exif)
    m.json["images"][0] = {"bufferView": m.view(file.getvalue()), "mimeType": "image/png"}
    found = parsed(m)
    np.testing.assert_array_equal(color_of(found)["pixels"].texels, PIXELS[::-1, ::-1])
    (told,) = [text for text in found.warnings if "EXIF" in text]
    assert told.startswith("/images/0: turned upright")


def test_webp_files_beside_the_scene_are_read(tmp_path):
    from alight.formats import load

    Image.fromarray(PIXELS).save(tmp_path / "a.webp", lossless=True)
    m = textured(extensions={WEBP: {"source": 0}})
    m.json["images"][0] = {"uri": "a.webp"}
    (tmp_path / "a.gltf").write_bytes(m.gltf())
    assert load(tmp_path / "a.gltf").source.held


def test_png_beside_webp_is_preferred_and_told():
    m = textured(source=1, extensions={WEBP: {"source": 0}})
    file = io.BytesIO()
    Image.fromarray(255 - PIXELS).save(file, "PNG")
    m.json["images"].append({"bufferView": m.view(file.getvalue()), "mimeType": "image/png"})
    found = parsed(m)
    np.testing.assert_array_equal(color_of(found)["pixels"].texels, 255 - PIXELS)
    assert f"{WEBP}: the PNG or JPEG beside it is used" in found.notes


@pytest.mark.parametrize("required", [False, True])
def test_pictures_that_are_not_read_name_a_way_out(required):
    m = textured(extensions={"KHR_texture_basisu": {"source": 0}})
    m.json["extensionsUsed"] = ["KHR_texture_basisu"]
    if required:
        m.json["extensionsRequired"] = ["KHR_texture_basisu"]
    with pytest.raises(SceneError, match="ktx extract --transcode rgba8"):
        found = parse(m.gltf(), "a.gltf")
        raise SceneError(found.issues)


def test_views_with_a_copy_that_is_not_compressed_are_read():
    m = Maker()
    m.node(mesh=m.square())
    for view in m.json["bufferViews"]:
        view["extensions"] = {"EXT_meshopt_compression": {"buffer": 1, "byteLength": 9}}
    m.json["extensionsUsed"] = ["EXT_meshopt_compression"]
    found = parsed(m)
    np.testing.assert_array_equal(found.data["nodes"]["node 0"]["shape"].vertices, POINTS)
    assert "EXT_meshopt_compression: the file holds the same data without it" in found.notes
    document = json.loads(m.gltf())
    document["bufferViews"][0]["buffer"] = 1
    document["buffers"].append({"byteLength": 48})
    with pytest.raises(SceneError, match="gltfpack -i IN -o OUT without -c"):
        parse(json.dumps(document).encode(), "a.gltf")
