"""``<transform>`` -> steps of the native format, in the order of the file.

Mitsuba's cameras and ``lookat`` look along their +z, ours along -z. The two differ by half a turn
about y, after which x, which points to the left in Mitsuba's pictures, points to the right.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from alight.core.errors import SceneError, unknown_name
from alight.formats.mitsuba.properties import Properties, coordinates
from alight.formats.reading.numbers import NotNumbersError, parse_number, parse_numbers
from alight.formats.reading.report import Report
from alight.formats.reading.xml import Element
from alight.scene.steps import parse_transform

Step = dict[str, Any]

HALF_TURN: Step = {"rotate": {"axis": "y", "angle": 180.0}}
MOST_STEPS = 200
_KINDS = ("translate", "rotate", "scale", "lookat", "matrix")
# A rotation's axis may be rounded in the file.
_ROUNDING = 1e-4


def steps_of(properties: Properties, name: str = "to_world") -> list[Step]:
    """Ask an object for a transform.

    Returns
    -------
    list of dict
        As `alight.scene.steps.parse_transform` reads them, without those that are wrong.
    """
    element = properties.find(name)
    report = properties.report
    if element is None:
        return []
    if element.tag == "animation":
        text = "is not covered: shapes, instances and sensors move, this stays"
        report.not_covered(element, text, "the first keyframe is taken")
        return _keyframes(element, report)[0][1]
    return _steps_in(element, report)


def motion_of(properties: Properties, of_camera: bool = False) -> tuple[list[Step], Any]:
    """Ask an object that can move for its transform.

    Parameters
    ----------
    properties : Properties
    of_camera : bool, default False
        Whether it looks along the axis of Mitsuba's cameras, see `camera_steps`.

    Returns
    -------
    steps : list of dict
        As of `steps_of`; of what moves the first ones.
    transform : list or dict
        The native transform.
    """
    element = properties.find("animation" if properties.has("animation") else "to_world")
    if element is None or element.tag != "animation":
        steps = steps_of(properties)
        return steps, camera_steps(steps) if of_camera else steps
    frames = _keyframes(element, properties.report)
    keyframes = [
        {"time": time, "steps": camera_steps(steps) if of_camera else steps}
        for time, steps in frames
    ]
    return frames[0][1], {"keyframes": keyframes}


def _keyframes(element: Element, report: Report) -> list[tuple[float, list[Step]]]:
    """Times and steps of an ``<animation>`` of Mitsuba 0.6."""
    result: list[tuple[float, list[Step]]] = []
    for child in element.children:
        if child.tag != "transform" or "time" not in child:
            report.error(child, f"must be a <transform time=...>, got {child.label}")
            continue
        try:
            time = parse_number(child.attributes["time"])
        except NotNumbersError as error:
            report.error(child, str(error))
            continue
        if result and time <= result[-1][0]:
            text = f"must be later than the one before, {result[-1][0]:g}, got {time:g}"
            report.error(child, text)
            continue
        result.append((time, _steps_in(child, report)))
    if not result:
        report.error(element, "has no keyframe")
    return result or [(0.0, [])]


def _steps_in(element: Element, report: Report) -> list[Step]:
    if element.tag != "transform":
        report.error(element, f"must be given as <transform>, got <{element.tag}>")
        return []
    if len(element.children) > MOST_STEPS:
        report.error(element, f"must have at most {MOST_STEPS} steps, got {len(element.children)}")
        return []
    result = []
    for child in element.children:
        try:
            steps = _steps(child, report)
            _check(steps)
            result += steps
        except NotNumbersError as error:
            report.error(child, str(error))
        except SceneError as error:
            report.errors_of(child, error)
    return result


def camera_steps(steps: list[Step]) -> list[Step]:
    """Turn a camera of Mitsuba around."""
    return steps[1:] if steps and steps[0] == HALF_TURN else [HALF_TURN, *steps]


def matrix_of(steps: list[Step]) -> np.ndarray:
    """Multiply steps to one matrix, (4, 4) float64."""
    return parse_transform(steps, lambda issue: None).matrix


def is_mirrored(steps: list[Step]) -> bool:
    """Whether steps turn a right hand into a left one."""
    return bool(np.linalg.det(matrix_of(steps)[:3, :3]) < 0.0)


def _check(steps: list[Step]) -> None:
    problems = []
    parse_transform(steps, problems.append)
    if problems:
        raise SceneError([problem.under("") for problem in problems])


def _steps(element: Element, report: Report) -> list[Step]:
    kind = element.tag
    if kind == "translate":
        return [{"translate": coordinates(element, 0.0)}]
    if kind == "scale":
        factors = coordinates(element, 1.0)
        return [{"scale": factors[0] if len(set(factors)) == 1 else factors}]
    if kind == "rotate":
        return [_rotate(element, report)]
    if kind == "lookat":
        return [HALF_TURN, {"look_at": _look_at(element)}]
    if kind == "matrix":
        return [{"matrix": _matrix(element)}]
    raise NotNumbersError(unknown_name("transform", kind, _KINDS, listed_as="transforms"))


def _rotate(element: Element, report: Report) -> Step:
    axis = coordinates(element, 0.0)
    if "angle" not in element:
        raise NotNumbersError("needs the attribute angle")
    if not any(axis) and parse_number(element.attributes["angle"]) == 0.0:
        # Templates have it; no turn about no axis.
        return {"translate": [0.0] * 3}
    length = float(np.linalg.norm(axis))
    if abs(length - 1.0) > _ROUNDING:
        report.warn(element, f"has an axis of length {length:g}, taken as a direction")
    return {"rotate": {"axis": axis, "angle": parse_number(element.attributes["angle"])}}


def _look_at(element: Element) -> dict[str, list[float]]:
    points = {}
    for name in ("origin", "target"):
        if name not in element:
            raise NotNumbersError(f"needs the attribute {name}")
        points[name] = parse_numbers(element.attributes[name], 3)
    if "up" in element and any(parse_numbers(element.attributes["up"], 3)):
        points["up"] = parse_numbers(element.attributes["up"], 3)
        return points
    # Mitsuba builds a frame around the view here; any that does not depend on rounding will do.
    points["up"] = _any_up(np.subtract(points["target"], points["origin"]))
    return points


def _any_up(view: np.ndarray) -> list[float]:
    """Mitsuba's choice without ``up``: the first axis of the frame of Duff et al. 2017."""
    length = float(np.linalg.norm(view))
    if length == 0.0:
        return [0.0, 1.0, 0.0]
    x, y, z = (float(component) for component in view / length)
    sign = 1.0 if z >= 0.0 else -1.0
    a = -1.0 / (sign + z)
    return [1.0 + sign * x * x * a, sign * x * y * a, -sign * x]


def _matrix(element: Element) -> list[list[float]]:
    if "value" not in element:
        raise NotNumbersError("needs the attribute value")
    numbers = np.array(parse_numbers(element.attributes["value"], 9, 16))
    if numbers.size == 16:
        return numbers.reshape(4, 4).tolist()
    result = np.eye(4)
    result[:3, :3] = numbers.reshape(3, 3)
    return result.tolist()
