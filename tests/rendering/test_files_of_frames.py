"""What the files of an animation show: denoised, with alpha or over black, new or kept."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

import alight
from alight.core.srgb import decode_srgb
from alight.films import Film
from alight.options.animation import AnimationOptions
from alight.outputs.image import read_image
from alight.rendering import animation
from alight.rendering.animation import Animation

SMALL = {"size": (8, 8), "spp": 1, "threads": 1, "turntable": True}


@pytest.fixture
def renders(monkeypatch):
    """Options of every film, which is rendered without layers: these take other kernels."""
    made, render = [], animation.main_loop.render_film

    def plain(scene, options, executor):
        film = render(scene, options.changed(aovs=()), executor)
        made.append(options)
        return film

    monkeypatch.setattr(animation.main_loop, "render_film", plain)
    return made


def test_frames_are_denoised_in_all_files(tmp_path, monkeypatch, renders):
    monkeypatch.setattr("alight.films.denoising.check_denoiser", lambda: None)

    def grey(film):
        picture = film.picture(True)
        return replace(picture, image=np.full_like(picture.image, 0.5)), None

    monkeypatch.setattr(animation, "denoise", grey)
    output = [tmp_path / "f_#.exr", tmp_path / "f_#.png", tmp_path / "f.apng"]
    alight.animate("cornell-box", **SMALL, denoise=True, frames="0:1", output=output)
    # As for a single picture.
    assert renders[0].aovs == ("albedo_through", "normal_through")
    assert (read_image(tmp_path / "f_0.exr") == 0.5).all()
    for name in ("f_0.png", "f.apng"):
        with Image.open(tmp_path / name) as image:
            assert (np.asarray(image.convert("RGB")) == 188).all()


def test_what_went_wrong_is_told_with_the_number_of_its_frame(tmp_path, monkeypatch):
    """And what is suspicious of the scene once."""

    def broken(scene, options, executor):
        film = Film(8, 8)
        film.stats, film.invalid, film.scene_warnings = {"msamples_per_s": 1.0}, 3, ("it is dark",)
        return film

    monkeypatch.setattr(animation.main_loop, "render_film", broken)
    options = AnimationOptions(**SMALL, frames="4:6", output=tmp_path / "f_#.png")
    made = Animation("cornell-box", options)
    made.render()
    broken_by = "3 samples were NaN or infinite and were added as black"
    assert list(made.warnings) == ["it is dark", *(f"frame {n}: {broken_by}" for n in (4, 5))]


def test_a_film_is_the_same_of_new_and_of_kept_frames(tmp_path, monkeypatch, renders):
    """Over black, as in JPEG files, where they have alpha."""

    def half_there(self, film, layers):
        picture = film.picture(layers)
        alpha = np.linspace(0.0, 1.0, picture.image[..., 0].size, dtype=np.float32)
        alpha = alpha.reshape(picture.image.shape[:2])
        return replace(picture, image=picture.image * alpha[..., None], alpha=alpha)

    monkeypatch.setattr(Animation, "_picture_of", half_there)
    output = [tmp_path / "f_#.exr", tmp_path / "f.apng"]
    words = {**SMALL, "frames": "0:2", "output": output}
    alight.animate("cornell-box", **words)
    first = output[1].read_bytes()
    alight.animate("cornell-box", **words)
    assert len(renders) == 2
    assert output[1].read_bytes() == first
    with Image.open(output[1]) as film:
        seen = decode_srgb(np.asarray(film.convert("RGB")) / 255.0)
    black = np.clip(read_image(tmp_path / "f_0.exr"), 0.0, 1.0)
    np.testing.assert_allclose(seen, black, atol=0.005)


def test_a_film_in_a_folder_that_is_missing_costs_no_frame(tmp_path, renders):
    output = [tmp_path / "f_#.png", tmp_path / "none" / "f.gif"]
    with pytest.raises(alight.OutputError, match="none does not exist"):
        alight.animate("cornell-box", **SMALL, frames="0:2", output=output)
    assert renders == [] and list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("output", "told"), [("f.gif", True), ("f_#.png", False)])
def test_films_keep_no_alpha_and_say_so(output, told):
    options = AnimationOptions(turntable=True, background="transparent", output=output)
    warnings = Animation("cornell-box", options).prepared.warnings()
    assert any("only EXR and PNG keep alpha" in text for text in warnings) == told
