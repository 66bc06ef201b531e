"""Spot lights, and area lights with a texture: closed forms, and samples against hits."""

import numpy as np
import pytest

from alight.accel import intersect_closest
from alight.compiled.lights import light_textures
from alight.compiled.scene import compile_scene
from alight.formats import loads
from alight.lights.hits import emitted
from alight.lights.sampling import sample_light
from alight.lights.spot import EXAMPLES, Spot, mean_color
from alight.lights.tables import MAPPED, STRIDE, TEXTURED
from alight.scene.flatten import PlacedLight, flatten
from alight.scene.transform import rotate, translate
from alight.shapes.surfaces import make_surface
from lanewise.jit import instantiate
from lanewise.simd import gather
from tests.lights.test_light_sampling import sample
from tests.shapes.tracing import PROGRAM, World, finite, rows, vec

N = 8192
SPOTS = PROGRAM._replace(lights=("spot",))


def irradiance(spec, angle, distance=2.0):
    """What a surface receives that faces the light, `angle` degrees off its axis."""
    # The node's +z is turned to -y.
    turned = translate(0, 5, 0).matrix @ rotate("x", 90).matrix
    world = World(lights=[PlacedLight("spot", spec, turned)])
    angle = np.radians(angle)
    p = (distance * np.sin(angle), 5.0 - distance * np.cos(angle), 0.0)
    return rows(sample(world, p, 16, program=SPOTS).radiance)[0, 0]


def test_spot_fades_linearly_between_beam_and_cutoff():
    spec = Spot(intensity=8.0, cutoff_angle=40.0, beam_width=10.0)
    for angle, share in (
        (0, 1),
        (9.9, 1),
        (17.5, 0.75),
        (25, 0.5),
        (39, 1 / 30),
        (41, 0),
        (180, 0),
    ):
        assert irradiance(spec, angle) == pytest.approx(2.0 * share, rel=1e-4, abs=1e-6)
    # Three quarters of the cutoff by default.
    assert irradiance(Spot(intensity=4.0), 15.0) == pytest.approx(1.0, rel=1e-4)
    assert irradiance(Spot(intensity=4.0), 17.5) == pytest.approx(0.5, rel=1e-4)


def share_of(spec, angle):
    """What is left of the intensity, `angle` radians off the axis."""
    cutoff = np.radians(spec.cutoff_angle)
    beam = np.radians(0.75 * spec.cutoff_angle if spec.beam_width is None else spec.beam_width)
    with np.errstate(divide="ignore"):
        if spec.falloff == "linear":
            return np.clip((cutoff - angle) / (cutoff - beam), 0.0, 1.0)
        t = (np.cos(angle) - np.cos(cutoff)) / (np.cos(beam) - np.cos(cutoff))
    t = np.clip(t, 0.0, 1.0)
    return {"smooth": t * t * (3 - 2 * t), "quadratic": t**2, "quartic": t**4}[spec.falloff]


@pytest.mark.parametrize("falloff", ["smooth", "quadratic", "quartic"])
def test_spot_fades_by_a_polynomial_in_the_cosine(falloff):
    spec = Spot(intensity=8.0, cutoff_angle=50.0, beam_width=20.0, falloff=falloff)
    for angle in (0.0, 19.0, 21.0, 30.0, 40.0, 49.0, 51.0, 180.0):
        expected = 2.0 * share_of(spec, np.radians(angle))
        assert irradiance(spec, angle) == pytest.approx(expected, rel=1e-4, abs=1e-6)


@pytest.mark.parametrize("falloff", ["linear", "smooth"])
def test_narrowest_spot_is_still_a_cone(falloff):
    spec = Spot(intensity=4.0, cutoff_angle=0.002, beam_width=0.0, falloff=falloff)
    expected = share_of(spec, np.radians(0.001)) if falloff == "linear" else 0.84375
    assert irradiance(spec, 0.001) == pytest.approx(expected, rel=2e-3)


def test_hard_spot_ends_at_its_edge():
    spec = Spot(intensity=4.0, cutoff_angle=30.0, beam_width=30.0)
    assert irradiance(spec, 29.99) == pytest.approx(1.0) and irradiance(spec, 30.01) == 0.0


@pytest.mark.parametrize("spec", EXAMPLES)
def test_mean_intensity_of_a_spot_is_the_integral(spec):
    theta = (np.arange(200_000) + 0.5) * np.pi / 200_000
    mean = 0.5 * np.sum(share_of(spec, theta) * np.sin(theta)) * np.pi / 200_000
    np.testing.assert_allclose(mean_color(spec), np.multiply(spec.intensity, mean), rtol=1e-4)


# ---------------------------------------------------------------- textured area lights

TEXTURED_LAMPS = """
alight: 1
camera: {}
textures:
  picture:
    type: bitmap
    pixels: [[[6, 3, 1], [0, 0.5, 2], [4, 4, 4]], [[0, 0, 0], [90, 0, 0], [0, 5, 0]]]
  grey: {type: constant, color: 0.25}
nodes:
  rectangle:
    transform: [{scale: [0.5, 0.8, 1]}, {rotate: {axis: x, angle: 90}}, {translate: [0, 3, 0]}]
    shape: rectangle
    light: {type: area, radiance: picture}
  disk:
    transform: [{scale: [0.5, 0.8, 1]}, {rotate: {axis: y, angle: 40}}, {translate: [-3, 0, -2]}]
    shape: disk
    light: {type: area, radiance: {type: checkerboard, color0: 1, color1: 0.2, scale: [2, 6]}}
  sphere:
    transform: [{rotate: {axis: x, angle: 30}}, {translate: [3, 0, 0]}]
    shape: sphere
    light: {type: area, radiance: picture}
  ellipsoid:
    transform: [{scale: [1, 0.5, 0.7]}, {rotate: {axis: x, angle: 30}}, {translate: [0, -3, 0]}]
    shape: sphere
    light: {type: area, radiance: picture}
  mesh:
    transform: [{rotate: {axis: z, angle: 30}}, {translate: [0, 0, -4]}]
    shape:
      type: mesh
      vertices: [[-1, -1, 0], [1, -1, 0.2], [1, 1, 0], [-0.3, 0.6, 0.3]]
      faces: [[0, 1, 2], [0, 2, 3]]
      uvs: [[0, 0], [1, 0], [1.5, 1], [0.2, 0.7]]
    light: {type: area, radiance: picture}
  plain:
    transform: [{rotate: {axis: x, angle: 180}}, {translate: [0, 0, 3]}]
    shape: disk
    light: {type: area, radiance: grey}
"""


@pytest.fixture(scope="module")
def lamps():
    return compile_scene(flatten(loads(TEXTURED_LAMPS)), structure="list")


def run(scene, kernel, *arguments):
    with np.errstate(all="ignore"):
        return instantiate(kernel, scene.program, compiled=False)(scene.tables, *arguments)


def test_samples_show_the_texture_of_the_point_that_they_hit(lamps):
    assert lamps.program.lights == ("area", TEXTURED, MAPPED)
    u = np.random.default_rng(1).random((3, N), np.float32)
    o = vec(np.zeros((3, N)))
    active = np.ones(N, bool)
    light = run(lamps, sample_light, o, o, u[0], (u[1], u[2]), active)
    wi = vec(rows(light.wi))
    far = np.full(N, np.inf, np.float32)
    hit = run(lamps, intersect_closest, o, wi, far, active)
    found = np.isfinite(hit.t) & (light.pdf > 0.0)
    # Another lamp may stand before the chosen one.
    found &= np.abs(hit.t - light.distance) < 1e-3
    surface = run(lamps, make_surface, finite(hit), o, wi, found)
    seen = np.broadcast_to(rows(run(lamps, emitted, surface, -wi)), (3, N))
    sampled = rows(light.radiance)
    same = np.isclose(sampled, seen, rtol=1e-3, atol=2e-3).all(0)
    for shape in range(6):
        mine = found & (surface.shape == shape)
        assert mine.sum() > 40
        # Edges of checkers, and the seam of the spheres.
        assert same[mine].mean() > 0.99
        assert np.ptp(sampled[1][mine]) > 0.1 or shape == 5
    np.testing.assert_allclose(sampled[:, found & (surface.shape == 5)], 0.25)


def test_lamps_are_chosen_by_their_mean_radiance(lamps):
    texel = np.mean([[6, 3, 1], [0, 0.5, 2], [4, 4, 4], [0, 0, 0], [90, 0, 0], [0, 5, 0]], 0)
    weights = [0.212671, 0.715160, 0.072169]
    pmf = lamps.tables.lights.data.array.reshape(-1, STRIDE)[:, 3]
    assert pmf[0] / pmf[5] == pytest.approx(texel @ weights * 1.6 / (0.25 * np.pi), rel=1e-4)
    assert pmf[1] / pmf[5] == pytest.approx(0.6 * 0.4 / 0.25, rel=1e-4)


def test_equal_textures_are_stored_once():
    flat = flatten(loads(TEXTURED_LAMPS))
    assert len(light_textures(flat)) == 2
    assert np.all(gather(compile_scene(flat).tables.lights.info, np.arange(2, 24, 4)) <= 2)


@pytest.mark.parametrize(
    "light",
    [
        "{type: area, radiance: {type: bitmap, pixels: [[0, 0]]}}",
        "{type: area, radiance: black}",
        "{type: area, radiance: {type: checkerboard, color0: 0, color1: 0}}",
    ],
)
def test_scene_of_black_lamps_says_so(light):
    scene = loads(
        "alight: 1\ncamera: {}\ntextures: {black: {type: constant, color: 0}}\n"
        f"nodes: {{a: {{shape: disk, light: {light}}}}}\n"
    )
    warnings = compile_scene(flatten(scene)).warnings
    assert [text for text in warnings if "no light" in text] and len(warnings) == 1


def test_scene_of_a_black_map_says_so():
    for pixels in ("[[0]]", "[[0, 0], [0, 0]]"):
        scene = loads(
            f"alight: 1\ncamera: {{}}\nenvironment: {{type: environment, pixels: {pixels}}}\n"
        )
        assert len(compile_scene(flatten(scene)).warnings) == 1
