"""Where a cluster stops scaling: many workers that render nothing, against scheduler and client.

    python -m benchmarks.cluster_scale --workers 1000 --tasks 20000

The scheduler is Dask's, in a process of its own; the workers are Dask's too, all in one process,
and answer each task at once with the same bytes: the sums of one tile of 32x32 pixels. The client
is `alight.cluster.dispatch`, and checks and adds each answer as a render does. Times are processor
time, so that whatever else the machine does is not in them. Then the same for a client without a
cluster: what reading, checking and adding a tile costs.
"""

from __future__ import annotations

import argparse
import asyncio
import functools
import gc
import json
import os
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np

import alight
from alight.cluster.dispatch import Dispatcher, Patience
from alight.films import Film
from alight.rendering.executors.block_tasks import BlockTask, Layout, read_blocks, render_blocks
from alight.rendering.executors.blocks import Block
from alight.rendering.tiles.tile_kernel import Tile

TILE = BlockTask(0, (Block(Tile(0, 0, 32, 32), np.tile(np.array([0, 64]), (4, 4, 1))),))
LAYOUT = Layout(4, 3, {})

#: What each worker does now and then: a thousand of them in one process would do nothing else.
IDLE = {
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "1h",
    "distributed.admin.system-monitor.interval": "1h",
}


def same_answer(answer: bytes, task: int) -> bytes:
    """What a fake worker does."""
    return answer


async def fake_workers(address: str, count: int) -> None:
    """Workers of one process, which share a few threads."""
    from concurrent.futures import ThreadPoolExecutor

    import dask.config
    from distributed import Worker

    dask.config.set(IDLE)
    pool = ThreadPoolExecutor(2)
    workers = [
        Worker(address, nthreads=1, executor=pool, dashboard=False, memory_limit=0)
        for _ in range(count)
    ]
    for at in range(0, count, 50):
        await asyncio.gather(*workers[at : at + 50])
    # A thousand workers are millions of objects: looking through them took a third of the time.
    gc.freeze()
    await asyncio.gather(*(worker.finished() for worker in workers))


def processor_seconds(pid: int) -> float:
    """Of a process so far."""
    fields = Path(f"/proc/{pid}/stat").read_text("utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def memory_mb() -> float:
    """Of this process now."""
    pages = int(Path("/proc/self/statm").read_text("utf-8").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def the_answer() -> bytes:
    """One tile of the Cornell box, rendered."""
    from alight.compiled.scene import compile_scene
    from alight.integrators.walk import make_settings
    from alight.rendering.executors.block_tasks import SharedScene
    from alight.rendering.tiles.tile import make_kernels
    from alight.scene import flatten

    scene = compile_scene(flatten(alight.load("cornell-box", ["film.size=[64, 64]"])))
    settings = make_settings(scene.integrator, seed=0, replicates=4)
    return render_blocks(SharedScene(scene, settings, make_kernels(scene)), TILE)


def cluster(workers: int, tasks: int, answer: bytes) -> dict:
    """Run tasks through scheduler and client."""
    from distributed import Client

    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        port = one.getsockname()[1]
    address = f"tcp://127.0.0.1:{port}"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    words = ["--host", "127.0.0.1", "--port", str(port), "--no-dashboard"]
    scheduler = subprocess.Popen([sys.executable, "-m", "dask", "scheduler", *words], **quiet)
    fakes = subprocess.Popen(
        [sys.executable, "-m", "benchmarks.cluster_scale", "--fake", address, str(workers)], **quiet
    )
    try:
        with Client(address, timeout=120) as client:
            client.wait_for_workers(workers, timeout=3600)
            return through(client, tasks, answer, scheduler.pid)
    finally:
        fakes.kill()
        scheduler.kill()


def through(client, tasks: int, answer: bytes, scheduler: int) -> dict:
    """Hand out tasks, and see what they cost."""
    left, done, memory = iter(range(tasks)), 0, []

    def check(task: int, value: bytes) -> list:
        return read_blocks(LAYOUT, TILE, value)

    def take(task: int, value: list, seconds: float) -> None:
        nonlocal done
        # A film of its own: the same samples twice would be refused.
        film = Film(64, 64)
        for partial, _ in value:
            film.add_tile(partial)
        done += 1
        if done % max(tasks // 10, 1) == 0:
            memory.append(round(memory_mb(), 1))
            print(json.dumps(costs()), flush=True)

    def costs() -> dict:
        wall, client = time.perf_counter() - begin, time.process_time() - own
        return {
            "tasks": done, "tasks_per_s": round(done / wall, 1),
            "scheduler_ms": round(1e3 * (processor_seconds(scheduler) - its) / done, 3),
            "client_ms": round(1e3 * client / done, 3), "client_mb": memory[-1],
        }  # fmt: skip

    patience = Patience(task=600.0, fetch=300.0, cluster=600.0)
    dispatcher = Dispatcher(client, same_answer, answer, check, patience)
    dispatcher.open()
    begin, own, its = time.perf_counter(), time.process_time(), processor_seconds(scheduler)
    rest = dispatcher.run(
        functools.partial(next, left, None), take, threading.Event(), lambda: None
    )
    found = costs()
    dispatcher.close()
    return {
        "workers": dispatcher.threads, "that_worked": len(dispatcher.workers), "left": len(rest),
        **found, "client_mb": memory, "again": dispatcher.counts["issued again"],
    }  # fmt: skip


def alone(answer: bytes, times: int = 2000) -> dict:
    """What the client does to an answer, without a cluster."""
    begin = time.process_time()
    for _ in range(times):
        parts = read_blocks(LAYOUT, TILE, answer)
    read = (time.process_time() - begin) / times
    begin = time.process_time()
    for _ in range(times):
        film = Film(64, 64)
        for partial, _ in parts:
            film.add_tile(partial)
    add = (time.process_time() - begin) / times
    return {"bytes": len(answer), "read_ms": round(1e3 * read, 3), "add_ms": round(1e3 * add, 3)}


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--workers", type=int, default=1000)
    parser.add_argument("--tasks", type=int, default=20_000)
    parser.add_argument("--fake", nargs=2)
    given = parser.parse_args()
    if given.fake:
        asyncio.run(fake_workers(given.fake[0], int(given.fake[1])))
        return
    answer = the_answer()
    print(json.dumps(alone(answer)))
    print(json.dumps(cluster(given.workers, given.tasks, answer)))


if __name__ == "__main__":
    main()
