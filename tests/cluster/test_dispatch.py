"""Each task is answered once, whatever happens to the workers."""

import functools
import os
import signal
import threading

import pytest

from alight.cluster import dispatch
from alight.cluster.dispatch import AHEAD, Dispatcher, Patience
from alight.cluster.worker import KEPT
from alight.core.errors import AlightError
from tests.cluster import jobs
from tests.cluster.workers import two_workers

#: Longer than any task takes on a busy machine; and, where one never ends, a second.
LONG = Patience()
SHORT = Patience(task=1.0, times=4.0, fetch=2.0, cluster=20.0)


@pytest.fixture(scope="module")
def client():
    with two_workers() as client:
        yield client


def same(task, value):
    return value


def answers_of(client, function, thing, count, check=same, on_answer=None, patience=LONG):
    """Values by task, each taken once; and the dispatcher."""
    dispatcher = Dispatcher(client, function, thing, check, patience)
    tasks, found = iter(range(count)), {}

    def take(task, value, seconds):
        assert task not in found, "counted twice"
        found[task] = value
        if on_answer:
            on_answer(len(found))

    dispatcher.open()
    try:
        left = dispatcher.run(functools.partial(next, tasks, None), take,
                              threading.Event(), lambda: None)  # fmt: skip
    finally:
        dispatcher.close()
    assert left == []
    assert not dispatcher._issues
    return found, dispatcher


def pids(client):
    return client.run(os.getpid)


def test_every_task_is_answered_once(client):
    # On a busy machine a second is soon over, and then tasks are issued again.
    patient = Patience(task=100.0)
    working = set()
    # Dask decides where tasks run: a worker that gets no processor for a while answers none.
    for _ in range(10):
        found, dispatcher = answers_of(client, jobs.multiplied, 7, 40, patience=patient)
        assert found == {n: 7 * n for n in range(40)}
        assert sum(of["tasks"] for of in dispatcher.workers.values()) == 40
        assert dispatcher.counts["failed"] == dispatcher.counts["issued again"] == 0
        working |= dispatcher.workers.keys()
        if len(working) == 2:
            break
    assert working == client.nthreads().keys()


def test_workers_leave_an_interrupt_to_the_client(client):
    """Ctrl-C reaches all processes of a terminal."""
    before = set(pids(client).values())
    for pid in before:
        os.kill(pid, signal.SIGINT)
    found, _ = answers_of(client, jobs.multiplied, 3, 8, patience=Patience(task=100.0))
    assert found == {n: 3 * n for n in range(8)}
    assert set(pids(client).values()) == before


def test_what_was_not_given_is_not_taken_back(client, caplog):
    """As when the client is stopped before it has given the workers anything."""
    with caplog.at_level("ERROR", logger="distributed.core"):
        Dispatcher(client, jobs.multiplied, 7, same).close()
    assert not caplog.records


def test_two_renders_of_the_same_take_nothing_from_each_other(client):
    """Of one client or of two; a worker may have been started again meanwhile."""
    first, second = (Dispatcher(client, jobs.multiplied, 7, same, LONG) for _ in range(2))
    found = {}
    first.open()
    second.open()
    first.close()
    client.run(jobs.keep_nothing)
    tasks = iter(range(8))
    try:
        second.run(functools.partial(next, tasks, None),
                   lambda task, value, seconds: found.update({task: value}),
                   threading.Event(), lambda: None)  # fmt: skip
    finally:
        second.close()
    assert found == {n: 7 * n for n in range(8)}
    assert second.counts["failed"] == 0


def test_processes_of_a_local_cluster_do_not_watch_themselves_all_the_time(client):
    """Of Dask's own accord scheduler and nannies take 3 % of a core, and workers too."""

    def is_quiet(server):
        return server.periodic_callbacks["tick"].callback_time >= 500 and not server.io_loop.profile

    assert is_quiet(client.cluster.scheduler)
    assert set(client.run(jobs.ticks_of_the_worker).values()) == {500}


def test_few_tasks_are_drawn_ahead_and_results_are_released(client):
    drawn = iter(range(30))
    dispatcher = Dispatcher(client, jobs.multiplied, 1, same, SHORT)
    open_tasks, most = 0, 0

    def draw():
        nonlocal open_tasks, most
        task = next(drawn, None)
        open_tasks += task is not None
        most = max(most, open_tasks)
        return task

    def take(task, value, seconds):
        nonlocal open_tasks
        open_tasks -= 1

    dispatcher.open()
    dispatcher.run(draw, take, threading.Event(), lambda: None)
    dispatcher.close()
    assert most <= AHEAD * 2
    assert not client.futures


def test_a_failing_task_is_tried_again_and_at_last_done_here(client, tmp_path):
    found, dispatcher = answers_of(client, jobs.failing, str(tmp_path), 8)
    assert found == {n: n for n in range(8)}
    # 0, 3 and 6 failed thrice; 5 failed once.
    assert dispatcher.counts["done here"] == 3
    assert dispatcher.counts["failed"] == 10


def test_a_malformed_answer_is_refused_and_the_task_done_again(client):
    seen = []

    def check(task, value):
        seen.append(task)
        if task == 3 and seen.count(3) == 1:
            raise ValueError("too much")
        return value

    found, dispatcher = answers_of(client, jobs.multiplied, 2, 6, check=check)
    assert found == {n: 2 * n for n in range(6)}
    assert dispatcher.counts["failed"] == 1


def test_workers_that_the_scene_did_not_reach_are_brought_it(client, monkeypatch):
    """As when the scheduler cannot connect to one for half a minute."""

    async def fails(**words):
        raise OSError("Timed out trying to connect")

    monkeypatch.setattr(client, "_register_worker_plugin", fails)
    found, dispatcher = answers_of(client, jobs.multiplied, 5, 12)
    assert found == {n: 5 * n for n in range(12)}
    assert dispatcher.counts["failed"] == dispatcher.counts["done here"] == 0
    assert not dispatcher.refused


def test_a_worker_that_dies_loses_nothing(client, tmp_path):
    found, _ = answers_of(client, jobs.deadly, str(tmp_path), 12)
    assert found == {n: n for n in range(12)}


def test_a_killed_worker_is_replaced_and_knows_the_shared_object(client):
    def kill(count):
        if count == 5:
            os.kill(next(iter(pids(client).values())), signal.SIGKILL)

    found, _ = answers_of(client, jobs.multiplied, 3, 60, on_answer=kill)
    assert found == {n: 3 * n for n in range(60)}


def test_a_worker_of_another_fingerprint_is_refused(client, monkeypatch):
    told = []
    # Dask and uvicorn configure logging as they like.
    monkeypatch.setattr(dispatch._LOG, "warning", lambda text, *values: told.append(text % values))
    try:
        # Dask decides where tasks run, and may give a worker none of so few.
        for _ in range(10):
            client.run(jobs.become_this_machine)
            client.wait_for_workers(2, timeout=20)
            one, _ = client.nthreads()
            client.run(jobs.become_another_machine, workers=[one])
            found, dispatcher = answers_of(client, jobs.multiplied, 2, 40)
            assert found == {n: 2 * n for n in range(40)}
            if dispatcher.refused:
                break
        assert set(dispatcher.refused) == {one}
        assert set(dispatcher.workers).isdisjoint({one})
        assert any(f"the worker {one} is refused" in line for line in told)
        client.run(jobs.become_another_machine)
        with pytest.raises(AlightError, match="every worker is refused"):
            answers_of(client, jobs.multiplied, 2, 20)
    finally:
        client.run(jobs.become_this_machine)


def test_a_worker_without_alight_is_refused_and_the_others_go_on(client):
    client.wait_for_workers(2, timeout=20)
    one, other = client.nthreads()
    try:
        client.run(jobs.lose_alight, workers=[one])
        # It may be given none of so few.
        for _ in range(10):
            found, dispatcher = answers_of(client, jobs.multiplied, 11, 12)
            assert found == {n: 11 * n for n in range(12)}
            if dispatcher.refused:
                break
        assert dispatcher.refused.keys() == {one}
        assert "ModuleNotFoundError" in dispatcher.refused[one]
        assert dispatcher.workers.keys() == {other}
        assert dispatcher.counts["failed"] == 0
        client.run(jobs.lose_alight, workers=[other])
        with pytest.raises(AlightError, match=r"(?s)every worker is refused.*ModuleNotFoundError"):
            answers_of(client, jobs.multiplied, 12, 4)
    finally:
        client.run(jobs.find_alight)


def test_a_worker_keeps_few_shared_objects(client):
    for thing in range(4):
        answers_of(client, jobs.multiplied, thing, 6)
    assert all(count <= KEPT for count in client.run(jobs.kept).values())


def test_a_cancelled_run_ends_at_once(client):
    cancel, dispatcher = threading.Event(), Dispatcher(client, jobs.multiplied, 2, same, SHORT)
    dispatcher.open()
    numbers, taken = iter(range(10**6)), []

    def take(task, value, seconds):
        taken.append(task)
        cancel.set()

    assert dispatcher.run(numbers.__next__, take, cancel, lambda: None) == []
    dispatcher.close()
    assert len(taken) <= AHEAD * 2
    assert next(numbers) < 20


def test_a_late_task_is_issued_again_and_its_first_answer_counts(client, tmp_path):
    try:
        found, dispatcher = answers_of(client, jobs.stuck, str(tmp_path), 10, patience=SHORT)
    finally:
        (tmp_path / "go").touch()
    assert found == {n: n for n in range(10)}
    assert dispatcher.counts["issued again"] >= 1
