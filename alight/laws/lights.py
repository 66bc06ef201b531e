"""Laws of lights that rays cannot hit: one direction, the inverse square, the declared power.

Each law is a function of an example and raises `BrokenLawError`. (Lights that rays can hit are
tested with their shapes and maps, by the density of what is hit.)
"""

from __future__ import annotations

import numpy as np

from alight.compiled.scene import CompiledScene, compile_scene
from alight.core.registry import Models
from alight.core.spec import Light
from alight.core.vec import Vec3, luminance
from alight.laws.materials import stacked
from alight.laws.report import demand, demand_close
from alight.laws.statistics import SphereCells, length_error, unit_vectors
from alight.lights.sampling import sample_light
from alight.scene import Node, Scene, flatten
from alight.scene.transform import rotate, translate
from alight.shapes.sphere import Sphere
from lanewise.jit import instantiate, kernel
from lanewise.simd import LANES, lanes, lanes_mask, load_lanes, store_lanes
from lanewise.view import View

#: Position and orientation of the light.
PLACE = (0.3, -0.2, 0.5)
N = 4096
CELLS = SphereCells(side=16)


def scene_of(spec: Light) -> CompiledScene:
    """A scene with this light and a sphere far away."""
    turned = rotate("y", 40) @ rotate("x", 25)
    nodes = {
        "light": Node(light=spec, transform=translate(*PLACE) @ turned),
        "far": Node(shape=Sphere(), transform=translate(0, 0, 1000)),
    }
    camera = Node(camera=Models("cameras")["pinhole"].EXAMPLES[0])
    return compile_scene(flatten(Scene(nodes=nodes, camera=camera)), structure="list")


def light_at(spec: Light, points: np.ndarray):
    """`LightSample` at points (3, n)."""
    n = points.shape[1]
    scene = scene_of(spec)
    rng = np.random.default_rng(1)
    u = rng.random((3, n), np.float32)
    p = Vec3(*np.ascontiguousarray(points, np.float32))
    sample = instantiate(sample_light, scene.program, compiled=False)
    with np.errstate(all="ignore"):
        return sample(scene.tables, p, p, u[0], (u[1], u[2]), np.ones(n, bool))


def _around(distance: float) -> np.ndarray:
    return np.reshape(PLACE, (3, 1)) + distance * unit_vectors(N, 3)


def samples_are_directions_with_light(spec: Light) -> None:
    """Samples are unit directions, with finite radiance and the density of a delta light."""
    light = light_at(spec, _around(3.0))
    wi, radiance = stacked(light.wi, N), stacked(light.radiance, N)
    pdf = np.broadcast_to(light.pdf, N)
    demand(length_error(wi[:, pdf > 0.0]) < 1e-6 if (pdf > 0.0).any() else True, "wi is not unit")
    demand(np.isfinite(radiance) & (radiance >= 0.0), "radiance is negative or not finite")
    demand(np.isin(pdf, (0.0, 1.0)), "the pdf of a delta light must be 1, or 0 where it is dark")
    demand(light.delta, "delta must be true")
    demand(np.broadcast_to(light.distance, N) > 0.0, "the distance must be > 0")


def light_comes_from_its_place(spec: Light) -> None:
    """All samples point to the place of the node, and fall off with the distance squared."""
    near, far = _around(2.0), _around(4.0)
    here, there = light_at(spec, near), light_at(spec, far)
    distance = np.broadcast_to(here.distance, N)
    lit = np.broadcast_to(here.pdf, N) > 0.0
    if not lit.any() or not np.isfinite(distance).all():
        return
    place = near + stacked(here.wi, N) * distance
    wanted = np.broadcast_to(np.reshape(PLACE, (3, 1)), place.shape)
    demand_close(place[:, lit], wanted[:, lit], "where samples point", atol=1e-5)
    a, b = stacked(here.radiance, N), 4.0 * stacked(there.radiance, N)
    demand_close(a, b, "four times the light at twice the distance", rtol=1e-3, atol=1e-5)


def power_is_the_integral(spec: Light) -> None:
    """`power` is the integral of the intensity over all directions."""
    module = Models("lights")[spec.type_name()]
    points = np.reshape(PLACE, (3, 1)) + CELLS.points
    light = light_at(spec, points)
    n = points.shape[1]
    if not np.isfinite(np.broadcast_to(light.distance, n)).all():
        return
    found = CELLS.integrals(luminance(Vec3(*stacked(light.radiance, n)))).sum()
    mean_color = getattr(module, "mean_color", None)
    color = mean_color(spec) if mean_color else module.place(spec, np.eye(4))[0]
    declared = module.power(float(luminance(Vec3(*color))), 0.0, 1.0)
    demand_close(declared, found, "declared power against the integral", rtol=5e-3, atol=1e-6)


@kernel
def light_of_points(scene, points, u, out, n):
    """Direction, distance, radiance and density at n points."""
    for i in range(0, n, LANES):
        p = Vec3(load_lanes(points, i), load_lanes(points, i + n), load_lanes(points, i + 2 * n))
        u2 = load_lanes(u, i + n), load_lanes(u, i + 2 * n)
        s = sample_light(scene, p, p, load_lanes(u, i), u2, lanes_mask(True))
        store_lanes(out, i, s.wi.x)
        store_lanes(out, i + n, s.wi.y)
        store_lanes(out, i + 2 * n, s.wi.z)
        store_lanes(out, i + 3 * n, lanes(0.0) + s.distance)
        store_lanes(out, i + 4 * n, s.radiance.x)
        store_lanes(out, i + 5 * n, s.radiance.y)
        store_lanes(out, i + 6 * n, s.radiance.z)
        store_lanes(out, i + 7 * n, lanes(0.0) + s.pdf)


def compiled_light_is_the_twins(spec: Light) -> None:
    """Machine code gives the light of the Python text."""
    scene = scene_of(spec)
    points = np.ascontiguousarray(_around(3.0), np.float32)
    u = np.random.default_rng(2).random((3, N), np.float32)
    found = []
    for compiled in (True, False):
        out = View(np.zeros((8, N), np.float32))
        run = instantiate(light_of_points, scene.program, compiled=compiled)
        with np.errstate(all="ignore"):
            run(scene.tables, View(points), View(u), out, N)
        found.append(out.shaped)
    with np.errstate(invalid="ignore"):
        both = np.where(np.isinf(found[0]) & np.isinf(found[1]), 0.0, found)
    demand_close(both[0], both[1], "compiled against Python", rtol=1e-3, atol=1e-4)


LAWS = (samples_are_directions_with_light, light_comes_from_its_place, power_is_the_integral)
COMPILED_LAWS = (compiled_light_is_the_twins,)
