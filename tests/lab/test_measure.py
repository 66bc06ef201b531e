"""What the time of a replicate is: processor time of all threads that render, and of no others."""

import hashlib
import threading
import time
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from alight.compiled.scene import compile_scene
from alight.formats import load
from alight.lab.evaluate import _shared_noise
from alight.lab.replicates import measure
from alight.lab.replicates.session import Session
from alight.lab.statistics.decomposition import reference_spread
from alight.scene import content_hash, flatten


@pytest.fixture(scope="module")
def scene():
    flat = flatten(load("smooth-direct-light", ["film.size=[16,16]"]))
    return compile_scene(flat, content_hash(flat))


def _seconds(scene, monkeypatch, delay):
    """Time of two steps of a ladder in which each tile also does `delay`."""
    kernels = measure.compiled_kernels(scene)
    render_tile = measure.render_tile

    def slower(*arguments):
        delay()
        return render_tile(*arguments)

    monkeypatch.setattr(measure, "render_tile", slower)
    return [rung.seconds for rung in measure.render_ladder(scene, kernels, 1, 3, (1, 2), 2)]


def test_waiting_costs_nothing(scene, monkeypatch):
    """Another program on the machine makes us wait; it must not make an arm look slow."""
    first, second = _seconds(scene, monkeypatch, lambda: time.sleep(0.4))
    assert first <= second < 0.2


def test_other_threads_of_the_program_cost_nothing(scene, monkeypatch):
    """FLIP leaves its threads spinning: two replicates in sixteen would seem a third slower."""
    data, over = bytes(1 << 20), threading.Event()

    def spin():
        while not over.is_set():
            hashlib.sha256(data)

    other = threading.Thread(target=spin)
    other.start()
    try:
        first, second = _seconds(scene, monkeypatch, lambda: time.sleep(0.4))
    finally:
        over.set()
        other.join()
    assert first <= second < 0.2


def test_work_in_all_threads_that_render_costs(scene, monkeypatch):
    def work():
        begin = time.thread_time()
        while time.thread_time() - begin < 0.05:
            pass

    first, second = _seconds(scene, monkeypatch, work)
    assert first >= 0.05
    assert second >= 0.10


def test_the_noise_of_references_widens_the_interval():
    """Shared, it cancels between arms of equal noise; of two references it adds up."""
    rng = np.random.default_rng(1)
    a, b = (SimpleNamespace(variance=rng.random((8, 8, 3)), seeds=16) for _ in range(2))
    spread_a, spread_b = (reference_spread(one.variance, 16) for one in (a, b))
    # Of arms whose MSE is 4 and 2.
    shared = _shared_noise(a, 1 / 4, a, 1 / 2)
    assert shared == pytest.approx(spread_a * (1 / 4 - 1 / 2) ** 2)
    assert _shared_noise(a, 1 / 4, a, 1 / 4) == 0.0
    apart = _shared_noise(a, 1 / 4, b, 1 / 2)
    assert apart == pytest.approx(spread_a / 16 + spread_b / 4)


def test_a_ladder_follows_the_guide_that_was_trained_for_it(scene, monkeypatch):
    """And what its training took is part of the time of every step."""
    guide, given = object(), []
    trained = replace(scene, guide=guide)
    monkeypatch.setattr(measure, "made_ready", lambda *asked: (trained, None, 1.5))
    monkeypatch.setattr(measure, "make_settings", lambda integrator, **words: words)
    monkeypatch.setattr(measure, "add_tiles", lambda *words: given.append(words[3]) or 0.25)
    first, second = measure.render_ladder(scene, None, 4, 7, (4, 8), 1)
    assert given == [{"seed": 7, "replicates": 4, "guide": guide}] * 2
    assert 1.75 <= first.seconds <= second.seconds - 0.25 < 2.0


def test_the_seconds_of_a_study_begin_at_nought_and_are_its_own():
    one, other = (Session(None, None, False, 1, print) for _ in range(2))
    one.seconds["render"] += 1.0
    assert set(other.seconds.values()) == {0.0}
    assert sum(one.seconds.values()) == 1.0
