"""The page's scripts in a browser, beside a server that only keeps what it is told.

Nothing is rendered: what each control sends, and where each word of a message is shown, is compared
with a second entry of it.
"""

import json
import mimetypes
from pathlib import Path

import numpy as np
import pytest

import alight
from alight.core.srgb import decode_srgb
from tests.view.browsing import CHROMIUM, launched
from tests.view.said import FILM, FRAME, NOTEBOOK, PIXELS, SCENE, SOCKET

pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium")

FILES = Path(alight.__file__).with_name("view") / "page"


@pytest.fixture(scope="module")
def browser():
    with launched() as made:
        yield made


@pytest.fixture
def page(browser):
    """The page with a scene, before anything is asked of it."""

    def answer(route):
        file = FILES / (route.request.url.rpartition("/")[2] or "index.html")
        kind = mimetypes.guess_type(file.name)[0]
        route.fulfill(body=file.read_bytes(), content_type=kind)

    made, errors = browser.new_page(viewport={"width": 1200, "height": 760}), []
    made.on("pageerror", lambda error: errors.append(str(error)))
    made.route("**/*", answer)
    made.add_init_script(SOCKET)
    made.goto("http://view.test/")
    made.wait_for_selector("body[data-connected=true]")
    told(made, SCENE)
    sent(made)
    yield made
    made.close()
    assert not errors


def told(page, message):
    """Let the server say something."""
    page.evaluate("message => socket.onmessage({ data: JSON.stringify(message) })", message)


def sent(page):
    """What the page has sent since the last time, after the next frame of the screen."""
    script = "new Promise((done) => requestAnimationFrame(() => done(window.sent.splice(0))))"
    return page.evaluate(script)


def texts(page, *names):
    return {name: page.inner_text(f"#{name}") for name in names}


def is_hidden(page, *names):
    return {name: page.evaluate(f"document.getElementById('{name}').hidden") for name in names}


def box(page):
    found = page.locator("#picture").bounding_box()
    return found["x"], found["y"], found["width"], found["height"]


KEYS = {
    "w": {"do": "fly", "right": 0, "up": 0, "ahead": 0.06},
    "s": {"do": "fly", "right": 0, "up": 0, "ahead": -0.06},
    "a": {"do": "fly", "right": -0.06, "up": 0, "ahead": 0},
    "d": {"do": "fly", "right": 0.06, "up": 0, "ahead": 0},
    "r": {"do": "fly", "right": 0, "up": 0.06, "ahead": 0},
    "f": {"do": "fly", "right": 0, "up": -0.06, "ahead": 0},
    "ArrowLeft": {"do": "orbit", "x": -0.06, "y": 0},
    "ArrowRight": {"do": "orbit", "x": 0.06, "y": 0},
    "ArrowUp": {"do": "orbit", "x": 0, "y": -0.06},
    "ArrowDown": {"do": "orbit", "x": 0, "y": 0.06},
    "q": {"do": "roll", "by": -0.06},
    "e": {"do": "roll", "by": 0.06},
    "[": {"do": "widen", "by": -0.06},
    "]": {"do": "widen", "by": 0.06},
    "Home": {"do": "camera", "name": "eye"},
    "l": {"do": "show", "layer": "error"},
    ",": {"do": "develop", "exposure": 1.0, "tone_map": "agx", "white_balance": "4300k"},
    ".": {"do": "develop", "exposure": 2.0, "tone_map": "agx", "white_balance": "4300k"},
    "c": {"do": "keep"},
    "m": {"do": "more"},
    "x": {"do": "stop"},
    "Control+z": {"do": "undo"},
    "Control+Shift+Z": {"do": "redo"},
}


def test_each_key_says_its_own_word(page):
    page.focus("#stage")
    for key, word in KEYS.items():
        page.keyboard.press(key)
        assert sent(page) == [word], key
    # In a field keys are letters.
    page.click("#tabs >> text=Scene")
    page.focus("#find")
    for key in ("w", "m", "Control+z"):
        page.keyboard.press(key)
    assert sent(page) == []
    # Of a film there is no camera, no region, and no render to go on with or to end.
    assert "orbit" in page.text_content("#keys")
    told(page, FILM)
    assert not any(word in page.text_content("#keys") for word in ("orbit", "camera", "undo"))
    page.focus("#stage")
    ends = ("m", "x", "Control+z", "Control+Shift+Z")
    for key in ("w", "ArrowUp", "q", "[", "Home", "b", "g", "t", *ends):
        page.keyboard.press(key)
    assert sent(page) == []
    assert page.get_attribute("#select", "aria-pressed") != "true"
    assert page.get_attribute("#focus", "aria-pressed") != "true"
    for key, pressed in (("p", True), ("p", False)):
        page.keyboard.press(key)
        assert page.is_hidden("#panel") is pressed


def test_each_control_says_its_own_word(page):
    develop = {"do": "develop", "exposure": 1.5, "tone_map": "agx", "white_balance": "4300k"}
    for control, word in {
        "narrow": {"do": "widen", "by": -0.1}, "wide": {"do": "widen", "by": 0.1},
        "roll-left": {"do": "roll", "by": -0.1}, "roll-right": {"do": "roll", "by": 0.1},
        "reset": {"do": "camera", "name": "eye"}, "stop": {"do": "stop"},
    }.items():  # fmt: skip
        page.click(f"#{control}")
        assert sent(page) == [word], control
    page.select_option("#camera", "")
    assert sent(page) == [{"do": "camera", "name": ""}]
    page.click("#tabs >> text=Display")
    page.select_option("#layer", "depth")
    assert sent(page) == [{"do": "show", "layer": "depth"}]
    page.fill("#exposure", "-2")
    assert sent(page) == [develop | {"exposure": -2}]
    page.select_option("#tone", "none")
    assert sent(page) == [develop | {"tone_map": "none"}]
    page.fill("#kelvin", "5200")
    assert sent(page) == [develop | {"white_balance": "5200K"}]
    page.select_option("#white", "auto")
    assert sent(page) == [develop | {"white_balance": "auto"}]
    page.check("#denoise")
    assert sent(page) == [{"do": "denoise", "on": True}]
    page.click("#keep")
    assert sent(page) == [{"do": "keep"}]
    told(page, SCENE | {"against": True})
    page.select_option("#way", "difference")
    assert sent(page)[-1] == {"do": "contrast", "way": "difference"}
    page.focus("#stage")
    page.keyboard.press("c")
    page.click("#drop")
    assert sent(page) == [{"do": "drop"}, {"do": "drop"}]


def test_the_pointer_moves_the_camera_or_the_picture(page):
    x, y, _, height = box(page)
    scale = height / 30

    def drag(dx, dy, **how):
        page.mouse.move(x + 100, y + 80)
        page.mouse.down(**how)
        page.mouse.move(x + 100 + dx, y + 80 + dy)
        page.mouse.up(**how)
        return sent(page)

    pivot = {"do": "pivot", "x": int(100 / scale), "y": int(80 / scale)}
    by = {"x": pytest.approx(60 / height), "y": pytest.approx(-30 / height)}
    assert drag(60, -30) == [pivot, {"do": "orbit", **by}, {"do": "rest"}]
    assert drag(60, -30, button="right") == [pivot, {"do": "pan", **by}, {"do": "rest"}]
    page.mouse.wheel(0, -200)
    assert sent(page) == [{"do": "dolly", "by": pytest.approx(0.4)}]
    # What is under the pointer stays there when the picture is zoomed into.
    page.mouse.move(x + 200, y + 90)
    page.keyboard.down("Control")
    page.mouse.wheel(0, -200)
    page.keyboard.up("Control")
    assert sent(page) == []
    there = box(page)
    factor = np.exp(2 * 0.4)
    assert there[3] == pytest.approx(factor * height, rel=1e-3)
    assert (x + 200 - there[0], y + 90 - there[1]) == pytest.approx(
        (200 * factor, 90 * factor), abs=1.5
    )
    page.mouse.click(x + 300, y + 200)
    [word] = sent(page)
    assert word == {
        "do": "pixel", "x": int((x + 300 - there[0]) / (scale * factor)),
        "y": int((y + 200 - there[1]) / (scale * factor)),
    }  # fmt: skip
    assert page.get_attribute("[role=tab] >> text=Inspect", "aria-selected") == "true"
    # A film's picture itself is drawn.
    told(page, FILM)
    assert drag(25, -40) == []
    moved = box(page)
    assert (moved[0] - there[0], moved[1] - there[1]) == pytest.approx((25, -40), abs=0.5)
    page.focus("#stage")
    page.keyboard.press("0")
    assert box(page) == pytest.approx((x, y, *box(page)[2:]), abs=0.5)
    page.keyboard.press("+")
    assert box(page)[3] == pytest.approx(1.5 * height, rel=1e-3)


def test_a_place_is_asked_about(page):
    page.click("#tabs >> text=Inspect")
    x, y, _, height = box(page)
    scale = height / 30
    page.mouse.click(x + 10.5 * scale, y + 7.5 * scale)
    sent(page)
    told(page, {"is": "pixel", "x": 10, "y": 7, "values": {"picture": [0.5, None, 2e-7]}})
    assert page.inner_text("#where") == "column 10, row 7; red, green, blue"
    assert page.inner_text("#pixel tbody").split() == ["picture", "0.5000", "–", "2.000e-7"]
    for control, sample in (("trace", 0), ("trace-after", 1), ("trace-after", 2),
                            ("trace-before", 1)):  # fmt: skip
        page.click(f"#{control}")
        assert sent(page) == [{"do": "trace", "x": 10, "y": 7, "sample": sample}]
        told(page, {
            "is": "trace", "x": 10, "y": 7, "number": 3, "value": [0.1, 0.2, 0.3],
            "lines": [{"kind": "path", "points": [[1, 2], [3, 4]]}],
            "vertices": [{"depth": 1, "place": "nodes/wall", "bsdf": "rough_glass", "lobe": "coat",
                          "contribution": [0.4, 0.4, 0.4]}],
        })  # fmt: skip
        assert page.inner_text("#sample") == f"sample {sample}"
    assert " ".join(page.inner_text("#vertices tbody").split()) == (
        "1 nodes/wall rough glass, coat 0.4 in all 0.1 0.2 0.3"
    )
    line = page.locator("#overlay line.path").last
    assert [line.get_attribute(key) for key in ("x1", "y1", "x2", "y2")] == ["1", "2", "3", "4"]
    page.keyboard.down("Alt")
    page.mouse.move(x + 20.5 * scale, y + 18.5 * scale)
    page.mouse.down()
    page.mouse.move(x + 5.5 * scale, y + 12.5 * scale)
    page.mouse.up()
    page.keyboard.up("Alt")
    region = {"x": 5, "y": 12, "width": 16, "height": 7}
    assert page.inner_text("#region") == "16 × 7 pixels from column 5, row 12"
    page.click("#why")
    assert sent(page) == [{"do": "why", **region}]
    assert page.is_disabled("#why")
    told(page, {"is": "why", "error": 0.25, "parts": [["light `lamp`", 0.75, 0.02]],
                "tables": [["by depth", [["2", "60 %"], ["3", "40 %"]]]]})  # fmt: skip
    assert page.is_enabled("#why")
    because = page.evaluate("document.getElementById('because').textContent")
    assert because == (
        "A sample of a pixel is off by 25.0 %. Of its variance:light lamp75.0 % ± 2.0"
        "by depth260 %340 %"
    )
    page.click("#part")
    assert sent(page) == [{"do": "region", **region}]
    assert page.is_hidden("#deselect")
    told(page, SCENE | {"is_part": True})
    page.click("#whole")
    assert sent(page) == [{"do": "whole"}]


def test_each_figure_of_the_state_stands_in_its_own_place(page):
    assert texts(page, "title", "phase", "error", "interval", "promise", "verdict", "biases",
                 "lens") == {
        "title": "a room", "phase": "6 of 24 spp", "error": "3.21 %",
        "interval": "relRMSE, 95 % interval 2.97 % to 3.45 %", "promise": "asked 2.00 %",
        "verdict": "soon", "biases": "a bias", "lens": "Field of view 41.3°",
    }  # fmt: skip
    assert page.inner_text("#facts").split("\n") == [
        "size", "40 × 30", "samples per pixel", "6", "time", "2.3 s", "rate", "7.13 Msamples/s",
        "seed", "11",
    ]  # fmt: skip
    assert page.evaluate("document.getElementById('progress').value") == 0.25
    assert page.is_disabled("#more")
    assert page.is_enabled("#stop")
    page.click("#tabs >> text=Display")
    assert texts(page, "stops", "kelvin-told") == {"stops": "1.50", "kelvin-told": "4300 K"}
    assert page.is_enabled("#denoise")
    told(page, SCENE | {"layer": "error", "scale": [0.01, 0.5], "white_balance": "none",
                        "can_denoise": False, "exposure": -0.25, "phase": "done"})  # fmt: skip
    assert texts(page, "low", "high", "stops", "denoised") == {
        "low": "1.00 %", "high": "50.0 %", "stops": "-0.25",
        "denoised": "needs a film and the extra “denoise”",
    }  # fmt: skip
    assert page.is_disabled("#denoise")
    assert is_hidden(page, "of-kelvin", "scale", "of-way", "of-split", "drop") == {
        "of-kelvin": True, "scale": False, "of-way": True, "of-split": True, "drop": True,
    }  # fmt: skip
    told(page, SCENE | {"against": True, "way": "difference", "rival": "before",
                        "contrast": {"mean": 0.125, "low": 0.05, "high": 0.75}})  # fmt: skip
    assert texts(page, "differs", "contrast-low", "contrast-high") == {
        "differs": "root of the relative MSE 12.5 %", "contrast-low": "5.00 %",
        "contrast-high": "75.0 %",
    }  # fmt: skip
    told(page, FILM | {"error": None, "replicates": 8, "spp": 6, "phase": "done"})
    page.click("#tabs >> text=Render")
    assert texts(page, "error", "interval", "phase") == {
        "error": "–", "interval": "unknown below 8 samples per pixel", "phase": "6 of 24 spp",
    }  # fmt: skip
    assert is_hidden(page, "of-camera", "more", "progress", "of-error") == {
        "of-camera": True, "more": True, "progress": True, "of-error": False,
    }  # fmt: skip
    told(page, SCENE | {"phase": "failed", "problem": "no light"})
    assert texts(page, "phase", "notice") == {"phase": "failed", "notice": "no light"}


def test_a_part_of_the_scene_is_chosen_and_edited(page):
    page.click("#tabs >> text=Scene")
    told(page, {"is": "tree", "items": [["bsdfs.red", "red", "materials", "rough_plastic"],
                                        ["nodes.ball", "ball", "nodes", "sphere"]]})  # fmt: skip
    page.fill("#find", "sph")
    assert page.locator("#tree > *").all_text_contents() == ["nodes", "ballsphere"]
    page.click("#tree [data-path='nodes.ball']")
    assert sent(page) == [{"do": "fields", "item": "nodes.ball"}]
    page.click("#steps >> text=+ rotate")
    assert sent(page) == [{"do": "add step", "item": "nodes.ball", "step": "rotate"}]
    fields = [
        {"path": "a.radius", "label": "radius", "kind": "number", "value": 2, "low": 1, "high": 5},
        {"path": "a.color", "label": "colour", "kind": "color", "value": [0.2, 0.5, 3]},
        {"path": "a.on", "label": "on", "kind": "truth", "value": False},
    ]  # fmt: skip
    told(page, {"is": "fields", "item": "nodes.ball", "fields": fields})
    page.fill("[aria-label='radius, slider']", "3.5")
    edit = {"do": "edit", "item": "nodes.ball", "path": "a.radius", "value": "3.5"}
    assert sent(page) == [edit]
    # One at a time, and of those that wait the newest.
    page.check("[aria-label=on]:not(div)")
    page.fill("[aria-label='radius, slider']", "4")
    assert sent(page) == []
    told(page, {"is": "wrong", "path": "a.radius", "why": "too large"})
    assert page.inner_text("[id='wrong-a.radius']") == "too large"
    assert sent(page) == [edit | {"value": "4"}]
    told(page, {"is": "edited", "path": "a.radius"})
    assert page.is_hidden("[id='wrong-a.radius']")
    page.click("#undo")
    assert sent(page) == [{"do": "undo"}]
    assert page.is_disabled("#redo")


def test_colours_of_the_picker_are_those_of_srgb(page):
    script = "text => import('./fields.js').then(({ picked, hex }) => [picked(text, [1, 1, 1]), hex(picked(text, [1, 1, 1]))])"  # noqa: E501
    for text in ("#0a3c80", "#01f0c8", "#0b0b0c"):
        found, again = page.evaluate(script, text)
        levels = np.array([int(text[at : at + 2], 16) for at in (1, 3, 5)])
        np.testing.assert_allclose(found, decode_srgb(levels / 255.0), rtol=1e-4)
        assert again == text


def test_the_command_is_that_of_the_picture(page):
    def shown(**changes):
        told(page, SCENE)
        page.click("#saves >> text=Command")
        assert sent(page)[-1] == {"do": "command"}
        told(page, {"is": "command", "text": "alight render x", "notes": ["one", "two"]})
        assert page.input_value("#command") == "alight render x"
        assert page.inner_text("#command-told") == "one; two"
        told(page, SCENE | changes)
        return page.is_visible("#command")

    assert shown(layer="depth", phase="done", spp=24)
    for change in (
        {"target": 48}, {"number": 9}, {"version": 6}, {"exposure": 0}, {"tone_map": "none"},
        {"white_balance": "none"}, {"denoise": True},
    ):  # fmt: skip
        assert not shown(**change), json.dumps(change)
    # An answer that comes after the picture has changed is that of the one before.
    told(page, SCENE)
    page.click("#saves >> text=Command")
    told(page, SCENE | {"number": 9})
    sent(page)
    told(page, {"is": "command", "text": "alight render y", "notes": []})
    assert not page.is_visible("#command")
    assert sent(page) == [{"do": "command"}]
    told(page, {"is": "command", "text": "alight render z", "notes": []})
    assert page.input_value("#command") == "alight render z"


def test_frames_are_drawn_where_they_belong(page):
    page.evaluate(f"socket.onmessage({{ data: ({FRAME}).buffer }})")
    colors = [255, 0, 0, 255, 0, 0, 255, 255]
    assert page.evaluate(PIXELS.format(canvas="document.getElementById('kept')")) == colors
    assert page.evaluate("document.getElementById('shown').width") == 1
    # A notebook's bytes may begin anywhere within a buffer.
    assert page.evaluate(NOTEBOOK % FRAME) == [colors, "6 spp", 0.25, True, True]


def test_a_lost_connection_is_tried_again_later_and_later(page):
    script = """() => {
      const waits = [], plain = window.setTimeout;
      window.setTimeout = (then, wait) => waits.push(wait);
      for (let i = 0; i < 6; i += 1) socket.onclose();
      window.setTimeout = plain;
      return waits;
    }"""
    assert page.evaluate(script) == [250, 500, 1000, 2000, 4000, 4000]
    assert page.inner_text("#phase") == "no connection; trying again"
