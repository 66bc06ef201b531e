"""What a study is: scenes, arms, a ladder of samples, replicates.

`Study` can be made in Python or read from a file (`alight.lab.study_file`).
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from alight.core.errors import AlightError, Issue, show_value, unknown_name
from alight.options.laboratory import TraceOptions

#: Options of an arm by a word of their own, as for `alight render`; all other keys of a scene
#: file are options by their path.
NAMED_OPTIONS = {
    name: one.key for name, one in TraceOptions.options().items() if "." in one.key
} | {
    "light_sampling": "integrator.light_sampling",
    "heuristic": "integrator.heuristic",
    "russian_roulette": "integrator.russian_roulette",
    "light_choice": "integrator.light_choice",
    "size": "film.size",
}

#: Options that are not in scene files: the tree over the surfaces.
ACCELERATION = {"structure": ("auto", "list", "bvh"), "builder": ("sah", "median")}

#: Where samples go (`alight.lab.replicates.steering`): not in scene files either.
SCHEDULE = "schedule"

#: Fewest replicates: below, intervals have no meaning worth printing.
LEAST_REPLICATES = 4


class StudyError(AlightError, ValueError):
    """A study that cannot be run, with every reason found."""

    def __init__(self, issues: Sequence[Issue] | str) -> None:
        self.issues = (Issue("", issues),) if isinstance(issues, str) else tuple(issues)
        super().__init__(self.issues)

    def __str__(self) -> str:
        """One block per issue."""
        return "\n".join(str(i) if i.place or i.path else i.message for i in self.issues)


@dataclass(frozen=True)
class ArmSpec:
    """One technique.

    Parameters
    ----------
    name : str
    options : mapping of str to value
        Words of `NAMED_OPTIONS` and `ACCELERATION`, or key paths of the scene file.
    label : str
        For figures; the name by default.
    declares_different : bool
        That the arm computes another picture than the baseline (depth, filter), and is compared
        all the same.
    own_reference : bool
        Compare with a reference that this arm renders for itself.
    expected_slope : float, optional
        Of log(RMSE) over log(spp).
    """

    name: str
    options: Mapping[str, Any] = field(default_factory=dict)
    label: str = ""
    declares_different: bool = False
    own_reference: bool = False
    expected_slope: float | None = None


@dataclass(frozen=True)
class ReferenceSpec:
    """Where the reference comes from.

    Parameters
    ----------
    arm : str
        That renders it; the baseline by default.
    spp : int, optional
        Enough for the claims by default, from a pilot.
    file : str
        Picture made elsewhere, relative to the study file.
    error : float, optional
        Its stated relRMSE; needed unless the file has a layer of standard errors.
    """

    arm: str = ""
    spp: int | None = None
    file: str = ""
    error: float | None = None


@dataclass(frozen=True)
class SceneSpec:
    """One scene of a study.

    Parameters
    ----------
    scene : str
        Name of a built-in scene, or a file relative to the study file.
    name : str
    label : str
    options : mapping of str to value
        For all arms.
    reference : ReferenceSpec
    arms : sequence of str
        Those that run here; all by default.
    crops : sequence of (x, y, width, height)
        Parts worth a closer look.
    spp : sequence of int
        Own ladder.
    """

    scene: str
    name: str = ""
    label: str = ""
    options: Mapping[str, Any] = field(default_factory=dict)
    reference: ReferenceSpec = ReferenceSpec()
    arms: Sequence[str] = ()
    crops: Sequence[Sequence[int]] = ()
    spp: Sequence[int] = ()


@dataclass(frozen=True)
class Study:
    """A study of pictures, of integrals or of acceleration.

    Parameters
    ----------
    name, title, description, teaches : str
    kind : {"pictures", "integrals", "acceleration"}
    scenes : sequence of SceneSpec
    arms : sequence of ArmSpec
    baseline : str
        Name of an arm; the first by default.
    spp : sequence of int
        Ladder of samples per pixel.
    equal_time : bool
        Whether there is a ladder of equal times too.
    replicates : int
        S, independent seeds of each arm.
    paired : bool
        Whether arms share their seeds.
    seed : int
        From which all seeds follow.
    folder : Path
        Where relative files are looked up.
    root : Path, optional
        See `alight.load`: of all its scenes.
    file : str
        Name of the study file, for messages.
    places : mapping of str to str
        Key path -> ``line:column``.
    settings : mapping
        Of the kinds other than pictures.
    """

    name: str
    arms: Sequence[ArmSpec] = ()
    scenes: Sequence[SceneSpec] = ()
    title: str = ""
    description: str = ""
    teaches: str = ""
    kind: str = "pictures"
    baseline: str = ""
    spp: Sequence[int] = (4, 16, 64)
    equal_time: bool = True
    replicates: int = 16
    paired: bool = False
    seed: int = 1
    folder: Path = Path()
    root: Path | None = None
    file: str = ""
    places: Mapping[str, str] = field(default_factory=dict)
    settings: Mapping[str, Any] = field(default_factory=dict)

    def issue(self, path: str, message: str) -> Issue:
        """Make an issue with the place of the nearest key that the file has."""
        at = path
        while at and at not in self.places:
            cut = max(at.rfind("."), at.rfind("["))
            at = at[:cut] if cut > 0 else ""
        place = f"{self.file}:{self.places.get(at, '1:1')}" if self.file else ""
        return Issue(path, message, place)

    def fail(self, path: str, message: str) -> StudyError:
        """Make the error of one issue."""
        return StudyError([self.issue(path, message)])

    def arms_of(self, scene: SceneSpec) -> list[ArmSpec]:
        """The arms that run in a scene, in the order of the study."""
        return [arm for arm in self.arms if not scene.arms or arm.name in scene.arms]

    def baseline_of(self, scene: SceneSpec) -> ArmSpec:
        """The arm that the others of a scene are compared with."""
        arms = self.arms_of(scene)
        return next((arm for arm in arms if arm.name == self.baseline), arms[0])

    def checked(self) -> Study:
        """Return itself.

        Raises
        ------
        StudyError
            If names do not exist or numbers are out of range.
        """
        issues = list(_problems(self))
        if issues:
            raise StudyError(issues)
        return self


def _problems(study: Study):
    """Every problem that needs no scene to be loaded."""
    if study.kind != "pictures":
        return
    names = [arm.name for arm in study.arms]
    if not study.scenes:
        yield study.issue("scenes", "must name at least one scene")
    if not names:
        yield study.issue("arms", "must name at least one arm")
    for name in {name for name in names if names.count(name) > 1}:
        yield study.issue(f"arms.{name}", "is given twice")
    if study.baseline and study.baseline not in names:
        yield study.issue("baseline", unknown_name("arm", study.baseline, names, "arms"))
    if study.replicates < LEAST_REPLICATES:
        text = (
            f"must be at least {LEAST_REPLICATES}, got {study.replicates}: "
            "intervals come from the spread of independent seeds"
        )
        yield study.issue("replicates", text)
    yield from _ladder_problems(study, "spp", study.spp)
    for i, scene in enumerate(study.scenes):
        path = f"scenes[{i}]"
        if scene.spp:
            yield from _ladder_problems(study, f"{path}.spp", scene.spp)
        known = {*names}
        for name in scene.arms:
            if name not in known:
                yield study.issue(f"{path}.arms", unknown_name("arm", name, names, "arms"))
        reference = scene.reference
        if reference.arm and reference.arm not in known:
            message = unknown_name("arm", reference.arm, names, "arms")
            yield study.issue(f"{path}.reference.arm", message)
        if reference.error is not None and not 0.0 < reference.error < 1.0:
            message = f"must be a share in (0, 1), as 0.5%, got {reference.error}"
            yield study.issue(f"{path}.reference.error", message)
    if names:
        yield from _problems_of_settings(study)
    labels = [scene_name(scene) for scene in study.scenes]
    for name in {name for name in labels if labels.count(name) > 1}:
        yield study.issue("scenes", f'two scenes are called "{name}": give them names')


def _problems_of_settings(study: Study):
    """What the tables of a study need."""
    if "relmse_after" not in study.settings:
        return
    path = "settings.relmse_after"
    seconds = study.settings["relmse_after"]
    is_number = isinstance(seconds, int | float) and not isinstance(seconds, bool)
    if not is_number or not 0.0 < seconds < math.inf:
        yield study.issue(path, f"must be seconds > 0, got {show_value(seconds)}")
    for scene in study.scenes:
        if len(scene.spp or study.spp) < 2:
            text = f"needs two steps of spp, {scene_name(scene)} has one"
            yield study.issue(path, text)
        arms = study.arms_of(scene)
        if arms and study.baseline_of(scene).declares_different:
            text = f"compares with the baseline, {study.baseline_of(scene).name}, which declares"
            yield study.issue(path, f"{text} itself different")


def _ladder_problems(study: Study, path: str, ladder: Sequence[int]):
    whole = all(isinstance(n, int) and not isinstance(n, bool) and n >= 1 for n in ladder)
    if not ladder or not whole or sorted(set(ladder)) != list(ladder):
        yield study.issue(path, f"must be rising whole numbers >= 1, got {list(ladder)}")


def scene_name(scene: SceneSpec) -> str:
    """Name of a scene in results."""
    return scene.name or Path(os.fspath(scene.scene)).stem
