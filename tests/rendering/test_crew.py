"""Threads that several jobs share: each has memory of its own, which it keeps."""

import threading

from alight.rendering.executors.blocks import Crew, Threads


def test_each_thread_keeps_memory_of_its_own():
    count = 4
    meeting, mine = threading.Barrier(count), [[], []]

    def work(turn):
        meeting.wait(timeout=30)
        mine[turn].append((threading.get_ident(), crew.scratch))

    with Crew(count) as crew:
        for turn in (0, 1):
            for future in [crew.pool.submit(work, turn) for _ in range(count)]:
                future.result()
    first, second = (dict(pairs) for pairs in mine)
    assert len({id(scratch) for scratch in first.values()}) == count
    assert first == second


class Job:
    """As much of a job as threads ask for when it begins."""

    threads = 2


def test_a_job_ends_its_own_threads_and_leaves_those_of_others():
    with Crew(1) as crew:
        for shared in (crew, None):
            with Threads(shared) as threads:
                threads.begin(Job())
                pool = threads._crew.pool
                assert (pool is crew.pool) == (shared is not None)
                assert pool.submit(int, 3).result() == 3
            assert pool._shutdown == (shared is None)
        assert crew.pool.submit(int, 4).result() == 4
