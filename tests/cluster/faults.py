"""Renders on a cluster that is damaged meanwhile: the campaign, as a program of its own.

    python -m tests.cluster.faults --faults 100 --folder /tmp/faults

A scheduler and two workers with nannies, behind TLS, stay from trial to trial; each render is a
process with a checkpoint that is written without a pause. At a moment drawn uniformly from what is
left of such a render when its first samples are there, one of `FAULTS` happens, or where the
rights of root let one worker be in a network namespace, one of `CUTS`: before, a scheduler
that does not answer is an error. Whatever is gone is started again for the next
trial; a client that was killed goes on from its checkpoint. The last line is JSON: what happened,
how many films differ from that of one process, and the longest delay over a render without fault.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

import alight
from alight.cluster import dispatch
from alight.cluster.dispatch import Patience
from alight.cluster.keys import CERTIFICATE, KEY, make_keys
from alight.films import Film
from alight.rendering.executors import cluster_executor, light_tasks
from tests.cluster.cut_network import Namespace, namespace_here

#: Seconds that a client waits for what is lost, in the campaign.
PATIENCE = Patience(task=3.0, times=4.0, fetch=3.0, cluster=12.0)

SIZE = {"size": (72, 40), "crop": (3, 2, 60, 37), "threads": 1}

#: What is rendered, in turn: a scene, changes to it, and options.
RENDERS: dict[str, tuple[str, list[str], dict]] = {
    "a box": ("cornell-box", [], {"spp": 2000, "aovs": "depth"}),
    "paths from both ends": ("cornell-box", ["integrator.type=bidirectional"], {"spp": 500}),
    "a guide": ("matt-room", ["integrator.guiding=camera"], {"spp": 800}),
    "chains": ("lamp-and-glass", ["integrator.caustics=manifold"], {"spp": 500}),
    "a spectrum": (
        "lamp-and-glass",
        ["nodes.glass-ball.bsdf={type: dielectric, dispersion: 30}"],
        {"spp": 1500, "aovs": "albedo_through"},
    ),
    "light paths": ("mirror-and-glass", ["integrator.type=light"], {"spp": 800}),
}

FAULTS = (
    "kill worker", "stop worker", "kill nanny", "stop nanny", "kill scheduler", "stop scheduler",
    "kill client", "kill worker twice",
)  # fmt: skip

#: Where one of the workers can be in a network of its own: for good, and for a while.
CUTS = ("cut worker", "cut worker briefly")

#: Seconds after which a render hangs.
HANGS = 180.0


class Damaged:
    """The processes of a cluster, started again when they are gone."""

    def __init__(self, folder: Path, network: Namespace | None) -> None:
        self.folder, self.port, self.network = folder, _free_port(), network
        self.keys = folder / "keys"
        make_keys(self.keys)
        self.host = network.here if network else "127.0.0.1"
        self.address = f"tls://{self.host}:{self.port}"
        self.scheduler: subprocess.Popen | None = None
        self.nannies: list[subprocess.Popen] = []
        self.log = (folder / "cluster.log").open("wb")

    def _start(self, *words: str, network: Namespace | None = None) -> subprocess.Popen:
        certificate, key = str(self.keys / CERTIFICATE), str(self.keys / KEY)
        tls = ["--tls-ca-file", certificate, "--tls-cert", certificate, "--tls-key", key]
        return subprocess.Popen(
            [*(network.words if network else ()), sys.executable, "-m", "dask", *words,
             "--host", network.there if network else self.host, *tls],
            stdout=self.log, stderr=self.log, cwd=self.folder,
            env={**os.environ, "PYTHONPATH": str(Path.cwd())},
        )  # fmt: skip

    def repair(self) -> None:
        """Start what is not there, and wait for it."""
        if self.scheduler is None or self.scheduler.poll() is not None:
            self.end()
            port = str(self.port)
            self.scheduler = self._start(
                "scheduler", "--port", port, "--no-dashboard", "--protocol", "tls"
            )
        words = "worker", self.address, "--nthreads", "1", "--no-dashboard"
        # The first one is where it can be cut off.
        for at, network in enumerate((self.network, None)):
            if self.nannies[at : at + 1] and self.nannies[at].poll() is None:
                continue
            self.nannies[at : at + 1] = [self._start(*words, network=network)]
        with suppress(alight.AlightError):
            self._wait()
            return
        # A scheduler that was stopped for long has given up its workers.
        self.end()
        self.repair()

    def _wait(self) -> None:
        from alight.cluster.addresses import connected

        with connected(self.address, self.keys) as client:
            try:
                client.wait_for_workers(2, timeout=30)
            except TimeoutError:
                raise alight.AlightError("no workers") from None

    def workers(self) -> list[int]:
        """Processes that render."""
        found = []
        for nanny in self.nannies:
            children = Path(f"/proc/{nanny.pid}/task/{nanny.pid}/children")
            with suppress(OSError):
                found += [int(pid) for pid in children.read_text().split() if _renders(int(pid))]
        return found

    def end(self) -> None:
        """Kill everything."""
        for process in (*self.nannies, *([self.scheduler] if self.scheduler else [])):
            for pid in (*(self.workers() if process in self.nannies else ()), process.pid):
                _signal(pid, signal.SIGKILL)
            process.wait()
        self.nannies, self.scheduler = [], None


def _renders(pid: int) -> bool:
    try:
        return b"spawn_main" in Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return False


def _free_port() -> int:
    import socket

    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def _signal(pid: int, number: int) -> None:
    with suppress(ProcessLookupError):
        os.kill(pid, number)


def render(name: str, **where: Any) -> Film:
    """One of `RENDERS`."""
    scene, changes, words = RENDERS[name]
    return alight.render(alight.load(scene, changes), **SIZE, **words, **where)


def client(address: str, keys: str, path: str, name: str) -> None:
    """What the process of a client does: begin, or go on."""
    # A render of seconds has many tasks only if they are short.
    cluster_executor.LONGEST, cluster_executor.SHORTEST = 0.2, 0.05
    light_tasks.LONGEST = 0.2
    dispatch.Patience = lambda: PATIENCE  # type: ignore[assignment,misc]
    where = {"cluster": address, "cluster_keys": keys, "every": 0.0}
    if Path(path).exists():
        alight.resume(path, **where, threads=1)
    else:
        render(name, checkpoint=path, **where)


class Campaign:
    """Trials of one folder."""

    def __init__(self, folder: Path, seed: int) -> None:
        self.network = namespace_here()
        self.faults = FAULTS + (CUTS if self.network else ())
        self.cluster, self.folder = Damaged(folder, self.network), folder
        self.random = random.Random(seed)
        self.whole: dict[str, Film] = {}
        self.lengths: dict[str, float] = {}
        self.told: Counter[str] = Counter()
        self.differing: list[str] = []
        self.delays: dict[str, float] = {}

    def length(self, name: str) -> float:
        """Seconds of a render without a fault."""
        if name not in self.lengths:
            self.whole[name] = render(name)
            self.cluster.repair()
            # The first one warms the workers up. A film that one scene left is no other's.
            names = [f"none-{len(self.lengths)}-{n}" for n in range(2)]
            self.lengths[name] = [self._trial(number, None, name) for number in names][-1]
        return self.lengths[name]

    def trial(self, number: int) -> None:
        """One render, and one fault."""
        fault = self.faults[number % len(self.faults)]
        # Ten faults and six scenes: sixty trials are all pairs.
        name = list(RENDERS)[(number + number // 30) % len(RENDERS)]
        length = self.length(name)
        self.cluster.repair()
        took = self._trial(f"{number}", fault, name)
        self.told[fault] += 1
        self.delays[fault] = max(self.delays.get(fault, 0.0), took - length)
        print(f"{number}: {name}, {fault}, {took:.1f} s, {len(self.differing)} differ", flush=True)

    def _trial(self, number: str, fault: str | None, name: str) -> float:
        path, begin = self.folder / f"{number}.alight", time.perf_counter()
        process = self._client(path, name)
        stopped: list[int] = []
        if fault is not None:
            while process.poll() is None and not (path.exists() and Film.load(path).spp > 0.0):
                time.sleep(0.05)
            left = self.length(name) - (time.perf_counter() - begin)
            time.sleep(self.random.uniform(0.0, max(left, 0.0)))
            process, stopped = self._happen(fault, process, lambda: self._client(path, name))
        try:
            process.wait(HANGS)
            took = time.perf_counter() - begin
        finally:
            for pid in stopped:
                _signal(pid, signal.SIGCONT)
            if self.network:
                self.network.mend()
            process.kill()
        if process.returncode != 0:
            self.differing.append(f"{number}: {name}, {fault}: exit code {process.returncode}")
            return took
        film = Film.load(path)
        whole = self.whole[name]
        planes = [(film.sums, whole.sums), (film.counts, whole.counts)]
        planes += [(film.aov_sums[layer], plane) for layer, plane in whole.aov_sums.items()]
        if not all(np.array_equal(a, b) for a, b in planes):
            self.differing.append(f"{number}: {name}, {fault}: other bits")
        path.unlink()
        return took

    def _client(self, path: Path, name: str) -> subprocess.Popen:
        words = ["--client", self.cluster.address, str(self.cluster.keys), str(path), name]
        return subprocess.Popen(
            [sys.executable, "-m", "tests.cluster.faults", *words],
            stdout=self.cluster.log, stderr=self.cluster.log,
        )  # fmt: skip

    def _happen(
        self, fault: str, process: subprocess.Popen, again: Callable[[], subprocess.Popen]
    ) -> tuple[subprocess.Popen, list[int]]:
        word, _, whom = fault.partition(" ")
        if word == "cut":
            assert self.network is not None
            self.network.cut()
            if whom == "worker briefly":
                time.sleep(self.random.uniform(0.0, PATIENCE.task))
                self.network.mend()
            return process, []
        if whom == "client":
            process.kill()
            process.wait()
            return again(), []
        assert self.cluster.scheduler is not None
        pids = {
            "worker": self.cluster.workers(), "worker twice": self.cluster.workers(),
            "nanny": [nanny.pid for nanny in self.cluster.nannies],
            "scheduler": [self.cluster.scheduler.pid],
        }[whom]  # fmt: skip
        if not pids:
            return process, []
        victim = self.random.choice(pids)
        _signal(victim, signal.SIGKILL if word == "kill" else signal.SIGSTOP)
        if whom == "worker twice":
            time.sleep(self.random.uniform(0.0, 1.0))
            for pid in self.cluster.workers():
                _signal(pid, signal.SIGKILL)
        return process, [victim] if word == "stop" else []


def run(folder: Path, numbers: Callable[[int], Iterable[int]], seed: int) -> dict:
    """A campaign; gives what its last line says.

    Parameters
    ----------
    folder : Path
    numbers : callable
        Given how many kinds of fault there are, which trials: each has the fault of its number.
    seed : int
    """
    campaign = Campaign(folder, seed)
    try:
        for number in numbers(len(campaign.faults)):
            campaign.trial(number)
    finally:
        campaign.cluster.end()
        campaign.cluster.log.close()
        if campaign.network:
            campaign.network.end()
    return {
        "faults": dict(campaign.told), "differing": campaign.differing,
        "length_s": {name: round(length, 1) for name, length in campaign.lengths.items()},
        "delay_s": {name: round(delay, 1) for name, delay in campaign.delays.items()},
    }  # fmt: skip


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--faults", type=int, default=16)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--folder", type=Path)
    parser.add_argument("--client", nargs=4)
    given = parser.parse_args()
    if given.client:
        client(*given.client)
        return
    given.folder.mkdir(parents=True, exist_ok=True)
    print(json.dumps(run(given.folder.resolve(), lambda kinds: range(given.faults), given.seed)))


if __name__ == "__main__":
    main()
