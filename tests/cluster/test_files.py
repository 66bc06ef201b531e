"""Cluster files: what they say is done, over TLS; what is wrong with one is said with its place."""

import logging
import re
import socket
import sys
import types
from dataclasses import replace

import pytest
import yaml

import alight
from alight.cluster import addresses, files, worker
from alight.cluster.addresses import check_address
from alight.cluster.files import read_cluster_file
from alight.cluster.keys import make_keys, role_settings, security_of
from alight.core.errors import AlightError, OptionError
from tests.docs.pages import ROOT

EXAMPLES = ROOT / "docs" / "clusters"


@pytest.fixture
def farm(tmp_path, monkeypatch):
    """Write farm.yaml beside keys, in the folder that is the current one."""
    monkeypatch.chdir(tmp_path)
    make_keys(tmp_path / "keys")

    def write(text):
        (tmp_path / "farm.yaml").write_text(text, encoding="utf-8")
        return "farm.yaml"

    return write


WRONG = {
    "no mapping": ("- 1", "farm.yaml must be a mapping"),
    "no type": ("workers: 3", "type\n  is missing: one of address, ssh"),
    "another type": ("type: slum", "farm.yaml:1:7  type\n  unknown type of cluster"),
    "another key": ("type: slurm\nworker: 3", 'did you mean "workers"'),
    "no hosts": ("type: ssh", "hosts\n  is missing"),
    "one host": ("type: ssh\nhosts: [a]", "farm.yaml:2:8  hosts\n  must be two texts or more"),
    "no number": ("type: slurm\nworkers: many", 'must be a whole number > 0, got "many"'),
    "none": ("type: slurm\nworkers: 0", "must be a whole number > 0, got 0"),
    "yes": ("type: slurm\nworkers: true", "must be a whole number > 0, got true"),
    "no address": ("type: address", "address\n  is missing: tls://HOST:PORT"),
    "in the clear": ("type: address\naddress: tcp://10.0.0.1:1", "neither encrypted nor closed"),
    "no number of seconds": ("type: slurm\nwait: .nan", "number of seconds > 0, got nan"),
    "no end": ("type: slurm\nwait: .inf", "number of seconds > 0, got inf"),
    "a key of another type": (
        "type: slurm\nhosts: [a, b]",
        "farm.yaml:2:8  hosts\n  belongs to the type ssh, not to slurm",
    ),
    "nothing to start": (
        "type: address\naddress: tls://a:1\nworkers: 2",
        "workers\n  has no effect: a cluster of",
    ),
    "no address at all": (
        "type: address\naddress: a",
        "farm.yaml: address must be tls://HOST:PORT or tcp://127.0.0.1:",
    ),
    "no host": ("type: address\naddress: tls://a..b:8786", "a..b is no name of a host"),
    "no port": ("type: address\naddress: tls://a:65536", "needs a port in [1, 65535], got 65536"),
    "no keys": ("type: slurm", "farm.yaml needs keys, or cluster_keys"),
    "keys of nobody": ("type: slurm\nkeys: lost", "there is no certificate.pem"),
    "code": ("type: !!python/name:os.system x", "YAML tags"),
}


@pytest.mark.parametrize(("text", "message"), WRONG.values(), ids=WRONG.keys())
def test_a_wrong_file_is_refused_before_anything_starts(farm, text, message):
    with pytest.raises(OptionError) as refused:
        alight.render("cornell-box", spp=1, size=8, cluster=farm(text))
    assert message in str(refused.value)


@pytest.mark.parametrize("name", ["certificate.pem", "key.pem"])
def test_files_that_are_no_keys_are_refused_before_anything_starts(farm, tmp_path, name):
    (tmp_path / "keys" / name).write_text("a shopping list")
    where = farm("type: slurm\nkeys: keys")
    with pytest.raises(OptionError, match="are not a certificate and its key: "):
        alight.render("cornell-box", spp=1, size=8, cluster=where)


def test_a_key_of_another_certificate_is_refused(tmp_path):
    for name in "ab":
        make_keys(tmp_path / name)
    (tmp_path / "a" / "key.pem").replace(tmp_path / "b" / "key.pem")
    with pytest.raises(OptionError, match=r"certificate and its key: KEY_VALUES_MISMATCH"):
        security_of(tmp_path / "b")


def test_a_host_that_nobody_knows_is_named(monkeypatch):
    def unknown(host, port):
        raise socket.gaierror(-2, "Name or service not known")

    monkeypatch.setattr(addresses.socket, "getaddrinfo", unknown)
    assert addresses._why("tls://lion:8786", TimeoutError("20 s")) == (
        "lion: Name or service not known"
    )


def test_addresses_in_brackets_are_looked_up_without_them(monkeypatch):
    asked = []
    monkeypatch.setattr(addresses.socket, "getaddrinfo", lambda *where: asked.append(where))
    assert addresses._why("tls://[::1]:8786", TimeoutError("20 s")) == "20 s"
    assert asked == [("::1", 8786)]


def test_a_scheduler_that_speaks_tls_is_asked_for_keys():
    told = addresses._why("tcp://127.0.0.1:1", OSError("reset"))
    assert told == "reset; if it was started with keys, use tls://127.0.0.1:1"


def test_a_file_that_is_not_there_is_refused(farm):
    with pytest.raises(OptionError, match="cannot read no\\.yaml: No such file"):
        check_address("no.yaml")


def test_keys_lie_beside_the_file_unless_others_are_given(farm, tmp_path):
    farm("type: slurm\nkeys: keys")
    assert read_cluster_file(tmp_path / "farm.yaml").keys == tmp_path / "keys"
    assert read_cluster_file("farm.yaml", tmp_path / "mine").keys == tmp_path / "mine"


@pytest.fixture
def local(monkeypatch):
    """What the makers of clusters were asked for; each is a worker of this process, over TLS."""
    from distributed import LocalCluster

    for name in ("distributed", "distributed.core"):
        logging.getLogger(name).setLevel(logging.ERROR)
    asked = {}

    class Made(LocalCluster):
        def __init__(self, *hosts, security=None, **words):
            import dask.config

            asked.update(words, hosts=hosts, security=security, scaled=None)
            asked["settings"] = dask.config.get("distributed.comm.tls.worker.key")
            super().__init__(
                n_workers=1, threads_per_worker=1, processes=False, host="127.0.0.1",
                protocol="tls://", security=security, dashboard_address="127.0.0.1:0",
            )  # fmt: skip

        def scale(self, jobs=None, **words):
            # At the end there are to be none.
            asked["scaled"] = asked["scaled"] or jobs

    queues = types.SimpleNamespace(SLURMCluster=Made)
    monkeypatch.setitem(sys.modules, "dask_jobqueue", queues)
    monkeypatch.setitem(sys.modules, "asyncssh", types.ModuleType("asyncssh"))
    monkeypatch.setattr("distributed.SSHCluster", Made)
    yield asked
    # The process of the worker was this one.
    worker._kept.clear()


def test_a_queue_is_asked_for_workers_that_speak_tls(farm, local, tmp_path):
    where = farm("type: slurm\nkeys: keys\nworkers: 40\noptions: {queue: render, cores: 16}")
    film = alight.render("cornell-box", spp=2, size=16, threads=1, cluster=where)
    assert (film.sums == alight.render("cornell-box", spp=2, size=16, threads=1).sums).all()
    assert film.stats["cluster"]["tasks"] > 0
    assert (local["queue"], local["cores"], local["processes"]) == ("render", 16, 1)
    assert (local["scaled"], local["protocol"]) == (40, "tls://")
    assert local["scheduler_options"] == {"dashboard": False, "dashboard_address": "127.0.0.1:0"}
    assert local["worker_extra_args"][:2] == ["--no-dashboard", "--dashboard-address"]
    assert local["security"].require_encryption
    for role in ("scheduler", "worker", "client"):
        found = local["security"].get_tls_config_for_role(role)
        assert found["key"] == str(tmp_path / "keys" / "key.pem")


def test_options_of_a_file_do_not_open_a_queue_to_others(farm, local):
    where = farm("type: slurm\nkeys: keys\noptions: {protocol: 'tcp://'}")
    with files.started(read_cluster_file(where)):
        pass
    assert local["protocol"] == "tls://"


def test_hosts_are_asked_by_ssh_for_workers_that_speak_tls(farm, local, tmp_path):
    where = farm(
        "type: ssh\nkeys: keys\nworkers: 2\nhosts: [lion, lion, tiger]\n"
        "options: {worker_options: {nthreads: 8}, remote_python: /opt/python}"
    )
    with files.started(read_cluster_file(where)):
        pass
    assert local["hosts"] == (["lion", "lion", "tiger"],)
    # Dask's pages know no keys.
    closed = {"dashboard": False, "dashboard_address": "127.0.0.1:0", "protocol": "tls://"}
    assert local["worker_options"] == {"nthreads": 8, "n_workers": 2, **closed}
    assert local["scheduler_options"] == closed
    assert local["remote_python"] == "/opt/python"
    # What SSHCluster sends to the hosts is the configuration.
    assert local["settings"] == str(tmp_path / "keys" / "key.pem")
    import dask.config

    assert dask.config.get("distributed.comm.tls.worker.key") is None
    assert "distributed.comm.require-encryption" in role_settings(tmp_path / "keys")


def test_a_cluster_that_does_not_start_is_one_message(farm, local, monkeypatch):
    where = farm("type: slurm\nkeys: keys")

    def fails(**words):
        raise ValueError("You must specify how many cores to use")

    monkeypatch.setattr(sys.modules["dask_jobqueue"], "SLURMCluster", fails)
    with pytest.raises(AlightError, match=r"farm\.yaml does not start: ValueError: You must"):
        alight.render("cornell-box", spp=1, size=8, cluster=where)
    monkeypatch.setitem(sys.modules, "dask_jobqueue", None)
    with pytest.raises(OptionError, match="type slurm needs dask-jobqueue: pip install dask-j"):
        alight.render("cornell-box", spp=1, size=8, cluster=where)


def test_the_examples_of_the_page_are_read(farm):
    slurm = read_cluster_file(EXAMPLES / "slurm.yaml")
    assert (slurm.type, slurm.workers, slurm.options["walltime"]) == ("slurm", 40, "02:00:00")
    ssh = read_cluster_file(EXAMPLES / "ssh.yaml")
    assert (ssh.type, len(ssh.hosts)) == ("ssh", 4)


def test_the_script_of_a_slurm_job_starts_a_worker_with_the_keys(farm, tmp_path):
    pytest.importorskip("dask_jobqueue")
    where = farm((EXAMPLES / "slurm.yaml").read_text(encoding="utf-8"))
    file = replace(read_cluster_file(tmp_path / where), workers=0)
    with files._queue(file, security_of(file.checked_keys)) as cluster:
        script = cluster.job_script()
    for line in ("#SBATCH -p render", "#SBATCH --cpus-per-task=16", "#SBATCH -t 02:00:00"):
        assert line in script
    assert "--nthreads 16" in script
    assert f"--tls-key {tmp_path / 'keys' / 'key.pem'}" in script
    assert "tls://" in script


def test_pods_of_the_manifest_speak_tls_with_the_keys_of_the_secret():
    text = (EXAMPLES / "kubernetes.yaml").read_text(encoding="utf-8")
    manifest = yaml.safe_load(text)
    assert (manifest["apiVersion"], manifest["kind"]) == ("kubernetes.dask.org/v1", "DaskCluster")
    spec, name = manifest["spec"], manifest["metadata"]["name"]
    for part in ("scheduler", "worker"):
        pod = spec[part]["spec"]
        [container] = pod["containers"]
        [volume], [mount] = pod["volumes"], container["volumeMounts"]
        assert container["args"][:2] == ["dask", part]
        assert volume["secret"]["secretName"] == "alight-keys"
        assert volume["name"] == mount["name"]
        paths = {f"{mount['mountPath']}/{file}" for file in ("certificate.pem", "key.pem")}
        given = [word.partition("=") for word in container["args"] if word.startswith("--tls")]
        assert {option for option, _, _ in given} == {"--tls-ca-file", "--tls-cert", "--tls-key"}
        assert {value for _, _, value in given} == paths
        assert "--dashboard-address=127.0.0.1:0" in container["args"]
    # The schema of the operator has texts where Kubernetes takes numbers, too.
    [container], [port] = (
        spec["scheduler"]["spec"]["containers"],
        spec["scheduler"]["service"]["ports"],
    )
    [own] = container["ports"]
    assert container["readinessProbe"]["tcpSocket"]["port"] == port["targetPort"] == own["name"]
    port = port["port"]
    assert f"tls://{name}-scheduler:{port}" in spec["worker"]["spec"]["containers"][0]["args"]
    assert "--protocol=tls" in spec["scheduler"]["spec"]["containers"][0]["args"]
    page = (ROOT / "docs" / "many-machines.md").read_text(encoding="utf-8")
    assert "create secret generic alight-keys" in page


def test_pages_that_ask_for_no_key_are_open_to_their_own_machine_alone():
    page = (ROOT / "docs" / "many-machines.md").read_text(encoding="utf-8")
    commands = re.findall(r"^dask (?:scheduler|worker) .*", page, re.MULTILINE)
    assert len(commands) == 2
    assert all(" --dashboard-address 127.0.0.1:" in command for command in commands)
