"""Renders that are killed at random moments and resumed: the campaign, as a program of its own.

    python -m tests.rendering.kills --kills 100 --folder /tmp/kills

Each render is a fork of one process that has compiled the kernel, so that a trial takes a fraction
of a second. It writes checkpoints without a pause; SIGKILL comes at a moment drawn uniformly from
the length of such a render. Every second resumed render is killed as well before the last one ends.
The last line is JSON: what happened, and how many results differ from the uninterrupted one.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import signal
import time
from collections import Counter
from pathlib import Path

import numpy as np

import alight
from alight.core.errors import FilmError, OutputError
from alight.films import Film

SPP = 48


def the_scene():
    changes = ["film.size=[72, 40]", "film.crop=[3, 2, 60, 37]", "integrator.max_depth=4"]
    return alight.load("cornell-box", changes)


def options():
    return {"threads": 2, "spp_per_pass": 1, "every": 0.0}


def begin(path):
    alight.render(the_scene(), spp=SPP, aovs=("depth",), checkpoint=path, **options())


def go_on(path):
    alight.resume(path, **options())


def forked(work, path, kill_after=None):
    """Run `work` in a fork: whether SIGKILL came before its end."""
    child = os.fork()
    if child == 0:
        code = 1
        try:
            work(path)
            code = 0
        finally:
            os._exit(code)
    if kill_after is not None:
        time.sleep(kill_after)
        os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status):
        return True
    assert os.WEXITSTATUS(status) == 0, f"a render ended with status {status}"
    return False


def same(film, reference):
    mine, others = [
        (f.sums, f.counts, f.aov_sums["depth"], np.array([f.invalid, f.saturated]))
        for f in (film, reference)
    ]
    return all(np.array_equal(a, b) for a, b in zip(mine, others, strict=True))


def campaign(kills, folder, seed):
    """Kill and resume until `kills` renders have died; counts of what happened."""
    rng, seen = random.Random(seed), Counter(kills=0)
    reference = alight.render(the_scene(), spp=SPP, aovs=("depth",))
    path = folder / "render.alight"
    lengths = []
    for _ in range(3):
        started = time.perf_counter()
        forked(begin, path)
        lengths.append(time.perf_counter() - started)
    length = sorted(lengths)[1]
    while seen["kills"] < kills:
        path.unlink(missing_ok=True)
        work = begin
        while forked(work, path, rng.uniform(0, length)):
            seen["kills"] += 1
            seen["inside a checkpoint's write"] += any(folder.glob(".alight-*.tmp"))
            if not path.exists():
                seen["before the first checkpoint"] += 1
                continue
            film = Film.load(path)
            seen[
                "before the first sample" if film.spp == 0 else "with samples in the checkpoint"
            ] += 1
            seen["inside a pass"] += len(set(film.cells[:, :7].flat)) > 1
            work = go_on
            if rng.random() < 0.5 or seen["kills"] >= kills:
                break
        seen["results"] += 1
        if not path.exists():
            begin(path)
        seen["different"] += not same(alight.resume(path, **options()), reference)
        seen["leftovers"] += len(list(folder.glob(".alight-*.tmp")))
    return {**seen, "seconds of a render": round(length, 3)}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--folder", type=Path, default=Path())
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    try:
        print(json.dumps(campaign(asked.kills, asked.folder, asked.seed)))
    except (FilmError, OutputError) as error:
        raise SystemExit(f"a checkpoint was refused: {error}") from error


if __name__ == "__main__":
    main()
