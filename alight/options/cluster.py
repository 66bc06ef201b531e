"""Options of a render by several processes or machines."""

from __future__ import annotations

from os import PathLike
from typing import Any

from alight.options.kinds import File, Text
from alight.options.table import SAMPLING, Options, option, table


@table
class ClusterOptions(Options):
    """Where a render's samples come from."""

    cluster: str | Any = option(
        Text("ADDRESS|local:N|FILE.yaml"),
        "Render on a Dask cluster, or in N processes, to the same bits. Needs the extra cluster.",
        default=None, shown="the threads of this process", panel=SAMPLING,
    )  # fmt: skip
    cluster_keys: str | PathLike[str] | None = option(
        File("FOLDER"), "Keys of a tls:// cluster, made by alight cluster keys.",
        default=None, panel=SAMPLING,
    )  # fmt: skip
