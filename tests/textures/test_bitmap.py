"""Bitmaps: places of texels, interpolation, wrapping, decoding; Mitsuba's and closed forms."""

import numpy as np
import pytest

from alight.bsdfs.matte.diffuse import Diffuse
from alight.bsdfs.plastics.phong import Phong
from alight.compiled.materials import compile_materials
from alight.compiled.program import Program
from alight.core.errors import SceneError
from alight.core.srgb import decode_srgb
from alight.textures import bitmap, checkerboard, constant
from alight.textures.bitmap import Bitmap
from alight.textures.checkerboard import Checkerboard
from alight.textures.fetch import color, texture_value, textured_scalar
from alight.textures.images import Image, as_image
from alight.textures.uv import UvTransform
from lanewise.jit import instantiate, kernel
from lanewise.simd import LANES, load_lanes, store_lanes
from lanewise.view import View
from tests.textures.lookup import Surface, look_up, scene_of

WRAPS = ("repeat", "mirror", "clamp")
WAYS = ("bilinear", "nearest")

#: 3 rows of 4 texels, 1/16 to 12/16.
RAMP = np.arange(1, 13, dtype=np.float32).reshape(3, 4) / 16

# What Mitsuba 3.9.1's `bitmap` (raw, format variant) gives for RAMP, its v being 1 - v here.
POINTS = np.array(
    [(0.125, 5 / 6), (0.5, 0.5), (0.02, 0.97), (0.9, 0.1), (-0.3, 1.4), (2.6, -1.7), (1.0, 0.001)]
)
MITSUBA = {
    ("repeat", "bilinear"): [0.0625, 0.40625, 0.34625, 0.63125, 0.53125, 0.58125, 0.40775],
    ("repeat", "nearest"): [0.0625, 0.4375, 0.0625, 0.75, 0.4375, 0.6875, 0.5625],
    ("mirror", "bilinear"): [0.0625, 0.40625, 0.0625, 0.75, 0.28125, 0.58125, 0.75],
    ("mirror", "nearest"): [0.0625, 0.4375, 0.0625, 0.75, 0.375, 0.6875, 0.75],
    ("clamp", "bilinear"): [0.0625, 0.40625, 0.0625, 0.75, 0.0625, 0.75, 0.75],
    ("clamp", "nearest"): [0.0625, 0.4375, 0.0625, 0.75, 0.0625, 0.75, 0.75],
}
#: With to_uv F M F, F turning v over, for M below.
MATRIX = [[2.0, 0.5, 0.25], [-0.3, 0.8, 0.1]]
MITSUBA_MATRIX = [0.296875, 0.51875, 0.28, 0.19625, 0.51125, 0.37125, 0.118275]


@pytest.mark.parametrize(("wrap", "interpolation"), MITSUBA)
def test_lookups_are_those_of_mitsuba(wrap, interpolation):
    texture = Bitmap(pixels=RAMP, wrap=wrap, interpolation=interpolation)
    found = look_up(texture, *POINTS.T)[:, 0]
    np.testing.assert_allclose(found, MITSUBA[wrap, interpolation], atol=2e-6)


def test_transforms_are_those_of_mitsuba():
    texture = Bitmap(pixels=RAMP, to_uv={"matrix": MATRIX})
    np.testing.assert_allclose(look_up(texture, *POINTS.T)[:, 0], MITSUBA_MATRIX, atol=2e-6)


@pytest.mark.parametrize("wrap", WRAPS)
@pytest.mark.parametrize("interpolation", WAYS)
def test_centres_show_their_texels_exactly(wrap, interpolation):
    """The first row is at the top, that is at the largest v."""
    pixels = np.random.default_rng(2).random((8, 4, 3)).astype(np.float32)
    y, x = np.mgrid[:8, :4]
    u, v = (x + 0.5) / 4, 1 - (y + 0.5) / 8
    found = look_up(
        Bitmap(pixels=pixels, wrap=wrap, interpolation=interpolation), u.ravel(), v.ravel()
    )
    np.testing.assert_array_equal(found, pixels.reshape(-1, 3))


@pytest.mark.parametrize("color_space", ["linear", "srgb"])
@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("whole", [np.uint8, np.uint16])
def test_how_a_picture_is_kept_does_not_change_it(whole, channels, color_space):
    """Bytes by a table, 16 bits and floats by themselves: the same colours, between texels too."""
    rng = np.random.default_rng(3)
    most = np.iinfo(whole).max
    pixels = rng.integers(0, most, (5, 7, channels), whole, endpoint=True)
    decoded = pixels / most if color_space == "linear" else decode_srgb(pixels / most)
    u, v = rng.uniform(-1.0, 2.0, (2, 500))
    for way in WAYS:
        kept, floats = (
            look_up(Bitmap(pixels=texels, color_space=space, interpolation=way), u, v)
            for texels, space in ((pixels, color_space), (decoded.astype(np.float32), "linear"))
        )
        np.testing.assert_allclose(kept, floats, atol=2e-6)


def wrapped(index, n, wrap):
    """Whole numbers -> columns, by the definition of each way to wrap."""
    if wrap == "repeat":
        return index % n
    if wrap == "clamp":
        return np.clip(index, 0, n - 1)
    twice = index % (2 * n)
    return np.where(twice < n, twice, 2 * n - 1 - twice)


@pytest.mark.parametrize("wrap", WRAPS)
def test_bilinear_is_the_formula_over_an_endless_picture(wrap):
    rng = np.random.default_rng(3)
    pixels = rng.random((3, 5))
    u, v = rng.uniform(-4.0, 4.0, (2, 4000))
    x, y = 5 * u - 0.5, 3 * (1.0 - v) - 0.5
    left, top = np.floor(x).astype(int), np.floor(y).astype(int)
    value = 0.0
    for i, j in ((0, 0), (0, 1), (1, 0), (1, 1)):
        texel = pixels[wrapped(top + j, 3, wrap), wrapped(left + i, 5, wrap)]
        weight = np.abs(1 - i - (x - left)) * np.abs(1 - j - (y - top))
        value = value + texel * weight
    np.testing.assert_allclose(
        look_up(Bitmap(pixels=pixels, wrap=wrap), u, v)[:, 0], value, atol=1e-5
    )


def test_far_from_the_picture_it_is_as_sharp_as_float32_allows():
    """The fraction is taken first: whole numbers added to (u, v) only round it."""
    u = np.arange(0, 1, 2.0**-8, dtype=np.float32)
    texture = Bitmap(pixels=np.random.default_rng(4).random((16, 64)))
    near = look_up(texture, u, 0.25 + u)
    np.testing.assert_array_equal(look_up(texture, u + 30000.0, 0.25 + u - 30000.0), near)


@pytest.mark.parametrize("wrap", WRAPS)
def test_no_coordinate_leads_outside_of_the_tables(wrap):
    bad = np.array([np.nan, np.inf, -np.inf, 1e30, -1e30, 3e38, 1e-45], np.float32)
    u, v = np.meshgrid(bad, bad)
    found = look_up(Bitmap(pixels=RAMP, wrap=wrap), u.ravel(), v.ravel())
    finite = np.isfinite(found).all(axis=1)
    assert found[finite].min() >= 1 / 16 and found[finite].max() <= 12 / 16
    # What is no number is not hidden: the film counts it.
    assert not finite[np.isnan(u.ravel())].any()


# ---------------------------------------------------------------- decoding


def test_whole_numbers_are_srgb_unless_they_are_data():
    levels = np.arange(256, dtype=np.uint8).reshape(1, 256)
    u, v = (np.arange(256) + 0.5) / 256, np.full(256, 0.5)
    encoded = look_up(Bitmap(pixels=levels), u, v)[:, 0]
    plain = look_up(Bitmap(pixels=levels, color_space="linear"), u, v)[:, 0]
    # IEC 61966-2-1: a straight piece below 0.04045, a power of 2.4 above.
    x = np.arange(256) / 255
    curve = np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)
    np.testing.assert_allclose(encoded, curve, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(plain, x, rtol=1e-6)
    wide = look_up(Bitmap(pixels=levels.astype(np.uint16) * 257), u, v)[:, 0]
    np.testing.assert_allclose(wide, curve, rtol=1e-6, atol=1e-9)


def test_floats_are_linear_unless_they_are_said_to_be_srgb():
    assert look_up(Bitmap(pixels=[[0.5]]), 0.3, 0.3)[0, 0] == 0.5
    found = look_up(Bitmap(pixels=[[0.5]], color_space="srgb"), 0.3, 0.3)[0, 0]
    assert found == pytest.approx(float(decode_srgb(np.float64(0.5))), rel=1e-6)


def test_interpolation_follows_decoding():
    black_and_white = Bitmap(pixels=np.array([[0, 255]], np.uint8), wrap="clamp")
    assert look_up(black_and_white, 0.5, 0.5)[0, 0] == pytest.approx(0.5, abs=1e-6)


# ---------------------------------------------------------------- tables


@pytest.mark.parametrize("size", [(1, 1), (4, 4), (5, 7), (8, 3), (2, 70), (131, 6)])
@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("dtype", [np.uint8, np.float32])
def test_every_texel_is_found_in_its_tile(size, channels, dtype):
    random = np.random.default_rng(9).integers(0, 256, (*size, channels), np.uint8)
    pixels = random if dtype is np.uint8 else random.astype(np.float32) / 255
    texture = Bitmap(pixels=pixels, interpolation="nearest", color_space="linear")
    row, column = np.indices(size).reshape(2, -1)
    found = look_up(texture, (column + 0.5) / size[1], 1 - (row + 0.5) / size[0])
    expected = np.broadcast_to(random / 255, (*size, 3)).reshape(-1, 3)
    np.testing.assert_allclose(found, expected, rtol=1e-6)


def test_pictures_begin_at_cache_lines():
    pictures = [np.ones((3, 3 + i), np.float32) for i in range(3)]
    scene, _ = scene_of(*(Bitmap(pixels=picture) for picture in pictures))
    assert scene.materials.texels.array.ctypes.data % 64 == 0
    assert scene.materials.texels.size == 16 + 16 + 16 + 32


def test_equal_pictures_are_stored_once():
    pixels = np.random.default_rng(5).integers(0, 256, (32, 32, 3)).astype(np.uint8)
    one, _ = scene_of(Bitmap(pixels=pixels))
    many, _ = scene_of(
        *(
            Bitmap(pixels=pixels.copy(), wrap=wrap, interpolation=way)
            for wrap in WRAPS
            for way in WAYS
        )
    )
    # A cache line with the blank word, 4 bytes a texel, and a table for decoding.
    assert one.materials.texels.size == many.materials.texels.size == 16 + 32 * 32 + 256
    raw, _ = scene_of(Bitmap(pixels=pixels), Bitmap(pixels=pixels, color_space="linear"))
    assert raw.materials.texels.size == 16 + 32 * 32 + 2 * 256
    grey, _ = scene_of(Bitmap(pixels=np.ones((32, 32))))
    assert grey.materials.texels.size == 16 + 32 * 32


def test_one_picture_can_be_decoded_in_two_ways():
    pixels = np.array([[0x8000]], np.uint16)
    scene, program = scene_of(Bitmap(pixels=pixels), Bitmap(pixels=pixels, color_space="linear"))
    fetch = instantiate(color, program, compiled=False)
    slots = np.array([0, scene.materials.data.size // 2], np.uint32)
    found = fetch(scene, slots, Surface(np.zeros(2, np.float32), np.zeros(2, np.float32), slots, 0))
    x = 0x8000 / 0xFFFF
    np.testing.assert_allclose(found.x, [((x + 0.055) / 1.055) ** 2.4, x], rtol=1e-6)


def test_scenes_without_textures_do_not_know_of_them():
    tables, _, names = compile_materials([Diffuse(), Phong(exponent=constant.Constant(color=1.0))])
    assert names == ("constant",) and tables.texels.size == 1
    assert (
        instantiate(textured_scalar, Program(textures=names), compiled=False).__name__ == "scalar"
    )


N = 256
ALL = [e for model in (checkerboard, bitmap, constant) for e in model.EXAMPLES]


@kernel
def _fetch_all(scene, slots, uv, out):
    for i in range(0, N, LANES):
        slot, u = load_lanes(slots, i), load_lanes(uv, i)
        surface = Surface(u, load_lanes(uv, N + i), slot & 0, 0)
        c = color(scene, slot, surface)
        store_lanes(out, i, c.x)
        store_lanes(out, N + i, c.y)
        store_lanes(out, 2 * N + i, c.z)
        store_lanes(out, 3 * N + i, textured_scalar(scene, slot, surface))
        # Lights look textures up by number; 0 is none.
        number = slot & 3
        e = texture_value(scene, number, surface, c * 2.0)
        store_lanes(out, 4 * N + i, e.y)


def test_compiled_code_equals_the_twin_for_any_mixture():
    scene, program = scene_of(*ALL)
    width = scene.materials.data.size // len(ALL)
    rng = np.random.default_rng(6)
    chosen = rng.integers(0, len(ALL), N)
    slots = View((chosen * width).astype(np.uint32))
    uv = View(rng.uniform(-2.0, 3.0, 2 * N).astype(np.float32))
    results = []
    # The twin first: NumPy refuses indices that machine code would follow.
    for compiled in (False, True):
        out = View(np.zeros(5 * N, np.float32))
        instantiate(_fetch_all, program, compiled=compiled)(scene, slots, uv, out)
        results.append(out.array.reshape(5, N))
    np.testing.assert_allclose(results[0], results[1], atol=2e-5)
    alone = np.zeros((N, 3))
    for i, texture in enumerate(ALL):
        mine = chosen == i
        alone[mine] = look_up(texture, uv.array[:N][mine], uv.array[N:][mine])
    np.testing.assert_allclose(results[0][:3].T, alone, atol=2e-5)
    # Constant textures have become the numbers of the row, of which a scalar is the first.
    varies = scene.materials.texture.array[slots.array] > 0
    luminance = np.where(varies, alone @ [0.212671, 0.715160, 0.072169], alone[:, 0])
    np.testing.assert_allclose(results[0][3], luminance, atol=2e-5)
    # Every row of `data` starts at a multiple of 4.
    np.testing.assert_allclose(results[0][4], 2.0 * results[0][1], rtol=1e-6)


# ---------------------------------------------------------------- descriptions


def test_checkerboards_turn_by_their_transform():
    turned = Checkerboard(color0=0.0, color1=1.0, scale=2.0, to_uv={"rotate": 90})
    # (0.3, 0.1) becomes (-0.1, 0.3), and by the scale (-0.2, 0.6).
    assert look_up(turned, 0.3, 0.1)[0, 0] == 1.0
    both = Checkerboard(scale=(2.0, 3.0), offset=(0.5, -1.0), to_uv={"translate": [1.0, 2.0]})
    np.testing.assert_allclose(both.matrix, [[2.0, 0.0, 2.5], [0.0, 3.0, 5.0]])


def test_steps_are_applied_from_left_to_right():
    steps = [{"scale": [2, 3]}, {"rotate": 90}, {"translate": [1, 0]}]
    texture = Bitmap(pixels=[[1.0]], to_uv=steps)
    np.testing.assert_array_equal(texture.to_uv.matrix, [[0, -3, 1], [2, 0, 0]])
    assert UvTransform.of_matrix(texture.to_uv.matrix).plain() == {
        "matrix": [[0.0, -3.0, 1.0], [2.0, 0.0, 0.0]]
    }


@pytest.mark.parametrize(
    "pixels",
    [
        np.arange(6, dtype=np.uint8).reshape(1, 2, 3),
        np.arange(600, 606, dtype=np.uint16).reshape(2, 3),
        np.float32([[0.1, 1e15], [1e-45, 0.3]]),
        np.float32([[[0.1, 0.2, 0.7]]]),
    ],
)
def test_pictures_written_out_are_read_back_exactly(pixels):
    image = as_image(pixels)
    assert as_image(image.plain()) == image
    assert as_image(image.plain()).texels.dtype == pixels.dtype


def test_pictures_cannot_be_changed_from_outside():
    pixels = np.ones((2, 2), np.float32)
    texture = Bitmap(pixels=pixels)
    pixels[:] = 0.0
    assert isinstance(texture.pixels, Image) and texture.maximum() == (1.0, 1.0, 1.0)
    with pytest.raises(ValueError, match="read-only"):
        texture.pixels.texels[0] = 0.0


def test_mean_and_maximum_are_linear():
    texture = Bitmap(pixels=np.array([[[0, 255, 64], [255, 255, 64]]], np.uint8))
    dark = float(decode_srgb(np.float64(64 / 255)))
    assert texture.mean() == pytest.approx((0.5, 1.0, dark), rel=1e-6)
    assert texture.maximum() == pytest.approx((1.0, 1.0, dark), rel=1e-6)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({}, "needs a file, or pixels"),
        ({"file": "a.png", "pixels": [[1.0]]}, "takes either file or pixels, got both"),
        ({"pixels": [[0.5, float("nan")]]}, "got nan in row 0, column 1"),
        ({"pixels": np.float32([[0.5], [-1.0], [np.inf]])}, "-1.0 in row 1, column 0; 2 texels"),
        ({"pixels": np.zeros((0, 3))}, "must have the shape (h, w) or (h, w, 3), got (0, 3)"),
        ({"pixels": np.zeros((2, 2), np.int64)}, "must be uint8 or uint16, got int64"),
        ({"pixels": [[1.0], [1.0, 2.0]]}, "rows of equal length"),
        ({"pixels": [["a"]]}, "texels must be a number or a list of 3 numbers"),
        ({"pixels": ["ff 0g"]}, "hexadecimal digits"),
        ({"pixels": ["ff 00", "ff"]}, "equally many words"),
        ({"pixels": np.broadcast_to(np.float32(0), (9000, 9000))}, "got 9000 x 9000"),
        ({"pixels": [[1.0]], "to_uv": {"scal": 2}}, 'unknown step "scal"; did you mean "scale"?'),
        ({"pixels": [[1.0]], "to_uv": {"scale": "big"}}, 'scale must be a number or a list of 2'),
        ({"pixels": [[1.0]], "to_uv": [{"scale": 1e9}] * 2}, "must stay below 1e+15"),
    ],
)  # fmt: skip
def test_what_is_no_bitmap_is_refused(fields, message):
    with pytest.raises(SceneError) as caught:
        Bitmap(**fields)
    assert message in str(caught.value)


def test_the_two_directions_may_wrap_differently():
    u, v = (4 * np.random.default_rng(8).random((2, 200)) - 2).astype(np.float32)
    both = Bitmap(pixels=RAMP, wrap="mirror", wrap_v="clamp")
    # Inside the square in one direction the other one's way decides.
    inside = np.clip(v, 0.0, 1.0)
    wanted = look_up(Bitmap(pixels=RAMP, wrap="mirror"), u, inside)
    np.testing.assert_allclose(look_up(both, u, v), wanted, atol=1e-6)
    other = Bitmap(pixels=RAMP, wrap="repeat", wrap_v="mirror")
    wanted = look_up(Bitmap(pixels=RAMP, wrap="mirror"), u - np.floor(u), v)
    same = look_up(Bitmap(pixels=RAMP), u, v - np.floor(v))
    middle = (u % 1 > 0.125) & (u % 1 < 0.875)
    np.testing.assert_allclose(look_up(other, u, v)[middle], wanted[middle], atol=1e-5)
    assert not np.allclose(look_up(other, u, v), same)
