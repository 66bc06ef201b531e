"""Renders that are stopped on purpose, and what must come of them."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest

from alight.films import Film


def assert_same(film, other):
    """The same sums and counts, to the bit."""
    np.testing.assert_array_equal(film.sums, other.sums)
    np.testing.assert_array_equal(film.counts, other.counts)


@contextmanager
def cancelled_after(tiles: int, monkeypatch: pytest.MonkeyPatch) -> Iterator[threading.Event]:
    """An event that is set when so many tiles are in the films."""
    cancel, add_tile, count = threading.Event(), Film.add_tile, 0

    def add_and_count(film, *tile):
        nonlocal count
        add_tile(film, *tile)
        count += 1
        if count == tiles:
            cancel.set()

    with monkeypatch.context() as patch:
        patch.setattr(Film, "add_tile", add_and_count)
        yield cancel
