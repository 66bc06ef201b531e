"""What is suspicious of a scene is told by every way in, each thing once."""

import html
import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

import alight
from alight.cli.main import app
from alight.compiled.warnings.scenes import warnings_of_scene
from alight.lab.sheet.tiles import render_tile
from alight.options.view import ViewOptions
from alight.rendering.executors.blocks import Threads
from alight.rendering.main_loop import render_film
from alight.view.opening import session_of
from tests.view.looking import settled

#: With the kernels of the Cornell box: a sensor that is not used, and a shape too far away.
ODD = """<scene version="3.0.0">
  <integrator type="path"/>
  <sensor type="perspective">
    <transform name="to_world"><lookat origin="0, 0, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/>
      <rfilter type="box"/></film>
    <sampler type="ldsampler"/>
  </sensor>
  <sensor type="perspective"/>
  <shape type="rectangle"/>
  <shape type="rectangle">
    <transform name="to_world"><scale value="0.001"/><translate x="1e6"/></transform>
  </shape>
  <shape type="rectangle">
    <transform name="to_world"><rotate y="1" angle="180"/><translate z="6"/></transform>
    <emitter type="area"><rgb name="radiance" value="9"/></emitter>
  </shape>
</scene>
"""

STUDY = """
scenes: [odd.xml]
spp: [1, 2]
replicates: 4
baseline: one
equal_time: false
arms: {one: {}, other: {integrator: {type: path, rr_depth: 3}}}
"""


@pytest.fixture
def told(tmp_path, monkeypatch):
    """All warnings of a scene in a file of the present folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "odd.xml").write_text(ODD)
    (tmp_path / "study.yaml").write_text(STUDY)
    found = warnings_of_scene(alight.load("odd.xml"))
    assert ["first sensor" in found[0], "float32" in found[1], len(found)] == [True, True, 2]
    return found


def said(*words):
    result = CliRunner().invoke(app, [str(word) for word in words])
    assert result.exit_code == 0, result.output
    return result.stderr


def rendered():
    return alight.render("odd.xml", spp=4)


def in_a_notebook():
    live = alight.view("odd.xml", spp=4)
    live.wait()
    live._thread.join()
    return live._repr_html_()


def on_the_page():
    session = session_of("odd.xml", ViewOptions(spp=4))
    # Before the first sample, which a film brings with the same warnings.
    at_once = session.state(None, None)["warnings"]
    settled(session)
    assert session.state(None, None)["warnings"] == at_once
    session.close()
    return "\n".join(at_once)


def resumed():
    said("render", "odd.xml", "--spp", 4, "--checkpoint", "a.checkpoint", "-o", "a.png")
    return said("resume", "a.checkpoint", "--spp", 8, "-o", "a.png")


def counted():
    said("render", "odd.xml", "--spp", 4, "--stats", "a.json", "-o", "a.png")
    return "\n".join(json.loads(Path("a.json").read_text())["warnings"])


def studied():
    text = said("study", "study.yaml", "-o", "found")
    (scene,) = json.loads(Path("found/results.json").read_text())["scenes"]
    assert all(text.count(note) == 1 for note in scene["notes"])
    return "\n".join(scene["notes"])


WAYS = {
    "render": lambda: said("render", "odd.xml", "--spp", 4, "-o", "a.png"),
    "animate": lambda: said("render", "odd.xml", "--turntable", "--frames", "0:2", "--spp", 4,
                            "-o", "a####.png"),
    "resume": resumed,
    "statistics": counted,
    "check": lambda: said("check", "odd.xml", "--only", "numbers"),
    "verdict": lambda: alight.check("odd.xml", only="numbers")._repr_html_(),
    "info": lambda: said("info", "odd.xml"),
    "trace": lambda: said("trace", "odd.xml", "--pixel", "4,4"),
    "film": lambda: "\n".join(rendered().warnings),
    "film in a notebook": lambda: rendered()._repr_html_(),
    "live film in a notebook": in_a_notebook,
    "page": on_the_page,
    "study": studied,
    "contact sheet": lambda: "\n".join(render_tile("odd.xml", (8, 8), spp=4).approximated),
}  # fmt: skip


@pytest.mark.parametrize("way", WAYS)
def test_every_way_in_tells_everything_once(way, told):
    text = html.unescape(WAYS[way]())
    assert [text.count(warning) for warning in told] == [1] * len(told), text


def test_it_is_told_before_threads_or_a_cluster_begin(told):
    """Also where no progress bar is shown: `film` has the warnings, and no sample."""
    heard, films, before = [], [], []

    class Watched(Threads):
        def begin(self, job):
            before.extend(heard)
            super().begin(job)

    def listen(progress):
        films.append((progress.phase, progress.film.spp))
        heard.extend(text for text in progress.film.warnings if text not in heard)

    with Watched() as executor:
        render_film(alight.load("odd.xml"), alight.RenderOptions(spp=4, progress=listen), executor)
    assert before == list(told)
    assert films[0] == ("compile", 0)
