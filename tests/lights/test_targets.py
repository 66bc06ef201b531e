"""What walks aim at: the table of targets by closed forms, and the boxes of what casts caustics."""

from types import SimpleNamespace

import numpy as np
import pytest

import alight
from alight.bsdfs.conductors.mirror import Mirror
from alight.compiled import casters
from alight.core.vec import Vec3
from alight.lights.targets import (
    FINE,
    SHINING,
    choose_target,
    end_at_point,
    far_light,
    leads_to_disk,
    radius_at,
    target_at,
    way_to,
    way_to_caster,
)
from alight.scene import flatten
from lanewise.jit import instantiate
from tests.rendering.many_paths import compiled, prepared

SCENE = """
alight: 1
integrator: {type: path, max_depth: 6, caustics: manifold}
camera: {type: pinhole, transform: {translate: [0, 0, 9]}}
%s
nodes:
  ball:
    shape: {type: sphere, radius: 0.5, center: [1, 2, 3]}
    light: {type: area, radiance: 2}
  panel:
    shape: rectangle
    light: {type: area, radiance: [1, 3, 2]}
    transform: [{scale: [2, 0.5, 1]}, {rotate: {axis: x, angle: 30}}, {translate: [-4, 5, 1]}]
  bulb: {light: {type: point, intensity: 3}, transform: {translate: [0, 7, 1]}}
  beam: {light: {type: directional, irradiance: 2}, transform: {rotate: {axis: x, angle: 50}}}
  glass: {shape: cube, bsdf: {type: dielectric}, transform: [{scale: 0.5}, {translate: [3, 0, 1]}]}
  mirror:
    shape: {type: sphere, radius: 0.25, center: [-2, -1, 4]}
    bsdf: {type: mirror}
  wood: {shape: {type: sphere, radius: 9}}
"""
#: The sun stands at (0, 1, 0) and is half a degree wide.
SUN = "environment: {type: sunsky, sun_direction: [0, 1, 0], diameter: 0.5}"
N = 1 << 12


def lower_and_upper():
    """Corners of the boxes of what casts caustics, sorted."""
    glass = [[2.5, -0.5, 0.5], [3.5, 0.5, 1.5]]
    mirror = [[-2.25, -1.25, 3.75], [-1.75, -0.75, 4.25]]
    return np.array([mirror, glass])


def vectors(v, n):
    """A vector of lanes as rows."""
    return np.stack([np.broadcast_to(c, n) for c in (v.x, v.y, v.z)], axis=-1).astype(np.float64)


@pytest.mark.parametrize("around", ["", SUN], ids=["nothing around", "a sun"])
def test_each_light_that_can_be_aimed_at_has_its_middle_and_its_size(around):
    scene, count = compiled(SCENE % around), 4 + bool(around)
    rows = np.arange(count, dtype=np.uint32)
    aim = instantiate(target_at, scene.program, compiled=False)
    target = aim(scene.tables, rows)
    far, delta = (np.broadcast_to(mask, count) for mask in (target.far, target.delta))
    middles = vectors(target.c, count)
    # Against the way that the beam goes, which is +z where it is not turned.
    s, c = np.sin(np.radians(50.0)), np.cos(np.radians(50.0))
    # Half of the box around the panel.
    wide = np.array([2.0, 0.5 * np.cos(np.radians(30.0)), 0.5 * np.sin(np.radians(30.0))])
    wanted = [
        ([1.0, 2.0, 3.0], 0.5, False, False),
        ([-4.0, 5.0, 1.0], np.linalg.norm(wide), False, False),
        ([0.0, 7.0, 1.0], FINE, False, True),
        ([0.0, s, -c], FINE, True, True),
        ([0.0, 1.0, 0.0], np.sin(np.radians(0.25)), True, False),
    ]
    met = []
    for middle, radius, is_far, is_delta in wanted[:count]:
        [row] = np.flatnonzero(np.abs(middles - middle).max(axis=1) < 1e-4)
        np.testing.assert_allclose(np.broadcast_to(target.radius, count)[row], radius, rtol=1e-3)
        assert (far[row], delta[row]) == (is_far, is_delta)
        met.append(row)
    assert sorted(met) == rows.tolist()
    if not around:
        return
    assert instantiate(far_light, scene.program, compiled=False)(scene.tables) == met[-1]
    # Its edge, from either side; and what lies opposite.
    angle = np.radians([0.0, 0.24, 0.26, 180.0])
    turn = np.array([0.6, 0.8], np.float32)
    d = Vec3(
        *np.array([np.sin(angle) * turn[0], np.cos(angle), np.sin(angle) * turn[1]], np.float32)
    )
    leads = instantiate(leads_to_disk, scene.program, compiled=False)(scene.tables, d)
    assert leads.tolist() == [True, True, False, False]


@pytest.mark.parametrize("kind", ["sphere", "mesh"])
def test_a_lamp_that_moves_is_aimed_at_as_it_rests(kind):
    """Walks go to where it is at the time of their ray; the table has it before its motion."""
    frames = [{"time": 0, "translate": [1, 2, 3]}, {"time": 1, "translate": [1, 2, 9]}]
    corners = [[-0.5, 0, 0], [0.5, 0, 0], [0, 0.5, 0], [0, 0, 0.5]]
    shapes = {
        "sphere": {"type": "sphere", "radius": 0.5, "center": [-3, 0, 0]},
        "mesh": {"type": "mesh", "vertices": corners, "faces": [[0, 1, 2], [0, 1, 3]]},
    }
    scene = prepared(alight.load({
        "alight": 1, "camera": {}, "integrator": {"type": "path", "caustics": "manifold"},
        "nodes": {
            "lamp": {"shape": shapes[kind], "light": "area", "transform": {"keyframes": frames}},
            "glass": {"shape": "cube", "bsdf": {"type": "dielectric"},
                      "transform": {"translate": [9, 0, 0]}},
        },
    }))  # fmt: skip
    # After the choice among one light: its sphere.
    *middle, radius = scene.tables.lights.targets.array[2:6]
    corner = [0.5, 0.25, 0.25]
    wanted = [-3.0, 0.0, 0.0, 0.5] if kind == "sphere" else [0, *corner[1:], np.linalg.norm(corner)]
    np.testing.assert_allclose([*middle, radius], wanted, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize(("color", "far"), [([2, 0, 0], 1), ([5, 0, 0], 0)])
def test_of_two_suns_the_brighter_one_is_aimed_at_in_its_colour(color, far):
    """Alike but for where they stand: of its red and its green, green is brighter."""
    both = "".join(
        f"  sun{i}: {{light: {{type: sun, sun_direction: [{x}, 1, 0], scale: {scale}}}}}\n"
        for i, (x, scale) in enumerate(((1, color), (-1, [0, 1, 0])))
    )
    scene = compiled(SCENE % "" + both)
    row = np.uint32(instantiate(far_light, scene.program, compiled=False)(scene.tables))
    target = instantiate(target_at, scene.program, compiled=False)(scene.tables, row)
    assert np.all(target.far)
    assert np.sign(np.ravel(target.c.x)[0]) == (1.0, -1.0)[far]


def test_lights_are_chosen_by_their_power():
    scene = compiled(SCENE % "")
    u = (np.arange(N, dtype=np.float32) + 0.5) / N
    choose = instantiate(choose_target, scene.program, compiled=False)
    row, probability = choose(scene.tables, u)
    share = np.bincount(row, minlength=4) / N
    for i in range(4):
        mine = row == i
        assert mine.any()
        np.testing.assert_allclose(probability[mine], share[i], atol=2.0 / N)


def test_mirrors_and_glass_are_aimed_at_alike_and_everywhere():
    scene = compiled(SCENE % SUN)
    corners = lower_and_upper()
    way = instantiate(way_to_caster, scene.program, compiled=False)
    p = np.array([5.0, -6.0, 7.0])
    rng = np.random.default_rng(3)
    u = (np.arange(N, dtype=np.float32) + 0.5) / N
    u[-1] = np.float32(1.0) - np.float32(2.0**-24)
    numbers = rng.random((3, N), np.float32)
    numbers[:, :: N // 8] = np.array([0.0, 1.0])[rng.integers(0, 2, (3, 8))]
    there, to = way(scene.tables, Vec3(*(np.float32(c) for c in p)), u, tuple(numbers))
    assert np.all(there)
    points = vectors(to, N) + p
    # One after the other, each with a part of the numbers of the same length.
    halves = points[: N // 2], points[N // 2 :]
    order = np.argsort([half[:, 0].mean() for half in halves])
    for index, (low, high) in zip(order, corners, strict=True):
        mine = np.ascontiguousarray(numbers.T[index * (N // 2) : (index + 1) * (N // 2)])
        np.testing.assert_allclose(halves[index], low + mine * (high - low), atol=1e-5)


def test_without_mirrors_nothing_is_aimed_at():
    text = SCENE % ""
    scene = compiled(text.replace("{type: dielectric}", "{type: diffuse}"))
    half = np.full(8, 0.5, np.float32)
    way = instantiate(way_to_caster, scene.program, compiled=False)
    there, _ = way(scene.tables, Vec3(half, half, half), half, (half, half, half))
    assert np.all(there)
    only_wood = text.replace("{type: dielectric}", "{type: diffuse}").replace("mirror}", "diffuse}")
    scene = compiled(only_wood)
    way = instantiate(way_to_caster, scene.program, compiled=False)
    there, _ = way(scene.tables, Vec3(half, half, half), half, (half, half, half))
    assert not np.any(there)


def row_of(scene, middle):
    """The row of the target in some place."""
    rows = np.arange(4, dtype=np.uint32)
    middles = vectors(
        instantiate(target_at, scene.program, compiled=False)(scene.tables, rows).c, 4
    )
    [row] = np.flatnonzero(np.abs(middles - middle).max(axis=1) < 1e-4)
    return np.uint32(row)


#: Where they are or whence they come, and the irradiance at a distance.
DELTA = {
    "a bulb": ([0.0, 7.0, 1.0], lambda distance: 3.0 / distance**2),
    "a beam": ([0.0, np.sin(np.radians(50.0)), -np.cos(np.radians(50.0))], lambda distance: 2.0),
}


@pytest.mark.parametrize("name", DELTA)
def test_a_light_without_a_size_is_a_disk_of_its_irradiance(name):
    """It ends the rays that lead to it, unless they meet something before."""
    scene = compiled(SCENE % "")
    middle, irradiance = DELTA[name]
    row, n = row_of(scene, middle), 6
    o = np.array([[0.5, 2.0, -1.0]] * n, np.float32)
    aim, end, radius, way = (
        np.errstate(all="ignore")(instantiate(text, scene.program, compiled=False))
        for text in (target_at, end_at_point, radius_at, way_to)
    )
    start = Vec3(*o.T)
    target = aim(scene.tables, np.full(n, row))
    to = vectors(way(target, start), n)
    far = name == "a beam"
    wanted = np.array(middle) if far else middle - o
    np.testing.assert_allclose(to, np.broadcast_to(wanted, (n, 3)), atol=1e-5)
    distance = np.linalg.norm(to, axis=1)
    # One angle from everywhere.
    seen = np.broadcast_to(radius(target, np.float32(distance)), n) / distance
    np.testing.assert_allclose(seen, FINE, rtol=1e-5)
    axis = to / distance[:, None]
    across = np.cross(axis, [0.0, 0.0, 1.0])
    across /= np.linalg.norm(across, axis=1)[:, None]
    # Ahead, within the part that shines, beyond it, behind; then blocked, and not asked.
    aside = SHINING * FINE * np.array([0.0, 0.98, 1.02, 0.0, 0.0, 0.0])
    d = axis + aside[:, None] * across
    d[3] *= -1.0
    d /= np.linalg.norm(d, axis=1)[:, None]
    t = np.full(n, np.inf, np.float32)
    t[4] = 2.0
    last = np.arange(n) != 5
    ends, found = end(scene.tables, target, start, Vec3(*d.astype(np.float32).T), t, last)
    lit = np.array([True, True, False, False, False, False])
    radiance = irradiance(distance[0]) / (np.pi * (SHINING * FINE) ** 2)
    np.testing.assert_allclose(vectors(found, n)[:, 1], np.where(lit, radiance, 0.0), rtol=1e-4)
    if far:
        np.testing.assert_array_equal(np.isfinite(ends), np.arange(n) == 4)
    else:
        np.testing.assert_allclose(ends, np.where(lit, distance, t), rtol=1e-5)


def test_a_lamp_with_a_shape_has_one_radius_from_everywhere():
    scene = compiled(SCENE % "")
    target = instantiate(target_at, scene.program, compiled=False)(
        scene.tables, row_of(scene, [1.0, 2.0, 3.0])
    )
    radius = instantiate(radius_at, scene.program, compiled=False)
    for distance in np.array([0.7, 1.0, 30.0], np.float32):
        np.testing.assert_allclose(radius(target, distance), 0.5, rtol=1e-4)


def test_what_reaches_to_infinity_has_no_box_to_aim_at(monkeypatch):
    """Along one axis is enough."""
    ends = [(np.zeros(3), np.ones(3)), (np.zeros(3), np.array([1.0, np.inf, 1.0])), None]
    shapes = [SimpleNamespace(bsdf=0, box=box, motion=None) for box in ends]
    flat = SimpleNamespace(bsdfs=[Mirror()], shapes=shapes)
    monkeypatch.setattr(casters, "box_of", lambda _, placed: placed.box)
    np.testing.assert_array_equal(casters.boxes_of_casters(flat), [[0, 0, 0, 1, 1, 1]])


def test_boxes_of_what_moves_hold_it_while_the_shutter_is_open():
    """A mirror that is turned about an axis beside it, and shifted."""
    turned = {"axis": [0, 0, 1], "angle": 90}
    frames = [{"time": 0, "translate": [1, 2, 3]},
              {"time": 1, "translate": [2, 2, 4], "rotate": turned}]  # fmt: skip
    scene = alight.load({
        "alight": 1, "camera": {"type": "pinhole"},
        "nodes": {"ball": {
            "shape": {"type": "sphere", "radius": 0.25, "center": [1, 0, 0]},
            "bsdf": {"type": "mirror"}, "transform": {"keyframes": frames},
        }},
    })  # fmt: skip
    flat = flatten(scene)
    ((*low, a, b, c),) = casters.boxes_of_casters(flat)
    middles = [flat.shapes[0].motion.at(time) @ [1, 0, 0, 1] for time in np.linspace(0, 1, 33)]
    least, most = np.min(middles, axis=0)[:3] - 0.25, np.max(middles, axis=0)[:3] + 0.25
    assert (low <= least).all() and (most <= (a, b, c)).all()
    # And not much more.
    np.testing.assert_allclose([*low, a, b, c], [*least, *most], atol=0.15)
