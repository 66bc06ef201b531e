"""UsdUVTexture beyond the edges: its own wrap, else that of the picture, else it is told."""

import itertools

import numpy as np
import OpenEXR
import pytest
from PIL import Image, PngImagePlugin

from alight.formats import load
from alight.outputs.wraps import read_wraps
from tests.formats.usd.stage import TEXTURED, stage_text

pytest.importorskip("pxr")

WRAPS = ("repeat", "mirror", "clamp")
#: As OpenEXR's standard attribute calls them.
EXR_WORDS = {"repeat": "periodic", "mirror": "mirror", "clamp": "clamp"}


@pytest.fixture
def read(tmp_path):
    """Reads a stage whose texture has some wraps of its own; the wraps, and what is remarked."""

    def run(file, u=1.0, v=1.0, **own):
        wraps = "\n        ".join(f'token inputs:{key} = "{own[key]}"' for key in own)
        text = stage_text(TEXTURED.format(file=file, inputs=wraps, nodes="", u=u, v=v))
        (tmp_path / "a.usda").write_text(text)
        scene = load(tmp_path / "a.usda")
        texture = next(iter(scene.bsdfs.values())).bsdf.base_color
        said = [text for text in scene.source.remarks.warnings if "repeats" in text]
        return (texture.wrap, texture.wrap_v or texture.wrap), "".join(said)

    return run


def exr(folder, wraps):
    header = {} if wraps is None else {"wrapmodes": ",".join(EXR_WORDS[w] for w in wraps)}
    OpenEXR.File(header, {"RGB": np.ones((2, 2, 3), np.float32)}).write(str(folder / "p.exr"))
    return "p.exr"


def png(folder, wraps):
    texts = PngImagePlugin.PngInfo()
    for key, wrap in zip(("wrapS", "wrapT"), wraps, strict=True):
        texts.add_text(key, wrap)
    Image.new("RGB", (2, 2)).save(folder / "p.png", pnginfo=texts)
    return "p.png"


@pytest.mark.parametrize("wraps", [*itertools.permutations(WRAPS, 2), ("mirror", "mirror")])
@pytest.mark.parametrize("write", [exr, png])
def test_pictures_say_what_is_beyond_their_edges(write, wraps, tmp_path, read):
    file = write(tmp_path, wraps)
    assert read(file, 3.0, 3.0) == (wraps, "")
    assert read(file, wrapS="useMetadata", wrapT="useMetadata") == (wraps, "")
    # What the texture itself says counts more.
    other = WRAPS[WRAPS.index(wraps[0]) - 1]
    assert read(file, 3.0, wrapS=other) == ((other, wraps[1]), "")


@pytest.mark.parametrize(("u", "v"), [(1.0, 1.0), (1.5, 1.0), (1.0, -0.5), (2.0, 2.0)])
def test_a_picture_that_says_nothing_repeats_and_it_is_told_where_it_shows(u, v, tmp_path, read):
    wraps, said = read(exr(tmp_path, None), u, v)
    assert wraps == ("repeat", "repeat")
    assert ("wrapS" in said) == (u > 1.0)
    assert ("wrapT" in said) == (not 0.0 <= v <= 1.0)
    assert read("p.exr", u, v, wrapS="repeat", wrapT="repeat") == (wraps, "")


def test_black_beyond_the_edges_becomes_their_colour_and_it_is_told(tmp_path, read):
    exr(tmp_path, None)
    assert read("p.exr", wrapS="black", wrapT="mirror")[0] == ("clamp", "mirror")
    scene = load(tmp_path / "a.usda")
    assert any("wrapS black became clamp" in text for text in scene.source.remarks.warnings)


@pytest.mark.parametrize("both", [None, "periodic", "clamp,mirror"])
@pytest.mark.parametrize("s", [None, "black"])
@pytest.mark.parametrize("t", [None, "clamp"])
def test_an_axis_has_its_own_word_or_that_of_both(both, s, t, tmp_path):
    said = {"wrapmodes": both, "wrapS": s, "wrapT": t}
    header = {key: word for key, word in said.items() if word is not None}
    path = tmp_path / "p.exr"
    OpenEXR.File(header, {"RGB": np.ones((2, 2, 3), np.float32)}).write(str(path))
    words = {None: ("", ""), "periodic": ("repeat", "repeat"), "clamp,mirror": ("clamp", "mirror")}
    assert read_wraps(path) == tuple(
        own or common for own, common in zip((s, t), words[both], strict=True)
    )
