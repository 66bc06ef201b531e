"""Studies of pictures: pilot, reference, interleaved replicates, evaluation.

Block k holds replicate k of every arm, in random order, so that fluctuations of the machine over
minutes (clock rates, neighbours) affect all arms alike. Every measurement goes to the store at
once, keyed by content, so that an interrupted study continues and only a newly added arm has to
run.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from alight.core.registry import registered_versions
from alight.lab.arm_plan import Plan
from alight.lab.arms import Arm, compile_arm, digest, load_arms, seed_of
from alight.lab.evaluate import evaluate_arms, no_noise
from alight.lab.references import (
    SEEDS,
    WANTED_SHARE,
    Reference,
    external_reference,
    fit_arms,
    is_named,
    reference_arm,
    rendered_reference,
)
from alight.lab.replicates.run_blocks import run_blocks
from alight.lab.replicates.session import Session, StudyProgress
from alight.lab.results import BIASED, SceneResult
from alight.lab.statistics.equal_time import Bracket, bracket, is_natural
from alight.lab.study import SceneSpec, scene_name
from alight.metrics.model import METRICS

#: Processor seconds of a reference above which a shortcut is suggested.
_LONG = 600.0

#: Slope of the MSE that a pilot is extrapolated with, to the steps of equal time: between
#: independent samples and nets.
_PILOT_SLOPE = 1.5


@dataclass(frozen=True)
class PilotPictures:
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

    def spp_for(self, mse: float) -> int:
        """Samples per pixel whose mean, over several seeds, has this error."""
        return int(self.spp * self.mse / mse)


@dataclass(frozen=True)
class _Setup:
    """What is known of a scene before its replicates are rendered.

    Attributes
    ----------
    index : int
        Of the scene in the study.
    arms : dict of str to Arm
    pilots : dict of str to PilotPictures
    ladder : tuple of int
    times : dict of str to tuple of Bracket
    """

    index: int
    arms: dict[str, Arm]
    pilots: dict[str, PilotPictures]
    ladder: tuple[int, ...]
    times: dict[str, tuple[Bracket, ...]]

    def least_error(self, name: str) -> float:
        """Expected MSE of an arm with the most samples that it is rendered with."""
        most = max((self.ladder[-1], *(step.high for step in self.times[name])))
        return self.pilots[name].mse_at(most)


def run_scene(session: Session, scene: SceneSpec) -> SceneResult:
    """Measure the arms of one scene, as far as the store does not know them, and judge them."""
    study = session.study
    # What is wrong is found before anything is rendered.
    first = reference_arm(study, scene)
    arms = _compiled(session, scene)
    baseline = study.baseline_of(scene).name
    ladder = session.ladder(scene)
    pilots = {name: _pilot(session, arm, ladder) for name, arm in arms.items()}
    for name, pilot in pilots.items():
        if pilot.mse == 0.0:
            raise no_noise(study, name)
    times = {name: _times(session, arms, pilots, ladder, baseline, name) for name in arms}
    setup = _Setup(list(study.scenes).index(scene), arms, pilots, ladder, times)
    result = _measured(session, scene, setup, first)
    verdicts = {arm.name: arm.bias.verdict for arm in result.arms}
    heirs = [name for name in fit_arms(study, scene) if verdicts[name] != BIASED]
    if is_named(scene) or verdicts[first] != BIASED or not heirs:
        return result
    # What everything was measured by is wrong: once more, by an arm that most agree with.
    result = _measured(session, scene, setup, heirs[0])
    note = f"{first} disagrees with most arms: {heirs[0]} renders the reference in its place"
    return replace(result, notes=[note, *result.notes])


def _measured(session: Session, scene: SceneSpec, setup: _Setup, chosen: str) -> SceneResult:
    """The scene with a reference by the chosen arm (or of the file that the study names)."""
    study, store, times = session.study, session.store, setup.times
    reference = _reference(session, scene, setup, chosen)
    plans = []
    for name, arm in setup.arms.items():
        own = arm.spec.own_reference
        mine = reference
        if own:
            spp = _own_spp(setup, name)
            mine = _render_reference(session, arm, spp, spp * setup.pilots[name].seconds)
        key = digest(
            arm.key, study.seed, scene_name(scene), study.paired, name, setup.ladder, times[name],
            mine.info.key, *registered_versions("metrics"),
        )  # fmt: skip
        plans.append(Plan(arm, key, setup.ladder, times[name], mine, own))
    order_seed = seed_of("order", study.seed, scene_name(scene))
    costs = [setup.pilots[plan.arm.spec.name].seconds * plan.ladder[-1] for plan in plans]
    run_blocks(session, scene, plans, costs, order_seed)
    begin = time.process_time()
    session.progress(StudyProgress(f"{scene_name(scene)}: statistics"))
    baseline = study.baseline_of(scene).name
    results = evaluate_arms(
        study, f"scenes[{setup.index}]", baseline, plans, store, session.replicates,
        reference_is_named=is_named(scene),
    )  # fmt: skip
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
        notes=[
            *_warnings(setup.arms),
            *_notes(results, set().union(*(store.processors(plan.key) for plan in plans))),
        ],
    )


def _notes(results: Sequence, processors: set[str]) -> list[str]:
    notes = []
    if len(processors) > 1:
        named = ", ".join(sorted(processors))
        notes.append(f"times are those of different processors: {named}")
    points = [point for arm in results for point in arm.times or arm.samples]
    for name, model in METRICS.items():
        if model.IN_STUDIES and all(point.errors[name] is None for point in points):
            notes.append(f"{model.LABEL} is left out: {model.missing() or 'no replicate has it'}")
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
    session.progress(StudyProgress(f"{scene_name(scene)}: compiled", warnings=_warnings(arms)))
    return arms


def _warnings(arms: Mapping[str, Arm]) -> tuple[str, ...]:
    """What is suspicious of the scenes of all arms, each once."""
    return tuple(dict.fromkeys(text for arm in arms.values() for text in arm.compiled.warnings))


def _pilot(session: Session, arm: Arm, ladder: Sequence[int]) -> PilotPictures:
    """Cost and noise of an arm, from two pictures at the last step of the ladder.

    Shorter ones would not do: nobody knows in advance how fast the error of a net falls.
    """
    spp, own = ladder[-1], (arm.key, arm.spec.name, session.study.seed)
    key = f"pilot {digest(*own)} {spp}"
    known = session.store.fact(key)
    if known is None:
        session.progress(StudyProgress(f"pilot of {arm.spec.name}"))
        first, second = (
            next(arm.render(seed_of("pilot", *own, k), [spp], session.threads)) for k in (0, 1)
        )
        difference = first.picture.astype(np.float64) - second.picture
        seconds = max(min(first.seconds, second.seconds), 1e-9) / spp
        known = [seconds, float((difference**2).mean()) / 2.0]
        session.store.keep(key, known)
    return PilotPictures(spp, *known)


def _times(
    session: Session,
    arms: dict[str, Arm],
    pilots: dict[str, PilotPictures],
    ladder: tuple[int, ...],
    baseline: str,
    name: str,
) -> tuple[Bracket, ...]:
    """Where an arm takes the baseline's time at each step."""
    if not session.study.equal_time:
        return ()
    arm, found = arms[name], []
    rate = pilots[baseline].seconds / pilots[name].seconds
    for spp in ladder:
        # The baseline takes its own time at any step that its sampler is made for.
        own = name == baseline and is_natural(spp, arm.sampler, arm.replicates)
        found.append(Bracket.at(spp) if own else bracket(spp * rate, arm.sampler, arm.replicates))
    return tuple(found)


def _reference(session: Session, scene: SceneSpec, setup: _Setup, chosen: str) -> Reference:
    """The scene's reference: of a file, or rendered by the chosen arm."""
    study, spec, pilots = session.study, scene.reference, setup.pilots
    arm = setup.arms[chosen]
    if spec.file:
        path = f"scenes[{setup.index}].reference"
        return external_reference(study, path, spec, arm.size)
    key = f"reference {arm.key} {chosen} {study.seed} {spec.spp} {setup.ladder}"
    spp = session.store.fact(key)
    if spp is None:
        least = min(setup.least_error(name) for name in pilots)
        spp = max(spec.spp or pilots[chosen].spp_for(WANTED_SHARE * least), SEEDS)
        session.store.keep(key, spp)
    return _render_reference(session, arm, spp, spp * pilots[chosen].seconds)


def _own_spp(setup: _Setup, name: str) -> int:
    """Samples of an arm's own reference."""
    return max(SEEDS, setup.pilots[name].spp_for(WANTED_SHARE * setup.least_error(name)))


def _render_reference(session: Session, arm: Arm, spp: int, seconds: float) -> Reference:
    text = f"reference: {spp} spp of {arm.spec.name}"
    if seconds > _LONG:
        text += f", {seconds:.0f} s (a more efficient arm? name it by reference.arm)"
    session.progress(StudyProgress(text, 0.0, 1.0))
    reference = rendered_reference(
        arm, spp, session.study.seed, session.threads,
        lambda share: session.progress(StudyProgress(text, share, 1.0)),
    )  # fmt: skip
    if reference.info.source == "rendered":
        session.seconds["reference"] += reference.info.seconds
    return reference
