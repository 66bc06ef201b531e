"""What holds for all tests, and for the processes that they start.

Linear algebra has one thread, garbage is not looked for among the tests themselves, and workers
share what is to be done once on a fresh clone.
"""

import contextlib
import gc
import importlib
import os
from pathlib import Path

import pytest

# Workers keep all cores busy. OpenBLAS's own threads spin while they wait, at the expense of
# others. It looks when NumPy is imported, which is later.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


@pytest.hookimpl(wrapper=True)
def pytest_collection(session):
    # Thousands of tests are made, and none of them is garbage; later, a collection that looks at
    # what the session holds to its end would take a second each time.
    gc.disable()
    try:
        import_own_share(session.config)
        return (yield)
    finally:
        gc.collect()
        gc.freeze()
        gc.enable()


def import_own_share(config):
    """Import, before all others, the files of tests that no other worker of xdist begins with.

    On a fresh clone most of the time goes into rewriting their assertions: each worker finds the
    bytecode of those that the others have rewritten.
    """
    worker = getattr(config, "workerinput", None)
    if worker is None or config.args != config.getini("testpaths"):
        return
    files = sorted(file for root in config.args for file in Path(root).rglob("test_*.py"))
    number, count = int(worker["workerid"].removeprefix("gw")), worker["workercount"]
    for file in files[len(files) * number // count : len(files) * (number + 1) // count]:
        # What is wrong with a file is told when it is collected; some are skipped as a whole.
        with contextlib.suppress(Exception, pytest.skip.Exception):
            importlib.import_module(".".join(file.with_suffix("").parts))
