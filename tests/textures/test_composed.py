"""Textures made of others: the arithmetic, the stack, names, limits, opacity."""

import numpy as np
import pytest

from alight.compiled.textures import _steps
from alight.core.errors import SceneError
from alight.formats import dumps, loads
from alight.scene.flatten import flatten
from alight.textures.add import Add
from alight.textures.bitmap import Bitmap
from alight.textures.channel import Channel
from alight.textures.checkerboard import Checkerboard
from alight.textures.clamp import Clamp
from alight.textures.images import as_image
from alight.textures.mix import Mix
from alight.textures.model import TEXTURES
from alight.textures.multiply import Multiply
from alight.textures.nesting import REGISTERS, Composed, count_steps, depth_of
from alight.textures.noise import Noise
from alight.textures.threshold import Threshold
from tests.textures.lookup import look_up

U, V = np.random.default_rng(4).random((2, 64), np.float32)
A = Bitmap(pixels=np.random.default_rng(1).random((4, 4, 3)).astype(np.float32))
B = Bitmap(pixels=np.random.default_rng(2).random((3, 5, 3)).astype(np.float32))
C = Checkerboard(color0=(0.9, 0.5, 0.1), color1=(0.2, 0.3, 0.4), scale=3.0)
GREY = np.array([0.212671, 0.715160, 0.072169], np.float32)


def value(texture):
    return look_up(texture, U, V)


def test_operators_are_their_formulas():
    a, b, c = value(A), value(B), value(C)
    weight = (c @ GREY)[:, None]
    cases = {
        Multiply(a=A, b=B): a * b,
        Multiply(a=A, b=(2.0, 0.5, 0.0)): a * (2.0, 0.5, 0.0),
        Add(a=A, b=B): a + b,
        Mix(a=A, b=B, weight=C): (1 - weight) * a + weight * b,
        Mix(a=A, b=B, weight=1.0): b,
        Threshold(texture=A, cutoff=0.4): a >= 0.4,
        Threshold(texture=(0.5, 0.5, 0.5), cutoff=0.5): np.ones((64, 3)),
        Clamp(texture=A, high=0.4): np.minimum(a, 0.4),
        Clamp(texture=Multiply(a=A, b=1.5)): np.minimum(1.5 * a, 1.0),
        Channel(texture=A, channel="r"): a[:, [0, 0, 0]],
        Channel(texture=A, channel="g"): a[:, [1, 1, 1]],
        Channel(texture=A, channel="b"): a[:, [2, 2, 2]],
        Channel(texture=A, channel="a"): np.ones((64, 3)),
    }
    for texture, wanted in cases.items():
        np.testing.assert_allclose(value(texture), wanted, atol=2e-6, err_msg=repr(texture))


def test_steps_and_the_depth_of_the_stack_are_those_of_the_list_that_kernels_run():
    """What is allowed is counted before there is a list."""
    rng = np.random.default_rng(6)

    def grown(depth):
        # Three times three parts would be too deep.
        kinds = (Add, Multiply, Clamp) if depth == 3 else (Add, Multiply, Clamp, Mix, None)
        kind = kinds[rng.integers(0, len(kinds))] if depth else None
        return C if kind is None else kind(**{name: grown(depth - 1) for name in kind.fields})

    for _ in range(40):
        spec = grown(3)
        steps, held, deepest = _steps(spec), 0, 0
        for step in steps:
            held += 1 - (len(step.parts) if isinstance(step, Composed) else 0)
            deepest = max(deepest, held)
        assert (count_steps(spec), depth_of(spec), held) == (len(steps), deepest, 1)


def test_coordinates_are_those_of_the_first_part_that_has_some():
    """Solid textures, colours and names have none."""
    solid, turned = Noise(), [{"rotate": 30.0}]
    flat = Bitmap(pixels=A.pixels, uv_set=2, to_uv=turned)
    other = Checkerboard(color0=0.0, color1=1.0, uv_set=1)
    for parts in ((solid, flat), (0.5, flat), ("name", flat), (flat, other), (flat, solid)):
        spec = Clamp(texture=Add(a=parts[0], b=parts[1]))
        assert spec.set_of_coordinates() == 2
        np.testing.assert_array_equal(spec.lookup(), flat.to_uv.matrix)
    assert Add(a=solid, b=0.5).set_of_coordinates() is None
    assert Add(a=solid, b=0.5).lookup() is None


@pytest.mark.parametrize("step", [{}, 3, {"scale": 2, "rotate": 5}, {"shear": 1}])
def test_a_step_of_a_lookup_is_one_of_four(step):
    said = ""
    try:
        Bitmap(pixels=A.pixels, to_uv=[{"scale": 2}, step])
    except SceneError as error:
        said = str(error)
    wanted = "unknown step" if "shear" in str(step) else "exactly one of translate, scale"
    assert wanted in said


def test_means_and_maxima_are_those_of_the_parts():
    """Lamps and lobes are chosen by them: wrong ones are noise, too small maxima are errors."""
    mean = 0.5 * (np.array(C.color0) + C.color1)
    high = np.maximum(C.color0, C.color1)
    cases = {
        Multiply(a=C, b=(2.0, 0.5, 0.0)): (mean * (2.0, 0.5, 0.0), high * (2.0, 0.5, 0.0)),
        Add(a=C, b=C): (2 * mean, 2 * high),
        Mix(a=C, b=(1.0, 0.0, 0.5), weight=0.25): (
            0.75 * mean + 0.25 * np.array((1.0, 0.0, 0.5)),
            np.maximum(high, (1.0, 0.0, 0.5)),
        ),
        Channel(texture=C, channel="r"): (mean[[0] * 3], high[[0] * 3]),
        Channel(texture=C, channel="g"): (mean[[1] * 3], high[[1] * 3]),
        Channel(texture=C, channel="b"): (mean[[2] * 3], high[[2] * 3]),
        Threshold(texture=C, cutoff=0.5): (mean * [1, 1, 0], [1, 1, 0]),
        Clamp(texture=C, high=0.3): (np.minimum(mean, 0.3), np.minimum(high, 0.3)),
    }
    for texture, (average, most) in cases.items():
        np.testing.assert_allclose(texture.mean(), average, rtol=1e-6, err_msg=repr(texture))
        np.testing.assert_allclose(texture.maximum(), most, rtol=1e-6, err_msg=repr(texture))


@pytest.mark.parametrize("space", ["world", "uv"])
def test_a_scaled_noise_is_the_plain_one_at_scaled_places(space):
    u, v = np.random.default_rng(4).uniform(-3.0, 3.0, (2, 200)).astype(np.float32)
    found = look_up(Noise(scale=(4.0, 0.5, 1.0), space=space), u, v)
    expected = look_up(Noise(space=space), 4.0 * u, 0.5 * v)
    np.testing.assert_array_equal(found, expected)
    assert expected.std() > 0.05


def test_deep_trees_come_off_the_stack_in_order():
    inner = Mix(a=Add(a=A, b=B), b=Multiply(a=B, b=C), weight=Multiply(a=C, b=A))
    outer = Mix(a=0.1, b=B, weight=Multiply(a=0.25, b=inner))
    assert depth_of(outer) == REGISTERS
    a, b, c = value(A), value(B), value(C)
    weight = ((c * a) @ GREY)[:, None]
    inside = (1 - weight) * (a + b) + weight * b * c
    share = (0.25 * inside @ GREY)[:, None]
    np.testing.assert_allclose(value(outer), (1 - share) * 0.1 + share * b, atol=3e-6)


def test_opacity_is_read_from_pictures_that_have_it():
    pixels = np.array([[[255, 0, 0, 51], [0, 255, 0, 255]]], np.uint8)
    spec = Channel(texture=Bitmap(pixels=pixels, interpolation="nearest"), channel="a")
    found = look_up(spec, [0.25, 0.75], [0.5, 0.5])
    np.testing.assert_allclose(found, [[0.2] * 3, [1.0] * 3], atol=1e-6)


SCENE = """alight: 1
camera: {type: pinhole}
environment: constant
textures:
  wood: {type: noise, scale: 3}
  stained: {type: multiply, a: wood, b: [0.9, 0.5, 0.1]}
bsdfs:
  board: {type: diffuse, reflectance: {type: mix, a: stained, b: 0.3, weight: wood}}
nodes: {wall: {shape: rectangle, bsdf: board}}
"""


def test_names_inside_textures_are_resolved_and_written_back():
    scene = loads(SCENE)
    assert loads(dumps(scene)) == scene
    (bsdf,) = flatten(scene).bsdfs
    mixed = bsdf.reflectance
    assert isinstance(mixed.a, Multiply)
    assert mixed.a.a == Noise(scale=3.0) == mixed.weight


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("a: wood", "a: stained", "textures.stained\n  contains itself: stained -> stained"),
        ("a: wood", "a: wod", 'unknown texture "wod"; did you mean "wood"?'),
        ("[0.9, 0.5, 0.1]", "5", "must be in [0, 1] everywhere; the texture's largest value is 5"),
        ("weight: wood", "weight: 1.5", "must be in [0, 1], got 1.5"),
    ],
)
def test_wrong_textures_are_named(before, after, words):
    with pytest.raises(SceneError) as caught:
        loads(SCENE.replace(before, after))
    assert words in str(caught.value)


def test_textures_that_double_each_other_are_refused_at_once():
    chain = "".join(f"  t{i}: {{type: multiply, a: t{i - 1}, b: t{i - 1}}}\n" for i in range(1, 60))
    with pytest.raises(SceneError, match="at most 64 textures"):
        loads(SCENE.replace("  wood:", "  t0: {type: constant}\n" + chain + "  wood:"))


def reference_noise(points):
    """Perlin's sum, corner by corner, in double precision."""
    axes = [(1, 1, 0), (1, 0, 1), (0, 1, 1)]
    result = np.zeros(len(points))
    for row, x in enumerate(points.astype(np.float64)):
        cell = np.floor(x)
        for corner in np.ndindex(2, 2, 2):
            at = cell + corner
            word = hashed(*(int(c) + 2**22 for c in at))
            h = ((word >> 16) * 12) >> 16
            offset = x - at
            pair = [offset[i] for i in range(3) if axes[h >> 2][i]]
            slope = (-1) ** (h & 1) * pair[0] + (-1) ** ((h >> 1) & 1) * pair[1]
            t = np.abs(offset)
            result[row] += slope * np.prod(1 - t**3 * (t * (6 * t - 15) + 10))
    return result


def hashed(x, y, z):
    """The first word of pcg4d, in Python's whole numbers."""
    v, mask = [x, y, z, 0], 2**32 - 1
    v = [(c * 1664525 + 1013904223) & mask for c in v]
    for shift in (False, True):
        if shift:
            v = [c ^ (c >> 16) for c in v]
        for i, (j, k) in enumerate(((1, 3), (2, 0), (0, 1), (1, 2))):
            v[i] = (v[i] + v[j] * v[k]) & mask
    return v[0]


def test_noise_is_the_sum_that_is_written_down():
    uv = np.random.default_rng(3).uniform(-40, 40, (50, 2)).astype(np.float32)
    found = look_up(Noise(space="uv", octaves=2, gain=0.25), *uv.T)[:, 0]
    points = np.column_stack([uv, np.zeros(50, np.float32)])
    wanted = (reference_noise(points) + 0.25 * reference_noise(2 * points)) / 1.25
    np.testing.assert_allclose(found, 0.5 + 0.5 * wanted, atol=2e-5)


def test_noise_is_centred_and_smooth():
    grid = np.linspace(0, 60, 4096, dtype=np.float32)
    found = look_up(Noise(space="uv", octaves=1), grid, 0.37 * grid + 5)[:, 0]
    assert abs(found.mean() - 0.5) < 0.03
    assert np.abs(np.diff(found)).max() < 0.03


def test_every_operator_says_how_many_parts_it_takes():
    for name, model in TEXTURES.items():
        if model.operate is not None:
            assert 1 <= len(model.spec.fields) <= 3, name


@pytest.mark.parametrize("level", [0, 128, 200, 254, 255])
def test_a_picture_has_alpha_where_a_texel_is_not_quite_opaque(level):
    texels = np.full((2, 2, 4), 255, np.uint8)
    texels[1, 1, 3] = level
    assert (as_image(texels).alpha is None) == (level == 255)
    assert (as_image(texels[..., 2:] / 255.0).alpha is None) == (level == 255)


def test_the_mean_of_a_product_is_taken_from_both_means():
    board = Checkerboard(color0=(0.8, 0.4, 0.2), color1=(0.2, 0.2, 0.6))
    other = Checkerboard(color0=(1.0, 0.0, 0.5), color1=(0.0, 0.5, 0.1), scale=8.0)
    found = Multiply(a=board, b=other)
    np.testing.assert_allclose(found.mean(), np.multiply(board.mean(), other.mean()))
    np.testing.assert_allclose(found.maximum(), np.multiply(board.maximum(), other.maximum()))
