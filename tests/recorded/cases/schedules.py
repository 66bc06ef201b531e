"""Schedules and what passes, tiles and tasks are made of their goals."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np

from alight.films import Film
from alight.options.render import RenderOptions
from alight.rendering.executors.block_tasks import BlockTask, Layout, samples_in, samples_of
from alight.rendering.executors.blocks import Block
from alight.rendering.executors.cluster_executor import BlockQueue, split
from alight.rendering.executors.light_tasks import LightQueue
from alight.rendering.schedules import adaptive, cycles, rare_noise, selection, stopping, unseen
from alight.rendering.schedules.passes import Pace, Work, ranges_of
from alight.rendering.schedules.schedule import Goal, Schedule, Uniform, Verdict
from alight.rendering.schedules.steering import Steered, towards
from alight.rendering.schedules.stopping import Promise
from alight.rendering.seeds import seed_of_round
from alight.rendering.tiles.division import tile_size, tiles_of
from alight.rendering.tiles.light_paths import parts_of
from alight.rendering.tiles.tile_kernel import Tile
from tests.recorded.making import add_samples, described, film_of, outcome, rows


def _fill(film: Film, goal: Goal, spread: float, dark: float) -> None:
    """Add what a goal asks for, cell by cell; a part of the window is quiet."""
    from alight.films import PartialFilm
    from alight.films.fixed_point import to_limbs

    work = Work(goal, film)
    while work.left:
        ranges = work.take(10**6)
        for cy, cx in np.ndindex(film.cells.shape):
            first, count = map(int, ranges[cy, cx])
            x, y, w, h = film.crop
            x0, x1 = max(x, 8 * cx), min(x + w, 8 * cx + 8)
            y0, y1 = max(y, 8 * cy), min(y + h, 8 * cy + 8)
            if not count or x0 >= x1 or y0 >= y1:
                continue
            draw = np.random.default_rng([film.seed, cy, cx, first])
            noise = draw.random((count, y1 - y0, x1 - x0, 3)) ** 3 * 4.0 - 1.0
            level = spread * (0.05 if cx == 0 else 1.0)
            values = (0.2 + 0.3 * cy + 0.1 * cx) * (1.0 + level * noise)
            values[draw.random(values.shape[:3]) < dark] = 0.0
            limbs = to_limbs(values.astype(np.float32))[0]
            sums = np.zeros((y1 - y0, x1 - x0, film.replicates, 3, 2), np.int64)
            counts = np.zeros(sums.shape[:3], np.int64)
            for i in range(count):
                sums[:, :, (first + i) % film.replicates] += limbs[i]
                counts[:, :, (first + i) % film.replicates] += 1
            film.add_tile(PartialFilm(x0, y0, sums, counts, 0, 0, (first, count)))


def _run(
    schedule: Schedule,
    *,
    spread: float = 1.0,
    dark: float = 0.0,
    most: int = 9,
    stop: str = "",
    **words: Any,
) -> list[Any]:
    """Goals and the verdict of a schedule, and its state on the way."""
    film = film_of((25, 18), spp=0, **words)
    rounds, told = [film], []
    for step in range(most):
        asked = schedule.next(rounds)
        if isinstance(asked, Verdict):
            told.append(described(asked))
            break
        if asked.round == len(rounds):
            rounds.append(
                film_of((25, 18), spp=0, **{**words, "seed": seed_of_round(film.seed, 1)})
            )
        counts = asked.count.tolist()
        told.append(
            [
                asked.round,
                np.unique(asked.first).tolist(),
                counts if step < 4 else sum(map(sum, counts)),
            ]
        )
        _fill(rounds[asked.round], asked, spread, dark)
        if stop and step == 2:
            told.append(described(schedule.cut_short(rounds, stop)))
            break
        # Saved and read again, it goes on in the same way.
        schedule = type(schedule).restored(schedule.state())
    state = described(schedule.state())
    biases = [bias.line for bias in schedule.biases(rounds)]
    return [
        *told,
        state,
        biases,
        schedule.promises,
        schedule.total_spp,
        schedule.picture(rounds).spp,
    ]


def runs() -> dict[str, Any]:
    """Whole renders by each schedule, with noise in the place of light."""
    crop = {"crop": (3, 2, 19, 11)}
    makes: dict[str, Any] = {
        "uniform": (lambda: Uniform(5, 12), {}),
        "endless": (lambda: Uniform(0, None), {"most": 0}),
        "error": (lambda: Steered(0, None, Promise(0.2)), {}),
        "error, window": (lambda: Steered(8, 200, Promise(0.1, 0.8)), crop),
        "error, never": (lambda: Steered(0, 24, Promise(0.01)), {}),
        "error, rare light": (lambda: Steered(0, 80, Promise(0.3)), {"dark": 0.97, "spread": 9.0}),
        "error, dark": (lambda: Steered(0, 40, Promise(0.3)), {"dark": 1.0}),
        "pixels": (lambda: Steered(0, 400, Promise(0.3, 0.9, "pixel", 0.9)), {"spread": 0.5}),
        "pixels, never": (lambda: Steered(0, 30, Promise(0.02, 0.9, "pixel", 0.99)), {}),
        "adaptive": (lambda: Steered(0, 20, None, True), {}),
        "adaptive, window": (lambda: Steered(4, 36, None, True), crop),
        "adaptive to an error": (lambda: Steered(0, 300, Promise(0.12), True), {}),
        "out of time": (lambda: Steered(0, 90, Promise(0.05)), {"stop": "time"}),
        "out of time, met": (lambda: Steered(0, 90, Promise(2.5)), {"stop": "time", "spread": 0.1}),
        "cancelled": (lambda: Steered(0, 90, Promise(0.05)), {"stop": "cancelled"}),
        "cycles": (lambda: cycles.Cycles(0, 160, 0.3), {"spread": 0.3}),
        "cycles, short": (lambda: cycles.Cycles(2, 8, 0.01), crop),
        "cycles, odd": (lambda: cycles.Cycles(0, 64, 0.1), {"replicates": 3}),
        "three replicates": (lambda: Steered(0, 64, Promise(0.3)), {"replicates": 3}),
        "eight replicates": (lambda: Steered(0, 64, Promise(0.15)), {"replicates": 8}),
    }
    return {
        name: outcome(lambda make=make, words=words: _run(make(), **words))
        for name, (make, words) in makes.items()
    }


def goes_on() -> dict[str, Any]:
    """Schedules that continue a render."""
    film = film_of((25, 18), spp=40)
    adaptive_one = Steered(0, 20, None, True)
    adaptive_one.shares = np.array([[0.5, 1.0, 2.0, 0.3]] * 3)
    found: dict[str, Any] = {}
    for name, one in {
        "uniform": Uniform(0, 40),
        "steered": Steered(0, 50, Promise(0.1)),
        "adaptive": adaptive_one,
        "cycles": cycles.Cycles(0, 64, 0.1),
    }.items():
        for spp in (None, 30, 90):
            found[f"{name} towards, {spp}"] = outcome(
                lambda one=one, spp=spp: described(towards(one, Promise(0.05), film, spp).state())
            )
        found[f"{name} to 64"] = outcome(lambda one=one: described(one.extended(64).state()))
    found["restored"] = outcome(selection.restored_schedule, "unifrom", {})
    found["wrong"] = [outcome(cycles.Cycles, 0, 4, 0.0), outcome(Steered, 0, None)]
    return found


CHOICES: dict[str, dict[str, Any]] = {
    "nothing": {},
    "spp": {"spp": 9, "first_sample": 3},
    "time": {"time_limit": "3s"},
    "both": {"spp": 5, "time_limit": 2},
    "error": {"error": "3%"},
    "error and most": {"error": "3%", "max_spp": 50, "max_time": "2m"},
    "pixels": {"error": "3%", "metric": "pixel", "share": "80%", "confidence": "90%"},
    "adaptive": {"adaptive": True},
    "adaptive spp": {"adaptive": True, "spp": 7},
    "adaptive error": {"adaptive": True, "error": 0.1},
    "cycles": {"criterion": "cycles", "adaptive": True},
    "cycles error": {"criterion": "cycles", "adaptive": True, "error": 0.05, "max_spp": 64},
    "part": {"part": "2/3", "spp": 10},
    "part of first": {"part": "3/3", "spp": 10, "first_sample": 100},
    "too many parts": {"part": "2/11", "spp": 10},
}


def chosen() -> dict[str, Any]:
    """The schedules of options."""

    def made(words: dict[str, Any]) -> Any:
        options = RenderOptions.of(words)
        found = []
        for own in (None, 24):
            one = selection.schedule_of(options, own)
            found.append(
                [type(one).name, described(one.state()), selection.planned_spp(options, own)]
            )
        promise = selection.promise_of(options)
        return [*found, selection.time_limit_of(options), described(promise)]

    found = rows(made, {name: (words,) for name, words in CHOICES.items()})
    found["parts"] = [
        [described(selection.part_of(Uniform(7, spp), i, n).state()) for i in range(1, n + 1)]
        for spp, n in ((10, 3), (7, 7), (64, 5))
    ]
    return found


def passes() -> dict[str, Any]:
    """How goals are cut into passes, and how long these are."""
    film = film_of((25, 18), crop=(3, 2, 19, 11), spp=3)
    goal = Goal(np.zeros((3, 4), np.int64), np.arange(12).reshape(3, 4) * 5)
    cuts: dict[str, Any] = {}
    for name, one in {
        "uneven": goal,
        "even": Goal.uniform(film, 1, 9),
        "later": Goal.uniform(film, 5, 4),
        "held": Goal.uniform(film, 0, 2),
    }.items():
        work = Work(one, film)
        steps = (3, 1, 7, 100, 2)
        cuts[name] = [[work.left, work.take(step).reshape(-1).tolist()] for step in steps]
    gappy = film_of((9, 9), spp=0)
    for first, count in ((2, 3), (7, 1), (10, 4)):
        add_samples(gappy, first, count)
    gaps, work = [], Work(Goal.uniform(gappy, 0, 13), gappy)
    while work.left and len(gaps) < 9:
        ranges = work.take(2)
        gaps.append(ranges[0, 0].tolist())
        add_samples(gappy, *map(int, ranges[0, 0]))
        if not work.left:
            work = Work(Goal.uniform(gappy, 0, 13), gappy)
    paces = {}
    for name, (fixed, seconds, limit) in {
        "grows": (None, 2.0, None),
        "fixed": (5, 2.0, None),
        "limit": (None, 2.0, 3.0),
        "endless": (None, math.inf, None),
        "short": (None, 0.1, 0.05),
    }.items():
        pace, told, left = Pace(fixed, seconds), [], limit
        for took in (0.01, 0.3, 1.1, 0.0, 4.0):
            count = pace.count(1000)
            told.append([count, pace.count(7), min(pace.step, 10**9)])
            pace.adapt(min(count, 1000), took, left)
            left = None if left is None else left - took
        paces[name] = told
    ranges = np.arange(24).reshape(3, 4, 2)
    return {
        "cuts": cuts,
        "gaps": gaps,
        "paces": paces,
        "of tiles": [
            ranges_of(Tile(*t), ranges).tolist()
            for t in ((0, 0, 8, 8), (9, 3, 25, 18), (3, 8, 16, 9))
        ],
        "division": {
            str(w): [tile_size(w), len(tiles_of(w)), [tuple(t) for t in tiles_of(w)[:6]]]
            for w in ((0, 0, 33, 9), (5, 30, 70, 40), (0, 0, 512, 512), (64, 0, 511, 512))
        },
        "wrong size": outcome(tiles_of, (0, 0, 9, 9), 12),
        "light paths": {
            f"{w}, {n}": [tuple(t) for t in parts_of(w, n)]
            for w in ((0, 0, 33, 9), (5, 30, 70, 40))
            for n in (1, 2, 5)
        },
        "rounds": [seed_of_round(s, r) for s in (0, 7, 2**32 - 1) for r in range(3)],
    }


def tasks() -> dict[str, Any]:
    """Blocks and light paths as tasks of a cluster."""
    window = (3, 2, 40, 45)
    ranges = np.zeros((6, 6, 2), np.int64)
    ranges[..., 0], ranges[..., 1] = 3, 5 + np.arange(6)
    blocks = [Block(tile, ranges_of(tile, ranges)) for tile in tiles_of(window)]
    found: dict[str, Any] = {
        "samples": [[samples_in(b), described(samples_of(b, 4))] for b in blocks],
        "split": [
            [described(half) for half in split(blocks[0], share)] for share in (0.1, 0.5, 0.9)
        ],
        "bytes": [
            Layout(4, 3, {"depth": ("Z",)}, surfaces).most_bytes(
                BlockTask(7, (blocks[0], blocks[1]))
            )
            for surfaces in (None, 3)
        ],
    }
    for name, speed, threads in (
        ("quick", 1e6, 4),
        ("slow", 900.0, 4),
        ("alone", 2e3, 1),
        ("nobody", 5e3, 0),
    ):
        queue, cut = BlockQueue(blocks, 7), []
        for _ in range(7):
            task = queue.cut(speed, threads)
            if task is None:
                cut.append(None)
                break
            cut.append(
                [
                    task.samples,
                    [[tuple(b.tile), b.ranges.reshape(-1).tolist()] for b in task.blocks],
                ]
            )
        rest = [[tuple(b.tile), b.ranges.reshape(-1).tolist()] for b in queue.rest([])]
        found[f"blocks, {name}"] = [cut, rest]
    strips = [Block(tile, ranges_of(tile, ranges)) for tile in parts_of(window, 2)]
    whole = Tile(3, 2, 43, 47)
    for name, speed, threads in (("quick", 1e6, 2), ("slow", 100.0, 2), ("middling", 3e3, 8)):
        light, cut = LightQueue(strips, whole, 3, 9), []
        taken = []
        for task in itertools.islice(
            iter(lambda light=light, s=speed, n=threads: light.cut(s, n), None), 6
        ):
            taken.append(task)
            starts = described(task.samples_of_pixels())
            cut.append(
                [tuple(task.strip), task.replicate, task.first, task.count, task.samples, starts]
            )
        rest = light.rest(taken[:2])
        found[f"light, {name}"] = [
            cut,
            [[tuple(b.tile), described(b.ranges)] for b in rest[:9]],
            len(rest),
        ]
    return found


def looks() -> dict[str, Any]:
    """What looks at films say: verdicts, lines, what is unseen, what is found by chance."""
    found: dict[str, Any] = {}
    films = {
        "quiet": film_of((25, 18), spp=16, spread=0.05),
        "noisy": film_of((25, 18), spp=16, spread=3.0),
        "five": film_of((25, 18), spp=20, replicates=5),
        "few": film_of((3, 2), spp=16),
    }
    promises = [Promise(0.03), Promise(0.4, 0.99), Promise(0.4, 0.7, "pixel", 0.6)]
    behind = np.array([[0.2, 0.3, 0.4, 0.5, 0.1, 0.2, 0.05]])
    for name, film in films.items():
        means, counts = film.replicate_means()
        means = means.copy()
        if name == "noisy":
            means[2:5, 3:7, 1] *= 60.0
        answers = []
        for promise in promises:
            known = [(None, False, None), (50.0, True, None), (1e6, False, behind)]
            for largest, by_chance, glass in known if name == "noisy" else known[:1]:
                judged = outcome(
                    stopping.judge_means, means, counts, promise, largest, by_chance, glass
                )
                answers.append(judged)
            judgement = stopping.judge_means(means, counts, promise)
            words = ("met", "not met", "not certifiable", stopping.word_of(judgement))
            answers.append([stopping.line_of(w, judgement, promise, 16.0) for w in words])
            answers.append(
                [
                    stopping.line_of("not met", judgement, promise, 16.0, 3.5),
                    stopping.early_line(judgement, promise, 20),
                ]
            )
        answers.append(outcome(unseen.unseen_error, means, counts, 0.1, None, True, None))
        answers.append(outcome(rare_noise.rare_noise, means, counts, behind))
        answers.append(stopping.share_within(means, counts, 0.2, 0.02))
        answers.append(described(adaptive.shares_of(film)))
        answers.append(described(cycles.cycles_error(means, counts)))
        found[name] = answers
    found["doubts"] = [
        stopping.look_doubt(c, d) for c in (0.5, 0.05, 0.001) for d in (0.0, 0.7, 0.9, 2.0)
    ]
    found["steps"] = [
        [stopping.first_look(r) for r in (1, 4, 5, 16, 40)],
        [stopping.next_look(s, r) for s in (16, 33, 1000) for r in (4, 5)],
    ]
    found["counts"] = adaptive.counts_at(
        np.array([[0.0, 0.2, 1.0], [3.3, 8.0, 0.7]]), 37, 4
    ).tolist()
    found["decisions"] = [cycles.first_decision(t) for t in (0.001, 0.01, 0.3, 4.0)]
    found["wrong promises"] = [
        outcome(Promise, *p)
        for p in ((0.0,), (0.1, 0.2), (0.1, 0.9, "both"), (0.1, 0.9, "pixel", 1.0))
    ]
    return found


CASES = {
    "runs": runs,
    "goes_on": goes_on,
    "chosen": chosen,
    "passes": passes,
    "tasks": tasks,
    "looks": looks,
}
