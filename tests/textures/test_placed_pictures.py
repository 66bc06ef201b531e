"""Pictures stand as their files say: upright, and in their display windows."""

import io

import numpy as np
import pytest
from PIL import Image as Pillow

from alight.outputs.texels import ORIENTATION, decode_texels, read_texels
from alight.scene.images import read_image

OpenEXR = pytest.importorskip("OpenEXR")

#: Where the first row and the first column of a file are seen (CIPA DC-008, table of tag 274).
SIDES = {
    1: ("top", "left"), 2: ("top", "right"), 3: ("bottom", "right"), 4: ("bottom", "left"),
    5: ("left", "top"), 6: ("right", "top"), 7: ("right", "bottom"), 8: ("left", "bottom"),
}  # fmt: skip
KINDS = {
    "jpg": {"quality": 100, "subsampling": 0},
    "png": {},
    "webp": {"lossless": True},
    "tif": {},
}
UPRIGHT = np.random.default_rng(2).integers(0, 8, (3, 2, 3), np.uint8)
#: Blocks, which JPEG files keep nearly as they are.
UPRIGHT = (32 * UPRIGHT).repeat(16, axis=0).repeat(16, axis=1)


def stored(upright, orientation):
    """The pixels of a file of which that is the picture."""
    height, width = upright.shape[:2]
    first_row, first_column = SIDES[orientation]
    down = {"top": lambda i: i, "bottom": lambda i: height - 1 - i}
    across = {"left": lambda i: i, "right": lambda i: width - 1 - i}
    if first_row in down:
        return np.array([
            [upright[down[first_row](r), across[first_column](c)] for c in range(width)]
            for r in range(height)
        ])  # fmt: skip
    return np.array([
        [upright[down[first_column](c), across[first_row](r)] for c in range(height)]
        for r in range(width)
    ])  # fmt: skip


def encoded(orientation, kind):
    exif = Pillow.Exif()
    exif[ORIENTATION] = orientation
    file = io.BytesIO()
    kinds = {"jpg": "JPEG", "tif": "TIFF"}
    image = Pillow.fromarray(stored(UPRIGHT, orientation))
    image.save(file, kinds.get(kind, kind.upper()), exif=exif, **KINDS[kind])
    return file.getvalue()


@pytest.mark.parametrize("orientation", SIDES)
@pytest.mark.parametrize("kind", KINDS)
def test_photos_stand_upright_and_it_is_told(tmp_path, kind, orientation):
    path, notes = tmp_path / f"a.{kind}", []
    path.write_bytes(encoded(orientation, kind))
    image = read_image(path, path.name, notes.append)
    np.testing.assert_allclose(image.texels, UPRIGHT, atol=3 if kind == "jpg" else 0)
    # Pillow turns TIFF files by itself.
    told = [f'"a.{kind}": turned upright, as its EXIF orientation says ({orientation})']
    assert notes == (told if orientation > 1 and kind != "tif" else [])


@pytest.mark.parametrize("orientation", SIDES)
@pytest.mark.parametrize("bits", [8, 16])
def test_grey_tiffs_of_plain_rows_stand_upright(tmp_path, bits, orientation):
    # Pillow maps such files into memory where it is given their names.
    upright = UPRIGHT[..., 0].astype(f"u{bits // 8}") << (bits - 8)
    exif = Pillow.Exif()
    exif[ORIENTATION] = orientation
    Pillow.fromarray(stored(upright, orientation)).save(tmp_path / "a.tif", exif=exif)
    assert np.array_equal(read_texels(tmp_path / "a.tif", lambda w, h: None), upright)


@pytest.mark.parametrize("kind", ["jpg", "png", "webp"])
def test_pictures_in_other_files_stand_upright_too(kind):
    texels = decode_texels(encoded(6, kind), lambda width, height: None)
    np.testing.assert_allclose(texels, UPRIGHT, atol=3 if kind == "jpg" else 0)


@pytest.mark.parametrize("orientation", [0, 9, 65535])
def test_an_orientation_that_is_none_changes_nothing(tmp_path, orientation):
    exif = Pillow.Exif()
    exif[ORIENTATION] = orientation
    Pillow.fromarray(UPRIGHT).save(tmp_path / "a.png", exif=exif)
    assert np.array_equal(read_texels(tmp_path / "a.png", lambda w, h: None), UPRIGHT)


@pytest.mark.parametrize("exif", [b"Exif\x00\x00II*\x00\xff\xff\xff\xff", b"nonsense", b""])
def test_broken_notes_of_a_camera_do_not_spoil_a_picture(tmp_path, exif):
    Pillow.fromarray(UPRIGHT).save(tmp_path / "a.png", exif=exif)
    assert np.array_equal(read_texels(tmp_path / "a.png", lambda w, h: None), UPRIGHT)


WINDOWS = {
    "crop": ((2, 1), (7, 6)),
    "overscan": ((-2, -3), (7, 6)),
    "beside": ((3, -1), (7, 6)),
    "moved": ((0, 0), (5, 4)),
}


@pytest.mark.parametrize("window", WINDOWS)
@pytest.mark.parametrize("origin", [(0, 0), (-4, 5)])
def test_pixels_lie_where_the_display_window_has_them(tmp_path, window, origin):
    """And where a file has none there is no light."""
    (x, y), (width, height) = WINDOWS[window]
    pixels = np.random.default_rng(3).random((4, 5, 3), np.float32) + np.float32(0.5)
    low = (x + origin[0], y + origin[1])
    header = {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        "dataWindow": (low, (low[0] + 4, low[1] + 3)),
        "displayWindow": (origin, (origin[0] + width - 1, origin[1] + height - 1)),
    }
    path, notes = tmp_path / "a.exr", []
    with OpenEXR.File(header, {"RGB": pixels}) as file:
        file.write(str(path))
    texels = read_image(path, "a.exr", notes.append).texels
    assert texels.shape == (height, width, 3)
    for row in range(height):
        for column in range(width):
            inside = 0 <= row - y < 4 and 0 <= column - x < 5
            expected = pixels[row - y, column - x] if inside else 0.0
            np.testing.assert_array_equal(texels[row, column], expected)
    told = [f'"a.exr": its 5x4 pixels were placed in its display window of 7x6, at {x},{y}']
    assert notes == (told if window != "moved" else [])


def test_a_file_without_a_pixel_in_its_display_window_is_refused(tmp_path):
    header = {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        "dataWindow": ((8, 0), (9, 1)),
        "displayWindow": ((0, 0), (7, 7)),
    }
    with OpenEXR.File(header, {"RGB": np.ones((2, 2, 3), np.float32)}) as file:
        file.write(str(tmp_path / "a.exr"))
    with pytest.raises(ValueError, match="has no pixel in its display window"):
        read_texels(tmp_path / "a.exr", lambda w, h: None)
