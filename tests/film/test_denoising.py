"""Denoising: less noise, lamps as bright as they were, and nothing hidden."""

import importlib.util

import numpy as np
import pytest
from typer.testing import CliRunner

import alight
from alight.cli.main import app
from alight.core.errors import OptionError
from alight.films import Film
from alight.films.denoising import FEATURES
from alight.films.fixed_point import to_limbs
from alight.outputs import read_image, write_image
from alight.outputs.exr import read_layers
from tests.film.test_film import partial_of

SIZE, SPP = 64, 8
LAMP = 50.0
needs_package = pytest.mark.skipif(
    importlib.util.find_spec("pyoidn") is None, reason="the extra denoise is not installed"
)


def true_picture():
    """A wall with a soft shade, two materials, and a lamp far above white."""
    y, x = np.mgrid[0:SIZE, 0:SIZE] / SIZE
    picture = np.where((x < 0.5)[..., None], [0.8, 0.4, 0.3], [0.3, 0.5, 0.8])
    picture = picture * (0.3 + 0.7 * y[..., None])
    picture[8:24, 8:24] = LAMP
    return picture


@pytest.fixture(scope="module")
def film():
    """Noise of 50 % a sample around the true picture, and the layers that help the filter."""
    truth = true_picture()
    noise = np.random.default_rng(7).gamma(4.0, 0.25, (SPP, SIZE, SIZE, 3))
    albedo = np.where((np.arange(SIZE) < SIZE // 2)[:, None], [0.8, 0.4, 0.3], [0.3, 0.5, 0.8])
    layers = {
        "albedo_through": np.broadcast_to(albedo, (SIZE, SIZE, 3)),
        "normal_through": np.broadcast_to([0.0, 0.0, 1.0], (SIZE, SIZE, 3)),
    }
    sums = {name: to_limbs((SPP * plane).astype(np.float32))[0] for name, plane in layers.items()}
    film = Film(SIZE, SIZE, replicates=4, aovs=dict.fromkeys(sums, ("R", "G", "B")))
    film.add_tile(partial_of((truth * noise).astype(np.float32), 0, 0, 0, aovs=sums))
    return film


@needs_package
def test_noise_goes_and_bright_lamps_stay(film):
    picture, _ = alight.denoise(film)
    truth = true_picture()
    error = np.square(picture.image / truth - 1.0).mean()
    noise = np.square(film.image / truth - 1.0).mean()
    assert error < noise / 3.0
    # The network for pictures up to 1 would cut it there.
    assert picture.image[12:20, 12:20].mean() == pytest.approx(LAMP, rel=0.03)


@needs_package
def test_the_noisy_picture_and_its_error_stay(film):
    picture, bias = alight.denoise(film)
    noisy = np.stack([picture.layers[f"noisy.{c}"] for c in "RGB"], axis=-1)
    np.testing.assert_array_equal(noisy, film.image)
    for c, plane in film.picture().layers.items():
        np.testing.assert_array_equal(picture.layers[c], plane)
    mean = film.image.mean(dtype=np.float64)
    assert bias.effect == pytest.approx(picture.image.mean(dtype=np.float64) / mean - 1.0)
    assert "Open Image Denoise" in picture.attributes["biases"]
    assert "with albedo and normal" in picture.attributes["biases"]
    assert not any(known.cause == "denoiser" for known in film.biases)


@needs_package
def test_without_layers_the_picture_alone_is_used(film):
    plain = Film(SIZE, SIZE, replicates=4)
    plain.add_tile(partial_of(film.image[None].repeat(4, axis=0), 0, 0, 0))
    picture, bias = alight.denoise(plain)
    assert np.isfinite(picture.image).all()
    assert " with " not in bias.text


@needs_package
def test_the_command_writes_both_pictures_and_the_film_as_it_was(film, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    film.save("a.alight")
    outputs = ["-o", "b.exr", "-o", "b.png", "-o", "b.alight"]
    result = CliRunner().invoke(app, ["merge", "a.alight", *outputs, "--denoise"])
    assert result.exit_code == 0, result.output
    assert "bias: denoised by Open Image Denoise" in result.output
    np.testing.assert_array_equal(read_layers("b.exr")[0]["noisy.G"], film.image[..., 1])
    image = alight.denoise(film)[0].image
    np.testing.assert_array_equal(read_image("b.exr"), image)
    write_image("c.png", image)
    np.testing.assert_array_equal(read_image("b.png"), read_image("c.png"))
    np.testing.assert_array_equal(Film.load("b.alight").image, film.image)


def test_without_the_package_nothing_is_rendered(film, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda n: None if n == "pyoidn" else find(n))
    with pytest.raises(OptionError, match=r'pip install ".*\[denoise\]"'):
        alight.denoise(film)
    result = CliRunner().invoke(app, ["render", "cornell-box", "--denoise"])
    assert result.exit_code == 2
    assert '[denoise]"' in result.stderr
    assert not list(tmp_path.iterdir())


def test_the_layers_are_those_that_the_renderer_has():
    from alight.integrators.aov import LAYERS

    assert set(FEATURES.values()) <= set(LAYERS)
