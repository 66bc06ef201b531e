"""A client of the campaign of faults: a process that renders on a cluster, or goes on."""

from __future__ import annotations

import faulthandler
import os
import sys
from pathlib import Path
from typing import Any

import alight
from alight.cluster import dispatch
from alight.cluster.dispatch import Patience
from alight.films import Film
from alight.rendering.executors import cluster_executor, light_tasks

#: Seconds that a client waits for what is lost, in the campaign.
PATIENCE = Patience(task=3.0, times=4.0, fetch=3.0, cluster=12.0)

SIZE = {"size": (72, 40), "crop": (3, 2, 60, 37), "threads": 1}

#: What is rendered, in turn: a scene, changes to it, and options.
RENDERS: dict[str, tuple[str, list[str], dict]] = {
    "a box": ("cornell-box", [], {"spp": 2000, "aovs": "depth"}),
    "paths from both ends": ("cornell-box", ["integrator.type=bidirectional"], {"spp": 500}),
    "a guide": ("matt-room", ["integrator.guiding=camera"], {"spp": 800}),
    "chains": ("lamp-and-glass", ["integrator.caustics=manifold"], {"spp": 500}),
    "a spectrum": (
        "lamp-and-glass",
        ["nodes.glass-ball.bsdf={type: dielectric, dispersion: 30}"],
        {"spp": 1500, "aovs": "albedo_through"},
    ),
    "light paths": ("mirror-and-glass", ["integrator.type=light"], {"spp": 800}),
}


def render(name: str, **where: Any) -> Film:
    """One of `RENDERS`."""
    scene, changes, words = RENDERS[name]
    return alight.render(alight.load(scene, changes), **SIZE, **words, **where)


def client(address: str, keys: str, path: str, name: str, log: str) -> None:
    """What the process of a client does: begin, or go on; what it says goes to a file."""
    # Nobody's terminal: the whole process ends as it would alone.
    os.setsid()
    with Path(log).open("ab") as file:
        for stream in (sys.stdout, sys.stderr):
            os.dup2(file.fileno(), stream.fileno())
    faulthandler.enable()
    # A render of seconds has many tasks only if they are short.
    cluster_executor.LONGEST, cluster_executor.SHORTEST = 0.2, 0.05
    light_tasks.LONGEST = 0.2
    dispatch.Patience = lambda: PATIENCE  # type: ignore[assignment,misc]
    where = {"cluster": address, "cluster_keys": keys, "every": 0.0}
    if Path(path).exists():
        alight.resume(path, **where, threads=1)
    else:
        render(name, checkpoint=path, **where)
