"""Renders that are killed at random moments and resumed: the campaign, as a program of its own.

    python -m tests.rendering.kills --kills 100 --folder /tmp/kills [--steered]

Each render is a fork of one process that has compiled the kernel, so that a trial takes a fraction
of a second. It writes checkpoints without a pause; SIGKILL comes at a moment drawn uniformly from
the length of such a render. Every second resumed render is killed as well before the last one ends.
With --steered the render is adaptive and ends at an error; each result is then merged with that of
other samples, and every second one is first rendered to a larger error, then to the smaller one.
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
from alight.rendering.checkpoints.checkpoint import read_checkpoint
from alight.rendering.schedules.steering import Steered
from alight.rendering.schedules.stopping import Promise

SPP = 48


def the_scene():
    changes = ["film.size=[72, 40]", "film.crop=[3, 2, 60, 37]", "integrator.max_depth=4"]
    return alight.load("cornell-box", changes)


def options():
    return {"threads": 2, "spp_per_pass": 1, "every": 0.0}


#: Errors that a steered render is to reach: at once, or one after the other.
ERRORS = (0.25, 0.15)

#: The samples that a steered result is merged with; those before are its own.
OTHER = 2**14


def begin(path):
    alight.render(the_scene(), spp=SPP, aovs=("depth",), checkpoint=path, **options())


def steered(error, first=0):
    return Steered(first, None, Promise(error), adaptive=True)


def begin_steered(path, error=ERRORS[1]):
    schedule = steered(error)
    alight.render(the_scene(), schedule=schedule, aovs=("depth",), checkpoint=path, **options())


def begin_with_more_error(path):
    begin_steered(path, ERRORS[0])


def go_on_to_less_error(path):
    alight.resume(path, promise=Promise(ERRORS[1]), **options())


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


def steered_campaign(kills, folder, seed):
    """As `campaign`, for adaptive renders that end at an error; results are merged with others."""
    rng, seen = random.Random(seed), Counter(kills=0)
    reference, path = folder / "reference.alight", folder / "render.alight"
    begin_steered(reference)
    other = folder / "other.alight"
    alight.render(
        the_scene(), schedule=steered(ERRORS[0], OTHER), aovs=("depth",), checkpoint=other
    )
    whole = alight.merge(reference, other)
    started = time.perf_counter()
    forked(begin_steered, path)
    length = time.perf_counter() - started
    while seen["kills"] < kills:
        path.unlink(missing_ok=True)
        in_two = rng.random() < 0.5
        work = begin_with_more_error if in_two else begin_steered
        while forked(work, path, rng.uniform(0, length)):
            seen["kills"] += 1
            seen["of renders with two errors"] += in_two
            if path.exists():
                seen["inside the pilot or before"] += len(read_checkpoint(path).state.rounds) == 1
                work = go_on
            if rng.random() < 0.5 or seen["kills"] >= kills:
                break
        if not path.exists():
            begin_steered(path)
        if in_two:
            while forked(go_on_to_less_error, path, rng.uniform(0, 2 * length)):
                seen["kills"] += 1
            go_on_to_less_error(path)
        else:
            go_on(path)
        seen["results"] += 1
        seen["different"] += not same(alight.merge(other, path), whole)
        seen["leftovers"] += len(list(folder.glob(".alight-*.tmp")))
    return {**seen, "seconds of a render": round(length, 3)}


def campaign(kills, folder, seed, inside=0):
    """Kill and resume until `kills` renders have died; counts of what happened.

    How many die inside a checkpoint's write is up to the disk: until those are `inside`, more are
    killed, up to four times as many.
    """
    rng, seen = random.Random(seed), Counter(kills=0)

    def enough():
        met = seen["inside a checkpoint's write"] >= inside
        return seen["kills"] >= (kills if met else 4 * kills)

    reference = alight.render(the_scene(), spp=SPP, aovs=("depth",))
    path = folder / "render.alight"
    lengths = []
    for _ in range(3):
        started = time.perf_counter()
        forked(begin, path)
        lengths.append(time.perf_counter() - started)
    length = sorted(lengths)[1]
    while not enough():
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
            if rng.random() < 0.5 or enough():
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
    parser.add_argument("--inside", type=int, default=0)
    parser.add_argument("--steered", action="store_true")
    asked = parser.parse_args()
    try:
        told = asked.kills, asked.folder, asked.seed
        seen = steered_campaign(*told) if asked.steered else campaign(*told, asked.inside)
        print(json.dumps(seen))
    except (FilmError, OutputError) as error:
        raise SystemExit(f"a checkpoint was refused: {error}") from error


if __name__ == "__main__":
    main()
