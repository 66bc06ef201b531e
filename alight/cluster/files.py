"""Cluster files: YAML that says where a cluster is, or how one is started for a render.

::

    type: slurm
    keys: keys
    workers: 40
    options: {queue: render, cores: 16, memory: 32GB, walltime: "02:00:00"}

Dask starts it: its `SSHCluster`, or the class of dask-jobqueue for the queue's manager. Every
connection is closed to those without the keys; the cluster ends with the render.
"""

from __future__ import annotations

import importlib
import logging
import math
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from alight.cluster.keys import role_settings, security_of
from alight.core.errors import AlightError, Issue, OptionError, SceneError, show_value, unknown_name
from alight.scene import plain_yaml

if TYPE_CHECKING:
    from distributed import Client

#: By the type of the file: class of dask-jobqueue.
_QUEUES = {
    "htcondor": "HTCondorCluster", "lsf": "LSFCluster", "moab": "MoabCluster",
    "oar": "OARCluster", "pbs": "PBSCluster", "sge": "SGECluster", "slurm": "SLURMCluster",
}  # fmt: skip

TYPES = ("address", "ssh", *_QUEUES)

_SUFFIXES = (".yaml", ".yml")
_MOST_BYTES = 2**20

#: Key -> (type, what it must be).
_KEYS: dict[str, tuple[type | tuple[type, ...], str]] = {
    "type": (str, f"one of {', '.join(TYPES)}"),
    "address": (str, "tls://HOST:PORT"),
    "hosts": (list, "a list of hosts, the first one for the scheduler"),
    "workers": (int, "a whole number > 0"),
    "wait": ((int, float), "a number of seconds > 0"),
    "keys": (str, "a folder that alight cluster keys made"),
    "options": (dict, "a mapping"),
}
_NEEDED = {"address": ("address",), "ssh": ("hosts",)}

#: Keys of one type only, and those without effect where a cluster runs already.
_ONLY = {"address": "address", "hosts": "ssh"}
_OF_STARTED = ("workers", "wait", "options")


#: Pages of Dask know no keys: none of its dashboard, the others for the machine itself.
_CLOSED = {"dashboard": False, "dashboard_address": "127.0.0.1:0"}


@dataclass(frozen=True)
class ClusterFile:
    """What a cluster file says.

    Attributes
    ----------
    path : str
    type : str
        One of `TYPES`.
    address : str
        Of the type ``address``.
    hosts : list of str
        Of the type ``ssh``: the scheduler's, then one for each worker.
    workers : int
        Jobs of a queue, processes of each host.
    wait : float, seconds
        Until the first worker must be there.
    keys : Path or None
    options : dict
        For the class of Dask that starts the cluster.
    """

    path: str
    type: str
    address: str = ""
    hosts: list[str] = field(default_factory=list)
    workers: int = 1
    wait: float = 3600.0
    keys: Path | None = None
    options: dict[str, Any] = field(default_factory=dict)

    @property
    def checked_keys(self) -> Path:
        """The folder of keys.

        Raises
        ------
        OptionError
            If none is named.
        """
        if self.keys is None:
            text = f"{self.path} needs keys, or {{cluster_keys}}: alight cluster keys makes them"
            raise OptionError(text, "cluster", names=("cluster_keys",))
        return self.keys.absolute()


def is_cluster_file(where: str) -> bool:
    """Whether this names a file, not an address."""
    return where.lower().endswith(_SUFFIXES)


def read_cluster_file(path: str | os.PathLike[str], keys: Any = None) -> ClusterFile:
    """Read a cluster file.

    Parameters
    ----------
    path : path
    keys : path, optional
        Instead of those that the file names, which are beside it.

    Raises
    ------
    OptionError
        If it cannot be read, or a key or value is wrong: with its place.
    """
    name = os.fspath(path)
    try:
        with Path(path).open(encoding="utf-8") as file:
            text = file.read(_MOST_BYTES)
        data, places, issues = plain_yaml.parse(text, name)
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is not text"
        raise OptionError(f"cannot read {name}: {reason}", "cluster") from None
    except SceneError as error:
        raise OptionError(str(error), "cluster") from None
    if not isinstance(data, dict):
        raise OptionError(f"{name} must be a mapping, got {show_value(data)}", "cluster")
    issues += [
        Issue(key, text, f"{name}:{places.get(key, '1:1')}") for key, text in _problems(data)
    ]
    if issues:
        raise OptionError("\n".join(map(str, issues)), "cluster")
    folder = keys or (Path(path).parent / data["keys"] if "keys" in data else None)
    return ClusterFile(name, **{**data, "keys": None if folder is None else Path(folder)})


def _problems(data: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """What is wrong: the key, and the message."""
    for key, value in data.items():
        if key not in _KEYS:
            yield key, unknown_name("key", key, _KEYS)
            continue
        kind, text = _KEYS[key]
        is_number = kind is not str and isinstance(value, int | float)
        is_wrong = is_number and (isinstance(value, bool) or not 0 < value < math.inf)
        if not isinstance(value, kind) or is_wrong:
            yield key, f"must be {text}, got {show_value(value)}"
    kind = data.get("type")
    if not isinstance(kind, str):
        if kind is None:
            yield "type", f"is missing: {_KEYS['type'][1]}"
        return
    if kind not in TYPES:
        yield "type", unknown_name("type of cluster", kind, TYPES)
        return
    for key, of in _ONLY.items():
        if key in data and kind != of:
            yield key, f"belongs to the type {of}, not to {kind}"
    if kind == "address":
        for key in _OF_STARTED:
            if key in data:
                yield key, "has no effect: a cluster of the type address runs already"
    for key in _NEEDED.get(kind, ()):
        if key not in data:
            yield key, f"is missing: {_KEYS[key][1]}"
    if kind != "ssh":
        return
    hosts = data.get("hosts", ["", ""])
    if isinstance(hosts, list) and (len(hosts) < 2 or not all(isinstance(h, str) for h in hosts)):
        yield "hosts", "must be two texts or more: the scheduler's host, and one for each worker"


@contextmanager
def started(file: ClusterFile) -> Iterator[Client]:
    """Start the cluster of a file that is not an address; a client of it.

    Raises
    ------
    OptionError
        If the file names no keys, or the package that starts it is not there.
    AlightError
        If it does not start, or no worker comes in time.
    """
    import dask.config
    from distributed import Client

    security = security_of(file.checked_keys)
    make = _ssh if file.type == "ssh" else _queue
    # SSHCluster hands this process's configuration to the others, and nothing else.
    with dask.config.set(role_settings(file.checked_keys)):
        try:
            cluster = make(file, security)
        except OptionError:
            raise
        except Exception as error:
            raise AlightError(
                f"the cluster of {file.path} does not start: {type(error).__name__}: {error}"
            ) from None
        try:
            with Client(cluster, security=security, set_as_default=False) as client:
                _wait(client, file)
                yield client
        finally:
            with suppress(Exception):
                cluster.close()


def _wait(client: Any, file: ClusterFile) -> None:
    try:
        client.wait_for_workers(1, timeout=file.wait)
    except TimeoutError:
        raise AlightError(f"{file.path}: no worker came in {file.wait:g} s") from None


def _needed(module: str, file: ClusterFile) -> Any:
    try:
        return importlib.import_module(module)
    except ImportError:
        package = module.replace("_", "-")
        text = f"{file.path}: the type {file.type} needs {package}: pip install {package}"
        raise OptionError(text, "cluster") from None


def _ssh(file: ClusterFile, security: Any) -> Any:
    _needed("asyncssh", file)
    from distributed import SSHCluster

    words = dict(file.options)
    for of in ("scheduler_options", "worker_options"):
        words[of] = {**_CLOSED, **words.get(of, {}), "protocol": "tls://"}
    words["worker_options"].setdefault("n_workers", file.workers)
    return SSHCluster(file.hosts, security=security, silence_logs=logging.WARNING, **words)


def _queue(file: ClusterFile, security: Any) -> Any:
    make: Callable[..., Any] = getattr(_needed("dask_jobqueue", file), _QUEUES[file.type])
    # One process a job, of all its cores: they share the scene.
    words = {"processes": 1, **file.options, "protocol": "tls://", "security": security}
    words["scheduler_options"] = {**_CLOSED, **words.get("scheduler_options", {})}
    closed = ["--no-dashboard", "--dashboard-address", _CLOSED["dashboard_address"]]
    words["worker_extra_args"] = [*closed, *words.get("worker_extra_args", [])]
    cluster = make(**words)
    cluster.scale(jobs=file.workers)
    return cluster
