"""The studio and the camera that stand in for what a file lacks go when the user replaces them."""

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from alight.cli.main import app
from alight.formats import load
from alight.formats.scenes.surroundings import STUDIO
from tests.formats.gltf.maker import Maker

TURN = np.radians(100.0)


@pytest.fixture
def files(tmp_path):
    """A model without a light, once with two cameras and once with none; and a picture."""
    for name, cameras in (("two.glb", True), ("none.glb", False)):
        m = Maker()
        m.node(mesh=m.square())
        if cameras:
            m.json["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1.0}}]
            m.node(camera=0, name="front", rotation=[0, np.sin(0.05), 0, np.cos(0.05)])
            half = 0.5 * TURN
            m.node(camera=0, name="side", rotation=[0, np.sin(half), 0, np.cos(half)])
        (tmp_path / name).write_bytes(m.glb())
    Image.new("RGB", (4, 2), (255, 255, 255)).save(tmp_path / "sky.png")
    return tmp_path


def said(scene):
    """Which of the three remarks there are."""
    words = {"light": "a soft studio stands", "camera": "one was placed", "first": "first camera"}
    return {key for key, text in words.items() if any(text in line for line in scene.warnings)}


@pytest.mark.parametrize(
    ("name", "changes", "remarks"),
    [
        ("two.glb", [], {"light", "first"}),
        ("two.glb", ["camera=1"], {"light"}),
        ("two.glb", ["environment.file=sky.png"], {"first"}),
        ("two.glb", ["environment={type: constant}"], {"first"}),
        ("two.glb", ["environment=null", "camera=side"], set()),
        ("none.glb", ["environment.scale=2", "film.size=[8, 8]"], {"light", "camera"}),
        ("none.glb", ["camera.fov=20"], {"light", "camera"}),
        ("none.glb", ["camera.transform={translate: [0, 0, 9]}"], {"light"}),
        ("none.glb", ["environment.file=sky.png"], {"camera"}),
    ],
)
def test_what_was_replaced_is_no_longer_told_of(name, changes, remarks, files):
    assert said(load(files / name, changes)) == remarks


def test_the_studio_turns_to_the_camera_that_was_chosen(files):
    first, chosen = (load(files / "two.glb", c) for c in ([], ["camera=side"]))
    assert first.environment.rotate == pytest.approx(np.degrees(0.1) - 30.0)
    assert chosen.environment.rotate == pytest.approx(70.0)
    assert chosen.environment.file == STUDIO
    by_hand = load(files / "two.glb", ["camera=side", "environment.rotate=5"])
    assert by_hand.environment.rotate == 5.0


def test_another_picture_stands_as_it_is(files):
    """It was the studio that was turned, for its box to be on the viewer's left."""
    assert load(files / "two.glb", ["environment.file=sky.png"]).environment.rotate == 0.0
    turned = ["environment.file=sky.png", "environment.rotate=15"]
    assert load(files / "two.glb", turned).environment.rotate == 15.0


def test_info_says_what_stands_there(files):
    path = str(files / "two.glb")
    with_sky = ["info", path, "--set", f"environment.file={files / 'sky.png'}", "--camera", "1"]
    for arguments, expected in ((["info", path], True), (with_sky, False)):
        done = CliRunner().invoke(app, arguments)
        assert done.exit_code == 0
        assert ("studio" in done.stderr) == expected
        assert ("first camera" in done.stderr) == expected
