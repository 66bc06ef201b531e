"""``alight sheet``: which files it shows, what is said of each, and that none is left out."""

import math
import threading

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from alight.cli.main import app
from alight.core.errors import OptionError
from alight.core.registration import unregister
from alight.lab.sheet import Tile, find_scenes
from alight.lab.sheet.tiles import fitted
from alight.lab.sheet.views import draw_sheet
from alight.options.render import RenderOptions
from tests.cli.stub import StubRender
from tests.extension.models import LAMBERT

SCENE = "alight: 1\ncamera: {type: pinhole}\nfilm: {size: [64, 32]}\nenvironment: constant\n"
TILE = (160, 100)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Two scenes, a broken one and the parts of one; renders are noise."""

    def render(scene, *, spp, time_limit, threads):
        options = {"aovs": (), "replicates": 4, "seed": 0, "spp": spp}
        seen = {"progress": lambda p: None, "cancel": threading.Event()}
        return StubRender()(scene, RenderOptions(**seen, **options))

    monkeypatch.setattr("alight.lab.sheet.tiles.render", render)
    (tmp_path / "b.yaml").write_text(SCENE)
    (tmp_path / "A.yaml").write_text(SCENE + "sampler: sobol\n")
    (tmp_path / "c.yaml").write_text(SCENE + "nodez: {}\n")
    (tmp_path / "notes.txt").write_text("no scene")
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "mesh.obj").write_text("v 0 0 0\n")
    (tmp_path / "empty").mkdir()
    return tmp_path


def run(*arguments):
    return CliRunner().invoke(app, ["sheet", *map(str, arguments)])


def test_a_folder_is_its_scenes_and_parts_below_are_said_not_to_be_entered(folder):
    found, closed = find_scenes([str(folder), "cornell-box", str(folder / "b.yaml")])
    assert found == [*(str(folder / f"{name}.yaml") for name in "Abc"), "cornell-box"]
    assert closed == [folder / "parts"]
    # A folder of folders is what lies in them.
    assert find_scenes([str(folder / "parts")]) == ([str(folder / "parts" / "mesh.obj")], [])
    with pytest.raises(OptionError, match=r"empty: the folder holds no scene file \(.yaml, "):
        find_scenes([str(folder / "empty")])


def test_what_fails_is_on_the_sheet_with_its_message(folder, tmp_path):
    page, picture = tmp_path / "out.html", tmp_path / "out.png"
    note = "Scenes: <made> here"
    result = run(folder, "-o", picture, "-o", page, "--spp", 4, "--tile", "160x100",
                 "--columns", 2, "--note", note)  # fmt: skip
    assert result.exit_code == 1
    assert "[3/3]" in result.output
    assert 'unknown key "nodez"; did you mean "nodes"?' in result.stderr
    text = page.read_text(encoding="utf-8")
    assert text.count("data:image/png") == 2
    assert "did you mean &#34;nodes&#34;?" in text
    assert "Scenes: &lt;made&gt; here" in text
    assert "Not entered, as scenes lie above" in text
    assert "3 scenes" in text
    assert "1 without a picture" in text
    with Image.open(picture) as shown:
        assert shown.width == 2 * 160 + 12 + 2 * 16
        # The two pictures are 160 x 80 in the middle of their tiles, on grey.
        pixels = np.array(shown.convert("RGB")).astype(int)
    first = pixels[16:116, 16:176]
    assert (first[:10] == first[0, 0]).all()
    assert (first[10:90].std(axis=(0, 1)) > 10).all()
    assert (first[90:] == first[0, 0]).all()
    # The message is red.
    third = pixels[16 + 157 : 16 + 257, 16:176]
    assert (third[..., 0] - third[..., 2]).max() > 100


def test_scenes_with_models_of_a_script(folder, tmp_path):
    script = tmp_path / "mine.py"
    script.write_text(f"{LAMBERT}\nimport alight\nalight.register(__name__)\n")
    scene = tmp_path / "mine.yaml"
    scene.write_text(f"{SCENE}bsdfs: {{a: {{type: lambert}}}}\n")
    words = [scene, "-o", tmp_path / "sheet.png"]
    assert "--plugin" in run(*words).stderr
    try:
        assert run(*words, "--plugin", script).exit_code == 0
    finally:
        unregister("bsdfs", "lambert")
    wrong = run(*words, "--plugin", tmp_path / "none.py")
    assert wrong.exit_code == 2
    assert wrong.stderr.startswith("error: --plugin: there is no file ")


def test_a_sheet_without_failures_ends_well(folder, tmp_path):
    result = run(folder / "b.yaml", "-o", tmp_path / "out.jpg", "-q", "--spp", 4)
    assert (result.exit_code, result.output) == (0, "")
    with Image.open(tmp_path / "out.jpg") as shown:
        assert shown.format == "JPEG"


def test_ctrl_c_keeps_what_there_is(folder, tmp_path, monkeypatch):
    import alight.lab.sheet.tiles as tiles

    first, calls = tiles.render, []

    def render(*arguments, **options):
        calls.append(1)
        if len(calls) == 2:
            raise KeyboardInterrupt
        return first(*arguments, **options)

    monkeypatch.setattr(tiles, "render", render)
    page = tmp_path / "out.html"
    result = run(folder, "-o", page, "--spp", 4)
    assert result.exit_code == 130
    assert "Stopped after 1 of 3 scenes." in page.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--tile", "8x100"], "--tile: must be 16 to 4096 pixels wide and high, got 8x100"),
        (["--tile", "big"], "--tile: must be WIDTHxHEIGHT"),
        (["-o", "out.exr"], 'unknown suffix ".exr"'),
        (["--exposure", "loud"], "exposure must be auto"),
    ],
)
def test_wrong_options_are_refused_before_the_first_scene(arguments, message, folder):
    result = run(folder, *arguments)
    assert result.exit_code == 2
    assert message in result.stderr
    assert "[1/" not in result.output


def test_pictures_are_as_large_as_fits():
    assert fitted((800, 600), (256, 192)) == (256, 192)
    assert fitted((100, 1000), (256, 192)) == (19, 192)
    assert fitted((100_000, 1), (256, 192)) == (256, 1)


def test_facts_name_what_is_not_known():
    tile = Tile("a/b", "glb", spp=64.0, seconds=1.234, error=math.nan, dropped=("x", "y"))
    assert tile.facts == ["64 spp, 1.23 s, error unknown", "2 dropped"]
    assert Tile("a", "glb", error=0.0123).facts[1] == "read as it is"
    assert Tile("a", "glb", error=1300.0).facts[0].endswith("± over 1000 %")


def test_long_names_and_messages_stay_in_their_tiles():
    long = Tile("x" * 300, "glb", message="word " * 500 + "y" * 400)
    alone = np.array(draw_sheet([long], TILE, 1, ()))
    beside = np.array(draw_sheet([long, Tile("a", "glb", message="b")], TILE, 2, ()))
    np.testing.assert_array_equal(alone[:, : 16 + 160], beside[:, : 16 + 160])
    # Nothing runs into the margin on the right.
    assert (alone[:, 16 + 160 :] == 255).all()
