"""Arms made ready: scenes loaded with their options, checked against the baseline, compiled."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from alight.compiled.casters import is_caster
from alight.compiled.scene import CompiledScene, compile_scene
from alight.core.errors import SceneError, show_value, unknown_name
from alight.core.noise_only import noise_only_fields
from alight.core.registry import default_of
from alight.core.spec import Integrator, Sampler, Spec
from alight.formats import builtin_names, load
from alight.lab.replicates.measure import Rung, compiled_kernels, render_ladder
from alight.lab.replicates.steering import is_steered, problem_of, steered_ladder
from alight.lab.study import (
    ACCELERATION,
    NAMED_OPTIONS,
    SCHEDULE,
    ArmSpec,
    SceneSpec,
    Study,
    StudyError,
)
from alight.lights.model import LIGHTS
from alight.rendering.tiles.tile import Kernels
from alight.scene import Scene, content_hash, flatten
from lanewise.machine import fingerprint

#: Longest side of pictures under ``--quick``.
QUICK_SIZE = 128


@dataclass(frozen=True)
class Arm:
    """One arm in one scene, ready to render.

    Attributes
    ----------
    spec : ArmSpec
    compiled : CompiledScene
    kernels : Kernels
    sampler : Sampler
    replicates : int
        R of the film.
    key : str
        Content hash of scene, settings and kernel version.
    load_seconds, compile_seconds : float
    """

    spec: ArmSpec
    compiled: CompiledScene
    kernels: Kernels
    sampler: Sampler
    replicates: int
    key: str
    load_seconds: float
    compile_seconds: float

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of its pictures."""
        crop = self.compiled.crop
        return self.compiled.size if crop is None else (crop[2], crop[3])

    def render(self, seed: int, ladder: Sequence[int], threads: int) -> Iterator[Rung]:
        """Render with one seed, stopping at each step of the ladder."""
        schedule = self.spec.options.get(SCHEDULE)
        if is_steered(schedule):
            return steered_ladder(
                self.compiled, self.kernels, self.replicates, seed, ladder, threads, schedule
            )
        return render_ladder(self.compiled, self.kernels, self.replicates, seed, ladder, threads)


def load_arms(study: Study, scene: SceneSpec, quick: bool) -> dict[str, Scene]:
    """Load the scene of each arm, and see that all compute the same picture.

    Raises
    ------
    StudyError
        For an option that does not exist or does not fit, other sizes, or an arm that computes
        something else than the baseline without saying so.
    """
    index = list(study.scenes).index(scene)
    loaded, issues = {}, []
    for arm in study.arms_of(scene):
        try:
            loaded[arm.name] = _load(study, scene, arm, quick)
        except SceneError as error:
            issues += [_placed(study, scene, index, arm, issue) for issue in error.issues]
        except StudyError as error:
            issues += error.issues
    if issues:
        # A scene that is wrong is so for every arm.
        raise StudyError(list(dict.fromkeys(issues)))
    _check_same_picture(study, scene, loaded)
    return loaded


def _load(study: Study, scene: SceneSpec, arm: ArmSpec, quick: bool) -> Scene:
    path = Path(scene.scene)
    named = scene.scene in builtin_names()
    changes = assignments(study, scene.options, "scenes")
    changes += assignments(study, arm.options, f"arms.{arm.name}")
    result = load(scene.scene if named else study.folder / path, changes, root=study.root)
    if not quick:
        return result
    film = result.film
    longest = max(film.size) if film.crop is None else max(film.crop[2:])
    if longest <= QUICK_SIZE or film.crop is not None:
        return result
    width, height = (max(8, round(n * QUICK_SIZE / longest)) for n in film.size)
    smaller = film.replaced(size=(width, height))
    return result.replaced(film=smaller).from_source(result.source)


def assignments(study: Study, options: Mapping[str, Any], path: str) -> list[str]:
    """Options as ``path=value``, models first: their keys follow them.

    Raises
    ------
    StudyError
        For a word that is no option.
    """
    found = []
    for name, value in options.items():
        if name in ACCELERATION:
            if value not in ACCELERATION[name]:
                message = unknown_name(name, str(value), ACCELERATION[name])
                raise study.fail(f"{path}.{name}", message)
            continue
        if name == SCHEDULE:
            problem = problem_of(value)
            if problem is not None:
                raise study.fail(f"{path}.{name}", problem)
            continue
        if name not in NAMED_OPTIONS and "." not in name and name not in _ROOTS:
            words = [*NAMED_OPTIONS, *ACCELERATION, SCHEDULE]
            message = unknown_name("option", name, words, "options")
            raise study.fail(f"{path}.{name}", f"{message}; or a key path of the scene file")
        target = NAMED_OPTIONS.get(name, name)
        if name == "size" and isinstance(value, int):
            value = [value, value]
        if isinstance(value, Mapping) and target.endswith(".type"):
            target = target.removesuffix(".type")
        # JSON is YAML; texts keep their quotes.
        found.append((not target.endswith(".type"), f"{target}={json.dumps(value)}"))
    return [text for _, text in sorted(found, key=lambda item: item[0])]


_ROOTS = ("film", "environment", "camera", "integrator", "sampler")


def _placed(study: Study, scene: SceneSpec, index: int, arm: ArmSpec, issue: Any) -> Any:
    """Move an issue of a scene to the place in the study file that caused it."""
    for path, options in (
        (f"arms.{arm.name}", arm.options),
        (f"scenes[{index}].set", scene.options),
    ):
        for name in options:
            target = NAMED_OPTIONS.get(name, name)
            root = target.removesuffix(".type")
            if issue.path and (issue.path.startswith(root) or target.startswith(issue.path)):
                return study.issue(f"{path}.{name}", f"{issue.path}: {issue.message}")
    # A file that is missing has no line of its own; what is wrong in it has.
    if issue.path or issue.place not in ("", scene.scene, str(study.folder / scene.scene)):
        return issue
    return study.issue(f"scenes[{index}]", f"{scene.scene}: {issue.message}")


def _check_same_picture(study: Study, scene: SceneSpec, loaded: Mapping[str, Scene]) -> None:
    baseline = study.baseline_of(scene)
    size, truth = _window(loaded[baseline.name]), same_picture_hash(loaded[baseline.name])
    issues = []
    for arm in study.arms_of(scene):
        mine = loaded[arm.name]
        if _window(mine) != size:
            text = f'has another size or crop than the baseline "{baseline.name}"'
            issues.append(study.issue(f"arms.{arm.name}", text))
        elif not arm.declares_different and same_picture_hash(mine) != truth:
            text = (
                f'computes another picture than the baseline "{baseline.name}" '
                f"({_what_differs(arm, baseline, mine)}); if that is meant, "
                "say declares_different: true"
            )
            issues.append(study.issue(f"arms.{arm.name}", text))
    if issues:
        raise StudyError(issues)


def _what_differs(arm: ArmSpec, baseline: ArmSpec, scene: Scene) -> str:
    free = {"sampler", "replicates", SCHEDULE, *ACCELERATION, *noise_only_fields(scene.integrator)}
    names = [
        name
        for name in {**arm.options, **baseline.options}
        if arm.options.get(name) != baseline.options.get(name) and name not in free
    ]
    return ", ".join(f"{n} {show_value(arm.options.get(n))}" for n in names) or "other options"


def _window(scene: Scene) -> tuple:
    return scene.film.size, scene.film.crop


def same_picture_hash(scene: Scene) -> str:
    """Content hash without all that changes the noise only."""
    plain = without_choices(scene)
    update = {
        "sampler": default_of(Sampler),
        "film": scene.film.model_copy(update={"replicates": 1}),
        "integrator": _transport(plain.integrator),
    }
    return content_hash(plain.model_copy(update=update)) + _more_than_paths(scene)


def _more_than_paths(scene: Scene) -> str:
    """Who finds caustics of lights without a size, of which paths find none; empty for nobody."""
    integrator = scene.integrator
    who = "walks" if integrator.aims_at_lamps else "light paths" if integrator.splats else ""
    if not (who and integrator.transports):
        return ""
    flat = flatten(scene)
    delta = any(LIGHTS[placed.light.type_name()].DELTA for placed in flat.lights)
    return who if delta and any(is_caster(bsdf) for bsdf in flat.bsdfs) else ""


def _transport(integrator: Integrator) -> Integrator:
    """The path tracer whose picture this one must have: a law where an integrator `transports`."""
    if integrator.sees_media or not integrator.transports:
        return integrator
    tracer, its = default_of(Integrator), dict(integrator)
    shared = {name: its[name] for name, _ in tracer if name in its and name != "type"}
    if integrator.longest_path is not None:
        shared["max_depth"] = integrator.longest_path
    return without_choices(tracer.model_copy(update=shared))


def without_choices(value: Any) -> Any:
    """The same descriptions with what changes their noise only at the defaults."""
    if isinstance(value, dict):
        changed = {name: without_choices(item) for name, item in value.items()}
        return changed if any(changed[n] is not value[n] for n in value) else value
    if isinstance(value, tuple):
        items = tuple(map(without_choices, value))
        return items if any(a is not b for a, b in zip(items, value, strict=True)) else value
    if not isinstance(value, Spec):
        return value
    changes, free = {}, noise_only_fields(value)
    for name, item in value:
        default = type(value).model_fields[name].default
        new = default if name in free else without_choices(item)
        if new is not item:
            changes[name] = new
    return value.model_copy(update=changes) if changes else value


def compile_arm(spec: ArmSpec, scene: Scene, threads: int) -> Arm:
    """Build arrays and machine code of an arm, and run it once without a sample."""
    begin = time.perf_counter()
    flat = flatten(scene)
    structure = spec.options.get("structure", "auto")
    builder = spec.options.get("builder", "sah")
    content = content_hash(flat)
    compiled = compile_scene(flat, content, structure=structure, builder=builder, threads=threads)
    loaded = time.perf_counter()
    replicates = flat.film.replicates
    kernels = compiled_kernels(compiled)
    done = time.perf_counter()
    schedule = spec.options.get(SCHEDULE)
    steered = [json.dumps(schedule, sort_keys=True)] if is_steered(schedule) else []
    key = digest(content, structure, builder, replicates, fingerprint(), *steered)
    return Arm(
        spec, compiled, kernels, flat.sampler, replicates, key, loaded - begin, done - loaded
    )


def digest(*parts: object) -> str:
    """Short content hash of some values."""
    text = json.dumps([str(part) for part in parts])
    return hashlib.sha256(text.encode()).hexdigest()[:24]


def seed_of(*parts: object) -> int:
    """A seed in [0, 2^32) that belongs to these values."""
    return int(digest(*parts)[:8], 16)
