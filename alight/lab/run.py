"""`run_study`: the one entry of the laboratory."""

from __future__ import annotations

import datetime
import math
import os
import platform
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from alight.core.errors import OptionError, OutputError
from alight.core.version import VERSION
from alight.lab.pictures import run_scene
from alight.lab.replicates.session import QUICK_REPLICATES, Session, StudyProgress
from alight.lab.replicates.spread import processor, spread_over
from alight.lab.result_files import save
from alight.lab.results import ArmResult, SceneResult, StudyResult, TableResult
from alight.lab.store import Store
from alight.lab.study import Study
from alight.lab.study_file import load_study, ready_names
from alight.metrics.estimate import Estimate
from alight.options.cluster import ClusterOptions
from alight.rendering.main_loop import usable_processors
from lanewise.machine import fingerprint, lanes_of_machine

#: Name of the results file in a study's folder.
STORE = "results.sqlite"
#: Cells of `relmse_after` without a number.
NOT_REACHED, NOT_MEASURED = "not reached", "not measured"


def run_study(
    study: Study | str | Path,
    folder: str | Path,
    *,
    quick: bool = False,
    threads: int | None = None,
    progress: Callable[[StudyProgress], None] | None = None,
    cluster: ClusterOptions | None = None,
) -> StudyResult:
    """Run a study, or what is left of it, and write its results.

    Parameters
    ----------
    study : Study, path or name of a ready study
    folder : path
        For ``results.sqlite``, ``results.json`` and ``results.npz``; made if it does not exist.
    quick : bool
        Smaller pictures, fewer samples and replicates, hence wider intervals.
    threads : int, optional
        All processors that this process may use by default.
    progress : callable, optional
        Called with a `StudyProgress` from time to time.
    cluster : ClusterOptions, optional
        Whose workers render the replicates.

    Returns
    -------
    StudyResult

    Raises
    ------
    AlightError
        For a study that is wrong, an arm without noise, a reference with too much, or a full disk.
        What was measured is kept, and the same call continues from there.
    """
    study = (study if isinstance(study, Study) else load_study(study)).checked()
    if cluster is not None and cluster.cluster is not None and study.kind != "pictures":
        raise OptionError(f"is for studies of pictures, this one is of {study.kind}", "cluster")
    # Ready studies have a name instead of a path.
    named = study.name if study.name in ready_names() else study.file or study.name
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"cannot write {folder}: {error.strerror}") from error
    begin = time.perf_counter()
    with Store(folder / STORE) as store, spread_over(cluster, study.equal_time) as spread:
        session = Session(
            study, store, quick, threads or usable_processors(), progress or (lambda _: None),
            spread,
        )  # fmt: skip
        scenes, curves, tables = [], [], []
        if study.kind == "integrals":
            from alight.lab.integrals import run_integrals

            curves, tables = run_integrals(session)
        elif study.kind == "acceleration":
            from alight.lab.acceleration import run_acceleration

            curves, tables = run_acceleration(session)
        else:
            scenes = [run_scene(session, scene) for scene in study.scenes]
            tables = variance_ratios(scenes, study.settings.get("variance_ratios", {}))
            if study.settings.get("relmse_gains"):
                tables.append(relmse_gains(scenes))
            if "relmse_after" in study.settings:
                tables.append(relmse_after(scenes, study.settings["relmse_after"]))
    session.seconds["wall"] = time.perf_counter() - begin
    result = StudyResult(
        name=study.name,
        title=study.title or study.name,
        description=study.description,
        teaches=study.teaches,
        command=f"alight study {named}{' --quick' if quick else ''}",
        created=datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        quick=quick,
        replicates=min(study.replicates, QUICK_REPLICATES) if quick else study.replicates,
        seed=study.seed,
        machine=machine(session.threads),
        versions=versions(),
        seconds=session.seconds,
        scenes=scenes,
        curves=curves,
        tables=tables,
    )
    save(result, folder)
    return result


def variance_ratios(
    scenes: list[SceneResult], expected: Mapping[str, Mapping[str, float]]
) -> list[TableResult]:
    """Measured variances over the baseline's next to the theoretical ones.

    Parameters
    ----------
    scenes : list of SceneResult
    expected : mapping of str to mapping of str to float
        By scene and arm.
    """
    rows = []
    for scene in scenes:
        base = next(arm for arm in scene.arms if arm.is_baseline).samples[-1].variance
        for arm in scene.arms:
            if arm.name in expected.get(scene.name, {}):
                mine = arm.samples[-1].variance
                ratio = mine.value / base.value
                # Independent arms: relative widths add up as squares.
                low = math.hypot(1.0 - mine.low / mine.value, base.high / base.value - 1.0)
                high = math.hypot(mine.high / mine.value - 1.0, 1.0 - base.low / base.value)
                interval = [ratio, ratio * (1.0 - low), ratio * (1.0 + high)]
                rows.append([scene.label, arm.label, interval, expected[scene.name][arm.name]])
    if not rows:
        return []
    columns = ["scene", "arm", "measured", "analytic"]
    text = "Variance at equal samples over the baseline's, and the value that theory gives."
    return [TableResult("variance-ratios", "Ratios of variances", text, columns, rows)]


def relmse_gains(scenes: list[SceneResult]) -> TableResult:
    """How much less relMSE each arm leaves than the baseline; for arms that aim at it.

    Efficiencies are of the MSE, in which dark parts of a picture hardly count.
    """
    rows = []
    for scene in scenes:
        base = next(arm for arm in scene.arms if arm.is_baseline)
        for arm in scene.arms:
            if arm.is_baseline:
                continue
            at_samples = _ratio([base.samples[-1].relmse], [arm.samples[-1].relmse])
            mine, its = (one.times or one.samples for one in (arm, base))
            at_time = _ratio([its[-1].relmse, its[-1].seconds], [mine[-1].relmse, mine[-1].seconds])
            change = np.mean([100.0 * np.array(one) for one in arm.bias.difference], axis=0)
            rows.append([scene.label, arm.label, at_samples, at_time, change.tolist()])
    columns = ["scene", "arm", "equal samples", "equal time", "mean, %"]
    text = (
        "relMSE of the baseline over that of the arm, at the last step of both ladders, and how "
        "much the mean of the arm's pictures differs from the reference."
    )
    return TableResult("relmse-gains", "relMSE over the baseline's", text, columns, rows)


def relmse_after(scenes: list[SceneResult], seconds: float) -> TableResult:
    """What longer renders would leave: arms that are trained first repay that only then.

    Parameters
    ----------
    scenes : list of SceneResult
        Whose arms have at least two steps of equal samples.
    seconds : float
        Of CPU time, training included.
    """
    rows = []
    for scene in scenes:
        # Errors that do not fall with more samples have no place here.
        arms = [arm for arm in scene.arms if not arm.declares_different]
        counts = {arm.label: _reach(arm, seconds) for arm in arms}
        base = next(arm for arm in arms if arm.is_baseline)
        for arm in arms:
            row = [scene.label, arm.label, *_count_cells(counts[arm.label])]
            rows.append([*row, _gain_after(arm, base, counts)])
    columns = ["scene", "arm", "s before the first sample", "spp", "relMSE"]
    text = (
        f"After {seconds:g} s of CPU time: samples a pixel, from the time that each of them takes, "
        "and relMSE of the baseline over that of the arm, as errors fall with one over the samples."
        f" {NOT_REACHED.capitalize()}: there is no sample by then; {NOT_MEASURED}: the last two "
        "steps took the same time."
    )
    return TableResult("relmse-after", f"After {seconds:g} s", text, columns, rows)


def _reach(arm: ArmResult, seconds: float) -> tuple[float, float] | None:
    """CPU seconds before an arm's first sample, and samples a pixel in all.

    None where the clock shows no time between two steps.
    """
    first, last = arm.samples[-2:]
    each = (last.seconds.value - first.seconds.value) / (last.spp - first.spp)
    if each <= 0.0:
        return None
    before = max(last.seconds.value - each * last.spp, 0.0)
    return before, max(seconds - before, 0.0) / each


def _count_cells(count: tuple[float, float] | None) -> list[float | str]:
    if count is None:
        return [NOT_MEASURED, NOT_MEASURED]
    before, spp = count
    return [before, spp or NOT_REACHED]


def _gain_after(
    arm: ArmResult, base: ArmResult, counts: Mapping[str, tuple[float, float] | None]
) -> str | list[float]:
    """RelMSE of the baseline over that of an arm, or why there is none."""
    if arm.is_baseline:
        return "1, the baseline"
    mine, its = counts[arm.label], counts[base.label]
    if mine is None or its is None:
        return NOT_MEASURED
    if not mine[1] or not its[1]:
        return NOT_REACHED
    last, first = arm.samples[-1], base.samples[-1]
    more = mine[1] / its[1] * first.spp / last.spp
    return [more * ratio for ratio in _ratio([first.relmse], [last.relmse])]


def _ratio(above: Sequence[Estimate], below: Sequence[Estimate]) -> list[float]:
    """A ratio of products of independent estimates with its interval, in logarithms."""
    value = math.prod(e.value for e in above) / math.prod(e.value for e in below)
    every = [*above, *below]
    width = math.sqrt(math.fsum((math.log(e.high / e.low) / 2.0) ** 2 for e in every))
    return [value, value * math.exp(-width), value * math.exp(width)]


def machine(threads: int) -> dict[str, str]:
    """What the times were measured on."""
    import llvmlite.binding as llvm

    return {
        "processor": processor(),
        "architecture": llvm.get_host_cpu_name(),
        "processors": str(os.cpu_count() or 0),
        "threads": str(threads),
        "lanes": str(lanes_of_machine()),
        "system": f"{platform.system()} {platform.release()}",
    }


def versions() -> dict[str, str]:
    """Versions of everything that decides the numbers."""
    from importlib.metadata import version

    return {
        "alight": VERSION,
        "kernels": fingerprint(),
        "python": platform.python_version(),
        "numpy": version("numpy"),
        "numba": version("numba"),
    }
