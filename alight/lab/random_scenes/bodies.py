"""Shapes of any registered kind, brought into the cube from -1 to 1."""

from __future__ import annotations

from typing import Any

import numpy as np

from alight.core.registry import Models as Registry
from alight.core.spec import Shape
from alight.lab.random_scenes.chance import Chance
from alight.lab.random_scenes.descriptions import of_model
from alight.lab.random_scenes.meshes import any_mesh
from alight.scene.transform import Transform, scale, translate
from alight.shapes.mesh import Mesh
from alight.shapes.model import SHAPES

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
    low, high = extent(shape)
    center = [float(f"{-c:.6g}") + 0.0 for c in 0.5 * (low + high)]
    factor = 2.0 / max(float((high - low).max()), 1e-12)
    fitted = scale(float(f"{factor:.6g}"))
    return shape, fitted @ translate(*center) if any(center) else fitted


def extent(shape: Shape) -> tuple[np.ndarray, np.ndarray]:
    """Corners of a box around a shape, in its own space."""
    fields: Any = shape
    if isinstance(shape, Mesh):
        vertices = np.asarray(shape.vertices, float)
        return vertices.min(axis=0), vertices.max(axis=0)
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
