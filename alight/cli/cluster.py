"""``alight cluster``: keys of a cluster, and what it consists of."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from alight.options.target import TargetOptions
from lanewise.machine import NATIVE


def keys(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder to write.")],
) -> None:
    """Make the keys of a cluster; whoever holds them may run any code on it."""
    from alight.cluster.addresses import check_dask
    from alight.cluster.keys import make_keys

    check_dask()
    for path in make_keys(folder):
        typer.echo(f"written: {path}")
    typer.echo("whoever holds the key may run any code on the cluster's machines, and on yours")


def status(
    address: Annotated[str, typer.Argument(help="As for alight render --cluster.")],
    cluster_keys: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Keys of a tls:// cluster.")
    ] = None,
    target: Annotated[
        str, typer.Option(metavar="NAME", help="Of the renders: native or portable.")
    ] = NATIVE,
) -> None:
    """Say which workers a cluster has, and which this machine's renders refuse."""
    from alight.cluster.addresses import check_address, connected
    from alight.cluster.status import dashboard_of, losses_of, workers_of

    check_address(address, cluster_keys)
    TargetOptions(target=target)
    with connected(address, cluster_keys) as client:
        found = workers_of(client, target)
        lost, dashboard = losses_of(client), dashboard_of(client)
    for worker in found:
        typer.echo(str(worker))
    usable = sum(worker.threads for worker in found if not worker.trouble)
    typer.echo(f"{_count(len(found), 'worker')}; threads that give this machine's bits: {usable}")
    gone = f"{_count(lost.workers, 'worker')}, {_count(lost.tasks, 'task')}"
    typer.echo(f"lost since the scheduler was started: {gone}")
    if dashboard:
        typer.echo(f"dashboard: {dashboard}")


def _count(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number} {what}s"


keys.spelling = status.spelling = {  # type: ignore[attr-defined]
    "cluster": "ADDRESS", "cluster_keys": "--cluster-keys", "target": "--target",
}  # fmt: skip
