"""Workers of this machine start while the client is busy with its own start."""

import logging
import signal
import subprocess
import sys
import threading
from contextlib import contextmanager

import pytest

from alight.cluster import fork_server, preload
from alight.lab.replicates import spread
from alight.rendering.executors import cluster_executor
from alight.rendering.executors.cluster_executor import ClusterExecutor

#: Says what is imported, and whether interrupts are blocked, where a server would be started.
SCRIPT = """
import signal, sys
from multiprocessing import forkserver
from alight.cli.main import app

def started():
    heavy = {"numpy", "alight.scene", "distributed"} & sys.modules.keys()
    print(sorted(heavy), signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, []))
    sys.exit(7)

forkserver.ensure_running = started
app(sys.argv[1:])
"""


@pytest.mark.skipif(not fork_server.can_fork(), reason="no servers of forks")
@pytest.mark.parametrize("command", ["render", "resume", "study"])
def test_the_server_starts_before_anything_heavy_is_imported(command):
    words = [command, "any", "--cluster", "local:2"]
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, *words], capture_output=True, text=True, check=False
    )
    assert (done.stdout.strip(), done.returncode) == ("[] True", 7), done.stderr


def test_the_server_imports_what_answers():
    assert cluster_executor.__name__ == fork_server.RENDERS
    assert spread.__name__ == fork_server.STUDIES


@pytest.mark.skipif(not fork_server.can_fork(), reason="no servers of forks")
def test_only_processes_of_this_machine_are_forked(monkeypatch):
    from multiprocessing import forkserver

    started = []
    monkeypatch.setattr(forkserver, "ensure_running", lambda: started.append(True))
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [])
    for where in (
        None,
        "tcp://127.0.0.1:8786",
        "local:",
        "local:0",
        "local:x",
        "local:2x",
        "a.yaml",
        object(),
    ):
        fork_server.start_fork_server(where, fork_server.RENDERS)
    assert not started
    fork_server.start_fork_server("local:2", fork_server.RENDERS)
    assert started == [True]
    assert signal.pthread_sigmask(signal.SIG_BLOCK, []) == before


class Slow:
    """A cluster that starts when it is let, and tells what happens to it."""

    def __init__(self, fails=False):
        self.fails, self.go, self.told = fails, threading.Event(), []

    @contextmanager
    def connected(self, *_):
        """Stands for that of `alight.cluster.addresses`."""
        assert self.go.wait(10.0)
        if self.fails:
            raise OSError("no room for it")
        self.told.append("started")
        yield "a client"
        self.told.append("ended")


def test_processes_that_are_still_starting_end_with_a_render_that_fails(monkeypatch):
    cluster = Slow()
    monkeypatch.setattr(cluster_executor, "connected", cluster.connected)
    with pytest.raises(ZeroDivisionError), ClusterExecutor("local:2"):
        assert cluster.told == []
        threading.Timer(0.05, cluster.go.set).start()
        raise ZeroDivisionError
    assert cluster.told == ["started", "ended"]


def test_why_processes_do_not_start_is_said_where_they_are_needed(monkeypatch):
    cluster = Slow(fails=True)
    monkeypatch.setattr(cluster_executor, "connected", cluster.connected)
    with ClusterExecutor("local:2") as executor:
        cluster.go.set()
        with pytest.raises(OSError, match="no room for it"):
            executor.begin(None)


def test_a_worker_leaves_the_end_of_the_scheduler_to_the_client(monkeypatch, caplog):
    monkeypatch.setattr(signal, "signal", lambda *_: None)
    log = logging.getLogger("distributed.worker")
    monkeypatch.setattr(log, "filters", [])
    monkeypatch.setattr(log, "disabled", False)
    log.addHandler(caplog.handler)
    try:
        preload.dask_setup(None)
        log.error("Failed to communicate with scheduler during heartbeat.")
        log.error("Unexpected exception during heartbeat. Closing worker.")
    finally:
        log.removeHandler(caplog.handler)
    assert {record.getMessage()[:10] for record in caplog.records} == {"Unexpected"}
