"""Transforms as they are written in scene files: one step or a list of steps.

    transform: {translate: [0, 1, 0]}
    transform: [{scale: 2}, {rotate: {axis: y, angle: 30}}, {translate: [0, 1, 0]}]

A list is applied from left to right, so this one is M = T R S. What moves is given at several
times (`alight.scene.keyframes`), each with its steps, scale first, then rotate, then translate, or
with a list of `steps`:

    transform: {keyframes: [{time: 0}, {time: 1, translate: [1, 0, 0]}]}
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator, ValidationError
from pydantic_core import PydanticCustomError

from alight.core.errors import Issue, SceneError, show_value, unknown_name
from alight.core.field_errors import translate
from alight.core.field_types import Degrees, Triple, Vector3
from alight.core.fields import Interval, Numbers, invalid
from alight.core.spec import Spec
from alight.scene import transform as make
from alight.scene.keyframes import MOST_KEYFRAMES, Keyframes, keyframes
from alight.scene.keyframes import problems as keyframe_problems
from alight.scene.transform import IDENTITY, Transform

Row = Annotated[tuple[float, float, float, float], Numbers(4, Interval())]
MOST_STEPS = 1000


def _axis_by_name(value: object) -> object:
    return make.AXES.get(value, value) if isinstance(value, str) else value


def _four_rows(value: object) -> object:
    if not isinstance(value, list | tuple) or len(value) != 4:
        raise invalid(f"must be a list of 4 rows of 4 numbers, got {show_value(value)}")
    return tuple(value)


class Translate(Spec):
    """Move by metres."""

    translate: Vector3

    def transform(self) -> Transform:
        """Build the transform."""
        return make.translate(*self.translate)


class Rotate(Spec):
    """Turn about an axis, by degrees."""

    axis: Annotated[Vector3, BeforeValidator(_axis_by_name)]
    angle: Degrees

    def transform(self) -> Transform:
        """Build the transform."""
        return make.rotate(self.axis, self.angle)


class Scale(Spec):
    """Scale by one factor or one per axis."""

    scale: Annotated[Triple, Numbers(3, Interval(), spread=True)]

    def transform(self) -> Transform:
        """Build the transform."""
        x, y, z = self.scale
        return make.scale(x) if x == y == z else make.scale(x, y, z)


class LookAt(Spec):
    """Stand somewhere and look at something."""

    origin: Vector3
    target: Vector3
    up: Vector3 = (0.0, 1.0, 0.0)

    def transform(self) -> Transform:
        """Build the transform."""
        return make.look_at(self.origin, self.target, self.up)


class Matrix(Spec):
    """A 4 x 4 matrix, row by row."""

    matrix: Annotated[tuple[Row, Row, Row, Row], BeforeValidator(_four_rows)]

    def transform(self) -> Transform:
        """Build the transform."""
        return make.matrix(self.matrix)


STEPS: dict[str, type[Translate | Rotate | Scale | LookAt | Matrix]] = {
    "translate": Translate,
    "rotate": Rotate,
    "scale": Scale,
    "look_at": LookAt,
    "matrix": Matrix,
}


#: Steps that can be combined in a keyframe, in the order in which they are applied.
IN_ORDER = ("scale", "rotate", "translate")


def parse_transform(data: object, report: Callable[[Issue], None]) -> Transform:
    """Build a transform from plain data.

    Parameters
    ----------
    data : mapping or list of mappings
        Steps, each with the name of one operation, or keyframes.
    report : callable
        Receives an issue, with a path relative to `data`, for each step that is wrong.

    Returns
    -------
    Transform
        The product of the steps that are right.
    """
    if isinstance(data, Mapping) and "keyframes" in data:
        return _parse_keyframes(data, report)
    steps = data if isinstance(data, list | tuple) else [data]
    result = IDENTITY
    if len(steps) > MOST_STEPS:
        report(Issue("", f"must have at most {MOST_STEPS} steps, got {len(steps)}"))
        return result
    for index, step in enumerate(steps):
        prefix = f"[{index}]" if steps is data else ""
        try:
            result = _parse_step(step) @ result
        except SceneError as error:
            for issue in error.issues:
                report(issue.under(prefix))
    return result


def _parse_keyframes(data: Mapping[str, Any], report: Callable[[Issue], None]) -> Transform:
    if len(data) > 1:
        other = next(name for name in data if name != "keyframes")
        text = "must stand alone: put what rests into a node above or into every keyframe"
        report(Issue("keyframes", f"{text}, got {other} beside them", about_key=True))
        return IDENTITY
    frames = data["keyframes"]
    if not isinstance(frames, list | tuple) or not 0 < len(frames) <= MOST_KEYFRAMES:
        got = len(frames) if isinstance(frames, list | tuple) else show_value(frames)
        text = f"must be a list of 1 to {MOST_KEYFRAMES} keyframes, got {got}"
        report(Issue("keyframes", text))
        return IDENTITY
    found: list[Issue] = []
    pairs = [
        _parse_keyframe(frame, f"keyframes[{i}]", found.append) for i, frame in enumerate(frames)
    ]
    if not found:
        found = [Issue(f"keyframes{path}", text) for path, text in keyframe_problems(pairs)]
    for issue in found:
        report(issue)
    return pairs[0][1] if found else keyframes(pairs)


def _parse_keyframe(
    frame: object, path: str, report: Callable[[Issue], None]
) -> tuple[float, Transform]:
    """Time and transform of one keyframe."""
    if not isinstance(frame, Mapping) or "time" not in frame:
        report(Issue(path, f"must have a time and steps, got {show_value(frame)}"))
        return 0.0, IDENTITY
    keys = dict(frame)
    try:
        time = Interval().check(keys.pop("time"))
    except PydanticCustomError as error:
        report(Issue(f"{path}.time", error.message()))
        time = 0.0
    if "steps" in keys:
        if len(keys) > 1:
            report(Issue(f"{path}.steps", "must be alone with the time", about_key=True))
        steps, place = keys["steps"], f"{path}.steps"
        result = parse_transform(steps, lambda issue: report(issue.under(place)))
        if isinstance(result, Keyframes):
            report(Issue(place, "must be steps of a transform that rests, got keyframes"))
            result = IDENTITY
        return time, result
    unknown = [name for name in keys if name not in STEPS]
    alone = [name for name in keys if name not in IN_ORDER]
    for name in unknown:
        text = unknown_name("transform", name, (*STEPS, "steps"))
        report(Issue(f"{path}.{name}", text, about_key=True))
    if not unknown and alone and len(keys) > 1:
        report(Issue(f"{path}.{alone[0]}", "must be alone with the time", about_key=True))
    steps = [{name: keys[name]} for name in (*IN_ORDER, *alone) if name in keys and name in STEPS]
    return time, parse_transform(steps, lambda issue: report(_without_index(issue).under(path)))


def _without_index(issue: Issue) -> Issue:
    """The issue of a step in a keyframe, which is no list."""
    path = issue.path.partition("]")[2].lstrip(".") if issue.path.startswith("[") else issue.path
    return Issue(path, issue.message, issue.place, about_key=issue.about_key)


def _parse_step(step: object) -> Transform:
    if not isinstance(step, Mapping) or len(step) != 1:
        names = ", ".join(STEPS)
        text = f"each step must have exactly one of {names}, got {show_value(step)}"
        if isinstance(step, Mapping) and len(step) > 1:
            text += "; several steps are a list, in the order in which they are applied"
        raise SceneError([Issue("", text)])
    ((name, value),) = step.items()
    if name not in STEPS:
        raise SceneError([Issue(name, unknown_name("transform", name, STEPS), about_key=True)])
    spec = STEPS[name]
    nested = name in ("rotate", "look_at")
    if nested and not isinstance(value, Mapping):
        keys = ", ".join(spec.model_fields)
        raise SceneError([Issue(name, f"must have the keys {keys}, got {show_value(value)}")])
    prefix = name if nested else ""
    try:
        made = spec.__pydantic_validator__.validate_python(dict(value) if nested else dict(step))
    except ValidationError as error:
        raise SceneError([i.under(prefix) for i in translate(spec, error)]) from None
    return made.transform()


def dump_transform(transform: Transform) -> Any:
    """Write a transform as plain data that `parse_transform` reads back to the same bits."""
    if isinstance(transform, Keyframes):
        return {"keyframes": [_dump_keyframe(time, frame) for time, frame in transform.frames]}
    steps = transform.steps
    rebuilt = IDENTITY
    for step in steps:
        rebuilt = _parse_step({step.name: step.value}) @ rebuilt
    # A matrix that was multiplied in another grouping differs in its last bits: write it out.
    if rebuilt != transform:
        return {"matrix": transform.matrix.tolist()}
    data = [{step.name: _plain(step.value)} for step in steps]
    return data[0] if len(data) == 1 else data


def _dump_keyframe(time: float, frame: Transform) -> dict[str, Any]:
    data = dump_transform(frame)
    steps = data if isinstance(data, list) else [data]
    names = [name for step in steps for name in step]
    in_order = [name for name in IN_ORDER if name in names]
    if names == in_order or len(names) == 1:
        return {"time": time, **{name: value for step in steps for name, value in step.items()}}
    return {"time": time, "steps": data}


def _plain(value: Any) -> Any:
    """Turn the tuples of a step into lists."""
    if isinstance(value, Mapping):
        return {name: _plain(item) for name, item in value.items()}
    return [_plain(item) for item in value] if isinstance(value, tuple) else value
