"""Comparing, white balance and denoising in the view, against what the library makes of them."""

import json

import numpy as np
import pytest

import alight
from alight.metrics.flip import flip, missing
from alight.outputs.display import Display
from alight.outputs.picture import as_picture
from alight.view import protocol
from alight.view.contrast import contrast, ways
from alight.view.layers import FileLayers, FilmLayers
from alight.view.painter import Painter
from alight.view.saving import save
from alight.view.session import Session
from alight.view.shades import shaded
from tests.view.looking import wait_for


def noisy(seed, level=0.1):
    draw = np.random.default_rng(seed)
    return (0.5 + level * draw.standard_normal((12, 16, 3))).astype(np.float32)


class Viewer:
    """Keeps the newest message of each kind."""

    def __init__(self):
        self.messages = {}

    def post(self, kind, message):
        self.messages[kind] = message

    @property
    def state(self):
        return json.loads(self.messages.get("state", "{}"))

    def frame(self, kind="frame"):
        message = self.messages.get(kind)
        return None if message is None else np.frombuffer(message[16:], np.uint8)


@pytest.fixture
def looked_at():
    """Gives a session a painter and a viewer."""
    painters = []

    def look(session):
        painters.append(Painter(session))
        viewer = Viewer()
        painters[-1].join(viewer)
        return viewer

    yield look
    for painter in painters:
        painter.close()


def layers(image):
    return FileLayers(as_picture(image))


def test_the_difference_is_that_of_relmse():
    one, other = noisy(1), noisy(2)
    plane, mean = contrast("difference", one, other)
    assert plane.shape == (12, 16, 1)
    scale = other.mean(axis=2, keepdims=True)
    assert mean == pytest.approx(np.sqrt(np.mean(((one - other) / scale) ** 2)), rel=1e-6)
    assert contrast("difference", one, one)[1] == 0.0
    dark = contrast("difference", one, np.zeros_like(one))
    assert np.isnan(dark[0]).all() and dark[1] == 0.0


@pytest.mark.skipif(bool(missing()), reason="flip-evaluator is not installed")
def test_flip_is_that_of_the_metric(looked_at):
    one, other = noisy(1), noisy(2)
    session = Session("a", layers(one), against=layers(other))
    viewer = looked_at(session)
    session.apply(protocol.Contrast("flip"))
    wait_for(lambda: "contrast" in viewer.state, 60)
    assert viewer.state["contrast"]["mean"] == pytest.approx(flip(one, other).mean)
    assert list(viewer.state["ways"]) == list(ways())


def test_both_pictures_are_shown_and_how_they_differ(looked_at):
    session = Session("a", layers(noisy(1)), against=layers(noisy(2)))
    viewer = looked_at(session)
    wait_for(lambda: viewer.frame("kept") is not None, 20)
    beside = viewer.frame("kept")
    np.testing.assert_array_equal(beside, shaded("picture", noisy(2), Display()).rgba.ravel())
    session.apply(protocol.Contrast("difference"))
    wait_for(lambda: not np.array_equal(viewer.frame("kept"), beside), 20)
    plane, mean = contrast("difference", noisy(1), noisy(2))
    wait_for(lambda: "contrast" in viewer.state, 20)
    assert viewer.state["contrast"]["mean"] == pytest.approx(mean)
    expected = shaded("difference", plane, Display())
    np.testing.assert_array_equal(viewer.frame("kept"), expected.rgba.ravel())
    session.against = layers(noisy(3)[:6])
    session.changed()
    wait_for(lambda: viewer.state.get("differs") == "the pictures differ in size", 20)


@pytest.mark.parametrize("white", ["auto", "3200K"])
def test_white_balance_is_seen_and_saved(looked_at, white, tmp_path):
    image = noisy(1) * np.array([1.0, 0.7, 0.4], np.float32)
    session = Session("a", layers(image))
    viewer = looked_at(session)
    session.apply(protocol.Develop(0.5, "none", white))
    expected = shaded("picture", image, Display(0.5, white_balance=white)).rgba
    wait_for(lambda: np.array_equal(viewer.frame(), expected.ravel()), 20)
    save(session, tmp_path / "a.png")
    alight.outputs.write_image(tmp_path / "b.png", image, exposure=0.5, white_balance=white)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_a_film_at_rest_is_denoised_on_the_page_only(looked_at, tmp_path):
    pytest.importorskip("pyoidn")
    film = alight.render("cornell-box", size=(24, 16), spp=4, threads=1)
    session = Session("a", FilmLayers(film))
    viewer = looked_at(session)
    session.apply(protocol.Denoise(True))
    wait_for(lambda: viewer.state.get("denoised"), 60)
    picture, bias = alight.denoise(film)
    assert viewer.state["denoised"] == bias.line
    expected = shaded("picture", picture.image, Display()).rgba.ravel()
    wait_for(lambda: np.array_equal(viewer.frame(), expected), 20)
    # What is saved, and the layers beside it, are those of the film.
    save(session, tmp_path / "a.exr")
    np.testing.assert_array_equal(alight.outputs.read_image(tmp_path / "a.exr"), film.image)
    session.apply(protocol.Show("error"))
    wait_for(lambda: viewer.state["denoised"] == "", 20)
