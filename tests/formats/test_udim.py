"""Sets of tiles are one picture, in every format that names them; right at the edges of tiles."""

import importlib.util
import re

import numpy as np
import pytest
from PIL import Image as Picture

import alight
from alight.core.srgb import decode_srgb
from alight.formats.materials.udim import _together, find_tiles, lay_out
from alight.formats.reading.reach import OutOfReachError, Reach
from alight.formats.reading.report import Report
from alight.textures import bitmap as model
from alight.textures.images import Image
from tests.formats import bare

#: Number of a tile -> its colour.
COLORS = {1001: (255, 0, 0), 1002: (0, 255, 0), 1011: (0, 0, 255), 1013: (255, 255, 0)}


@pytest.fixture
def folder(tmp_path):
    """A folder with tiles of 4 x 4 texels, one of them of 2 x 2."""
    for number, color in COLORS.items():
        side = 2 if number == 1002 else 4
        texels = np.tile(np.array(color, np.uint8), (side, side, 1))
        # The lowest row is darker, to tell up from down.
        texels[-side // 4 or -1 :] //= 2
        Picture.fromarray(texels).save(tmp_path / f"t.{number}.png")
    return tmp_path


def laid_out(folder, **more):
    reach = Reach(folder)
    data = {"type": "bitmap", "file": find_tiles("t.<UDIM>.png", reach), **more}
    lay_out(data, reach, Report())
    return data


def texel_at(data, u, v):
    """The nearest texel that a bitmap shows."""
    spec = model.Bitmap(**data)
    s, t = spec.to_uv.matrix @ [u, v, 1.0]
    texels = spec.pixels.texels
    rows, columns = texels.shape[:2]
    x = int(np.clip(np.floor(s * columns), 0, columns - 1))
    y = int(np.clip(np.floor((1.0 - t) * rows), 0, rows - 1))
    return tuple(texels[y, x].tolist())


@pytest.mark.parametrize("number", COLORS)
def test_tiles_lie_where_their_numbers_say(number, folder):
    data = laid_out(folder)
    column, row = (number - 1001) % 10, (number - 1001) // 10
    edge = 1e-3
    for u in (edge, 0.5, 1.0 - edge):
        assert texel_at(data, column + u, row + 1.0 - edge) == COLORS[number]
        dark = tuple(c // 2 for c in COLORS[number])
        assert texel_at(data, column + u, row + edge) == dark


def test_squares_without_a_tile_show_the_border_of_the_nearest(folder):
    data = laid_out(folder)
    # 1003 is missing: 1002 lies to its left.
    assert texel_at(data, 2.5, 0.9) == COLORS[1002]
    # 1012, too: 1002 lies below it, and 1011 as near to its left.
    assert texel_at(data, 1.5, 1.9) == COLORS[1002]
    assert data["wrap"] == "clamp"


@pytest.mark.parametrize("seed", range(8))
def test_every_texel_is_the_nearest_tile_s_at_clamped_coordinates(seed, tmp_path):
    """Sets with gaps on all sides; of two tiles as near, that of the lower number."""
    rng = np.random.default_rng(seed)
    places = [divmod(int(k), 4)[::-1] for k in rng.choice(16, 4, replace=False)]
    tiles = {place: rng.integers(0, 256, (3, 5, 3), np.uint8) for place in places}
    for (column, row), texels in tiles.items():
        Picture.fromarray(texels).save(tmp_path / f"t.{1001 + column + 10 * row}.png")
    data = laid_out(tmp_path)
    low, high = np.min(places, axis=0), np.max(places, axis=0)
    # Centres of texels, upwards from the lower left corner of the lowest and leftmost tile.
    u = low[0] + (np.arange(5 * (high[0] - low[0] + 1)) + 0.5) / 5
    v = low[1] + (np.arange(3 * (high[1] - low[1] + 1)) + 0.5) / 3
    expected = np.zeros((v.size, u.size, 3), np.uint8)
    for y, x in np.ndindex(v.size, u.size):
        square = np.floor([u[x], v[y]])
        c, r = min(places, key=lambda p: (np.sum((square - p) ** 2), p[1], p[0]))
        s, t = np.clip([(u[x] - c) * 5, (v[y] - r) * 3], 0, [4, 2]).astype(int)
        expected[y, x] = tiles[c, r][2 - t, s]
    np.testing.assert_array_equal(data["pixels"].texels, expected[::-1])
    assert [texel_at(data, x, v[0]) for x in u] == [tuple(row) for row in expected[0].tolist()]


def test_coordinates_are_moved_first(folder):
    data = laid_out(folder, to_uv=[{"scale": 2.0}], wrap="repeat", wrap_v="mirror")
    assert texel_at(data, 0.75, 0.45) == COLORS[1002]
    assert texel_at(data, 0.25, 0.95) == COLORS[1011]


def test_tiles_of_other_depths_and_with_opacity(folder):
    with_alpha = np.full((4, 4, 4), 200, np.uint8)
    Picture.fromarray(with_alpha).save(folder / "t.1003.png")
    spec = model.Bitmap(**laid_out(folder))
    assert set(np.unique(spec.pixels.alpha)) == {200, 255}
    np.save(folder / "f.1001.npy", np.full((2, 2, 3), 4.0, np.float32))
    reach = Reach(folder)
    data = {"type": "bitmap", "file": find_tiles("f.<UDIM>.npy", reach)}
    lay_out(data, reach, Report())
    assert data["pixels"].texels.max() == 4.0


def test_sets_that_are_too_large_are_made_smaller(folder, monkeypatch):
    monkeypatch.setattr("alight.formats.materials.udim.MOST_TEXELS", 6 * 4)
    reach, report = Reach(folder), Report()
    data = {"type": "bitmap", "file": find_tiles("t.<UDIM>.png", reach)}
    lay_out(data, reach, report)
    assert (data["pixels"].width, data["pixels"].height) == (6, 4)
    assert any("2 times smaller" in line for line in report.warnings)
    assert texel_at(data, 1.5, 0.9) == COLORS[1002]


def _set_of(folder, **more):
    data = {"type": "bitmap", "file": find_tiles("m.<UDIM>.png", Reach(folder)), **more}
    lay_out(data, Reach(folder), Report())
    return data


@pytest.mark.parametrize("space", ["auto", "linear", "srgb"])
def test_tiles_of_8_and_of_16_bits_show_what_each_shows_by_itself(space, tmp_path):
    Picture.fromarray(np.full((2, 2), 100, np.uint8)).save(tmp_path / "m.1001.png")
    Picture.fromarray(np.full((2, 2), 30000, np.uint16)).save(tmp_path / "m.1002.png")
    data = _set_of(tmp_path, color_space=space)
    shown = data["pixels"].linear(data["color_space"])[0, [0, 2], 0]
    meant = np.array([100 / 255, 30000 / 65535])
    meant = meant if space == "linear" else decode_srgb(meant)
    np.testing.assert_allclose(shown, meant, rtol=1e-5)


@pytest.mark.parametrize("space", ["linear", "srgb"])
def test_tiles_of_whole_numbers_and_of_floats_are_decoded_as_said(space):
    images = [Image(np.full((1, 1, 1), 51, np.uint8)), Image(np.full((1, 1, 1), 0.2, np.float32))]
    both = _together(images, space)
    np.testing.assert_allclose(both[0], both[1], rtol=1e-6)
    assert both[0][0, 0, 0] == pytest.approx(0.2 if space == "linear" else decode_srgb(0.2))


@pytest.mark.parametrize("space", ["linear", "srgb"])
def test_sets_that_are_made_smaller_keep_their_mean(space, tmp_path, monkeypatch):
    texels = np.array([[0, 255], [255, 255]], np.uint8)
    Picture.fromarray(texels).save(tmp_path / "m.1001.png")
    monkeypatch.setattr("alight.formats.materials.udim.MOST_TEXELS", 1)
    data = _set_of(tmp_path, color_space=space)
    found = data["pixels"].linear(data["color_space"])
    assert found[0, 0, 0] == pytest.approx(0.75, abs=0.004)
    # The nearest of 256 levels.
    assert data["pixels"].texels[0, 0, 0] == (191 if space == "linear" else 225)


def test_sets_without_a_tile_or_out_of_reach(folder):
    with pytest.raises(OutOfReachError, match=r"no tile, such as .*u\.1001\.png"):
        find_tiles("u.<UDIM>.png", Reach(folder))
    with pytest.raises(OutOfReachError, match="leads out of"):
        find_tiles("../t.<UDIM>.png", Reach(folder))
    (folder / "t.1001.png").write_bytes(b"broken")
    with pytest.raises(OutOfReachError, match=r"t\.1001\.png"):
        find_tiles("t.<UDIM>.png", Reach(folder))


def test_tiles_that_are_links_stay_within_reach(folder, tmp_path_factory):
    elsewhere = tmp_path_factory.mktemp("elsewhere") / "x.png"
    (folder / "t.1001.png").rename(elsewhere)
    try:
        (folder / "t.1001.png").symlink_to(elsewhere)
    except OSError:
        pytest.skip("needs symbolic links")
    said = ""
    try:
        find_tiles("t.<UDIM>.png", Reach(folder))
    except OutOfReachError as error:
        said = str(error)
    assert re.search(r"leads out of .*t\.1001\.png.*, by a link", said)
    assert find_tiles("t.<UDIM>.png", Reach(folder, folder.parent.parent))


OBJ = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 2 0\nvt 0 2\nusemtl m\nf 1/1 2/2 3/3\n"
USD = """#usda 1.0
def Mesh "wall" (prepend apiSchemas = ["MaterialBindingAPI"])
{
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
    point3f[] points = [(0, 0, 0), (2, 0, 0), (2, 1, 0)]
    texCoord2f[] primvars:st = [(0, 0), (2, 0), (0, 2)] (interpolation = "vertex")
    rel material:binding = </m>
}
def Material "m"
{
    token outputs:surface.connect = </m/s.outputs:surface>
    def Shader "s"
    {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = </m/p.outputs:rgb>
        token outputs:surface
    }
    def Shader "p"
    {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @t.<UDIM>.png@
        float3 outputs:rgb
    }
}
"""
MTLX = """<materialx version="1.38"><standard_surface name="S" type="surfaceshader">
<input name="base_color" type="color3" nodename="p"/></standard_surface>
<image name="p" type="color3"><input name="file" type="filename" value="t.&lt;UDIM&gt;.png"
colorspace="srgb_texture"/></image></materialx>"""


@pytest.mark.parametrize("name", ["a.obj", "a.usda", "a.mtlx"])
def test_every_format_reads_them(name, folder):
    if name == "a.usda" and importlib.util.find_spec("pxr") is None:
        pytest.skip("needs usd-core")
    (folder / "a.mtl").write_text("newmtl m\nKd 1 1 1\nmap_Kd t.<UDIM>.png\n")
    (folder / name).write_text({"a.obj": OBJ, "a.usda": USD, "a.mtlx": MTLX}[name])
    scene = bare.load(folder / name)
    (bsdf,) = scene.bsdfs.values()
    texture = bsdf.bsdf.base_color
    assert (texture.pixels.width, texture.pixels.height) == (12, 8)
    np.testing.assert_allclose(texture.to_uv.matrix, [[1 / 3, 0, 0], [0, 1 / 2, 0]])
    for tile in COLORS:
        (folder / f"t.{tile}.png").unlink()
    with pytest.raises(alight.SceneError, match=r"t\.<UDIM>\.png"):
        bare.load(folder / name)
