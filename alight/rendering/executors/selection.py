"""Which executor the options ask for."""

from __future__ import annotations

from alight.core.errors import OptionError
from alight.options.cluster import ClusterOptions
from alight.options.device import GPU
from alight.rendering.executors.blocks import Executor, Threads
from alight.rendering.executors.cluster_executor import ClusterExecutor


def executor_of(options: ClusterOptions, device: str) -> Executor:
    """The executor that the options ask for: threads, a GPU, or a cluster.

    Raises
    ------
    AlightError
        For options that contradict each other, or a GPU that is not there.
    """
    if device == GPU:
        if options.cluster is not None:
            # Or of a film that was begun on a GPU, which goes on there.
            raise OptionError("a GPU renders on this machine, {cluster} on others",
                              names=("cluster",))  # fmt: skip
        from alight.rendering.executors.gpu_executor import GpuExecutor

        return GpuExecutor()
    if options.cluster is None:
        if options.cluster_keys is not None:
            raise OptionError("{cluster_keys} are those of {cluster}",
                              names=("cluster_keys", "cluster"))  # fmt: skip
        return Threads()
    return ClusterExecutor(options.cluster, options.cluster_keys)
