"""The page in a real browser: every control, the keyboard, a narrow window, a server that restarts.

Skipped where there is no Playwright or no Chromium.
"""

import re

import numpy as np
import pytest

import alight
from alight.outputs.image import write_image
from tests.view.browsing import (
    CHROMIUM,
    SETTLED,
    launched,
    opened,
    pixels_of,
    seen,
    served,
    until,
    view_of,
)

pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium")

SCENE = ("cornell-box", "--size", "48x32", "--spp", "8", "--aov", "normal,depth")


@pytest.fixture(scope="module")
def browser():
    with launched() as made:
        yield made


def test_every_control_of_a_scene(browser):
    with served(*SCENE) as address:
        page, errors = opened(browser, address)
        stage = page.locator("#picture").bounding_box()
        middle = stage["x"] + stage["width"] / 2, stage["y"] + stage["height"] / 2

        page.mouse.click(*middle)
        # Where its values are is opened.
        page.wait_for_selector("#pixel tr >> nth=3")
        told = page.inner_text("#pixel")
        assert "standard error" in told and "95 % from" in told and "red, green, blue" in told
        assert re.match("column 2[34], row 1[56]; red", page.inner_text("#where"))

        def moves(act):
            picture = pixels_of(page)
            seen(page, act)
            until(page, f"document.getElementById('shown').toDataURL() !== '{picture}'")

        def drag(button="left"):
            page.mouse.move(*middle)
            page.mouse.down(button=button)
            page.mouse.move(middle[0] + 60, middle[1] + 20, steps=5)
            page.mouse.up(button=button)

        moves(drag)
        moves(lambda: drag("right"))
        moves(lambda: page.mouse.wheel(0, -200))
        for key in ("w", "a", "s", "d", "r", "f", "q", "e", "[", "]", "ArrowLeft", "ArrowUp"):
            moves(lambda key=key: page.keyboard.press(key))
        page.click("#tabs >> text=Render")
        for control in ("#narrow", "#wide", "#roll-left", "#roll-right", "#reset"):
            moves(lambda control=control: page.click(control))

        page.click("#tabs >> text=Display")
        for layer in ("error", "samples", "normal", "depth", "picture"):
            picture = pixels_of(page)
            page.select_option("#layer", layer)
            until(page, f"document.getElementById('shown').toDataURL() !== '{picture}'")
            until(page, f"document.getElementById('layer').value === '{layer}'")
            scaled = layer in ("error", "samples", "depth")
            page.wait_for_selector("#scale", state="visible" if scaled else "hidden")
        page.fill("#exposure", "2")
        until(page, "document.getElementById('stops').textContent === '2.00'")
        page.select_option("#tone", "agx")
        page.click("#keep")
        page.wait_for_selector("#of-split")
        page.fill("#split", "20")
        assert page.evaluate("document.getElementById('divider').style.left") == "20%"
        page.click("#drop")
        page.wait_for_selector("#of-split", state="hidden")
        page.click("#tabs >> text=Render")
        page.click("#more")
        until(page, "document.getElementById('phase').textContent.includes('16')")
        with page.expect_download() as download:
            page.click("#saves >> text=Film")
        assert download.value.suggested_filename == "cornell-box.alight"
        page.click("#fold")
        assert page.is_hidden("#panel")
        assert not errors


def test_the_scene_is_edited_inspected_and_compared(browser):
    with served(*SCENE) as address:
        page, errors = opened(browser, address)
        page.click("#tabs >> text=Scene")
        page.click("#tree [data-path='bsdfs.white']")
        boxes = "[...document.querySelectorAll('#fields input')]"
        cut = f"{boxes}.some((box) => box.scrollWidth > box.clientWidth)"
        assert not page.evaluate(cut)
        box = page.locator("[aria-label=reflectance] input[type=text]").first
        picture = pixels_of(page)
        box.fill("0,2")
        seen(page, lambda: box.press("Enter"))
        assert pixels_of(page) != picture
        box.fill("1.5")
        box.press("Enter")
        page.wait_for_selector(".wrong >> text=must be in [0, 1], got 1.5")
        assert box.get_attribute("aria-invalid") == "true"
        seen(page, lambda: page.fill("[aria-label=reflectance] input[type=color]", "#ff0000"))
        page.wait_for_selector(".wrong", state="hidden")
        page.focus("#tree")
        page.keyboard.press("ArrowDown")
        assert page.get_attribute("#tree [aria-selected=true]", "data-path") != "bsdfs.white"
        while page.is_enabled("#undo"):
            # The button tells of the last edit only once the page has heard of it.
            seen(page, lambda: page.click("#undo"))
        assert pixels_of(page) == picture

        page.click("#tree [data-path='camera']")
        seen(page, lambda: page.locator("#fields input[type=range]").first.fill("50"))
        seen(page, lambda: page.click("#undo"))

        page.click("#tabs >> text=Inspect")
        stage = page.locator("#picture").bounding_box()
        page.mouse.click(stage["x"] + stage["width"] / 2, stage["y"] + stage["height"] / 2)
        page.keyboard.press("t")
        page.wait_for_selector("#vertices tbody tr >> nth=1")
        assert page.locator("#overlay line.path").count() >= 2
        page.keyboard.press("b")
        page.mouse.move(stage["x"] + 20, stage["y"] + 20)
        page.mouse.down()
        page.mouse.move(stage["x"] + 220, stage["y"] + 160, steps=3)
        page.mouse.up()
        page.wait_for_selector("#why:enabled")
        seen(page, lambda: page.click("#part"))
        seen(page, lambda: page.click("#whole"))
        page.wait_for_selector("#whole", state="hidden")

        page.click("#tabs >> text=Display")
        picture = pixels_of(page)
        page.select_option("#white", "kelvin")
        until(page, f"document.getElementById('shown').toDataURL() !== '{picture}'")
        page.click("#keep")
        page.select_option("#way", "difference")
        page.wait_for_selector("#differs >> text=root of the relative MSE 0.00 %")
        assert not errors


def test_a_film_is_looked_at_and_nothing_of_it_moves(browser, tmp_path):
    film = alight.render("cornell-box", size=(48, 32), spp=8, seed=1)
    with served(str(film.save(tmp_path / "a.alight"))) as address:
        page, errors = opened(browser, address)
        before, picture = view_of(page), pixels_of(page)
        page.focus("#stage")
        for key in ("ArrowLeft", "w", "r"):
            page.keyboard.press(key)
        page.wait_for_timeout(300)
        assert (view_of(page), pixels_of(page)) == (before, picture)
        # What the server refuses is told on the page's console.
        assert not errors


LENS = "camera={type: thin_lens, fov: 40, aperture_radius: 0.1, focus_distance: 1, transform: %s}"
THERE = "{look_at: {origin: [0, 1, 3.9], target: [0, 1, 0]}}"


def test_a_click_focuses_and_the_command_of_the_picture_can_be_copied(browser):
    with served(*SCENE, "--set", LENS % THERE) as address:
        page, errors = opened(browser, address)
        stage = page.locator("#picture").bounding_box()
        middle = stage["x"] + stage["width"] / 2, stage["y"] + stage["height"] / 2
        assert page.inner_text("#focus-at") == "Focus at 1 m"
        picture = pixels_of(page)
        page.click("#focus")
        assert page.get_attribute("#focus", "aria-pressed") == "true"
        before = view_of(page)
        page.mouse.click(*middle)
        page.wait_for_selector("#focus-at >> text=/Focus at [34].* m/", timeout=300_000)
        # The command is hidden when the next picture begins.
        until(page, f"Number(document.body.dataset.view) > {before}")
        page.wait_for_selector(SETTLED)
        assert pixels_of(page) != picture
        assert page.get_attribute("#focus", "aria-pressed") == "false"
        page.click("#saves >> text=Command")
        page.wait_for_selector("#command")
        told = page.input_value("#command")
        assert told.startswith("alight render cornell-box ")
        assert "--spp 8" in told
        assert "--seed 0" in told
        assert re.search(r'"focus_distance": [34]\.', told)
        page.context.grant_permissions(["clipboard-read", "clipboard-write"])
        page.click("#copy")
        page.wait_for_selector("#command-told >> text=copied")
        assert page.evaluate("navigator.clipboard.readText()") == told
        # By keys; the command is hidden once it is that of another picture.
        page.focus("#stage")
        page.keyboard.press("Control+z")
        page.wait_for_selector("#focus-at >> text='Focus at 1 m'")
        page.wait_for_selector("#of-command", state="hidden")
        page.keyboard.press("g")
        assert page.get_attribute("#focus", "aria-pressed") == "true"
        assert not errors


def test_two_pictures_are_named_and_compared(browser, tmp_path):
    for name, value in (("a.png", 0.2), ("b.png", 0.4)):
        write_image(tmp_path / name, np.full((6, 8, 3), value, np.float32))
    with served(str(tmp_path / "a.png"), "--against", str(tmp_path / "b.png")) as address:
        page, errors = opened(browser, address)
        assert page.get_attribute("[role=tab] >> text=Display", "aria-selected") == "true"
        assert (page.inner_text("#rival"), page.inner_text("#here")) == (
            "left: b.png",
            "right: a.png",
        )
        # The button that folds the panel stays at the edge, though there is no progress to show.
        button = page.locator("#fold").bounding_box()
        assert button["x"] + button["width"] > 1180
        page.select_option("#way", "difference")
        until(page, "document.getElementById('differs').innerText.includes('MSE 49')")
        assert not errors


def test_two_browsers_see_the_same_and_a_narrow_window_holds_everything(browser):
    with served(*SCENE) as address:
        one, errors = opened(browser, address)
        other, more_errors = opened(browser, address, width=400)
        one.keyboard.press("ArrowRight")
        for page in (one, other):
            until(page, "document.body.dataset.view === '1'")
            page.wait_for_selector(SETTLED)
        assert pixels_of(one) == pixels_of(other)
        assert other.evaluate("document.documentElement.scrollWidth") <= 400
        assert other.evaluate("document.getElementById('panel').scrollWidth") <= 400
        # Of films and pictures there is no progress; the button stays where it is.
        page.evaluate("document.getElementById('progress').hidden = true")
        button = other.locator("#fold").bounding_box()
        assert 380 < button["x"] + button["width"] <= 400
        assert not errors + more_errors


def test_the_page_finds_a_server_that_was_started_again(browser):
    with served(*SCENE) as address:
        page, _ = opened(browser, address)
        port = re.search(r":(\d+)/", address)[1]
    page.wait_for_selector("body[data-connected=false]")
    with served(*SCENE, "--port", port):
        page.wait_for_selector(SETTLED, timeout=60_000)
        page.keyboard.press("ArrowRight")
        until(page, "document.body.dataset.drawn === '1'")
