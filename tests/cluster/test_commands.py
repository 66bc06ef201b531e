"""``alight render --cluster`` and ``alight cluster`` on the terminal."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from alight.cli.main import app
from alight.cluster.addresses import connected
from alight.films import Film
from tests.cluster.workers import two_workers

SMALL = ["cornell-box", "--size", "48", "--threads", "1", "-q"]


def alight(*words):
    return CliRunner().invoke(app, [str(word) for word in words])


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--cluster", "somewhere"], "--cluster: must be local:N"),
        (["--cluster", "tcp://10.0.0.1:8786"], "use tls:// and --cluster-keys"),
        (["--cluster", "tls://h:1"], "--cluster with tls:// needs --cluster-keys"),
        (["--cluster-keys", "k"], "--cluster-keys are those of --cluster"),
        (["--cluster", "tcp://127.0.0.1:1", "--cluster-keys", "k"], "tcp:// takes no keys"),
        (["--cluster", "local:1", "--cluster-keys", "k"], "local:N makes its own keys"),
        # A digit of Unicode, and the name of a host, which anybody may have.
        (["--cluster", "local:\uff12"], "local:N needs N in [1, 1024]"),
        (["--cluster", "tcp://127.999.0.1:8786"], "use tls:// and --cluster-keys"),
    ],
)
def test_what_cannot_be_is_one_message(tmp_path, monkeypatch, words, message):
    monkeypatch.chdir(tmp_path)
    done = alight("render", *SMALL, *words)
    assert done.exit_code == 2
    assert message in done.stderr
    assert not any(tmp_path.iterdir())


def test_the_status_of_a_target_that_is_none_is_refused():
    done = alight("cluster", "status", "local:1", "--target", "portabel")
    assert done.exit_code == 2
    assert '--target: unknown target "portabel"; did you mean "portable"?' in done.stderr


def test_keys_are_made_once(tmp_path):
    done = alight("cluster", "keys", tmp_path / "keys")
    assert done.exit_code == 0
    assert "whoever holds the key may run any code" in done.stdout
    again = alight("cluster", "keys", tmp_path / "keys")
    assert again.exit_code == 2
    assert "File exists" in again.stderr


def test_the_status_names_workers_and_their_trouble():
    from alight.cluster.status import workers_of
    from tests.cluster import jobs

    with two_workers() as client:
        one, other = sorted(client.nthreads())
        client.run(jobs.become_another_machine, workers=[one])
        told = workers_of(client)
    assert [worker.address for worker in told] == [one, other]
    assert [bool(worker.trouble) for worker in told] == [True, False]
    assert "refused: lanes is another" in str(told[0])
    assert "1 thread," in str(told[1])


def test_ctrl_c_keeps_the_samples_and_resume_gives_the_same_bits(tmp_path):
    """The signal goes to all processes of the terminal, those of the workers too."""
    words = [sys.executable, "-m", "alight", "render", *SMALL, "--spp", "200000",
             "--cluster", "local:2", "--checkpoint", "a.alight", "--every", "0",
             "--spp-per-pass", "20"]  # fmt: skip
    environment = {**os.environ, "PYTHONPATH": str(Path.cwd())}
    process = subprocess.Popen(
        words, cwd=tmp_path, start_new_session=True, env=environment, stderr=subprocess.PIPE,
        text=True,
    )  # fmt: skip
    path = tmp_path / "a.alight"
    try:
        give_up = time.perf_counter() + 120
        while not (path.exists() and Film.load(path).spp > 0):
            assert time.perf_counter() < give_up
            assert process.poll() is None
            time.sleep(0.2)
        os.killpg(process.pid, signal.SIGINT)
        _, told = process.communicate(timeout=60)
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
    assert process.returncode == 130, told
    assert "to continue: alight resume a.alight" in told
    # Answers come in any order: a pixel may lack samples before the last one that it holds.
    spp = max(end for cell in Film.load(path).cells.flat for _, end in cell) + 1
    done = alight("resume", path, "--spp", spp, "-o", tmp_path / "b.alight", "-q")
    assert done.exit_code == 0, done.output
    whole = alight("render", *SMALL, "--spp", spp, "-o", tmp_path / "c.alight")
    assert whole.exit_code == 0
    found, own = Film.load(tmp_path / "b.alight"), Film.load(tmp_path / "c.alight")
    np.testing.assert_array_equal(found.sums, own.sums)


def test_a_cluster_that_does_not_start_leaves_no_thread_behind(monkeypatch):
    async def fails(cluster):
        raise OSError("no room for it")

    # When its scheduler is there, and has been asked to be a part of the cluster.
    monkeypatch.setattr("distributed.deploy.cluster.Cluster._start", fails)
    before = set(threading.enumerate())
    with pytest.raises(RuntimeError, match="no room for it"), connected("local:1"):
        pass
    for one in set(threading.enumerate()) - before:
        if one.name == "IO loop":
            one.join(20.0)
            assert not one.is_alive()
