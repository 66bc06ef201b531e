"""Pure tasks on the workers of a Dask cluster: each answered once, whatever happens to a worker.

Nothing here knows what a task is. `addresses` finds a cluster, `dispatch` hands out tasks and takes
their answers, `worker` runs in the workers' processes. Needs the extra ``cluster``.
"""
