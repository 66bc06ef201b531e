r"""Nodes and morph targets as an animation moves them at one time.

Between two keys :math:`t_k` and :math:`t_{k+1}`, with :math:`d = t_{k+1} - t_k` and
:math:`s = (t - t_k) / d`, values are constant (STEP), linear (LINEAR; rotations turn at an even
speed about one axis), or cubic (CUBICSPLINE):

.. math::
    v = (2s^3 - 3s^2 + 1)\, v_k + d\,(s^3 - 2s^2 + s)\, b_k
        + (3s^2 - 2s^3)\, v_{k+1} + d\,(s^3 - s^2)\, a_{k+1}

with the out-tangents b and the in-tangents a. Before the first key and after the last one, values
stay.

Source: Khronos Group, glTF 2.0 specification, section 3.11 and appendix C; Shoemake 1985, Animating
Rotation with Quaternion Curves.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from alight.core.errors import Issue, SceneError, quote
from alight.formats.gltf.accessors import read_accessor
from alight.formats.gltf.container import Document
from alight.formats.gltf.scenes import numbered
from alight.formats.gltf.values import Item
from alight.formats.reading.shown import Shown

Rows = NDArray[np.float64]
#: What a channel moves -> how many numbers that is; weights are as many as there are targets.
PATHS = {"translation": 3, "rotation": 4, "scale": 3, "weights": 0}
WAYS = ("LINEAR", "STEP", "CUBICSPLINE")


def pose(document: Document, shown: Shown) -> None:
    """Give nodes the transforms and weights that an animation has for them at a time.

    Parameters
    ----------
    document : Document
    shown : Shown
        `at` is the time in seconds; without it nothing moves. `animation` is its name or number,
        the first one by default.

    Raises
    ------
    SceneError
        If there is no such animation, or it is broken.
    """
    animations, report = document.list("animations"), document.report
    if animations:
        report.count("animations", len(animations))
    if shown.at is None:
        if shown.animation is not None:
            text = "says which animation --at SECONDS is a time of; give it, too"
            raise SceneError([Issue("--animation", text, document.root.name)])
        if animations:
            report.drop(
                f"animations ({len(animations)}): the scene is shown at rest; --at SECONDS shows "
                "it at a time"
            )
        return
    if not math.isfinite(shown.at):
        text = f"must be a number of seconds, got {shown.at}"
        raise SceneError([Issue("--at", text, document.root.name)])
    if not animations:
        asked = "--at" if shown.animation is None else "--animation"
        raise SceneError([Issue(asked, "the file has no animations", document.root.name)])
    index = 0
    if shown.animation is not None:
        name = shown.animation
        index = numbered(animations, name, "animation", "animation", document.root.name)
    others = ", ".join(
        quote(item.text("name") or str(number))
        for number, item in list(enumerate(animations))[:21]
        if number != index
    )
    if others:
        report.drop(f"other animations ({others}): --animation shows one of them")
    played, nodes = animations[index], document.list("nodes")
    samplers = played.objects("samplers")
    for channel in played.objects("channels"):
        _move(document, channel, samplers, nodes, shown.at)
    if report.issues:
        raise SceneError(report.issues)


def _move(
    document: Document, channel: Item, samplers: list[Item], nodes: list[Item], at: float
) -> None:
    """Give one node one of its values at a time."""
    target = channel.object("target")
    number = channel.index("sampler", len(samplers), "samplers")
    if target is None or number is None:
        raise channel.fatal("", "needs a target and a sampler")
    path = target.text("path")
    if path not in PATHS:
        document.report.approximate(
            f"{target.pointer}: an animation of {quote(path)} is left out  "
            f"(covered: {', '.join(PATHS)})"
        )
        return
    index = target.index("node", len(nodes), "nodes")
    if index is None:
        # The specification asks to leave these out.
        document.report.drop(f"{channel.pointer}: it moves no node")
        return
    node = nodes[index].value
    if "matrix" in node and path != "weights":
        text = f"{nodes[index].pointer}: it has a matrix, whose parts cannot be animated; it stays"
        document.report.approximate(text)
        return
    value = sampled(document, samplers[number], at, PATHS[path])
    node[path] = value.reshape(-1).tolist()


def sampled(document: Document, sampler: Item, at: float, columns: int) -> Rows:
    """The value of a sampler at a time.

    Parameters
    ----------
    at : float
        Seconds.
    columns : int
        Numbers of a value; 4 for quaternions, 0 for as many as there are.

    Returns
    -------
    (n,) float64
    """
    times = _table(document, sampler, "input")[:, 0]
    rows = _table(document, sampler, "output")
    way = sampler.text("interpolation", "LINEAR", WAYS)
    keys, parts = len(times), 3 if way == "CUBICSPLINE" else 1
    if (np.diff(times) <= 0.0).any():
        raise sampler.fatal("input", "must hold times that grow")
    if columns and rows.shape[1] != columns:
        text = f"must have rows of {columns} numbers, got {rows.shape[1]}"
        raise sampler.fatal("output", text)
    if rows.size % (keys * parts) or (columns and rows.size != keys * parts * columns):
        raise sampler.fatal("output", f"must hold {parts} values for each of {keys} times")
    values = rows.reshape(keys, parts, -1)
    # Keys are stored in single precision: 0.1 means the key that is written as 0.1.
    at = float(np.float32(at))
    before = int(np.clip(np.searchsorted(times, at, "right") - 1, 0, keys - 1))
    after = min(before + 1, keys - 1)
    length = float(times[after] - times[before])
    share = float(np.clip((at - times[before]) / length, 0.0, 1.0)) if length > 0.0 else 0.0
    if way == "STEP" and share < 1.0:
        return values[before, 0]
    if way == "CUBICSPLINE":
        return _spline(values, before, after, length, share)
    first, second = values[before, 0], values[after, 0]
    return _turned(first, second, share) if columns == 4 else first + share * (second - first)


def _spline(values: Rows, before: int, after: int, length: float, s: float) -> Rows:
    first, leaving = values[before, 1], values[before, 2]
    arriving, second = values[after, 0], values[after, 1]
    return (
        (2 * s**3 - 3 * s**2 + 1) * first
        + length * (s**3 - 2 * s**2 + s) * leaving
        + (3 * s**2 - 2 * s**3) * second
        + length * (s**3 - s**2) * arriving
    )


def _turned(first: Rows, second: Rows, share: float) -> Rows:
    """Between two unit quaternions, along the shorter arc."""
    cosine = float(first @ second)
    if cosine < 0.0:
        second, cosine = -second, -cosine
    angle = math.acos(min(cosine, 1.0))
    if angle < 1e-6:
        return first + share * (second - first)
    a, b = math.sin((1.0 - share) * angle), math.sin(share * angle)
    return (a * first + b * second) / math.sin(angle)


def _table(document: Document, sampler: Item, key: str) -> Rows:
    index = sampler.index(key, len(document.list("accessors")), "accessors")
    if index is None:
        raise sampler.fatal(key, "must be the index of an accessor")
    table: Any = read_accessor(document, index).astype(np.float64)
    if not np.isfinite(table).all():
        raise sampler.fatal(key, "must hold finite numbers")
    return table
