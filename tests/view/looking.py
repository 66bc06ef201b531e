"""A small scene that is viewed, and how to wait for what a view does in its own thread."""

import time

import alight
from alight.options.view import ViewOptions
from alight.view.session import Session

OPTIONS = ViewOptions(size=(24, 16), spp=4, threads=1)


def cornell(options=OPTIONS):
    return Session(
        "cornell-box", alight.load("cornell-box", options.assignments()), options.of_render
    )


def wait_for(condition, seconds=240.0):
    """Until a condition holds; kernels may have to be compiled."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it has not happened"
        time.sleep(0.002)


def settled(session):
    """Wait for the picture of the newest view to be finished, and give its film."""

    def is_done():
        live = session.live
        assert live.phase != "failed", live.problem
        wish = live.wish
        return live.phase == "done" and not wish.moves and live.layers.number == wish.number

    wait_for(is_done)
    return session.film
