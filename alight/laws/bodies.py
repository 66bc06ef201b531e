"""Shapes as the laws look at them: one that shines, under affine maps, met by rays."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial, wraps
from typing import Any

import numpy as np

from alight.accel import intersect_closest
from alight.cameras import MODELS as CAMERAS
from alight.compiled.scene import compile_scene
from alight.compiled.shapes import compile_shapes
from alight.core.spec import Shape
from alight.laws.remembered import remembered
from alight.laws.report import BrokenLawError
from alight.laws.statistics import UNIT, unit_vectors
from alight.lights.model import LIGHTS
from alight.scene import Node, Scene, flatten
from alight.scene.transform import Transform, matrix, rotate, scale, translate
from alight.shapes.hit import Hit
from alight.shapes.surfaces import make_surface
from lanewise.jit import instantiate
from lanewise.vec3 import Vec3

#: Affine maps that keep, move and turn, stretch and mirror, and slant.
PLACEMENTS: dict[str, Transform] = {
    "as it is": scale(1.0),
    "turned": translate(1, -2, 0.5) @ rotate((1, 2, 3), 40) @ scale(0.7),
    "mirrored": rotate((1, 0, 2), 25) @ scale(-0.5, 2.0, 1.3),
    "slanted": matrix([[1, 0.6, -0.2, 0.1], [0, 0.8, 0.5, 0.3], [0.2, 0, 1.1, -0.4], [0, 0, 0, 1]]),
}
#: Lines, and samples.
N = 20_000
#: Error of a hit, relative to the ray's origin and length: 16 operations in a row, which take the
#: ray to the shape's space, find the root, and bring the point back.
HIT = 16 * UNIT


def scene_of(nodes: dict[str, Node]) -> Scene:
    """A scene of these nodes, with a camera and an environment."""
    sky = next(light for light in LIGHTS.values() if light.is_around).EXAMPLES[0]
    return Scene(nodes=nodes, camera=Node(camera=CAMERAS[0].EXAMPLES[0]), environment=sky)


class Body:
    """One shape that shines, alone in the world or among others, by the text of the kernels.

    Parameters
    ----------
    spec : Shape
    placement : Transform
    **others : Node

    Attributes
    ----------
    to_world : (4, 4) float64
    low, high : (3,) float64, metres
        Its box.
    center, radius : (3,) float64 and float, metres
        A sphere around that.
    """

    def __init__(self, spec: Shape, placement: Transform, **others: Node):
        lamp = next(light for light in LIGHTS.values() if light.is_on_shape).EXAMPLES[0]
        light = lamp if spec.finite else None
        body = Node(shape=spec, transform=placement, light=light)
        flat = flatten(scene_of({"body": body, **others}))
        compiled = compile_scene(flat, structure="list")
        shapes = compile_shapes(flat)
        # All that surfaces know of themselves.
        self.program = compiled.program._replace(
            aovs=("uv",), bsdfs=(*compiled.program.bsdfs, "anisotropic")
        )
        self.scene = compiled.tables
        self.spec, self.shapes, self.to_world = spec, shapes, placement.matrix
        corners = [np.array([low, high], float) for _, low, high in shapes.boxes()]
        corners += [shapes.triangles.vertices.astype(float)] if len(shapes.triangles.faces) else []
        # What is infinite is looked at near its node.
        points = np.concatenate(corners or [placement.matrix[:3, 3] + [[-3.0], [3.0]]])
        self.low, self.high = points.min(axis=0), points.max(axis=0)
        self.center = 0.5 * (self.low + self.high)
        self.radius = 0.5 * float(np.linalg.norm(self.high - self.low))

    def run(self, kernel: Callable, *arguments: Any) -> Any:
        """A kernel on lanes of NumPy."""
        with np.errstate(all="ignore"):
            return instantiate(kernel, self.program, compiled=False)(*arguments)

    def hit(self, o: np.ndarray, d: np.ndarray, active: np.ndarray) -> tuple[Hit, Any]:
        """Nearest hits of rays (3, n), and the surfaces there."""
        hit = nearest_hits(partial(self.run, intersect_closest, self.scene), o, d, active)
        found = np.isfinite(hit.t)
        there = hit._replace(t=np.where(found, hit.t, np.float32(1.0)))
        return hit, self.run(make_surface, self.scene, there, vec_of(o), vec_of(d), found)

    def lines(self, seed: int) -> tuple[np.ndarray, np.ndarray]:
        """Uniform random lines through the sphere around it, from outside: origins, directions."""
        d = unit_vectors(N, seed).astype(np.float64)
        across = np.cross(d, unit_vectors(N, seed + 100), axis=0)
        across /= np.linalg.norm(across, axis=0)
        r = self.radius * np.sqrt(np.random.default_rng(seed).random(N))
        middle = self.center[:, None] + r * across
        o = middle - 1.5 * self.radius * d
        return np.ascontiguousarray(o, np.float32), np.ascontiguousarray(d, np.float32)


def nearest_hits(search: Callable, o: np.ndarray, d: np.ndarray, active: np.ndarray) -> Hit:
    """Nearest hits of rays (3, n), by ``search(o, d, t_max, active)``; only active ones are traced.

    What lanes of NumPy do takes as long for those that are not active.
    """
    n, rays = o.shape[1], np.flatnonzero(active)
    none, number = np.zeros(n, np.float32), np.zeros(n, np.uint32)
    hit = Hit(none + np.float32(np.inf), none, none.copy(), number, number.copy())
    if rays.size:
        far, all_of_them = np.full(rays.size, np.inf, np.float32), np.ones(rays.size, bool)
        for whole, part in zip(
            hit, search(vec_of(o[:, rays]), vec_of(d[:, rays]), far, all_of_them), strict=True
        ):
            whole[rays] = part
    return hit


def margin_of(body: Body, o: np.ndarray) -> float:
    """Error of hits by rays from o (3, n), in m."""
    return HIT * float(np.linalg.norm(o.astype(float), axis=0).max() + 6.0 * body.radius)


def vec_of(v: np.ndarray) -> Vec3:
    """Rows (3, n) as lanes."""
    return Vec3(*np.ascontiguousarray(v, np.float32))


def rows_of(v: Any, n: int) -> np.ndarray:
    """Lanes as rows (3, n) of float64."""
    return np.stack([np.broadcast_to(c, n) for c in (v.x, v.y, v.z)]).astype(np.float64)


@remembered(8)
def body_of(spec: Shape, placement: str) -> Body:
    """The example under one of `PLACEMENTS`."""
    return Body(spec, PLACEMENTS[placement])


def placed_everywhere(law: Callable[[Body], None]) -> Callable[[Shape], None]:
    """A law of an example from one of it where it is placed."""

    @wraps(law)
    def judged(spec: Shape) -> None:
        for name in PLACEMENTS:
            try:
                law(body_of(spec, name))
            except BrokenLawError as error:
                raise BrokenLawError(f"{name}: {error}") from None

    return judged
