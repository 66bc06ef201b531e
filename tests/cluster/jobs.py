"""Tasks that workers of the tests run, and faults that are planted in their processes."""

import os
import sys
import time
from pathlib import Path

import alight.cluster.worker
import alight.lab.replicates.spread
import lanewise.machine
from lanewise.machine import describe_machine, fingerprint, target

_PROCESSOR = alight.lab.replicates.spread.processor


def multiplied(factor, number):
    """Take some time for it, so that workers can be lost meanwhile."""
    time.sleep(0.02)
    return factor * number


def failing(folder, number):
    """Fail for multiples of 3 on every worker, for 5 on the first attempt."""
    if number % 3 == 0 and alight.cluster.worker._kept:
        raise ValueError("planted")
    if number == 5 and _is_first(folder, number):
        raise OSError("planted")
    return number


def deadly(folder, number):
    """End the worker's process at the first attempt of task 4."""
    if number == 4 and _is_first(folder, number):
        os._exit(1)
    return number


def stuck(folder, number):
    """Wait at the first attempt of task 2 until the test lets it go."""
    if number == 2 and _is_first(folder, number):
        end = time.monotonic() + 60.0
        while not (Path(folder) / "go").exists() and time.monotonic() < end:
            time.sleep(0.02)
    time.sleep(0.01)
    return number


def _is_first(folder, number):
    mark = Path(folder) / str(number)
    try:
        mark.touch(exist_ok=False)
    except FileExistsError:
        return False
    return True


def keep_nothing():
    """Forget what this process has unpickled, as one that was started again."""
    alight.cluster.worker._kept.clear()


def become_another_machine():
    """Let this process have another fingerprint, of a machine with other lanes."""
    alight.cluster.worker.fingerprint = lambda target: "another"
    own = describe_machine()
    alight.cluster.worker.describe_machine = lambda target: {**own, "lanes": "another"}


def become_this_machine():
    """Undo it."""
    alight.cluster.worker.fingerprint = fingerprint
    alight.cluster.worker.describe_machine = describe_machine


def kept():
    """How many shared objects this process keeps."""
    return len(alight.cluster.worker._kept)


def keep_kernels_in(folder):
    """Let this process find and keep kernels in a folder; None is the usual one."""
    if folder is None:
        os.environ.pop("ALIGHT_CACHE", None)
    else:
        os.environ["ALIGHT_CACHE"] = folder


def has_compiler():
    """Whether this process has imported Numba."""
    return "numba" in sys.modules


def ticks_of_the_worker(dask_worker):
    """Milliseconds between two looks at its event loop."""
    return dask_worker.periodic_callbacks["tick"].callback_time


def lose_alight():
    """Let this process be one in which alight is not installed."""
    sys.modules["alight.cluster.worker"] = None


def find_alight():
    """Undo it."""
    sys.modules["alight.cluster.worker"] = alight.cluster.worker


def become_another_processor():
    """Let this process be timed on another processor."""
    lanewise.machine.processor = alight.lab.replicates.spread.processor = lambda: "Slow 3000"


def become_this_processor():
    """Undo it."""
    lanewise.machine.processor = alight.lab.replicates.spread.processor = _PROCESSOR


def target_of_process():
    """What this process compiles for."""
    return target()
