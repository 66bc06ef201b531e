"""Pictures from files: every format, in scenes, saved, hashed; and files that are broken."""

import io
import os
import struct
import sys
import threading
import zlib
from types import ModuleType

import numpy as np
import pytest
from PIL import Image as Pillow

from alight.compiled.materials import compile_materials
from alight.compiled.scene import compile_scene
from alight.compiled.textures import pack_bytes
from alight.core.errors import SceneError
from alight.films import fixed_point
from alight.formats import dumps, load, loads, save
from alight.integrators.walk import make_settings
from alight.outputs import write_image
from alight.outputs.png import encode_png
from alight.outputs.texels import KEPT_BLOCKS, STRIP, decode_texels, reusing_memory
from alight.rendering.tiles.tile import make_kernels, render_tile
from alight.rendering.tiles.tile_kernel import Tile
from alight.scene import content_hash, flatten
from alight.scene.files import Files
from alight.scene.images import loaded, read_image
from alight.textures.bitmap import Bitmap

RNG = np.random.default_rng(7)
SMALL = RNG.integers(0, 256, (9, 13, 3)).astype(np.uint8)
WIDE = RNG.integers(0, 65536, (9, 13, 3)).astype(np.uint16)
LINEAR = RNG.random((9, 13, 3)).astype(np.float32)

SCENE = """alight: 1
camera: {type: orthographic, height: 2, transform: {translate: [0, 0, 3]}}
environment: constant
integrator: {type: path, max_depth: 2, light_sampling: bsdf}
film: {size: [2, 2]}
textures:
  picture: {type: bitmap, file: pictures/a.png, interpolation: nearest}
nodes:
  wall: {shape: rectangle, bsdf: {type: diffuse, reflectance: picture}}
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "pictures").mkdir()
    (tmp_path / "scene.yaml").write_text(SCENE)
    colours = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [255, 255, 255]]], np.uint8)
    Pillow.fromarray(colours).save(tmp_path / "pictures" / "a.png")
    return tmp_path


# ---------------------------------------------------------------- formats


@pytest.mark.parametrize(
    ("mode", "expected"),
    [
        ("RGB", SMALL), ("RGBA", SMALL), ("L", SMALL[..., :1]), ("LA", SMALL[..., :1]),
        ("1", np.uint8(255) * (SMALL[..., :1] > 99)), ("P", SMALL & 0xC0), ("I;16", WIDE[..., :1]),
    ],
)  # fmt: skip
def test_png_of_every_kind(mode, expected, tmp_path):
    grey = SMALL[..., 0]
    made = {
        "RGB": lambda: Pillow.fromarray(SMALL),
        "RGBA": lambda: Pillow.fromarray(np.dstack([SMALL, grey])),
        "L": lambda: Pillow.fromarray(grey),
        "LA": lambda: Pillow.fromarray(np.dstack([grey, grey])),
        "1": lambda: Pillow.fromarray(grey > 99),
        "P": lambda: Pillow.fromarray(SMALL & 0xC0).quantize(64),
        "I;16": lambda: Pillow.fromarray(WIDE[..., 0]),
    }[mode]()
    made.save(tmp_path / "a.png")
    found = read_image(tmp_path / "a.png").texels
    np.testing.assert_array_equal(found, expected)
    assert found.dtype == expected.dtype


def test_all_16_bits_of_colour_are_read(tmp_path):
    """Pillow alone keeps 8 of them."""
    (tmp_path / "a.png").write_bytes(encode_png(WIDE / 65535.0, bits=16))
    np.testing.assert_array_equal(read_image(tmp_path / "a.png").texels, WIDE)


def test_all_16_bits_of_grey_and_alpha_are_read(tmp_path):
    """Rows are written as they are, as differences to the left and to the row above."""
    whole = np.random.default_rng(3).integers(0, 2**16, (6, 5, 2), np.uint16)
    rows = whole.astype(">u2").view(np.uint8).reshape(6, -1)
    left, above = np.zeros_like(rows), np.zeros_like(rows)
    left[:, 4:], above[1:] = rows[:, :-4], rows[:-1]
    filtered = [[rows, rows - left, rows - above][i % 3][i] for i in range(6)]
    data = b"".join(bytes([i % 3]) + row.tobytes() for i, row in enumerate(filtered))

    def chunk(name, content):
        return (
            struct.pack(">I", len(content))
            + name
            + content
            + struct.pack(">I", zlib.crc32(name + content))
        )

    header = chunk(b"IHDR", struct.pack(">IIBBBBB", 5, 6, 16, 4, 0, 0, 0))
    parts = header + chunk(b"IDAT", zlib.compress(data)) + chunk(b"IEND", b"")
    (tmp_path / "a.png").write_bytes(b"\x89PNG\r\n\x1a\n" + parts)
    found = read_image(tmp_path / "a.png")
    np.testing.assert_array_equal(found.texels[..., 0], whole[..., 0])
    np.testing.assert_array_equal(found.alpha, whole[..., 1])


@pytest.mark.parametrize("name", ["a.exr", "a.hdr", "a.pfm", "a.npy"])
def test_linear_formats(name, tmp_path):
    write_image(tmp_path / name, LINEAR)
    found = read_image(tmp_path / name).texels
    # Radiance files keep 8 bits of the largest channel.
    np.testing.assert_allclose(found, LINEAR, atol=1 / 256 if name == "a.hdr" else 0.0)


def test_jpeg(tmp_path):
    smooth = np.broadcast_to(np.arange(0, 208, 16, dtype=np.uint8)[None, :, None], SMALL.shape)
    Pillow.fromarray(np.ascontiguousarray(smooth)).save(tmp_path / "a.jpg", quality=95)
    assert np.abs(read_image(tmp_path / "a.jpg").texels.astype(int) - smooth).max() <= 3


@pytest.mark.parametrize("name", ["a.bmp", "a.tga", "a.tif"])
def test_other_pictures_of_whole_numbers(name, tmp_path):
    Pillow.fromarray(SMALL).save(tmp_path / name)
    np.testing.assert_array_equal(read_image(tmp_path / name).texels, SMALL)
    if name == "a.bmp":
        return
    both = np.dstack([SMALL, SMALL[..., 0]])
    Pillow.fromarray(both).save(tmp_path / name)
    found = read_image(tmp_path / name)
    np.testing.assert_array_equal(found.texels, SMALL)
    np.testing.assert_array_equal(found.alpha, SMALL[..., 0])


def test_floats_in_tiff_files_are_refused(tmp_path):
    Pillow.fromarray(LINEAR[..., 0].astype(np.float32)).save(tmp_path / "a.tif")
    with pytest.raises(SceneError, match="holds floats: EXR and PFM files may"):
        read_image(tmp_path / "a.tif")


def test_exr_with_half_floats_and_grey(tmp_path):
    import OpenEXR

    half = LINEAR.astype(np.float16)
    header = {"compression": OpenEXR.PIZ_COMPRESSION, "type": OpenEXR.scanlineimage}
    for name, channels in (
        (
            "rgb.exr",
            {c: half[..., i].copy() for i, c in enumerate("RGB")} | {"A": half[..., 0].copy()},
        ),
        ("grey.exr", {"Y": half[..., 0].copy()}),
    ):
        with OpenEXR.File(header, channels) as file:
            file.write(str(tmp_path / name))
    np.testing.assert_array_equal(read_image(tmp_path / "rgb.exr").texels, half)
    np.testing.assert_array_equal(read_image(tmp_path / "grey.exr").texels, half[..., :1])


def test_the_content_tells_the_format_not_the_name(tmp_path):
    Pillow.fromarray(SMALL).save(tmp_path / "a.jpg", "PNG")
    np.testing.assert_array_equal(read_image(tmp_path / "a.jpg").texels, SMALL)


# ---------------------------------------------------------------- broken files


def png_header(width, height):
    """A PNG file that promises more than it holds."""
    size = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunks = ((b"IHDR", size), (b"IDAT", zlib.compress(bytes(100))), (b"IEND", b""))
    parts = [
        struct.pack(">I", len(d)) + k + d + struct.pack(">I", zlib.crc32(k + d)) for k, d in chunks
    ]
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


HDR_HEADER = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n"
BROKEN = {
    "bomb.png": (png_header(60000, 60000), "has too many pixels"),
    "large.png": (png_header(8000, 9000), "at most 67108864 texels, got 8000 x 9000"),
    "short.png": (png_header(100, 100), "truncated"),
    "empty.png": (b"", "is not a PNG, JPEG, WebP, EXR, HDR, PFM, NPY, BMP, TGA or TIFF picture"),
    "text.png": (
        b"hello, world",
        "is not a PNG, JPEG, WebP, EXR, HDR, PFM, NPY, BMP, TGA or TIFF picture",
    ),
    "cut.exr": (b"\x76\x2f\x31\x01" + bytes(40), "broken OpenEXR file"),
    "huge.hdr": (HDR_HEADER + b"-Y 99999 +X 99999\n" + bytes(99), "got 99999 x 99999"),
    "short.hdr": (HDR_HEADER + b"-Y 50 +X 50\n" + bytes(999), "ends early"),
    "huge.pfm": (b"PF\n900000 900000\n-1.0\n", "got 900000 x 900000"),
    "nan.pfm": (b"Pf\n1 1\n-1.0\n" + np.float32(np.nan).tobytes(), "got nan in row 0, column 0"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_broken_pictures_are_refused_in_words(name, folder, capfd):
    content, message = BROKEN[name]
    (folder / name).write_bytes(content)
    text = SCENE.replace("pictures/a.png", name)
    with pytest.raises(SceneError) as caught:
        loads(text, "scene.yaml", folder)
    (issue,) = caught.value.issues
    assert issue.place == "scene.yaml:7:33" and issue.path == "textures.picture.file"
    assert f'"{name}"' in issue.message and message in issue.message
    assert "\n" not in issue.message and not capfd.readouterr().err


def test_files_that_are_not_there(folder):
    for name, message in (
        ("pictures/b.png", 'no such file: "pictures/b.png"; did you mean "a.png"?'),
        ("pictures", '"pictures": is not a file'),
    ):
        with pytest.raises(SceneError) as caught:
            loads(SCENE.replace("pictures/a.png", name), "scene.yaml", folder)
        assert message in str(caught.value)
    with pytest.raises(SceneError, match="is not a file"):
        load(folder / "scene.yaml", [f"textures.picture.file={os.devnull}"])


# ---------------------------------------------------------------- scenes


def test_pictures_stand_upright_on_a_rectangle(folder):
    """Under a sky of radiance 1, each pixel is the reflectance of a quarter of the wall."""
    scene = compile_scene(flatten(load(folder / "scene.yaml")), structure="list")
    kernels = make_kernels(scene, compiled=False)
    settings = make_settings(scene.integrator, seed=0, replicates=4)
    film, _ = render_tile(
        kernels, scene, settings, Tile(0, 0, 2, 2), np.array([[[0, 4]]], np.int64)
    )
    fixed_point.carry(film.sums)
    picture = fixed_point.to_float(film.sums).sum(axis=2) / film.counts.sum(axis=2)[..., None]
    expected = [[[1, 0, 0], [0, 1, 0]], [[0, 0, 1], [1, 1, 1]]]
    np.testing.assert_allclose(picture[..., :3], expected, atol=1e-5)


def test_files_are_relative_to_the_scene_and_read_once(folder, monkeypatch):
    scene = load(folder / "scene.yaml")
    monkeypatch.chdir(os.sep)
    (bsdf,) = flatten(scene).bsdfs
    assert bsdf.reflectance.file is None and bsdf.reflectance.pixels.width == 2
    files = Files(folder)
    texture = scene.textures["picture"]
    clamped = texture.replaced(wrap="clamp")
    assert loaded(texture, files).pixels is loaded(clamped, files).pixels


def test_content_hash_sees_the_picture_not_its_name(folder):
    first = content_hash(load(folder / "scene.yaml"))
    (folder / "pictures" / "a.png").rename(folder / "b.png")
    (folder / "other.yaml").write_text(SCENE.replace("pictures/a.png", "b.png"))
    assert content_hash(load(folder / "other.yaml")) == first
    Pillow.fromarray(SMALL[:2, :2]).save(folder / "b.png")
    assert content_hash(load(folder / "other.yaml")) != first


def test_saved_scenes_find_their_pictures(folder):
    scene = load(folder / "scene.yaml")
    inline = scene.replaced(textures={"picture": Bitmap(pixels=WIDE)}).from_source(scene.source)
    (folder / "deeper").mkdir()
    for original in (scene, inline):
        save(original, folder / "deeper" / "saved.yaml")
        again = load(folder / "deeper" / "saved.yaml")
        assert content_hash(again) == content_hash(original)
        assert loads(dumps(original), "scene.yaml", folder) == original
    assert len(list((folder / "deeper").glob("*.npy"))) == 1


def test_values_are_edited_by_their_path(folder):
    changes = ["textures.picture.wrap=clamp", "textures.picture.to_uv={scale: 2}"]
    texture = load(folder / "scene.yaml", changes).textures["picture"]
    assert texture.wrap == "clamp" and texture.to_uv.matrix[0, 0] == 2.0


def test_reflectances_above_1_are_refused_and_radiances_are_not(folder):
    bright = 0.5 + np.arange(4, dtype=np.float32).reshape(2, 2)
    np.save(folder / "bright.npy", bright)
    text = SCENE.replace("pictures/a.png", "bright.npy")
    with pytest.raises(SceneError) as caught:
        loads(text, "scene.yaml", folder)
    (issue,) = caught.value.issues
    assert issue.path == "nodes.wall.bsdf.reflectance"
    assert "must be in [0, 1] everywhere; the texture's largest value is 3.5" in issue.message
    wall = "{type: diffuse, reflectance: picture}"
    lamp = text.replace(f"bsdf: {wall}", "light: {type: area, radiance: picture}")
    (shape,) = flatten(loads(lamp, "scene.yaml", folder)).shapes
    assert shape.light.radiance.maximum() == (3.5, 3.5, 3.5)


def test_sums_of_reflectances_count_the_picture(folder):
    phong = "{type: phong, diffuse: picture, specular: 0.3}"
    with pytest.raises(SceneError, match="must be at most 1 in each channel, got"):
        loads(SCENE.replace("{type: diffuse, reflectance: picture}", phong), "scene.yaml", folder)


def test_exponents_can_be_pictures(folder):
    np.save(folder / "sharp.npy", np.array([[5.0, 500.0]]))
    phong = "{type: phong, exponent: {type: bitmap, file: sharp.npy}}"
    text = SCENE.replace("{type: diffuse, reflectance: picture}", phong)
    (bsdf,) = flatten(loads(text, "scene.yaml", folder)).bsdfs
    tables, _, names = compile_materials([bsdf])
    assert names == ("constant", "bitmap") and tables.texture.array[6] == 1


@pytest.mark.parametrize("mode", ["L", "LA", "RGB", "RGBA", "P", "1"])
def test_pictures_of_several_strips_are_whole(mode):
    pixels = np.random.default_rng(3).integers(0, 256, (2 * STRIP + 7, 5, 4), np.uint8)
    picture = Pillow.fromarray(pixels[..., : 4 if "A" in mode else 3]).convert(mode)
    file = io.BytesIO()
    picture.save(file, "PNG")
    wanted = {"P": "RGB", "1": "L"}.get(mode, mode)
    found = decode_texels(file.getvalue(), lambda width, height: None)
    np.testing.assert_array_equal(found, np.asarray(picture.convert(wanted)))


@pytest.mark.parametrize("shape", [(1, 1, 3), (1, 1, 1), (3, 5, 3), (4, 2, 1)])
def test_packed_texels_have_red_in_their_lowest_byte(shape):
    texels = np.random.default_rng(4).integers(0, 256, shape, np.uint8)
    words = np.full(shape[0] * shape[1], 0xFFFFFFFF, np.uint32)
    pack_bytes(texels, words)
    red, green, blue = np.broadcast_to(texels, (*shape[:2], 3)).reshape(-1, 3).T.astype(np.uint32)
    np.testing.assert_array_equal(words, red | green << 8 | blue << 16)


def test_memory_of_pictures_is_kept_only_while_more_are_read():
    file = io.BytesIO()
    Pillow.fromarray(SMALL).save(file, "PNG")

    def kept():
        decode_texels(file.getvalue(), lambda width, height: None)
        return Pillow.core.get_stats()["blocks_cached"]

    with reusing_memory():
        with reusing_memory():
            assert kept() > 0
        assert kept() > 0
    assert kept() == 0
    # A picture that is broken ends it too.
    with pytest.raises(ValueError, match="broken"), reusing_memory():
        assert kept() > 0
        raise ValueError("broken")
    assert kept() == 0


def test_memory_is_given_back_while_another_thread_imports_pillow(monkeypatch):
    # What stands in sys.modules until the import is done.
    monkeypatch.setitem(sys.modules, "PIL.Image", ModuleType("PIL.Image"))
    with reusing_memory():
        pass


def test_memory_is_kept_for_a_thread_that_begins_while_another_ends(monkeypatch):
    file, found, ended = io.BytesIO(), [], threading.Event()
    Pillow.fromarray(SMALL).save(file, "PNG")

    def decode():
        decode_texels(file.getvalue(), lambda width, height: None)

    def second():
        with reusing_memory():
            decode()
            ended.wait()
            found.append(Pillow.core.blocks)

    class Core:
        """Pillow's; the other thread begins where this one lets go."""

        blocks, real, thread = 0, Pillow.core, threading.Thread(target=second)

        def __getattr__(self, name):
            return getattr(self.real, name)

        def set_blocks_max(self, count):
            if count == 0 and self.thread.ident is None:
                self.thread.start()
                self.thread.join(0.05)
            self.blocks = count

    monkeypatch.setattr(Pillow, "core", Core())
    with reusing_memory():
        decode()
    ended.set()
    Core.thread.join()
    assert found == [KEPT_BLOCKS]
    assert Pillow.core.blocks == 0
