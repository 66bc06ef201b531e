"""Numbers of coloured pictures are pbrt's: its own reading of texels, written down once more."""

import numpy as np
import pytest
from PIL import Image

from alight.scene.images import loaded
from tests.formats.pbrt.reading import node, read, read_old

#: Modes of PNG files, and whether all of their texels are opaque.
KINDS = {"L": True, "LA": False, "RGB": True, "RGBA": False, "RGBA opaque": True}

WEIGHTS = (0.212671, 0.715160, 0.072169)


def decoded(byte, encoding):
    """What pbrt makes of one byte: the curve of sRGB, or none."""
    x = byte / 255.0
    if encoding == "linear":
        return x
    return x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4


def number_in_pbrt_4(texel, kind, encoding, is_opaque):
    """Of one texel: one channel as it is, opacity where there is any, and else the mean."""
    channels = [decoded(byte, encoding) for byte in texel]
    if len(channels) < 3:
        return channels[0]
    if kind == "point":
        return channels[0]
    return sum(channels[:3]) / 3.0 if is_opaque else channels[3]


def number_in_pbrt_3(texel, encoding):
    """The luminance of what the file holds, decoded."""
    if len(texel) < 3:
        return decoded(texel[0], encoding)
    return decoded(sum(w * byte for w, byte in zip(WEIGHTS, texel[:3], strict=True)), encoding)


def picture_in(folder, kind):
    """Random texels as bytes (h, w, channels), and a file that holds them."""
    mode, is_opaque = kind.split()[0], KINDS[kind]
    texels = np.random.default_rng(131).integers(0, 256, (3, 2, len(mode)), np.uint8)
    if mode == "RGBA" and is_opaque:
        texels[..., 3] = 255
    Image.fromarray(texels[..., 0] if mode == "L" else texels, mode).save(folder / "p.png")
    return texels


def numbers_of(scene):
    """What the texture `t` of one number shows at its texels."""
    texture = loaded(scene.textures["t"], scene.source.files())
    texels = texture.pixels.linear(texture.color_space)
    return texels @ np.array(WEIGHTS) if texels.shape[2] == 3 else texels[..., 0]


@pytest.mark.parametrize("encoding", ["sRGB", "linear"])
@pytest.mark.parametrize("kind", KINDS)
def test_numbers_of_pictures_are_those_of_pbrt(kind, encoding, tmp_path):
    texels = picture_in(tmp_path, kind)
    head = '"string filename" "p.png"'
    shape = 'Shape "sphere" "texture alpha" "t"'
    for filtered in ("point", "bilinear", "trilinear"):
        options = f'"string filter" "{filtered}" "string encoding" "{encoding}"'
        scene = read(f'Texture "t" "float" "imagemap" {head} {options} {shape}', folder=tmp_path)
        expected = [
            [number_in_pbrt_4(texel, filtered, encoding, KINDS[kind]) for texel in row]
            for row in texels.tolist()
        ]
        np.testing.assert_allclose(numbers_of(scene), expected, rtol=2e-6)
    gamma = '"bool gamma" "false"' if encoding == "linear" else ""
    scene = read_old(f'Texture "t" "float" "imagemap" {head} {gamma} {shape}', folder=tmp_path)
    expected = [[number_in_pbrt_3(texel, encoding) for texel in row] for row in texels.tolist()]
    np.testing.assert_allclose(numbers_of(scene), expected, rtol=2e-6)


def test_files_other_than_png_and_exr_lose_their_opacity(tmp_path):
    texels = picture_in(tmp_path, "RGBA")
    Image.fromarray(texels, "RGBA").save(tmp_path / "p.tga")
    text = 'Texture "t" "float" "imagemap" "string filename" "p.tga"'
    scene = read(f'{text} Shape "sphere" "texture alpha" "t"', folder=tmp_path)
    expected = [[number_in_pbrt_4(t, "bilinear", "sRGB", True) for t in row] for row in texels]
    np.testing.assert_allclose(numbers_of(scene), expected, rtol=2e-6)


def test_colours_keep_their_file(tmp_path):
    picture_in(tmp_path, "RGBA")
    text = 'Texture "t" "spectrum" "imagemap" "string filename" "p.png"'
    shape = 'Material "diffuse" "texture reflectance" "t" Shape "sphere"'
    scene = read(f"{text} {shape}", folder=tmp_path)
    assert scene.textures["t"].file == "p.png"


def test_in_pbrt_3_only_an_alpha_of_nought_is_a_hole(tmp_path):
    assert node(read_old('Shape "sphere" "float alpha" 0.25')).bsdf == "default"
    Image.fromarray(np.array([[0, 1, 255]], np.uint8), "L").save(tmp_path / "p.png")
    text = 'Texture "t" "float" "imagemap" "string filename" "p.png"'
    scene = read_old(f'{text} Shape "sphere" "texture alpha" "t"', folder=tmp_path)
    opacity = node(scene).bsdf.opacity
    assert (opacity.type_name(), opacity.texture) == ("threshold", "t")
    assert 0.0 < opacity.cutoff < (1.0 / 255.0) / 12.92
    assert node(read_old('Shape "sphere" "float alpha" 0')).bsdf.opacity == 0.0
