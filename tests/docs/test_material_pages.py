"""Every material has a page that says what its file says, and a picture."""

import importlib.util
import itertools
import re
import sys

import numpy as np
import pytest
from PIL import Image

import alight
from alight.core.registry import type_name_of
from tests.docs.pages import ROOT


def script(name):
    """A module of docs/site."""
    path = ROOT / "docs" / "site" / f"{name}.py"
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


material_pages = script("material_pages")
key_page = script("key_page")

MATERIALS = material_pages.materials()
RENEW = "python docs/figures/materials.py --pages rewrites it"


@pytest.mark.parametrize("module", MATERIALS, ids=type_name_of)
def test_page_is_what_the_file_says(module):
    page = material_pages.PAGES / f"{type_name_of(module)}.md"
    assert page.exists(), RENEW
    assert page.read_text(encoding="utf-8") == material_pages.page(module), RENEW


def test_there_is_an_overview_and_nothing_else():
    names = {path.stem for path in material_pages.PAGES.glob("*")}
    assert names == {"index", *map(type_name_of, MATERIALS)}
    overview = (material_pages.PAGES / "index.md").read_text(encoding="utf-8")
    assert overview == material_pages.index(), RENEW


def test_pages_are_in_the_navigation():
    navigation = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    listed = re.findall(r"- materials/(\w+)\.md", navigation)
    assert listed == ["index", *map(type_name_of, MATERIALS)]


@pytest.mark.parametrize("module", MATERIALS, ids=type_name_of)
def test_pages_are_complete(module):
    """No markup of docstrings is left, each key is explained, each formula is closed."""
    text = material_pages.page(module)
    assert ".. math::" not in text
    assert ":math:" not in text
    assert text.count("$$") % 2 == 0
    rows = re.findall(r"^\| `(\w+)` \| (.+?) \| (.*?) \| (.*) \|$", text, re.MULTILINE)
    fields = set(type(module.EXAMPLES[0]).model_fields) - {"type"}
    assert {name for name, *_ in rows} == fields
    assert all(kind.strip() and text.strip() for _, kind, _, text in rows)


@pytest.mark.parametrize("module", MATERIALS, ids=type_name_of)
def test_the_material_of_the_picture_goes_onto_the_ball(module):
    scene = alight.load("material-ball", [f"bsdfs.ball={material_pages.shown(module)}"])
    assert scene.bsdfs["ball"].type_name() == type_name_of(module)


@pytest.mark.parametrize("module", MATERIALS, ids=type_name_of)
def test_picture_is_there_and_bright(module):
    with Image.open(material_pages.IMAGES / f"{type_name_of(module)}.png") as picture:
        assert picture.size == (320, 320)
        grey = np.asarray(picture.convert("L")).mean()
    assert 50 < grey < 200


def test_pictures_are_small():
    sizes = [path.stat().st_size for path in material_pages.IMAGES.glob("*.png")]
    assert sum(sizes) < 1.4e5 * len(MATERIALS)


def test_the_page_of_scene_keys_is_what_the_code_checks():
    found = key_page.PAGE.read_text(encoding="utf-8")
    assert found == key_page.text(), "python docs/site/key_page.py rewrites it"


STRIPS = key_page.STRIPS


def test_each_strip_is_of_a_key_and_is_there():
    page = key_page.PAGE.read_text(encoding="utf-8")
    for name, strip in STRIPS.items():
        assert f"](images/keys/{name}.png)" in page, name
        with Image.open(key_page.IMAGES / f"{name}.png") as picture:
            count = len(strip.values)
            assert picture.size == (112 * count + 4 * (count - 1), 84)
            pixels = np.asarray(picture.convert("RGB"), np.float64)
        # Values that show nothing, or all the same, are no picture of a key.
        parts = [pixels[:, 116 * i : 116 * i + 112] for i in range(count)]
        assert 10.0 < pixels.mean() < 245.0, name
        assert min(np.abs(a - b).mean() for a, b in itertools.pairwise(parts)) > 0.2, name
    files = sorted(path.stem for path in key_page.IMAGES.glob("*.png"))
    assert files == sorted(STRIPS)
    assert sum(path.stat().st_size for path in key_page.IMAGES.glob("*.png")) < 1.5e6
