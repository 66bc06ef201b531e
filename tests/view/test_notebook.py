"""`alight.view(scene)` in a notebook: the film of a render, shown while it grows."""

import hashlib
import json
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

import alight
from alight.view import notebook
from alight.view.frames import frame
from tests.view.browsing import CHROMIUM, launched

SMALL = {"size": 24, "spp": 16, "seed": 5}


@pytest.fixture
def cells(monkeypatch):
    """What cells show, one list of bundles each."""
    shown = []

    def display(bundle, raw, display_id):
        assert raw and display_id
        shown.append([bundle])
        return SimpleNamespace(update=lambda other, raw: shown[-1].append(other))

    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace())
    monkeypatch.setitem(sys.modules, "IPython.display", SimpleNamespace(display=display))
    return shown


@pytest.mark.parametrize("has_widgets", [False, True])
def test_the_film_is_shown_at_the_end(has_widgets, cells, monkeypatch, tmp_path):
    monkeypatch.setattr(notebook, "_widget", lambda stop: widget if has_widgets else None)
    widget = SimpleNamespace(_repr_mimebundle_=lambda: ({"widget": 1}, {}))
    live = alight.view("cornell-box", output=tmp_path / "a.png", **SMALL)
    live._ipython_display_()
    film = live.wait()
    live._thread.join()
    assert live.is_done and film is live.film
    np.testing.assert_array_equal(film.sums, alight.render("cornell-box", **SMALL).sums)
    assert (tmp_path / "a.png").exists()
    first, last = cells[0][0], cells[0][-1]
    assert {"text/plain", "text/html"} <= set(first)
    assert "data:image/png" in last["text/html"] and "16 samples per pixel" in last["text/html"]
    assert last["text/plain"] == repr(live) == "<LiveFilm: done>"
    if has_widgets:
        assert widget.told == {"phase": "done", "share": 1.0, "text": "done", "warnings": []}
        picture, width, height, _ = np.frombuffer(widget.frame[:16], np.uint32)
        assert (picture, width, height) == (0, 24, 24)
        rgba = np.frombuffer(widget.frame[16:], np.uint8).reshape(24, 24, 4)
        shown = alight.RenderOptions().display.apply(film.image)
        np.testing.assert_array_equal(rgba[..., :3], np.rint(shown * 255.0))


@pytest.mark.parametrize("options", [{"background": "transparent"}, {"exposure": 1.5}])
def test_its_last_frame_is_the_picture_that_is_written(options, monkeypatch, tmp_path):
    widget = SimpleNamespace()
    monkeypatch.setattr(notebook, "_widget", lambda stop: widget)
    scene = {
        "alight": 1, "camera": {"transform": {"translate": [0, 0, 4]}},
        "environment": {"type": "constant", "radiance": [0.9, 0.5, 0.2]},
        "nodes": {"ball": {"shape": "sphere"}},
    }  # fmt: skip
    live = alight.view(scene, output=tmp_path / "a.png", **SMALL, **options)
    live.wait()
    live._thread.join()
    with Image.open(tmp_path / "a.png") as file:
        written = np.asarray(file.convert("RGBA"), np.int32)
    frame = np.frombuffer(widget.frame[16:], np.uint8).reshape(24, 24, 4)
    # Files are dithered or rounded: one step apart, at most, where anything is to be seen.
    seen = written[..., 3] > 16
    assert np.abs(written - frame)[seen].max() <= 1
    assert np.abs(written - frame)[..., 3].max() <= 1
    assert (written[..., 3].min() < 255) == ("background" in options)


def test_it_tells_how_far_it_is_and_can_be_stopped(monkeypatch, tmp_path):
    told = []
    live = alight.view(
        "cornell-box", size=24, spp=2**20, output=tmp_path / "a.png",
        progress=lambda report: told.append((report.phase, repr(live))) or live.stop()
        if report.done_samples else None,
    )  # fmt: skip
    film = live.wait()
    assert 0 < film.spp < 2**20 and repr(live) == "<LiveFilm: stopped>"
    assert told[-1][0] == "render"
    # What was not finished leaves no file.
    assert not (tmp_path / "a.png").exists()


def test_a_stop_while_its_files_are_written_comes_too_late(monkeypatch, tmp_path):
    finish = notebook.finish

    def stopped_meanwhile(*arguments):
        live.stop()
        finish(*arguments)

    monkeypatch.setattr(notebook, "finish", stopped_meanwhile)
    live = alight.view("cornell-box", output=tmp_path / "a.png", **SMALL)
    live.wait()
    assert (tmp_path / "a.png").exists() and repr(live) == "<LiveFilm: done>"


def test_shares_of_samples_time_and_error():
    film = SimpleNamespace(
        relmse_estimate=lambda literature: SimpleNamespace(relrmse=SimpleNamespace(value=0.04)),
        spp=12.0,
    )
    progress = alight.Progress("render", 25, 100, 3.0, film)
    options = alight.RenderOptions()
    assert notebook._share(progress, options) == 0.25
    assert notebook._share(progress, options.changed(max_time=6, error=0.01)) == 0.5
    progress = alight.Progress("render", 25, 0, 3.0, film)
    assert notebook._share(progress, options) is None
    assert notebook._share(progress, options.changed(error=0.02)) == pytest.approx(0.25)
    assert notebook._words(progress, 0.25) == "12 spp, error 4.00%, 9 s left"
    assert notebook._words(progress, None) == "12 spp, error 4.00%"


def test_what_is_wrong_is_said_at_once_or_at_the_end():
    with pytest.raises(alight.SceneError, match="cornell-box"):
        alight.view("cornell-bx")
    with pytest.raises(alight.OptionError, match="spp"):
        alight.view("cornell-box", sppp=4)

    def fail(report):
        raise RuntimeError("no more")

    live = alight.view("cornell-box", progress=fail, **SMALL)
    with pytest.raises(RuntimeError, match="no more"):
        live.wait()
    assert "no more" in repr(live)


def test_a_failure_is_shown_below_the_picture():
    def fail(report):
        if report.done_samples:
            raise RuntimeError("no <b>more</b>")

    live = alight.view("cornell-box", progress=fail, **SMALL)
    with pytest.raises(RuntimeError, match="no"):
        live.wait()
    assert live.film.sample_count.any()
    assert "<p>RuntimeError: no &lt;b&gt;more&lt;/b&gt;</p>" in live._repr_html_()


def test_a_page_that_is_lost_does_not_cost_the_film(monkeypatch):
    class Closed:
        def __setattr__(self, name, value):
            raise OSError("closed")

    monkeypatch.setattr(notebook, "_widget", lambda stop: Closed())
    film = alight.view("cornell-box", **SMALL).wait()
    np.testing.assert_array_equal(film.sums, alight.render("cornell-box", **SMALL).sums)


@pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium")
def test_its_module_draws_and_stops_in_a_browser():
    rgba = np.zeros((2, 3, 4), np.uint8)
    rgba[1, 2] = 10, 20, 30, 255
    packed = list(frame(0, 0, rgba))
    # An offset of one byte: no place where numbers of four bytes may begin.
    script = f"""
        const {{ default: widget }} = await import(URL.createObjectURL(
          new Blob([{json.dumps(notebook.module_text())}], {{ type: "text/javascript" }})));
        const bytes = new Uint8Array([0, ...{packed}]);
        const state = {{ frame: new DataView(bytes.buffer, 1), stops: false,
                         told: {{ phase: "render", share: 0.5, text: "8 spp" }} }};
        const heard = {{}};
        let saved = 0;
        const el = document.body;
        widget.render({{ el, model: {{
          get: (name) => state[name], set: (name, value) => {{ state[name] = value; }},
          on: (name, act) => {{ heard[name] = act; }}, save_changes: () => ++saved }} }});
        const canvas = el.querySelector("canvas"), stop = el.querySelector("button");
        const before = [canvas.width, canvas.height, el.querySelector("progress").value,
          el.innerText.includes("8 spp"), ...canvas.getContext("2d").getImageData(2, 1, 1, 1).data];
        stop.click();
        const after = [state.stops, saved, stop.hidden];
        state.told = {{ phase: "done", share: 1, text: "done" }};
        heard["change:told"]();
        return [...before, ...after, stop.hidden];
    """
    with launched() as browser:
        page = browser.new_page()
        found = page.evaluate(f"(async () => {{{script}}})()")
    assert found == [3, 2, 0.5, True, 10, 20, 30, 255, True, 1, False, True]


def test_a_notebook_runs_and_keeps_the_pictures():
    """By nbconvert, with a kernel of Jupyter and a real widget."""
    pytest.importorskip("anywidget")
    pytest.importorskip("ipykernel")
    nbconvert = pytest.importorskip("nbconvert")
    import nbformat
    from nbconvert.preprocessors import ExecutePreprocessor

    begin = "import alight\nlive = alight.view('cornell-box', size=24, spp=16, seed=5)\nlive"
    tell = "import hashlib\nfilm = live.wait()\nprint(hashlib.sha256(film.sums).hexdigest())"
    cells = (begin, f"{tell}\nprint(type(live._widget).__name__)", "film")
    made = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(text) for text in cells])
    ExecutePreprocessor(timeout=300, kernel_name="python3").preprocess(made, {})
    film = alight.render("cornell-box", **SMALL)
    printed = made.cells[1].outputs[0].text.split()
    assert printed == [hashlib.sha256(film.sums).hexdigest(), "Widget"]
    body, _ = nbconvert.HTMLExporter().from_notebook_node(made)
    assert body.count("data:image/png") >= 2 and "16 samples per pixel" in body


def test_frames_take_their_share_of_the_time_and_no_more(monkeypatch):
    """Each one costs as much as fifty reports; the clock is ours."""
    clock, costs = [0.0], 0.5
    monkeypatch.setattr(notebook.time, "perf_counter", lambda: clock[0])
    monkeypatch.setattr(notebook, "_share", lambda progress, options: None)
    monkeypatch.setattr(notebook, "_words", lambda progress, share: "")
    live = object.__new__(notebook.LiveFilm)
    live.film, live._next, live._widget = None, 0.0, SimpleNamespace()
    live._prepared = SimpleNamespace(options=SimpleNamespace(progress=None))
    spent = 0.0

    def show(phase, share):
        nonlocal spent
        spent += costs
        clock[0] += costs

    live._show = show
    while clock[0] < 200.0:
        live._take(SimpleNamespace(film=None, phase="render"))
        clock[0] += 0.01
    assert 0.8 * notebook._SHARE < spent / clock[0] <= 1.05 * notebook._SHARE
