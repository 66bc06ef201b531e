"""Shapes of any registered kind, brought into the cube from -1 to 1."""

from __future__ import annotations

from typing import Any

import numpy as np

from alight.core.registry import Models as Registry
from alight.core.registry import specs_of
from alight.core.spec import Shape
from alight.lab.random_scenes.chance import Chance
from alight.lab.random_scenes.descriptions import of_model
from alight.lab.random_scenes.meshes import any_mesh, closed_mesh
from alight.scene.transform import Transform, scale, translate
from alight.shapes.mesh import Mesh
from alight.shapes.model import SHAPES
from alight.shapes.strands import DEGREE, STEP, StrandShape

#: Solid bodies are seen more often than flat ones.
_OFTEN = ("sphere", "mesh", "mesh", "cube")


def finite_shapes() -> list[str]:
    """Names of the registered shapes that have an end, and a far side: they may bound media."""
    return [name for name, model in SHAPES.items() if model.spec.finite and not model.is_many]


def any_body(chance: Chance, names: list[str] | None = None) -> tuple[Shape, Transform]:
    """A shape, and the transform that brings it into the cube from -1 to 1."""
    name = chance.choose(names or [*finite_shapes(), *_OFTEN])
    if name == "mesh":
        shape: Any = any_mesh(chance)
    else:
        shape = of_model(chance, Registry("shapes")[name])
    # Inside out only now and then: closed bodies are black then, or filled with the outer medium.
    shape = shape.replaced(flip_normals=chance.happens(0.05))
    return shape, _into_the_cube(shape)


def closed_body(chance: Chance) -> tuple[Shape, Transform]:
    """As `any_body`: a shape without holes, which faces outwards."""
    names = [name for name in finite_shapes() if specs_of(Shape)[name].closed]
    name = chance.choose([*names, "mesh"])
    if name == "mesh":
        shape: Any = closed_mesh(chance)
    else:
        shape = of_model(chance, Registry("shapes")[name]).replaced(flip_normals=False)
    return shape, _into_the_cube(shape)


def strands(chance: Chance) -> tuple[Shape, Transform]:
    """As `any_body`: a tuft of strands on the ground, or a few that wind about each other."""
    kinds = [spec for spec in specs_of(Shape).values() if issubclass(spec, StrandShape)]
    basis = chance.choose(tuple(DEGREE))
    count = round(chance.scaled(1.0, 40.0))
    length = DEGREE[basis] + STEP[basis] * chance.whole(1, 3) + 1
    # From points on the ground upwards, each less straight than the last.
    lean = chance.within(0.0, 1.0)
    steps = chance.numbers(count, length, 3) - 0.5
    steps[:, 0] *= (2.0, 0.0, 2.0)
    steps[:, 1:] = lean * steps[:, 1:] + (0.0, 2.0 / length, 0.0)
    thick = chance.scaled(0.005, 0.12)
    taper = np.linspace(1.0, chance.choose((0.0, 0.3, 1.0)), length)
    shape = chance.choose(kinds)(
        points=np.round(np.cumsum(steps, axis=1), 4).reshape(-1, 3),
        radii=np.round(np.tile(thick * taper, count), 5),
        counts=np.full(count, length),
        basis=basis,
    )
    return shape, _into_the_cube(shape)


def _into_the_cube(shape: Shape) -> Transform:
    """What brings a shape into the cube from -1 to 1."""
    low, high = extent(shape)
    center = [float(f"{-c:.6g}") + 0.0 for c in 0.5 * (low + high)]
    factor = 2.0 / max(float((high - low).max()), 1e-12)
    fitted = scale(float(f"{factor:.6g}"))
    return fitted @ translate(*center) if any(center) else fitted


def extent(shape: Shape) -> tuple[np.ndarray, np.ndarray]:
    """Corners of a box around a shape, in its own space."""
    fields: Any = shape
    if isinstance(shape, Mesh):
        vertices = np.asarray(shape.vertices, float)
        return vertices.min(axis=0), vertices.max(axis=0)
    if isinstance(shape, StrandShape):
        points, radius = np.asarray(shape.points, float), float(np.asarray(shape.radii).max())
        return points.min(axis=0) - radius, points.max(axis=0) + radius
    if hasattr(shape, "center"):
        center = np.array(fields.center)
        return center - fields.radius, center + fields.radius
    if hasattr(shape, "p0"):
        ends = np.array([fields.p0, fields.p1])
        return ends.min(axis=0) - fields.radius, ends.max(axis=0) + fields.radius
    boxes = [_box(*part) for part in shape.parts() or ((shape, np.eye(4)),)]
    return np.min(boxes, axis=0)[0], np.max(boxes, axis=0)[1]


def _box(shape: Shape, matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corners of the box of a shape with a formula, without what they leave for rounding."""
    model = SHAPES[shape.type_name()]
    assert model.pack is not None and model.bounds is not None
    low, high = model.bounds(model.pack(shape, matrix))
    return _rounded(low), _rounded(high)


def _rounded(v: np.ndarray) -> np.ndarray:
    return np.array([float(f"{x:.5g}") for x in v])
