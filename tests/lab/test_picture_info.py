"""What info says of films and pictures."""

import numpy as np
import pytest

import alight
from alight.core.errors import AlightError, OptionError
from alight.lab.info import SceneInfo
from alight.lab.picture_info import is_film_or_picture
from alight.outputs.image import write_image


@pytest.fixture(scope="module")
def film():
    """A crop, so that the picture and its window differ in size."""
    return alight.render("cornell-box", size=(24, 16), crop=(4, 2, 10, 8), spp=8, seed=5)


def test_a_film_says_its_window_samples_layers_and_error(film, tmp_path):
    film.save(tmp_path / "a.alight")
    found = dict(alight.info(tmp_path / "a.alight").facts)
    assert found["film"] == "10x8 pixels, at 4,2 of 24x16"
    assert found["samples"] == "8 spp"
    assert found["seed"] == "5"
    assert found["scene hash"] == film.provenance["scene_hash"]
    values = f"{film.mean.min():.4g} to {film.mean.max():.4g}, mean {film.mean.mean():.4g}"
    assert found["values"] == values
    assert "%" in found["error"]


def test_a_picture_of_that_film_tells_the_same_origin(film, tmp_path):
    film.save(tmp_path / "a.alight")
    film.save(tmp_path / "a.exr")
    of_film, of_picture = (
        dict(alight.info(tmp_path / name).facts) for name in ("a.alight", "a.exr")
    )
    assert of_picture["picture"] == "10x8 pixels, EXR"
    for name in ("version", "seed", "replicates", "scene hash", "fingerprint", "biases"):
        assert of_picture.get(name) == of_film.get(name) is not None, name


@pytest.mark.parametrize("suffix", ["png", "pfm", "npy", "hdr"])
def test_every_format_says_size_and_range(tmp_path, suffix):
    values = np.full((3, 5, 3), 1.0, np.float32)
    write_image(tmp_path / f"a.{suffix}", values)
    found = dict(alight.info(tmp_path / f"a.{suffix}").facts)
    assert found["picture"] == f"5x3 pixels, {suffix.upper()}"
    assert found["values"] == "1 to 1, mean 1"


def test_what_is_not_finite_is_counted_and_left_out(tmp_path):
    values = np.full((2, 2, 3), 2.0, np.float32)
    values[0, 0] = np.nan, np.inf, 4
    np.save(tmp_path / "a.npy", values)
    found = dict(alight.info(tmp_path / "a.npy").facts)
    assert found["values"] == "2 to 4, mean 2.2, 2 not finite"
    np.save(tmp_path / "b.npy", np.full((2, 2, 3), np.nan, np.float32))
    assert dict(alight.info(tmp_path / "b.npy").facts)["values"] == "none is finite"


@pytest.mark.parametrize("name", ["a.exr", "a.alight", "a.png"])
def test_missing_and_broken_files_are_refused(tmp_path, name):
    with pytest.raises(AlightError, match=name):
        alight.info(tmp_path / name)
    (tmp_path / name).write_bytes(b"no picture")
    with pytest.raises(AlightError, match=name):
        alight.info(tmp_path / name)


def test_options_of_scenes_are_refused(tmp_path):
    with pytest.raises(OptionError, match=r"a\.exr is no scene"):
        alight.info(tmp_path / "a.exr", tree=True)


def test_scenes_are_no_pictures():
    assert not any(map(is_film_or_picture, ("cornell-box", "a.yaml", "b.glb", "c.json", 3)))


def test_remarks_are_called_what_they_are():
    info = SceneInfo([], [], ["a"], ["b"], ["c"], ["d", "e"])
    assert info.remarks() == ["dropped: a", "approximated: b", "warning: c", "note: d", "note: e"]
