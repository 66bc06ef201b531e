"""The replicates of a scene: by the threads of this process, or the workers of a cluster."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence

import numpy as np

from alight.core.errors import OptionError
from alight.lab.arm_plan import Plan
from alight.lab.arms import seed_of
from alight.lab.figures import Figures
from alight.lab.replicates.measure import Rung
from alight.lab.replicates.session import Session, StudyProgress
from alight.lab.replicates.spread import Ladder, processor
from alight.lab.statistics.block_means import block_row
from alight.lab.store import Example, Replicate
from alight.lab.study import SceneSpec, scene_name

#: Replicates whose slow figures are worked out: FLIP costs fifty times all others together, and
#: hardly differs from one replicate to the next.
_SLOW = 2


def run_blocks(
    session: Session,
    scene: SceneSpec,
    plans: Sequence[Plan],
    costs: Sequence[float],
    order_seed: int,
) -> None:
    """Render what the store does not have yet, block by block.

    Parameters
    ----------
    session : Session
    scene : SceneSpec
    plans : sequence of Plan
        One for each arm.
    costs : sequence of float
        CPU seconds of a replicate of each.
    order_seed : int

    Raises
    ------
    OptionError
        If equal times would be compared with those of another processor, in the store.
    """
    if session.study.equal_time:
        _check_processors(session, plans)
    done = [session.store.numbers(plan.key) for plan in plans]
    figures = {
        id(plan.reference): Figures(plan.reference.image, plan.reference.variance) for plan in plans
    }
    count = session.replicates
    total = sum(
        cost * len(set(range(count)) - known) for cost, known in zip(costs, done, strict=True)
    )
    spent = 0.0
    order = np.random.default_rng(order_seed)
    # The order is drawn for all arms, done or not: it is the same after an interruption.
    drawn = [(number, i) for number in range(count) for i in order.permutation(len(plans)).tolist()]
    wanted = [(number, i) for number, i in drawn if number not in done[i]]

    def run(number: int, i: int, rungs: Iterable[Rung], timed_on: str) -> None:
        nonlocal spent
        plan = plans[i]
        text = f"{scene_name(scene)}: replicate {number + 1} of {count}, {plan.arm.spec.name}"
        session.progress(StudyProgress(text, spent, total))
        seed = _seed(session, scene, plan, number)
        errors = figures[id(plan.reference)]
        _keep_replicate(session, plan, errors, number, seed, rungs, timed_on)
        spent += costs[i]

    if session.spread is None:
        for number, i in wanted:
            plan = plans[i]
            seed = _seed(session, scene, plan, number)
            run(number, i, plan.arm.render(seed, plan.ladder, session.threads), processor())
    else:
        tasks = {
            Ladder(i, _seed(session, scene, plans[i], number), tuple(plans[i].ladder)): number
            for number, i in wanted
        }
        session.spread.render(
            [plan.arm for plan in plans], list(tasks), max(costs, default=0.0),
            lambda task, rungs, timed_on: run(tasks[task], task.arm, rungs, timed_on),
        )  # fmt: skip
    session.progress(StudyProgress(f"{scene_name(scene)}: rendered", total, total))


def _check_processors(session: Session, plans: Sequence[Plan]) -> None:
    own = processor()
    found = set().union(*(session.store.processors(plan.key) for plan in plans))
    if others := sorted(found - {own}):
        raise OptionError(
            "equal times are compared among processors of one kind, and this one is "
            f"{own}, replicates in {session.store.path} were timed on {', '.join(others)}: write "
            "to another folder, or say equal_time: false"
        )


def _seed(session: Session, scene: SceneSpec, plan: Plan, number: int) -> int:
    """Of a replicate."""
    name = "" if session.study.paired else plan.arm.spec.name
    return seed_of("arm", session.study.seed, scene_name(scene), name, number)


def _keep_replicate(
    session: Session,
    plan: Plan,
    figures: Figures,
    number: int,
    seed: int,
    ladder: Iterable[Rung],
    timed_on: str,
) -> None:
    """Work out the figures of a replicate's pictures, step by step, and store them."""
    rungs, pictures, looked_at = {}, {}, {}
    example, blocks, invalid = None, np.zeros(0), 0
    for rung in ladder:
        begin = time.process_time()
        rungs[rung.spp] = {"seconds": rung.seconds, **figures.of(rung.picture)}
        if rung.spp in (plan.judged.low, plan.judged.high) and number < _SLOW:
            looked_at[rung.spp] = rung.picture
        if rung.spp in plan.tops:
            pictures[rung.spp] = rung.picture
        if rung.spp == plan.shown and number == 0:
            example = Example(rung.spp, rung.seconds, rung.picture)
        if rung.spp == plan.ladder[-1]:
            blocks, invalid = block_row(rung.picture), rung.invalid
            session.seconds["render"] += rung.seconds
        session.seconds["statistics"] += time.process_time() - begin
    begin = time.process_time()
    # Between the steps it would leave the caches cold for some of the arms.
    for spp, picture in looked_at.items():
        rungs[spp] |= figures.of(picture, slow=True)
    replicate = Replicate(number, seed, invalid, rungs, blocks, timed_on)
    session.store.add(plan.key, replicate, pictures, example)
    session.seconds["statistics"] += time.process_time() - begin
