"""A torus, a light on it, haze around it and a tone curve, each a user's one file."""

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import alight
from alight.cli.main import app
from alight.core.registration import unregister
from alight.core.srgb import decode_srgb, encode_srgb
from alight.formats import loads
from alight.lab.random_scenes.bodies import any_body
from alight.lab.random_scenes.chance import Chance
from alight.outputs import read_image, write_image
from alight.outputs.display import Display
from tests.extension import beam, haze, logarithm, torus

USERS = {
    "torus": ("shapes", torus),
    "beam": ("lights", beam),
    "haze": ("media", haze),
    "logarithm": ("tone_curves", logarithm),
}


@pytest.fixture(scope="module", autouse=True)
def registered():
    for _, model in USERS.values():
        alight.register(model)
    yield
    for name, (family, _) in USERS.items():
        unregister(family, name)


@pytest.mark.parametrize("name", USERS)
def test_they_obey_the_laws_of_their_families(name):
    report = alight.check_laws(USERS[name][1], compiled=name == "torus")
    assert report, str(report)


def test_a_torus_whose_tube_fills_its_ring_is_refused():
    with pytest.raises(alight.SceneError, match="minor must be smaller than major, got 1 and 1"):
        loads(SCENE.replace("{type: torus, minor: 0.2}", "{type: torus, minor: 1}"))


@pytest.mark.parametrize("seed", range(8))
def test_random_scenes_bring_a_users_shape_into_their_cube(seed):
    """Any torus reaches the cube from -1 to 1, and not beyond."""
    shape, fitted = any_body(Chance(seed), ["torus"])
    low, high = torus.bounds(torus.pack(shape, fitted.matrix))
    assert np.maximum(-low, high).max() == pytest.approx(1.0, abs=1e-4)


SCENE = """
alight: 1
camera: {type: pinhole, fov: 50, transform: {look_at: {origin: [0, 2.5, 5], target: [0, 0.3, 0]}}}
film: {size: [24, 16]}
sampler: independent
integrator: INTEGRATOR
nodes:
  floor: {shape: plane, transform: {rotate: {axis: x, angle: -90}}}
  ring:
    shape: {type: torus, major: 0.8, minor: 0.2}
    transform:
      keyframes:
        - {time: 0, translate: [0.6, 1.6, 0]}
        - {time: 1, rotate: {axis: x, angle: 50}, translate: [0.2, 1.3, 0.3]}
    light: {type: beam, radiance: [20, 15, 10], exponent: 2}
  still:
    shape: {type: torus, major: 0.5, minor: 0.1}
    transform: [{rotate: {axis: x, angle: 60}}, {translate: [-1, 1.2, 0.8]}]
    light: {type: beam, radiance: [10, 20, 10], exponent: 1}
  other:
    shape: {type: torus, minor: 0.2}
    transform: [{rotate: {axis: x, angle: 70}}, {translate: [-0.4, 0.6, -0.8]}]
    light: {type: area, radiance: [0, 1, 2]}
  ball: {shape: {type: sphere, center: [1.2, 0.5, 0.5], radius: 0.4}}
"""


def film(options, spp=256):
    text = SCENE.replace("INTEGRATOR", f"{{type: path, max_depth: 4, {options}}}")
    return alight.render(loads(text, "users"), spp=spp, seed=1)


def agree(a, b):
    """The means of both pictures, by their error bars."""
    assert a.invalid == b.invalid == 0
    means = np.array([f.image.mean(axis=(0, 1)) for f in (a, b)])
    squares = [(f.standard_error**2).sum(axis=(0, 1)) for f in (a, b)]
    errors = np.sqrt(squares) / a.image[..., 0].size
    assert means.min() > 0.01
    z = np.abs(means[0] - means[1]) / np.sqrt((errors**2).sum(axis=0))
    assert z.max() < 4.5, (means, z)


@pytest.fixture(scope="module")
def by_bsdf():
    """Lights that move and lights at rest, as rays hit them by chance."""
    return film("light_sampling: bsdf", spp=1024)


@pytest.mark.parametrize(
    "options",
    [
        "light_sampling: mis",
        pytest.param("light_sampling: emitter", marks=pytest.mark.proofs),
        "light_choice: tree",
    ],
)
def test_every_way_to_find_their_light_gives_one_picture(by_bsdf, options):
    """By both strategies, whose weights need all densities, and with the lights from a tree."""
    agree(film(options), by_bsdf)


def test_haze_dims_by_the_closed_form():
    """Straight up through haze of the height h over y = 0: exp(-sigma h (1 - exp(-y / h)))."""
    text = """
alight: 1
camera:
  type: orthographic
  height: 0.1
  medium: air
  transform: {rotate: {axis: x, angle: 90}}
film: {size: [4, 4]}
media:
  air: {type: haze, sigma_t: [1.0, 2.0, 0.5], albedo: 0, height: 0.7}
environment: {type: constant, radiance: 1}
integrator: {type: volpath, max_depth: 8}
nodes:
  air:
    shape: {type: sphere, radius: 2}
    bsdf: {type: "null"}
    interior: air
"""
    scene = loads(text, "haze")
    image = alight.render(scene, spp=4096, seed=3).image.mean(axis=(0, 1))
    depth = 0.7 * (1.0 - np.exp(-2.0 / 0.7))
    np.testing.assert_allclose(image, np.exp(-depth * np.array([1.0, 2.0, 0.5])), rtol=0.02)


def test_pictures_are_shown_by_a_users_tone_curve(tmp_path):
    """White stays white, and what is dark is brighter than without it, as the formula says."""
    levels = np.array([0.0, 1e-3, 0.1, 1.0])[None, :, None] * np.ones(3)
    shown = decode_srgb(Display(tone_map="logarithm").apply(levels))
    expected = np.log1p(levels / 0.1) / np.log1p(10.0)
    np.testing.assert_allclose(shown, expected, atol=1e-7)
    written = read_image(write_image(tmp_path / "a.png", levels, tone_map="logarithm"))
    # Half a step of 8 bits.
    np.testing.assert_allclose(encode_srgb(written), encode_srgb(expected), atol=0.501 / 255.0)


def test_a_script_brings_the_tone_curve_that_the_same_command_asks_for(tmp_path):
    words = ["render", "cornell-box", "--spp", "1", "--set", "film.size=[8, 8]", "-o"]
    words += [str(tmp_path / "a.png"), "--tone-map", "doubled", "--plugin"]
    script = tmp_path / "doubled.py"
    text = Path(logarithm.__file__).read_text().replace('"logarithm"', '"doubled"')
    script.write_text(text + "\n\nimport alight\n\nalight.register(__name__)\n")
    try:
        done = CliRunner().invoke(app, [*words, str(script)])
        assert done.exit_code == 0, done.output
        assert (tmp_path / "a.png").is_file()
    finally:
        unregister("tone_curves", "doubled")
