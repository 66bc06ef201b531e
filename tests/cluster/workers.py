"""Clusters of the tests: two processes of one thread each, on this machine."""

import logging
from contextlib import contextmanager

from alight.cluster.addresses import connected


@contextmanager
def two_workers():
    """A client of two workers that listen on the loopback interface."""
    for name in ("distributed", "distributed.nanny", "distributed.core"):
        logging.getLogger(name).setLevel(logging.ERROR)
    with connected("local:2") as client:
        yield client
