"""Looking at the kernels of the NumPy twin while they run: calls, arguments, results.

Nothing is computed here a second time. The twin's kernels are the text that the compiled renderer
runs; an `Observer` puts itself between them (`lanewise.jit.instantiate`, ``observe``) and notes
what happens in one lane.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from alight.accel.lists import search_triangles
from alight.shapes.hit import Hit
from alight.shapes.triangle import rotated, shear_of, sheared_hit
from lanewise.jit import Specialised
from lanewise.vec3 import Vec3

#: Triangles that are tested at once: a few arrays of this length are held at a time.
BATCH = 1 << 18

#: Arguments that are the same for all calls.
_UNIFORM = {"scene", "settings", "tile", "film", "accel", "data"}


@dataclass
class Event:
    """One call of an observed kernel.

    Attributes
    ----------
    name : str
    arguments : dict of str to value
        What the lane was given: floats, whole numbers, truth values, triples and named tuples.
    result : value
        What it got.
    inner : list of Event
        Calls made before it returned.
    """

    name: str
    arguments: dict[str, Any]
    result: Any = None
    inner: list[Event] = field(default_factory=list)

    def calls(self, name: str) -> list[Event]:
        """Those of the inner calls that were of one kernel, in their order."""
        return [event for event in self.inner if event.name == name]


class Observer:
    """Notes calls of kernels; give it to `instantiate` as ``observe``.

    Parameters
    ----------
    kernels : mapping of str to kernel
        Which to watch, by the names that events shall have.
    names : iterable of str
        Further kernels by the names of their functions, for those that are written for a program.
    lane : int, default 0
        Which lane to look at.

    Attributes
    ----------
    events : list of Event
        Outermost calls.
    """

    def __init__(
        self, kernels: Mapping[str, Any], names: Iterable[str] = (), lane: int = 0
    ) -> None:
        self.events: list[Event] = []
        self.lane = lane
        self._watched = {id(kernel): name for name, kernel in kernels.items()}
        self._names = set(names)
        self._open: list[Event] = []

    def __call__(self, node: Any, function: Callable) -> Callable:
        """What is called instead of a kernel."""
        if node is search_triangles:
            return search_all_triangles
        name = self._watched.get(id(node))
        if name is None and not isinstance(node, Specialised) and node.__name__ in self._names:
            name = node.__name__
        return function if name is None else self._noting(name, function)

    def _noting(self, name: str, function: Callable) -> Callable:
        parameters = list(inspect.signature(function).parameters)

        @functools.wraps(function)
        def noted(*arguments: Any) -> Any:
            given = {
                key: lane_of(value, self.lane)
                for key, value in zip(parameters, arguments, strict=True)
                if key not in _UNIFORM
            }
            event = Event(name, given)
            (self._open[-1].inner if self._open else self.events).append(event)
            self._open.append(event)
            try:
                result = function(*arguments)
            finally:
                self._open.pop()
            event.result = lane_of(result, self.lane)
            return result

        return noted


def lane_of(value: Any, lane: int) -> Any:
    """One lane of a value of the twin, in plain Python numbers."""
    if isinstance(value, Vec3):
        return tuple(lane_of(part, lane) for part in (value.x, value.y, value.z))
    if isinstance(value, np.ndarray):
        return value.reshape(-1)[lane if value.size > 1 else 0].item()
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, tuple):
        parts = [lane_of(part, lane) for part in value]
        return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
    return value


def lanes_of(value: Any, n: int) -> Any:
    """The same value in n lanes of the twin, as kernels take it: the inverse of `lane_of`."""
    if isinstance(value, tuple):
        parts = [lanes_of(part, n) for part in value]
        if hasattr(value, "_fields"):
            return type(value)(*parts)
        # Vectors have become triples; what a scene does not have is an empty tuple.
        return Vec3(*parts) if len(parts) == 3 else tuple(parts)
    kind = np.bool_ if isinstance(value, bool) else np.uint32 if isinstance(value, int) else None
    return np.full(n, value, kind or np.float32)


# ---------------------------------------------------------------- all triangles at once


def search_all_triangles(accel: Any, data: Any, o: Vec3, d: Vec3, best: Hit, nearest: bool) -> Hit:
    """`search_triangles`, one lane after the other against arrays of triangles.

    The loop over triangles is Python's in the twin, far too slow for a mesh. The test itself works
    elementwise on many triangles as well as on many rays, with the same rounding.
    """
    fields = [np.array(np.broadcast_to(part, np.shape(best.t))) for part in best]
    ids = accel.triangle_ids.array.reshape(-1, 2)
    for lane in np.flatnonzero(fields[0] > 0.0):
        for first, (t, u, v, inside) in _tests(accel, o, d, lane):
            met = inside & (t > 0.0)
            if not nearest:
                if np.any(met & (t <= fields[0][lane])):
                    fields[0][lane] = -1.0
                    break
                continue
            t = np.where(met, t, np.inf)
            k = int(np.argmin(t))
            shape, prim = ids[first + k]
            earlier = t[k] == fields[0][lane] and shape < fields[3][lane]
            if np.isfinite(t[k]) and (t[k] < fields[0][lane] or earlier):
                for part, value in zip(fields, (t[k], u[k], v[k], shape, prim), strict=True):
                    part[lane] = value
    return Hit(*fields)


def _tests(accel: Any, o: Vec3, d: Vec3, lane: int) -> Iterator[tuple[int, Any]]:
    """`sheared_hit` of one lane's ray with all triangles, in batches: (first, result)."""
    shear = shear_of(_ray_part(d, lane))
    origin = rotated(_ray_part(o, lane), shear)
    axes = [int(axis) for axis in shear[:3]]
    corners = accel.triangles.array[:-1].reshape(-1, 3, 3)
    for first in range(0, len(corners), BATCH):
        batch = corners[first : first + BATCH]
        a, b, c = (Vec3(*(batch[:, k, axis] for axis in axes)) - origin for k in range(3))
        yield first, sheared_hit(a, b, c, shear)


def _ray_part(v: Vec3, lane: int) -> Vec3:
    parts = (np.broadcast_to(part, (max(np.size(part), lane + 1),)) for part in (v.x, v.y, v.z))
    return Vec3(*(np.float32(part[lane]) for part in parts))
