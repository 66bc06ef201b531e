"""Pictures with negative light, as lossy compression leaves it behind."""

import numpy as np
import pytest
from typer.testing import CliRunner

import alight
from alight.cli.main import app
from alight.core.errors import SceneError
from alight.scene.images import read_image

SCENE = "alight: 1\ncamera: {type: pinhole}\nenvironment: {type: environment, file: sky.npy}\n"


@pytest.fixture
def picture(tmp_path):
    def write(**texels):
        """A grey sky with some other texels, their rows and columns as ``r1_c2``."""
        pixels = np.full((4, 8, 3), 0.5, np.float32)
        for place, value in texels.items():
            row, column = (int(part[1:]) for part in place.split("_"))
            pixels[row, column] = value
        np.save(tmp_path / "sky.npy", pixels)
        return tmp_path / "sky.npy"

    return write


def test_negative_light_is_taken_for_none_and_said(picture):
    notes = []
    image = read_image(picture(r1_c2=(-0.25, 1.0, 2.0), r3_c0=-2.0), "sky.npy", notes.append)
    assert notes == [
        '"sky.npy": 2 of 32 texels hold negative light (down to -2), which was taken for none'
    ]
    expected = np.full((4, 8, 3), 0.5)
    expected[1, 2], expected[3, 0] = (0.0, 1.0, 2.0), 0.0
    np.testing.assert_array_equal(image.texels, expected)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e16])
def test_what_is_no_number_is_refused_still(value, picture):
    notes = []
    with pytest.raises(SceneError, match="texels must be finite"):
        read_image(picture(r0_c1=value), "sky.npy", notes.append)
    assert notes == []


def test_pictures_without_any_stay_as_they_are(picture):
    notes = []
    assert read_image(picture(), "sky.npy", notes.append).texels.min() == 0.5
    assert notes == []


def test_info_and_renders_say_it(picture, tmp_path):
    picture(r0_c0=-1.0)
    scene = tmp_path / "a.yaml"
    scene.write_text(SCENE)
    said = '"sky.npy": 1 of 32 texels hold negative light (down to -1)'
    assert said in CliRunner().invoke(app, ["info", str(scene)]).output
    film = alight.render(scene, spp=1, seed=1)
    assert [note.startswith(said) for note in film.warnings] == [True]
    out = tmp_path / "a.png"
    options = ["--spp", "1", "--size", "8x8", "-o", str(out)]
    assert said in CliRunner().invoke(app, ["render", str(scene), *options]).output
