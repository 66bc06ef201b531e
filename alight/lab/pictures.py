"""Studies of pictures: pilot, reference, interleaved replicates, evaluation.

Block k holds replicate k of every arm, in an order drawn at random: what the machine does over
minutes (clock rates, neighbours) falls on all arms alike. Everything measured goes to the store at
once, under keys of content, so that an interrupted study goes on and an arm that was added is all
that runs.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from alight.lab.arms import Arm, compile_arm, digest, load_arms, seed_of
from alight.lab.blocks import block_row
from alight.lab.evaluate import Plan, evaluate_arms, no_noise
from alight.lab.figures import Figures
from alight.lab.references import (
    SEEDS,
    WANTED_SHARE,
    Reference,
    external_reference,
    rendered_reference,
)
from alight.lab.results import SceneResult
from alight.lab.steering import is_biased
from alight.lab.store import Example, Replicate, Store
from alight.lab.study import SCHEDULE, SceneSpec, Study, scene_name

#: Under ``--quick``: replicates, and most samples per pixel of the ladder.
QUICK_REPLICATES, QUICK_SPP = 8, 16

#: Replicates whose FLIP is worked out: it costs fifty times all other figures together, and hardly
#: differs from one replicate to the next.
_FLIPS = 2

#: Slope of the MSE that a pilot is extrapolated with, to the steps of equal time: between
#: independent samples and nets.
_PILOT_SLOPE = 1.5


@dataclass(frozen=True)
class StudyProgress:
    """How far a study is.

    Attributes
    ----------
    text : str
        What is being done.
    done, total : float
        CPU seconds of rendering in the present phase; the total is 0 where it is not known.
    """

    text: str
    done: float = 0.0
    total: float = 0.0


@dataclass
class Session:
    """What all scenes of a study share while it runs.

    Attributes
    ----------
    study : Study
    store : Store
    quick : bool
    threads : int
    progress : callable
    seconds : dict of str to float
        Spent so far, by kind.
    """

    study: Study
    store: Store
    quick: bool
    threads: int
    progress: Callable[[StudyProgress], None]
    seconds: dict[str, float] = field(
        default_factory=lambda: dict.fromkeys(
            ("render", "reference", "load", "compile", "statistics"), 0.0
        )
    )

    @property
    def replicates(self) -> int:
        """S."""
        return min(self.study.replicates, QUICK_REPLICATES) if self.quick else self.study.replicates

    def ladder(self, scene: SceneSpec) -> tuple[int, ...]:
        """Samples per pixel at which arms are compared."""
        full = tuple(scene.spp or self.study.spp)
        if not self.quick:
            return full
        return tuple(n for n in full if n <= QUICK_SPP) or full[:1]


@dataclass(frozen=True)
class Pilot:
    """What two pictures say about an arm beforehand.

    Attributes
    ----------
    spp : int
    seconds : float
        CPU time of one sample per pixel.
    mse : float
        Of a picture with `spp` samples.
    """

    spp: int
    seconds: float
    mse: float

    def mse_at(self, spp: float) -> float:
        """Expected error at another number of samples."""
        return self.mse * (self.spp / spp) ** _PILOT_SLOPE


def run_scene(session: Session, scene: SceneSpec) -> SceneResult:
    """Measure the arms of one scene, as far as the store does not know them, and judge them."""
    study, store = session.study, session.store
    index = list(study.scenes).index(scene)
    arms = _compiled(session, scene)
    baseline = study.baseline_of(scene).name
    ladder = session.ladder(scene)
    pilots = {name: _pilot(session, arm, ladder) for name, arm in arms.items()}
    for name, pilot in pilots.items():
        if pilot.mse == 0.0:
            raise no_noise(study, name)
    times = {name: _times(session, arms, pilots, ladder, baseline, name) for name in arms}
    reference = _reference(session, scene, index, arms, pilots, times, ladder)
    plans = []
    for name, arm in arms.items():
        own = arm.spec.own_reference
        spp = _own_spp(session, pilots[name], ladder, times[name]) if own else 0
        mine = _render_reference(session, arm, spp) if own else reference
        seeds = () if study.paired else (name,)
        key = digest(
            arm.key, study.seed, scene_name(scene), seeds, ladder, times[name], mine.info.key
        )
        plans.append(Plan(arm, key, ladder, times[name], mine, own))
    order_seed = seed_of("order", study.seed, scene_name(scene))
    _run_blocks(session, scene, plans, pilots, order_seed)
    begin = time.process_time()
    session.progress(StudyProgress(f"{scene_name(scene)}: statistics"))
    results = evaluate_arms(study, f"scenes[{index}]", baseline, plans, store, session.replicates)
    session.seconds["statistics"] += time.process_time() - begin
    return SceneResult(
        name=scene_name(scene),
        label=scene.label or scene_name(scene),
        size=list(plans[0].arm.size),
        baseline=baseline,
        paired=study.paired,
        order_seed=order_seed,
        reference=reference.info,
        reference_image=reference.image,
        reference_variance=reference.variance,
        arms=results,
        crops=[list(crop) for crop in scene.crops] if not session.quick else [],
        notes=_notes(results),
    )


def _notes(results: Sequence) -> list[str]:
    notes = []
    if all(point.flip is None for arm in results for point in arm.times or arm.samples):
        notes.append("FLIP is left out: the package flip-evaluator is not installed")
    return notes + [
        f"{arm.label}: {arm.invalid} samples were NaN or infinite, counted as 0"
        for arm in results
        if arm.invalid
    ]


def _compiled(session: Session, scene: SceneSpec) -> dict[str, Arm]:
    """Load and compile all arms; what is wrong is found before anything is rendered."""
    begin = time.perf_counter()
    loaded = load_arms(session.study, scene, session.quick)
    session.seconds["load"] += time.perf_counter() - begin
    arms = {}
    for spec in session.study.arms_of(scene):
        session.progress(StudyProgress(f"{scene_name(scene)}: compiling {spec.name}"))
        arm = compile_arm(spec, loaded[spec.name], session.threads)
        session.seconds["load"] += arm.load_seconds
        session.seconds["compile"] += arm.compile_seconds
        arms[spec.name] = arm
    return arms


def _pilot(session: Session, arm: Arm, ladder: Sequence[int]) -> Pilot:
    """Cost and noise of an arm, from two pictures at the last step of the ladder.

    Shorter ones would not do: how fast the error of a net falls nobody knows beforehand.
    """
    spp = ladder[-1]
    key = f"pilot {arm.key} {spp}"
    known = session.store.fact(key)
    if known is None:
        session.progress(StudyProgress(f"pilot of {arm.spec.name}"))
        first, second = (
            next(arm.render(seed_of("pilot", arm.key, k), [spp], session.threads)) for k in (0, 1)
        )
        difference = first.picture.astype(np.float64) - second.picture
        seconds = max(min(first.seconds, second.seconds), 1e-9) / spp
        known = [seconds, float((difference**2).mean()) / 2.0]
        session.store.keep(key, known)
    return Pilot(spp, *known)


def _times(
    session: Session,
    arms: dict[str, Arm],
    pilots: dict[str, Pilot],
    ladder: tuple[int, ...],
    baseline: str,
    name: str,
) -> tuple[int, ...]:
    """Samples per pixel with which an arm takes the baseline's time at each step."""
    if not session.study.equal_time:
        return ()
    if name == baseline:
        return ladder
    key = f"times {arms[baseline].key} {arms[name].key} {ladder}"
    known = session.store.fact(key)
    if known is None:
        rate = pilots[baseline].seconds / pilots[name].seconds
        known = sorted({max(1, round(n * rate)) for n in ladder})
        session.store.keep(key, known)
    return tuple(known)


def _reference(
    session: Session,
    scene: SceneSpec,
    index: int,
    arms: dict[str, Arm],
    pilots: dict[str, Pilot],
    times: dict[str, tuple[int, ...]],
    ladder: tuple[int, ...],
) -> Reference:
    """The scene's reference: of a file, of a named arm, or of the most efficient one."""
    study, spec = session.study, scene.reference
    baseline = study.baseline_of(scene).name
    if spec.file:
        size = arms[baseline].size
        return external_reference(study, f"scenes[{index}].reference", spec, size)
    path = f"scenes[{index}].reference.arm"
    if spec.arm and spec.arm not in arms:
        raise study.fail(path, f'arm "{spec.arm}" does not run in this scene')
    fit = [name for name, arm in arms.items() if not arm.spec.declares_different]
    steered = {name for name in fit if is_biased(arms[name].spec.options.get(SCHEDULE))}
    if spec.arm in steered:
        text = f'arm "{spec.arm}" decides by the samples that it keeps: it is no reference'
        raise study.fail(path, text)
    fit = [name for name in fit if name not in steered]
    if spec.arm and spec.arm not in fit:
        raise study.fail(path, f'arm "{spec.arm}" is declared different: it is no reference')
    key = f"reference {arms[baseline].key} {spec.arm} {spec.spp} {ladder}"
    known = session.store.fact(key)
    if known is None or known[0] not in arms or arms[known[0]].key != known[1]:
        name = spec.arm or min(fit, key=lambda n: pilots[n].mse * pilots[n].seconds * pilots[n].spp)
        noisy = min(pilots[n].mse_at(max((*ladder, *times[n]))) for n in arms)
        spp = spec.spp or int(pilots[name].spp * pilots[name].mse / (WANTED_SHARE * noisy))
        known = [name, arms[name].key, max(spp, SEEDS)]
        session.store.keep(key, known)
    return _render_reference(session, arms[known[0]], known[2])


def _own_spp(
    session: Session, pilot: Pilot, ladder: tuple[int, ...], times: tuple[int, ...]
) -> int:
    """Samples of an arm's own reference."""
    noisy = pilot.mse_at(max((*ladder, *times)))
    return max(SEEDS, int(pilot.spp * pilot.mse / (WANTED_SHARE * noisy)))


def _render_reference(session: Session, arm: Arm, spp: int) -> Reference:
    text = f"reference: {spp} spp of {arm.spec.name}"
    session.progress(StudyProgress(text, 0.0, 1.0))
    reference = rendered_reference(
        arm, spp, session.threads, lambda share: session.progress(StudyProgress(text, share, 1.0))
    )
    if reference.info.source == "rendered":
        session.seconds["reference"] += reference.info.seconds
    return reference


def _run_blocks(
    session: Session,
    scene: SceneSpec,
    plans: Sequence[Plan],
    pilots: dict[str, Pilot],
    order_seed: int,
) -> None:
    """Render what the store does not have yet, block by block."""
    costs = [pilots[plan.arm.spec.name].seconds * plan.ladder[-1] for plan in plans]
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
    for number in range(count):
        # The order is drawn for all arms, done or not: it is the same after an interruption.
        for i in order.permutation(len(plans)).tolist():
            if number in done[i]:
                continue
            plan = plans[i]
            text = f"{scene_name(scene)}: replicate {number + 1} of {count}, {plan.arm.spec.name}"
            session.progress(StudyProgress(text, spent, total))
            _run_replicate(session, scene, plan, figures[id(plan.reference)], number)
            spent += costs[i]
    session.progress(StudyProgress(f"{scene_name(scene)}: rendered", total, total))


def _run_replicate(
    session: Session, scene: SceneSpec, plan: Plan, figures: Figures, number: int
) -> None:
    study, name = session.study, plan.arm.spec.name
    seed = seed_of("arm", study.seed, scene_name(scene), "" if study.paired else name, number)
    rungs, pictures = {}, {}
    example, blocks, invalid = None, np.zeros(0), 0
    for rung in plan.arm.render(seed, plan.ladder, session.threads):
        begin = time.process_time()
        judged = rung.spp == plan.judged
        found = figures.of(rung.picture, with_flip=judged and number < _FLIPS)
        rungs[rung.spp] = {"seconds": rung.seconds, **found}
        if rung.spp in plan.tops:
            pictures[rung.spp] = rung.picture
        if judged and number == 0:
            example = Example(rung.spp, rung.seconds, rung.picture)
        if rung.spp == plan.ladder[-1]:
            blocks, invalid = block_row(rung.picture), rung.invalid
            session.seconds["render"] += rung.seconds
        session.seconds["statistics"] += time.process_time() - begin
    begin = time.process_time()
    session.store.add(plan.key, Replicate(number, seed, invalid, rungs, blocks), pictures, example)
    session.seconds["statistics"] += time.process_time() - begin
