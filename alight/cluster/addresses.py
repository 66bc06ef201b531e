"""Where a cluster is: processes of this machine, a scheduler's address, or a file that says it."""

from __future__ import annotations

import os
import re
import socket
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from ipaddress import ip_address
from pathlib import Path
from typing import TYPE_CHECKING, Any

from alight.cluster.files import is_cluster_file, read_cluster_file, started
from alight.cluster.fork_server import can_fork, preloaded
from alight.cluster.keys import security_of
from alight.core.errors import AlightError, OptionError
from alight.core.extras import install_command
from lanewise.application import variable
from lanewise.jit import uses_stock_pipeline

if TYPE_CHECKING:
    from distributed import Client

#: Most processes of this machine.
_MOST = 1024

_LAST_PORT = 65535

#: Dask samples the stacks of its loops 100 times a second, and looks at each of them 50 times: with
#: a scheduler and two nannies that is 3 % of the client's core.
_QUIET = {
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "500ms",
}

#: Seconds after which a scheduler that does not answer is not waited for.
_CONNECT = 20.0


def check_address(where: Any, keys: str | os.PathLike[str] | None = None) -> None:
    """Refuse an address that is none, or at which others could listen.

    Parameters
    ----------
    where : str or distributed.Client
        ``local:N``, ``tls://HOST:PORT``, on this machine ``tcp://HOST:PORT``, or a file
        (`alight.cluster.files`).
    keys : path, optional
        Folder that ``alight cluster keys`` made.

    Raises
    ------
    OptionError
        Also if Dask is not installed.
    """
    check_dask()
    if uses_stock_pipeline():
        text = f"kernels of {variable('PIPELINE')}=stock stay in the process that compiled them"
        raise OptionError(text, "cluster")
    if not isinstance(where, str):
        if not hasattr(where, "scheduler_info"):
            raise OptionError("must be an address or a client of Dask distributed", "cluster")
        if keys is not None:
            text = "a client of Dask has its keys: leave out {cluster_keys}"
            raise OptionError(text, names=("cluster_keys",))
        return
    if processes_of(where):
        if keys is not None:
            text = "local:N makes its own keys: leave out {cluster_keys}"
            raise OptionError(text, "cluster", names=("cluster_keys",))
        return
    if is_cluster_file(where):
        file = read_cluster_file(where, keys)
        if file.type != "address":
            security_of(file.checked_keys)
            return
        name, where, keys = f"{file.path}: address ", file.address, file.keys
        forms = "tls://HOST:PORT or tcp://127.0.0.1:PORT"
    else:
        name, forms = "", "local:N, tls://HOST:PORT, tcp://127.0.0.1:PORT or FILE.yaml"
    found = re.fullmatch(r"(tcp|tls)://(\[[0-9a-fA-F:]+\]|[^:/\[\]]+):([0-9]{1,5})", where)
    if found is None:
        raise OptionError(f'{name}must be {forms}, got "{where}"', "cluster")
    try:
        found[2].encode("idna")
    except UnicodeError:
        # Dask would ask for its address in the background, and leave a client behind.
        raise OptionError(f"{name}{found[2]} is no name of a host", "cluster") from None
    if not 0 < int(found[3]) <= _LAST_PORT:
        raise OptionError(
            f"{name}needs a port in [1, {_LAST_PORT}], got {int(found[3])}", "cluster"
        )
    if found[1] == "tcp" and keys is not None:
        text = "tcp:// takes no keys: use tls://, or leave out {cluster_keys}"
        raise OptionError(text, "cluster", names=("cluster_keys",))
    if found[1] == "tcp" and not _is_this_machine(found[2]):
        raise OptionError(
            f"{name}tcp:// is neither encrypted nor closed to strangers, and only for this "
            "machine: use tls:// and {cluster_keys}",
            "cluster", names=("cluster_keys",),
        )  # fmt: skip
    if found[1] == "tls" and keys is None:
        text = "{cluster} with tls:// needs {cluster_keys}, which alight cluster keys makes"
        raise OptionError(text, names=("cluster", "cluster_keys"))


def check_dask() -> None:
    """Refuse to go on without Dask.

    Raises
    ------
    OptionError
    """
    try:
        import distributed  # noqa: F401
    except ImportError:
        command = install_command("cluster", "distributed")
        raise OptionError(f"needs the extra cluster: {command}", "cluster") from None


def processes_of(where: str) -> int:
    """N of ``local:N``, or 0.

    Raises
    ------
    OptionError
        If it is not in the range.
    """
    if not where.startswith("local:"):
        return 0
    found = re.fullmatch(r"local:([0-9]{1,4})", where)
    if found is None or not 1 <= int(found[1]) <= _MOST:
        raise OptionError(f'local:N needs N in [1, {_MOST}], got "{where}"', "cluster")
    return int(found[1])


def _is_this_machine(host: str) -> bool:
    if host == "localhost":
        return True
    with suppress(ValueError):
        return ip_address(host.strip("[]")).is_loopback
    return False


@contextmanager
def connected(
    where: Any, keys: str | os.PathLike[str] | None = None, modules: Sequence[str] = ()
) -> Iterator[Client]:
    """A client of the cluster at an address that `check_address` has let pass.

    A client that was given is given back, and stays open.

    Parameters
    ----------
    where, keys
        See `check_address`.
    modules : sequence of str
        Imported once for all processes of ``local:N``, where the system can fork.

    Raises
    ------
    AlightError
        If there is no scheduler.
    """
    from distributed import Client

    if not isinstance(where, str):
        yield where
        return
    processes = processes_of(where)
    if processes:
        with (
            _local_cluster(processes, modules) as cluster,
            Client(cluster, set_as_default=False) as client,
        ):
            yield client
        return
    if is_cluster_file(where):
        file = read_cluster_file(where, keys)
        if file.type != "address":
            with started(file) as client:
                yield client
            return
        where, keys = file.address, file.keys
    security = None if keys is None else security_of(Path(keys))
    try:
        client = Client(where, security=security, timeout=_CONNECT, set_as_default=False)
    except (OSError, TimeoutError) as error:
        raise AlightError(f"no scheduler answers at {where}: {_why(where, error)}") from None
    with client:
        yield client


def _why(where: str, error: Exception) -> str:
    """Why a scheduler may not answer; Dask itself reports only how long it has waited."""
    scheme, _, rest = where.partition("://")
    host, _, port = rest.rpartition(":")
    try:
        socket.getaddrinfo(host.strip("[]"), int(port))
    except OSError as unknown:
        return f"{host}: {unknown.strerror}"
    if scheme == "tcp":
        return f"{error}; if it was started with keys, use tls://{rest}"
    return str(error)


def _local_cluster(processes: int, modules: Sequence[str]) -> Any:
    """Processes of one thread each, behind TLS with keys that live as long as they do."""
    import logging

    import dask.config
    from distributed import LocalCluster, Security
    from distributed.utils import get_mp_context

    class Local(LocalCluster):
        """Ends its loop where it does not start; Dask leaves the thread behind."""

        def __init__(self, **words: Any) -> None:
            try:
                super().__init__(**words)
            except BaseException:
                self._loop_runner.stop()
                raise

    settings: dict[str, Any] = dict(_QUIET)
    if can_fork():
        settings["distributed.worker.multiprocessing-method"] = "forkserver"
    with dask.config.set(settings):
        if len(settings) > len(_QUIET):
            # Dask names modules of its own here, once, and others may be named after it has.
            get_mp_context().set_forkserver_preload(preloaded(modules))
        return Local(
            n_workers=processes, threads_per_worker=1, processes=True, host="127.0.0.1",
            protocol="tls://", security=Security.temporary(), dashboard_address="127.0.0.1:0",
            memory_limit=0, silence_logs=logging.ERROR, preload=["alight.cluster.preload"],
        )  # fmt: skip
