"""A server in a process of its own, and its page in a headless Chromium that settles."""

import os
import re
import shutil
import subprocess
import sys
import time
from contextlib import contextmanager

TOKEN = "a-token-of-ours"
SETTLED = "body[data-phase=done][data-connected=true]"
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")

#: Nothing is asked of any network; root, in containers, has no sandbox.
_FLAGS = [
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--no-first-run", *(["--no-sandbox"] if getattr(os, "getuid", lambda: 1)() == 0 else []),
]  # fmt: skip


@contextmanager
def served(*words):
    """A server in a process of its own; gives the address of its page."""
    command = [sys.executable, "-u", "-m", "alight", "view", *words, "--no-browser"]
    process = subprocess.Popen(
        [*command, "--token", TOKEN], stdout=subprocess.PIPE, text=True, env=dict(os.environ)
    )
    try:
        line = process.stdout.readline()
        yield re.search(r"http\S+", line)[0]
    finally:
        process.terminate()
        process.wait(20)
        process.stdout.close()


@contextmanager
def launched():
    """A browser."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as started:
        made = started.chromium.launch(executable_path=CHROMIUM, args=_FLAGS)
        yield made
        made.close()


def opened(browser, address, width=1200, script=""):
    """A page that has settled, and the errors that it notes from now on.

    `script` runs before those of the page.
    """
    page, errors = browser.new_page(viewport={"width": width, "height": 760}), []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("console", lambda m: errors.append(m.text) if m.type in ("error", "warning") else None)
    page.add_init_script(script)
    page.goto(address)
    page.wait_for_selector(SETTLED, timeout=300_000)
    until(page, "Number(document.body.dataset.frames) > 0")
    return page, errors


def until(page, script, seconds=60.0):
    """Wait for an expression to hold; the page's own rules forbid Playwright to do it there."""
    end = time.monotonic() + seconds
    while not page.evaluate(script):
        assert time.monotonic() < end, script
        page.wait_for_timeout(20)


def seen(page, act):
    """Do what asks for another view, and wait for its finished picture.

    Before the page has heard of the act, what it shows is finished, too.
    """
    before = view_of(page)
    act()
    until(page, f"Number(document.body.dataset.view) > {before}")
    page.wait_for_selector(SETTLED)
    until(page, "document.body.dataset.drawn === document.body.dataset.view")


def view_of(page):
    return int(page.evaluate("document.body.dataset.view"))


def pixels_of(page):
    return page.evaluate("document.getElementById('shown').toDataURL()")
