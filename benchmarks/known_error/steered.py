"""Campaigns on steering: bias, gain at equal time, predicted cost, and the price of replicates."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from typing import Any

import numpy as np
from scenes import REPLICATES, SIDE, Runner, load_scene
from truth import Truth

from alight.films import Film
from alight.films.sample_ranges import empty_cells
from alight.rendering import render
from alight.rendering.job import seed_of_round
from alight.rendering.plan import make_plan
from alight.rendering.schedules.adaptive import PILOT_SPP, counts_at, shares_of
from alight.rendering.schedules.cycles import STEP, cycles_error, first_decision, in_noise
from alight.rendering.schedules.schedule import Goal, Verdict
from alight.rendering.schedules.steering import Steered
from alight.rendering.schedules.stopping import Promise

#: Mean of the rare-spike scene: the floor shines 1, and sees 99 in a thousandth of its sky.
RARE_SPIKE_MEAN = 1.0 + 0.001 * 99.0

#: Samples per pixel at which an adaptive and an even picture are compared.
EVEN_SPP = 256

#: Cycles' threshold, and the samples at which it gives up.
CYCLES_THRESHOLD, CYCLES_MOST = 0.01, 1024


class _Pilot:
    """What `shares_of` reads of a film."""

    def __init__(self, means: np.ndarray) -> None:
        height, width = means.shape[:2]
        self.crop, self.cells = (0, 0, width, height), empty_cells(width, height)
        self.replicates = REPLICATES
        self._means = means

    def replicate_means(self) -> tuple[np.ndarray, np.ndarray]:
        return self._means, np.full(self._means.shape[:3], PILOT_SPP // REPLICATES)


def cell_shares(pilot: np.ndarray) -> np.ndarray:
    """Each cell's share of the samples, from the means (h, w, R, 3) of a pilot."""
    return shares_of(_Pilot(pilot))  # type: ignore[arg-type]


def adaptive_picture(runner: Runner, seed: int, spp: int) -> np.ndarray:
    """Mean of every pixel of an adaptive picture of `spp` samples per pixel on average."""
    shares = cell_shares(runner.means(seed_of_round(seed, 1), PILOT_SPP))
    counts = counts_at(shares, spp, REPLICATES)
    sums = runner.sums(seed, 0, counts).sum(axis=2)
    return sums / np.kron(counts, np.ones((8, 8)))[..., None]


def cycles_picture(runner: Runner, seed: int, by_cells: bool) -> tuple[np.ndarray, float]:
    """Mean of every pixel under Cycles' rule, and the samples per pixel that it took.

    By pixels, as published, or by 8x8 cells, as alight does. The samples of pixels that have ended
    are rendered too, and dropped.
    """
    active, done = np.ones((SIDE, SIDE), bool), 0
    sums, counts = np.zeros((SIDE, SIDE, REPLICATES, 3)), np.zeros((SIDE, SIDE, REPLICATES), int)
    while active.any() and done < CYCLES_MOST:
        more = STEP if done else first_decision(CYCLES_THRESHOLD)
        sums += runner.sums(seed, done, more) * active[..., None, None]
        counts += active[..., None] * (more // REPLICATES)
        done += more
        error = cycles_error(sums / counts[..., None], counts)
        active = in_noise(error, CYCLES_THRESHOLD, active)
        if by_cells:
            cells = active.reshape(SIDE // 8, 8, SIDE // 8, 8).any(axis=(1, 3))
            active = np.kron(cells, np.ones((8, 8), bool))
    n = counts.sum(axis=2)
    return sums.sum(axis=2) / n[..., None], float(n.mean())


def report_energy(name: str, energies: Sequence[float], truth: float) -> None:
    """Print the bias with its 95 % interval, and t."""
    runs, relative = len(energies), np.asarray(energies) / truth - 1.0
    error = float(relative.std(ddof=1)) / math.sqrt(runs)
    bias = float(relative.mean())
    print(
        f"{name}: energy {bias:+.3%} (95 %: {bias - 1.96 * error:+.3%} to "
        f"{bias + 1.96 * error:+.3%}), t {bias / error:+.1f}, {runs} pictures",
        flush=True,
    )


def bias(runs: int) -> None:
    """Mean of adaptive pictures and of Cycles' rule on the rare-spike scene, against its truth."""
    runner = Runner("rare-spike")
    adaptive = [float(adaptive_picture(runner, 7000 + i, 64).mean()) for i in range(runs)]
    report_energy("rare-spike, adaptive", adaptive, RARE_SPIKE_MEAN)
    for by_cells, name in ((False, "by pixels, as published"), (True, "by cells")):
        pictures = [cycles_picture(runner, 9000 + i, by_cells) for i in range(max(runs // 10, 5))]
        report_energy(
            f"rare-spike, Cycles' rule {name}, {np.mean([p[1] for p in pictures]):.0f} spp",
            [float(p[0].mean()) for p in pictures],
            RARE_SPIKE_MEAN,
        )


def gain(names: Sequence[str], runs: int, truth_spp: int) -> None:
    """relMSE times processor time, even over adaptive: above 1 where adapting pays."""
    for name in names:
        runner = Runner(name)
        truth = Truth(runner, truth_spp)
        same, cost = ideal_gain(runner, truth)
        error, seconds = np.zeros((runs, 2)), np.zeros((runs, 2))
        for i in range(runs):
            for j, make in enumerate((_even_picture, adaptive_picture)):
                begin = time.process_time()
                picture = make(runner, 11_000 + 2 * i + j, EVEN_SPP)
                seconds[i, j] = time.process_time() - begin
                error[i, j] = truth.relmse(picture)
        ratios = error[:, 0] / error[:, 1]
        ratio = np.median(seconds[:, 1] / seconds[:, 0])
        mean = error[:, 0].mean() / error[:, 1].mean()
        doubt = ratios.std(ddof=1) / math.sqrt(runs)
        print(
            f"{name}: error {mean:.2f} +- {doubt:.2f} times less (ideal {same:.2f}) at "
            f"{ratio:.2f} times the processor time: gain {mean / ratio:.2f} (ideal {cost:.2f})",
            flush=True,
        )


def ideal_gain(runner: Runner, truth: Truth) -> tuple[float, float]:
    """The gain of one who knows each cell's variance and cost: at equal samples, and at equal time.

    With V / n the relMSE of a cell of cost c a sample, n ~ sqrt(V) is best for the samples, and
    n ~ sqrt(V / c) for the time; the pilot costs nothing, and n may be anything.
    """
    relative = (truth.variance * truth.weight).mean(axis=2)
    V = relative.reshape(SIDE // 8, 8, SIDE // 8, 8).mean(axis=(1, 3))
    c = runner.rays(32)
    samples = V.mean() / np.sqrt(V).mean() ** 2
    return samples, V.mean() * c.mean() / np.sqrt(V * c).mean() ** 2


def _even_picture(runner: Runner, seed: int, spp: int) -> np.ndarray:
    return runner.means(seed, spp).mean(axis=2)


class _Timed(Steered):
    """A rule that knows the processor time of rendering, which is what a plan predicts."""

    begin = seconds = 0.0

    def next(self, rounds: Sequence[Film]) -> Goal | Verdict:
        self.begin = self.begin or time.process_time()
        answer = super().next(rounds)
        self.seconds = time.process_time() - self.begin
        return answer


def plans(names: Sequence[str], runs: int) -> None:
    """How often the true cost of a promise lay in the interval that `plan` gave."""
    rng, inside, timely = np.random.default_rng(4), 0, 0
    for i in range(runs):
        scene = load_scene(names[i % len(names)])
        options: dict[str, Any] = {"threads": 1, "seed": 100 + i}
        pilot = make_plan(scene, Promise(0.5), **options).pilot_error
        # From less than the pilot has reached to a quarter of its error.
        asked = pilot * float(np.exp(rng.uniform(np.log(0.3), np.log(1.2))))
        plan = make_plan(scene, Promise(asked), **options)
        schedule = _Timed(0, None, Promise(asked))
        film = render(scene, schedule=schedule, threads=1, seed=500 + i)
        seconds = schedule.seconds
        inside += plan.spp.low <= film.spp <= plan.spp.high
        timely += plan.seconds.low <= seconds <= plan.seconds.high
        spp, cost = plan.spp, plan.seconds
        print(
            f"{names[i % len(names)]} to {asked:.2%}: {film.spp:g} spp, planned {spp.value:.0f} "
            f"({spp.low:.0f} to {spp.high:.0f}); {seconds:.2f} s, planned {cost.value:.2f} "
            f"({cost.low:.2f} to {cost.high:.2f})",
            flush=True,
        )
    print(f"plan: samples inside {inside} of {runs}, seconds inside {timely} of {runs}")


def replicates(names: Sequence[str], runs: int, truth_spp: int) -> None:
    """relMSE at equal samples for R replicates, over that for 1."""
    for name in names:
        runner = Runner(name)
        truth = Truth(runner, truth_spp)
        for spp in (64, 256):
            errors = np.zeros((runs, 4))
            for i in range(runs):
                for j, count in enumerate((1, 2, 4, 8)):
                    runner.settings = runner.settings._replace(replicates=count)
                    picture = runner.sums(13_000 + i, 0, spp).sum(axis=2) / spp
                    errors[i, j] = truth.relmse(picture)
            mean = errors.mean(axis=0)
            doubt = errors.std(axis=0, ddof=1) / math.sqrt(runs) / mean[0]
            shown = ", ".join(
                f"R = {count}: {m / mean[0]:.2f} +- {d:.2f}"
                for count, m, d in zip((1, 2, 4, 8), mean, doubt, strict=True)
            )
            print(f"{name} at {spp} spp, relMSE {mean[0]:.3g}: {shown}", flush=True)
        runner.settings = runner.settings._replace(replicates=REPLICATES)
