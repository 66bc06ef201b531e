"""Moving lights in the light tree: their bounds over the whole way, densities and means."""

import numpy as np
import pytest

from alight.compiled.light_tree import find_leaves
from alight.compiled.lights import _rows
from alight.compiled.motion import MotionTable
from alight.compiled.shapes import compile_shapes
from alight.formats import loads
from alight.lights.model import LIGHTS
from alight.lights.sampling import sample_light
from alight.lights.tables import INFO
from alight.lights.tree.traversal import FAR_FROM_ALL, choose_by_tree, mis_probability
from alight.scene import flatten, keyframes, rotate, translate
from alight.scene.motion import NOWHERE
from lanewise.vec3 import Vec3
from tests.motion.moving import compiled
from tests.motion.test_kernels import seen, twin_of
from tests.sampling.statistics import LARGEST_Z, SIGNIFICANCE, chi_square

#: Lamps near a floor that shift, turn away from it and towards it, and some that rest.
LAMPS = """
alight: 1
film: {size: [8, 8]}
sampler: independent
integrator: {type: path, max_depth: 2, light_choice: %s}
camera: {type: orthographic, height: 0.02, transform: {translate: [0, 0, 0.3]}}
nodes:
  floor: {shape: rectangle, transform: {scale: 10}, bsdf: {type: diffuse, reflectance: 0.5}}
  train:
    transform: {keyframes: [{time: 0, translate: [-4, 1, 1]}, {time: 1, translate: [3, 1, 1]}]}
    children:
      lamp:
        shape: rectangle
        light: {type: area, radiance: 2}
        transform: [{scale: 0.3}, {rotate: {axis: x, angle: 180}}]
  flap:
    transform:
      keyframes:
        - {time: 0, rotate: {axis: x, angle: 20}, translate: [1, -1, 1]}
        - {time: 1, rotate: {axis: x, angle: 190}, translate: [1, -1, 1]}
    children:
      lamp:
        light: {type: area, radiance: 8}
        shape: {type: mesh, vertices: [[0, 0, 0], [0.4, 0, 0], [0, 0.4, 0], [0, 0, 0.4]],
                faces: [[0, 1, 2], [0, 3, 1], [0, 2, 3]]}
  spark:
    transform: {keyframes: [{time: 0, translate: [5, 0, 2]}, {time: 1, translate: [0, 5, 2]}]}
    children: {lamp: {light: {type: point, intensity: 1}}}
  beam:
    transform:
      keyframes:
        - {time: 0, rotate: {axis: y, angle: 70}, translate: [-1, 0, 2]}
        - {time: 1, rotate: {axis: y, angle: 200}, translate: [-1, 0, 2]}
    children: {lamp: {light: {type: spot, intensity: 5}}}
  ball: {shape: {type: sphere, radius: 0.3, center: [0, 2, 1]}, light: {type: area, radiance: 2}}
  still1: {light: {type: point, intensity: 1}, transform: {translate: [6, 6, 1]}}
  still2: {light: {type: point, intensity: 1}, transform: {translate: [-7, 5, 1]}}
  still3: {light: {type: point, intensity: 1}, transform: {translate: [-5, -7, 1]}}
  sun: {light: {type: directional, irradiance: 0.003}, transform: {rotate: {axis: x, angle: 180}}}
"""


def scene_of(choice):
    scene = compiled(LAMPS % choice)
    if choice == "tree":
        # It is walked, not taken to be even.
        assert scene.tables.lights.cdf.array[FAR_FROM_ALL] > 0.0
    return scene


def light_at(choice, place, n, seed):
    """Mean of the light on a floor without shadows while the shutter is open, and its error."""
    scene, rng = scene_of(choice), np.random.default_rng(seed)
    at, every = seen(scene, rng.random(n)), np.ones(n, bool)
    p = Vec3(*np.tile(np.float32(place)[:, None], n))
    up = Vec3(*np.tile(np.float32([[0], [0], [1]]), n))
    u = rng.random((3, n)).astype(np.float32)
    s = twin_of(sample_light, scene)(at, p, up, u[0], (u[1], u[2]), every)
    lit = (s.pdf > 0.0) & (s.wi.z > 0.0)
    value = np.where(lit, s.radiance.x * s.wi.z / np.where(lit, s.pdf, 1.0), 0.0).astype(float)
    return value.mean(), value.std() / np.sqrt(n)


@pytest.mark.parametrize("place", [(0.0, 0.0, 0.0), (1.0, -1.5, 0.5), (-3.0, 3.0, 0.2)])
def test_moving_lights_shine_as_much_by_tree_as_by_power(place):
    tree, error = light_at("tree", place, 300_000, 1)
    power, other = light_at("power", place, 900_000, 2)
    assert abs(tree - power) < 4.0 * np.hypot(error, other)
    assert np.hypot(error, other) < 0.01 * power


@pytest.mark.parametrize("place", [(0.0, 0.0, 0.0), (1.0, -1.5, 0.5), (-8.0, 3.0, 4.0)])
def test_choices_among_moving_lights_follow_their_probabilities(place):
    """Each as often as it says at any time, all of them 1, and what rays ask for is the same."""
    scene, n = scene_of("tree"), 40_000
    rng = np.random.default_rng(1)
    info = scene.tables.lights.info.array.reshape(-1, INFO)
    at, every = seen(scene, rng.random(n)), np.ones(n, bool)
    p = Vec3(*np.tile(np.float32(place)[:, None], n))
    none = Vec3(*np.zeros((3, n), np.float32))
    u = rng.random((3, n)).astype(np.float32)
    found = twin_of(choose_by_tree, scene)(at, p, none, u[0], (u[1], u[2]), every)
    there = found.pmf > 0.0
    word = found.index.astype(int) * 4 + found.rest.astype(int)
    _, first, counts = np.unique(word[there], return_index=True, return_counts=True)
    said = found.pmf[there][first].astype(float)
    assert chi_square(np.append(counts, n - counts.sum()), said) > SIGNIFICANCE
    error = np.sqrt(there.mean() * (1.0 - there.mean()) / n)
    assert abs(said.sum() - there.mean()) <= LARGEST_Z * error + 1e-5
    np.testing.assert_allclose(found.mis_pmf[there], found.pmf[there], rtol=1e-5)
    lamps = info[:, 0] == LIGHTS["area"].number
    mine = there & lamps[found.index]
    assert len(set(word[mine])) >= 4
    asked = twin_of(mis_probability, scene)(
        at, found.index, found.rest.astype(np.uint32) * mine, p, mine
    )
    np.testing.assert_allclose(asked[mine], found.mis_pmf[mine], rtol=1e-5)


def test_leaves_bound_their_lights_at_every_time():
    flat = flatten(loads(LAMPS % "tree", "scene.yaml"))
    shapes = compile_shapes(flat, MotionTable())
    rows = _rows(flat, shapes, None)
    leaves = find_leaves(rows, np.ones(len(rows)), shapes)
    placed = {k: flat.shapes[shapes.rows[row.shape].source] for k, row in enumerate(rows[:3])}
    checked = 0
    for i, number in enumerate(leaves.row):
        row = rows[number]
        if row.motion is None:
            continue
        if row.cone is not None:
            corners, axis = row.numbers[None, :3], row.cone[0]
        elif placed[number].geometry < 0:
            square = np.array([[x, y, 0.0, 1.0] for x in (-1, 1) for y in (-1, 1)])
            corners, axis = square @ placed[number].to_world[:3].T, placed[number].to_world[:3, 2]
        else:
            mesh = flat.geometries[placed[number].geometry]
            corners = mesh.vertices[mesh.faces[leaves.prim[i]]] @ placed[number].to_world[:3, :3].T
            axis = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        axis = axis / np.linalg.norm(axis)
        middle = 0.5 * (leaves.low[i] + leaves.high[i])
        for time in np.linspace(0.0, 1.0, 97):
            matrix = row.motion.at(time)
            now, facing = corners @ matrix[:3, :3].T + matrix[:3, 3], matrix[:3, :3] @ axis
            assert (leaves.low[i] <= now).all()
            assert (now <= leaves.high[i]).all()
            assert leaves.axis[i] @ facing >= np.cos(leaves.spread[i]) - 1e-6
            assert ((middle - now) @ facing).max() <= leaves.behind[i] + 1e-6
        checked += 1
    assert checked == 6


def test_turning_axes_stay_in_their_cones():
    rng = np.random.default_rng(4)
    wide = []
    for _ in range(25):
        frames = [
            (t, translate(*rng.normal(size=3)) @ rotate(tuple(rng.normal(size=3)), angle))
            for t, angle in ((0.0, 0.0), (0.4, rng.uniform(-90, 90)), (1.0, rng.uniform(-90, 90)))
        ]
        motion = NOWHERE.then(keyframes(frames), (0.0, 1.0)).motion
        axes, points = rng.normal(size=(40, 3)), rng.normal(size=(40, 3, 3))
        axes /= np.linalg.norm(axes, axis=1, keepdims=True)
        (middle, half), (low, high) = motion.turned(axes), motion.swept(points)
        least = np.full(40, np.inf)
        for time in rng.random(200):
            matrix = motion.at(time)
            least = np.minimum(least, np.sum(middle * (axes @ matrix[:3, :3].T), axis=1))
            moved = points @ matrix[:3, :3].T + matrix[:3, 3]
            assert (low[:, None] <= moved).all()
            assert (moved <= high[:, None]).all()
        reached = np.arccos(np.clip(least, -1.0, 1.0))
        assert (reached <= half + 1e-9).all()
        wide.append((half - reached).max())
    assert np.max(wide) < 0.15
