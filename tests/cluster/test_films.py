"""Films of a cluster have the bits of ``alight render``, through every fault."""

import os
import signal
import threading

import numpy as np
import pytest

import alight
from alight.cluster import dispatch
from alight.cluster.addresses import connected
from alight.cluster.dispatch import Patience
from alight.core.errors import OptionError
from alight.films import Film
from alight.rendering.executors import cluster_executor
from tests.cluster import jobs
from tests.cluster.workers import two_workers
from tests.rendering.interrupted import cancelled_after

BOX = {"size": (72, 40), "crop": (3, 2, 60, 37), "threads": 1}

#: A ball that is thrown, in fog.
BALL = """
alight: 1
camera: {type: pinhole, fov: 40, shutter: [0, 1],
         transform: {look_at: {origin: [0, 0, 6], target: [0, 0, 0]}}}
film: {size: [40, 24]}
integrator: {type: volpath, max_depth: 4}
environment: {type: constant, radiance: [0.5, 0.6, 0.8]}
medium: fog
media: {fog: {type: homogeneous, sigma_t: 0.1, albedo: 0.8}}
bsdfs: {white: {type: diffuse, reflectance: 0.7}}
nodes:
  ball:
    shape: {type: sphere, radius: 0.7}
    bsdf: white
    transform: {keyframes: [{time: 0, translate: [-1, 0, 0]}, {time: 1, translate: [1, 0, 0]}]}
"""

RENDERS = {
    "a box": ("cornell-box", {**BOX, "spp": 13, "first_sample": 3, "replicates": 5}),
    "layers": ("cornell-box", {**BOX, "spp": 6, "aovs": "depth,id,direct,indirect"}),
    "passes of 3": ("cornell-box", {**BOX, "spp": 7, "spp_per_pass": 3, "seed": 4}),
    "motion in fog": (BALL, {"spp": 4, "threads": 1}),
    "adaptive": ("cornell-box", {**BOX, "spp": 24, "adaptive": True}),
    "light paths": ("cornell-box", {**BOX, "spp": 20, "integrator": "light"}),
    "an error": ("cornell-box", {**BOX, "error": 0.3, "adaptive": True, "max_spp": 200}),
}


@pytest.fixture(scope="module")
def client():
    with two_workers() as client:
        yield client


@pytest.fixture
def many_tasks(monkeypatch):
    """Tasks of some milliseconds."""
    monkeypatch.setattr(cluster_executor, "LONGEST", 0.004)
    monkeypatch.setattr(cluster_executor, "SHORTEST", 0.001)
    monkeypatch.setattr(cluster_executor, "_SPEED", 1e6)


@pytest.fixture
def impatient(monkeypatch):
    """What does not answer for two seconds is taken for lost: where something is."""
    short = Patience(task=1.5, times=4.0, fetch=2.0, cluster=20.0)
    monkeypatch.setattr(dispatch, "Patience", lambda: short)


def assert_same_film(film, other):
    np.testing.assert_array_equal(film.sums, other.sums)
    np.testing.assert_array_equal(film.counts, other.counts)
    assert (film.cells == other.cells).all()
    assert film.aov_sums.keys() == other.aov_sums.keys()
    for name, plane in film.aov_sums.items():
        np.testing.assert_array_equal(plane, other.aov_sums[name])
    assert film.biases == other.biases
    assert (film.invalid, film.saturated) == (other.invalid, other.saturated)


@pytest.mark.parametrize(("scene", "words"), RENDERS.values(), ids=RENDERS.keys())
def test_a_cluster_renders_the_same_film(client, many_tasks, tmp_path, scene, words):
    if scene == BALL:
        (tmp_path / "ball.yaml").write_text(BALL)
        scene = tmp_path / "ball.yaml"
    # First here: the workers then find the kernels in the cache.
    own = alight.render(scene, **words)
    film = alight.render(scene, cluster=client, **words)
    assert_same_film(film, own)
    assert film.stats["rays"] == own.stats["rays"]
    assert film.stats["verdict"] == own.stats["verdict"]
    told = film.stats["cluster"]
    assert told["tasks"] >= 2
    assert told.get("done_here", 0) == told.get("failed", 0) == 0


def test_workers_need_neither_compiler_nor_cache(client, many_tasks, tmp_path):
    """Kernels arrive as object code: nothing is read from the cache, or written to it."""
    cache = tmp_path / "cold"
    client.run(jobs.keep_kernels_in, str(cache))
    try:
        words = {**RENDERS["layers"][1], "seed": 9}
        film = alight.render("cornell-box", cluster=client, **words)
    finally:
        client.run(jobs.keep_kernels_in, os.environ.get("ALIGHT_CACHE"))
    assert_same_film(film, alight.render("cornell-box", **words))
    assert not cache.exists()
    assert set(client.run(jobs.has_compiler).values()) == {False}


def test_a_cancelled_render_goes_on_to_the_same_bits(client, many_tasks, monkeypatch, tmp_path):
    path, words = tmp_path / "a.alight", {**BOX, "spp": 24}
    with cancelled_after(5, monkeypatch) as cancel:
        film = alight.render("cornell-box", checkpoint=path, cancel=cancel, cluster=client, **words)
    assert 0 < film.spp < 24
    whole = alight.render("cornell-box", **words)
    # Here, and from the same file on the cluster.
    copy = tmp_path / "b.alight"
    copy.write_bytes(path.read_bytes())
    assert_same_film(alight.resume(copy), whole)
    assert_same_film(alight.resume(path, cluster=client), whole)
    assert_same_film(Film.load(path), whole)


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_workers_that_are_killed_or_stopped_change_no_bit(client, many_tasks, impatient, number):
    client.wait_for_workers(2, timeout=30)
    hit = []

    def fault(progress):
        if progress.phase == "render" and progress.done_samples and not hit:
            hit.append(client.run(os.getpid).popitem()[1])
            os.kill(hit[0], number)

    words = {**BOX, "spp": 200}
    try:
        film = alight.render("cornell-box", cluster=client, progress=fault, **words)
    finally:
        if number == signal.SIGSTOP and hit:
            os.kill(hit[0], signal.SIGCONT)
    assert hit
    assert_same_film(film, alight.render("cornell-box", **words))


def test_a_lost_cluster_leaves_the_rest_to_this_process(many_tasks, impatient):
    from distributed import Client, LocalCluster

    with LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, protocol="tcp://", host="127.0.0.1",
        dashboard_address="127.0.0.1:0",
    ) as cluster, Client(cluster) as client:  # fmt: skip
        words = {**BOX, "spp": 100}

        def lose(progress):
            if progress.phase == "render" and progress.done_samples and client.status == "running":
                client.close()

        film = alight.render("cornell-box", cluster=client, progress=lose, **words)
    told = film.stats["cluster"]
    assert told["tasks"] > 0
    assert_same_film(film, alight.render("cornell-box", **words))


def test_frames_of_an_animation_are_those_of_one_machine(client, many_tasks, monkeypatch, tmp_path):
    """And two of them are in work: the second has its workers before the first lets go of them."""

    def animate(name, **words):
        (tmp_path / name).mkdir(exist_ok=True)
        words = {**BOX, "spp": 6, "turntable": True, "frames": "0:3", **words}
        alight.animate("cornell-box", output=tmp_path / name / "f_#.png", **words)
        return [path.read_bytes() for path in sorted((tmp_path / name).iterdir())]

    dispatchers, opened, two_are_open, waited = [], [], threading.Event(), []

    class Dispatcher(dispatch.Dispatcher):
        def __init__(self, *words):
            super().__init__(*words)
            dispatchers.append(self)

        def open(self):
            super().open()
            opened.append(self)
            if len(opened) == 2:
                two_are_open.set()
            waited.append(two_are_open.wait(30.0))

    monkeypatch.setattr(dispatch, "Dispatcher", Dispatcher)
    own = animate("own")
    assert len(set(own)) == 3
    assert animate("theirs", cluster=client) == own
    assert [one.counts["tasks"] > 1 for one in dispatchers] == [True] * 3
    assert all(waited)
    # Where a frame was rendered is no part of what it is.
    animate("own", cluster=client)
    assert len(dispatchers) == 3


def test_a_time_limit_ends_a_render(client):
    film = alight.render("cornell-box", cluster=client, time_limit=0.5, **BOX)
    assert film.stats["verdict"]["word"] == "time"
    spp = int(film.spp)
    assert_same_film(film, alight.render("cornell-box", spp=spp, **BOX))


REFUSALS = {
    "no address": ({"cluster": "somewhere"}, "cluster: must be local:N"),
    "no processes": ({"cluster": "local:0"}, "local:N needs N in"),
    "not encrypted": ({"cluster": "tcp://10.0.0.1:8786"}, "neither encrypted nor closed"),
    "no keys": ({"cluster": "tls://10.0.0.1:8786"}, "needs cluster_keys"),
    "no such keys": ({"cluster": "tls://127.0.0.1:1", "cluster_keys": "no"}, "there is no certif"),
    "keys of nothing": ({"cluster_keys": "no"}, "cluster_keys are those of cluster"),
    "no client": ({"cluster": 3}, "an address or a client"),
}


@pytest.mark.parametrize(("words", "message"), REFUSALS.values(), ids=REFUSALS.keys())
def test_what_is_no_cluster_is_refused(words, message):
    with pytest.raises(OptionError, match=message):
        alight.render("cornell-box", spp=1, **BOX, **words)


def test_keys_let_in_who_holds_them(tmp_path):
    from distributed import LocalCluster

    from alight.cluster.keys import make_keys, security_of

    keys, strange = tmp_path / "keys", tmp_path / "strange"
    for path in (*make_keys(keys), *make_keys(strange)):
        assert path.stat().st_mode & 0o077 == 0
    with pytest.raises(alight.OutputError, match="File exists"):
        make_keys(keys)
    security = security_of(keys)
    certificate, key = security.tls_client_cert, security.tls_client_key
    for role in ("scheduler", "worker"):
        setattr(security, f"tls_{role}_cert", certificate)
        setattr(security, f"tls_{role}_key", key)
    with LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, host="127.0.0.1", protocol="tls://",
        security=security, dashboard_address="127.0.0.1:0",
    ) as cluster:  # fmt: skip
        address = cluster.scheduler_address
        with connected(address, keys) as client:
            assert client.submit(sum, [2, 3]).result(timeout=10) == 5
        with pytest.raises(alight.AlightError, match="no scheduler answers"):
            connected_quickly(address, strange)


def connected_quickly(address, keys):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("alight.cluster.addresses._CONNECT", 1.0)
        with connected(address, keys):
            pass
