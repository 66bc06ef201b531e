"""Renders on a cluster that is damaged meanwhile: the campaign, as a program of its own.

    python -m tests.cluster.faults --faults 100 --folder /tmp/faults

It goes on where it was interrupted if the folder is the same. A scheduler and two workers with
nannies, behind TLS, stay from trial to trial; each render is a process with a checkpoint that is
written without a pause. At a moment drawn uniformly from what is left of such a render when its
first samples are there, one of `FAULTS` happens, or where the rights of root let one worker be in a
network namespace, one of `CUTS`: before, a scheduler that does not answer is an error. Whatever is
gone is started again for the next trial; a client that was killed goes on from its checkpoint.
Whether one hangs is told by what comes of it, see `tests.cluster.progress`. The last line is JSON:
what happened, which films differ from that of one process, the longest delay over a render without
fault, and the longest time in which nothing came though the processors were free.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
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
from alight.cluster.keys import CERTIFICATE, KEY, make_keys
from alight.films import Film
from tests.cluster.campaign_client import PATIENCE, RENDERS, client, render
from tests.cluster.cut_network import Namespace, namespace_here
from tests.cluster.progress import Hang, Watch

FAULTS = (
    "kill worker", "stop worker", "kill nanny", "stop nanny", "kill scheduler", "stop scheduler",
    "kill client", "kill worker twice",
)  # fmt: skip

#: Where one of the workers can be in a network of its own: for good, and for a while.
CUTS = ("cut worker", "cut worker briefly")


class Damaged:
    """The processes of a cluster, started again when they are gone."""

    def __init__(self, folder: Path, network: Namespace | None) -> None:
        self.folder, self.port, self.network = folder, _free_port(), network
        self.keys = folder / "keys"
        if not self.keys.exists():
            make_keys(self.keys)
        self.host = network.here if network else "127.0.0.1"
        self.address = f"tls://{self.host}:{self.port}"
        self.scheduler: subprocess.Popen | None = None
        self.nannies: list[subprocess.Popen] = []
        self.log = (folder / "cluster.log").open("ab")

    def _start(self, *words: str, network: Namespace | None = None) -> subprocess.Popen:
        certificate, key = str(self.keys / CERTIFICATE), str(self.keys / KEY)
        tls = ["--tls-ca-file", certificate, "--tls-cert", certificate, "--tls-key", key]
        return subprocess.Popen(
            [*(network.words if network else ()), sys.executable, "-m", "dask", *words,
             "--host", network.there if network else self.host, *tls],
            stdout=self.log, stderr=self.log, cwd=self.folder,
            env={**os.environ, "PYTHONPATH": str(Path.cwd())}, start_new_session=True,
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

    def pids(self) -> list[int]:
        """Processes of the cluster."""
        started = [*self.nannies, *([self.scheduler] if self.scheduler else [])]
        return [process.pid for process in started] + self.workers()

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


def _samples(path: Path) -> float:
    """Per pixel, in a checkpoint; 0 before the first."""
    return Film.load(path).spp if path.exists() else 0.0


def _signal(pid: int, number: int) -> None:
    with suppress(ProcessLookupError):
        os.kill(pid, number)


class Campaign:
    """Trials of one folder, which knows those that were there before."""

    def __init__(self, folder: Path, seed: int) -> None:
        self.network = namespace_here()
        self.faults = FAULTS + (CUTS if self.network else ())
        self.cluster, self.folder, self.seed = Damaged(folder, self.network), folder, seed
        self.random = random.Random()
        # Clients have imported what they need before they begin.
        self._forks = multiprocessing.get_context("forkserver")
        self._forks.set_forkserver_preload(["distributed", client.__module__])
        self.whole: dict[str, Film] = {}
        self.lengths: dict[str, float] = {}
        #: By number: fault, delay, seconds without a result, and what is wrong, if anything is.
        self.trials: dict[str, dict[str, Any]] = {}
        self._kept = folder / "trials.json"
        if self._kept.exists():
            self.lengths, self.trials = json.loads(self._kept.read_text())

    def length(self, name: str) -> float:
        """Seconds of a render without a fault."""
        if name not in self.whole:
            self.whole[name] = render(name)
        if name not in self.lengths:
            self.cluster.repair()
            # The first one warms the workers up. A film that one scene left is no other's.
            names = [f"none-{len(self.lengths)}-{n}" for n in range(2)]
            self.lengths[name] = [self._trial(number, None, name) for number in names][-1]
        return self.lengths[name]

    def trial(self, number: int) -> None:
        """One render, and one fault, unless it was there."""
        if f"{number}" in self.trials:
            return
        fault = self.faults[number % len(self.faults)]
        # Ten faults and six scenes: sixty trials are all pairs.
        name = list(RENDERS)[(number + number // 30) % len(RENDERS)]
        length = self.length(name)
        self.cluster.repair()
        self.random.seed(f"{self.seed} {number}")
        took = self._trial(f"{number}", fault, name)
        self.trials[f"{number}"] |= {"fault": fault, "delay": took - length}
        self._keep()
        wrong = ", ".join(self.differing) or "none differs"
        print(f"{number}: {name}, {fault}, {took:.1f} s, {wrong}", flush=True)

    def _keep(self) -> None:
        temporary = self._kept.with_suffix(".new")
        temporary.write_text(json.dumps([self.lengths, self.trials]))
        temporary.replace(self._kept)

    @property
    def differing(self) -> list[str]:
        """What is wrong, trial by trial."""
        return [trial["wrong"] for trial in self.trials.values() if trial["wrong"]]

    def _trial(self, number: str, fault: str | None, name: str) -> float:
        path, begin = self.folder / f"{number}.alight", time.perf_counter()
        path.unlink(missing_ok=True)
        process, stopped = self._client(path, name), list[int]()
        watch = Watch(lambda: _samples(path), lambda: [process.pid, *self.cluster.pids()])
        wrong = ""
        try:
            if fault is not None:
                watch.until(lambda: not process.is_alive() or _samples(path) > 0.0)
                left = self.length(name) - (time.perf_counter() - begin)
                time.sleep(self.random.uniform(0.0, max(left, 0.0)))
                process, stopped = self._happen(fault, process, lambda: self._client(path, name))
            watch.until(lambda: not process.is_alive())
        except Hang as hang:
            # Where it hangs goes to the log.
            _signal(process.pid, signal.SIGABRT)
            process.join()
            wrong = str(hang)
        finally:
            took = time.perf_counter() - begin
            for pid in stopped:
                _signal(pid, signal.SIGCONT)
            if self.network:
                self.network.mend()
            process.kill()
            process.join()
        wrong = wrong or self._fault_of(path, process.exitcode, name)
        self.trials[number] = {
            "fault": None, "idle": watch.longest,
            "wrong": wrong and f"{number}: {name}, {fault}: {wrong}",
        }  # fmt: skip
        return took

    def _fault_of(self, path: Path, code: int, name: str) -> str:
        """What is wrong with a render that has ended, or nothing."""
        if code != 0:
            return f"exit code {code}"
        film = Film.load(path)
        whole = self.whole[name]
        planes = [(film.sums, whole.sums), (film.counts, whole.counts)]
        planes += [(film.aov_sums[layer], plane) for layer, plane in whole.aov_sums.items()]
        if not all(np.array_equal(a, b) for a, b in planes):
            return "other bits"
        path.unlink()
        return ""

    def _client(self, path: Path, name: str) -> Any:
        where = self.cluster.address, str(self.cluster.keys), str(path), name
        process = self._forks.Process(target=client, args=(*where, self.cluster.log.name))
        process.start()
        return process

    def _happen(self, fault: str, process: Any, again: Callable[[], Any]) -> tuple[Any, list[int]]:
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
            process.join()
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
    told = {number: trial for number, trial in campaign.trials.items() if trial["fault"]}
    delays = {
        fault: max(trial["delay"] for trial in told.values() if trial["fault"] == fault)
        for fault in campaign.faults if fault in {trial["fault"] for trial in told.values()}
    }  # fmt: skip
    return {
        "faults": dict(Counter(trial["fault"] for trial in told.values())),
        "differing": campaign.differing,
        "length_s": {name: round(length, 1) for name, length in campaign.lengths.items()},
        "delay_s": {name: round(delay, 1) for name, delay in delays.items()},
        "idle_s": round(max((trial["idle"] for trial in told.values()), default=0.0), 1),
    }  # fmt: skip


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--faults", type=int, default=16)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--folder", type=Path, required=True)
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    # What was started ends with it.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    numbers = range(given.first, given.first + given.faults)
    print(json.dumps(run(given.folder.resolve(), lambda kinds: numbers, given.seed)))


if __name__ == "__main__":
    main()
