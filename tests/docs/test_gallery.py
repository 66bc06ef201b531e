"""The gallery shows every built-in scene, with the command that renders it."""

import re

from PIL import Image

from alight.formats import builtin_names
from tests.docs.pages import ROOT

GALLERY = (ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")


def test_every_scene_is_in_the_gallery():
    commands = set(re.findall(r"`alight render ([\w-]+)", GALLERY))
    assert commands == set(builtin_names())


def test_every_picture_is_shown_with_its_command():
    shown = re.findall(r"\(images/gallery/([\w-]+)\.png\)<br>`alight render ([\w-]+)", GALLERY)
    assert all(picture == scene for picture, scene in shown)
    files = (ROOT / "docs" / "images" / "gallery").glob("*.png")
    assert {picture for picture, _ in shown} == {path.stem for path in files}


def test_pictures_fit_a_page():
    for path in (ROOT / "docs" / "images" / "gallery").glob("*.png"):
        with Image.open(path) as picture:
            assert 320 <= picture.width <= 640, path.name
        assert path.stat().st_size < 400_000, path.name
