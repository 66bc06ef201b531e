"""Transforms as they are written in scene files: one step or a list of steps.

    transform: {translate: [0, 1, 0]}
    transform: [{scale: 2}, {rotate: {axis: y, angle: 30}}, {translate: [0, 1, 0]}]

A list is applied from left to right, so this one is M = T R S.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator, ValidationError

from alight.core.errors import Issue, SceneError, show_value, unknown_name
from alight.core.spec import Degrees, Interval, Numbers, Spec, Triple, Vector3, invalid, translate
from alight.scene import transform as make
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


def parse_transform(data: object, report: Callable[[Issue], None]) -> Transform:
    """Build a transform from plain data.

    Parameters
    ----------
    data : mapping or list of mappings
        Steps, each with the name of one operation.
    report : callable
        Receives an issue, with a path relative to `data`, for each step that is wrong.

    Returns
    -------
    Transform
        The product of the steps that are right.
    """
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


def _parse_step(step: object) -> Transform:
    if not isinstance(step, Mapping) or len(step) != 1:
        names = ", ".join(STEPS)
        text = f"each step must have exactly one of {names}, got {show_value(step)}"
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
    steps = transform.steps
    rebuilt = IDENTITY
    for step in steps:
        rebuilt = _parse_step({step.name: step.value}) @ rebuilt
    # A matrix that was multiplied in another grouping differs in its last bits: write it out.
    if rebuilt != transform:
        return {"matrix": transform.matrix.tolist()}
    data = [{step.name: _plain(step.value)} for step in steps]
    return data[0] if len(data) == 1 else data


def _plain(value: Any) -> Any:
    """Turn the tuples of a step into lists."""
    if isinstance(value, Mapping):
        return {name: _plain(item) for name, item in value.items()}
    return [_plain(item) for item in value] if isinstance(value, tuple) else value
