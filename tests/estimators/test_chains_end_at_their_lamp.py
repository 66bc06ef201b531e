"""A chain of mirrors that leads to a lamp finds the light of that lamp, and of no other one."""

from unittest import mock

import numpy as np
import pytest

from alight.accel import intersect_closest
from alight.bsdfs.flags import REFLECTION
from alight.core.vec import Vec3
from alight.integrators import walk
from alight.integrators.caustics.chain_types import MOST_EVENTS, Type, no_chain
from alight.integrators.caustics.specular_chain import Plan, Start, extended, follow
from alight.lights.targets import target_at
from alight.media.tables import Stream
from alight.shapes.surfaces import make_surface
from lanewise.jit import instantiate
from tests.rendering.many_paths import compiled

MIRROR = """
alight: 1
integrator: {type: path, max_depth: 6, caustics: manifold}
camera: {type: pinhole, transform: {translate: [0, 0, 9]}}
nodes:
  mirror: {shape: rectangle, bsdf: {type: mirror}, transform: [{scale: 20}]}
  first:
    shape: {type: sphere, center: [0, 0, 3], radius: 0.5}
    light: {type: area, radiance: 5}
  second:
    shape: {type: sphere, center: [0.3, 0.2, 2], radius: 0.4}
    light: {type: area, radiance: 7}
"""
LAMPS = {0: ((0.0, 0.0, 3.0), 0.5, 5.0), 1: ((0.3, 0.2, 2.0), 0.4, 7.0)}
N = 400


def first_lamp(o, d):
    """The number of the lamp that each ray meets first, -1 for none."""
    found, nearest = np.full(len(d), -1), np.full(len(d), np.inf)
    for number, (center, radius, _) in LAMPS.items():
        to = np.array(center) - o
        along = (to * d).sum(axis=1)
        inside = radius**2 - (to**2).sum(axis=1) + along**2
        t = along - np.sqrt(np.maximum(inside, 0.0))
        nearer = (inside > 0.0) & (t > 0.0) & (t < nearest)
        found, nearest = np.where(nearer, number, found), np.where(nearer, t, nearest)
    return found


def test_lamps_before_each_other_are_told_apart():
    rng, scene = np.random.default_rng(2), compiled(MIRROR)
    start = np.array([-0.4, 0.1, 1.5])
    lead = np.errstate(all="ignore")(instantiate(follow, scene.program, compiled=False))
    aim = instantiate(target_at, scene.program, compiled=False)
    one, none = np.ones(N, bool), np.zeros(N, np.uint32)
    turn = np.array([1.0, 1.0, -1.0])
    # Where a mirror shows both lamps, and what is beside them.
    image = turn * (np.array([0.1, 0.1, 2.5]) + rng.uniform(-0.7, 0.7, (N, 3)))
    d = image - start
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    at = start - d * (start[2] / d[:, 2:])
    met = first_lamp(at, d * turn)
    assert {-1, 0, 1} == {*met.tolist()}
    o = Vec3(*(np.full(N, c, np.float32) for c in start))
    rays = Start(o, Vec3(*np.float32(d.T)), (), (), ())
    type_, stream = Type(none + REFLECTION, none + 1), Stream(none, none, none)
    plan = Plan(type_, ~one, one, stream, none, none + np.uint32(9))
    for number in (0, 1):
        target = aim(scene.tables, none + np.uint32(number))
        middle = [float(np.ravel(c)[0]) for c in (target.c.x, target.c.y, target.c.z)]
        [wanted] = [n for n, lamp in LAMPS.items() if np.allclose(lamp[0], middle)]
        center, radius, radiance = LAMPS[wanted]
        # Rays are counted by the bits of a packet, of which there is none here.
        with mock.patch.object(walk, "mask_bits", lambda mask: 0):
            followed = lead(scene.tables, rays, target, plan, one)
        found = np.broadcast_to(followed.found.x, N)
        np.testing.assert_allclose(found, np.where(met == wanted, radiance, 0.0))
        assert np.all(followed.fine)
        # By how many radii the last ray passes the lamp's middle.
        aside = np.linalg.norm(np.cross(center - at, d * turn), axis=1) / radius
        miss = followed.miss
        miss = np.linalg.norm([np.broadcast_to(c, N) for c in (miss.x, miss.y, miss.z)], axis=0)
        np.testing.assert_allclose(miss, aside, atol=1e-4)


def test_chains_start_where_light_is_scattered_but_not_on_lamps():
    """Nor are they looked for from there: what a path finds behind a mirror then counts."""
    text = MIRROR.replace("bsdf: {type: mirror}", "bsdf: {type: diffuse}") + (
        "  pane: {shape: rectangle, bsdf: {type: mirror}, transform: {translate: [0, 0, -5]}}\n"
    )
    scene = compiled(text)
    meet, describe, extend, empty = (
        np.errstate(all="ignore")(instantiate(root, scene.program, compiled=False))
        for root in (intersect_closest, make_surface, extended, no_chain)
    )
    # Straight down: on the first lamp, and beside both.
    x = np.array([-0.2, 5.0], np.float32)
    o, d = Vec3(x, 0.0 * x, 0.0 * x + 9.0), Vec3(0.0 * x, 0.0 * x, 0.0 * x - 1.0)
    there = np.ones(2, bool)
    surface = describe(scene.tables, meet(scene.tables, o, d, x + np.inf, there), o, d, there)
    assert (surface.light > 0).tolist() == [True, False]
    up, scattered = Vec3(d.x, d.y, -d.z), np.full(2, REFLECTION, np.uint32)
    chain = extend(scene.tables, empty(), surface, surface.p, up, scattered)
    assert chain.known.tolist() == [False, True]
    assert np.broadcast_to(chain.type.count, 2).tolist() == [0, 0]


def led(text, d, type_, most, rng=None):
    """`Followed` of rays (n, 3) from the origin to the only lamp; by chance if `rng` is given."""
    scene, n = compiled(text), len(d)
    lead, aim = (
        np.errstate(all="ignore")(instantiate(root, scene.program, compiled=False))
        for root in (follow, target_at)
    )
    none = np.zeros(n, np.uint32)
    keys = [none, none]
    if rng is not None:
        keys = [rng.integers(0, 1 << 32, n, dtype=np.uint32) for _ in range(2)]
    start = Start(Vec3(*np.zeros((3, n), np.float32)), Vec3(*np.float32(d.T)), (), (), ())
    plan = Plan(
        type=Type(none + type_[0], none + type_[1]), chance=np.full(n, rng is not None),
        final=none == 0, stream=Stream(*keys, none), first=none, most=none + np.uint32(most),
    )  # fmt: skip
    with mock.patch.object(walk, "mask_bits", lambda mask: 0):
        return lead(scene.tables, start, aim(scene.tables, none), plan, none == 0)


ABOVE = """
alight: 1
integrator: {type: path, max_depth: 6, caustics: manifold}
camera: {type: pinhole, transform: {translate: [0, 0, 9]}}
nodes:
  mirror:
    shape: rectangle
    bsdf: {type: mirror}
    transform: [{scale: 90}, {translate: [0, 0, %g]}]
  lamp: {shape: {type: sphere, center: [0, 0, 5], radius: 0.5}, light: {type: area, radiance: 5}}
"""


@pytest.mark.parametrize("leaves", [1, 5, 12])
def test_a_chain_passes_as_many_leaves_as_there_are(leaves):
    """Each takes its part and is an edge, and the light needs them all."""
    text = ABOVE % -1 + "".join(
        f"  leaf{i}: {{shape: rectangle,\n"
        f"         bsdf: {{type: mask, opacity: 0.1, bsdf: {{type: diffuse}}}},\n"
        f"         transform: [{{scale: 9}}, {{translate: [0, 0, {0.5 + 0.2 * i}]}}]}}\n"
        for i in range(leaves)
    )
    d = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    for row, (edges, type_) in enumerate(((1, (0, 0)), (2, (REFLECTION, 1)))):
        for more in (0, 1):
            most = edges + leaves - 1 + more
            found = led(text, d[[row]], type_, most=most)
            wanted = 5.0 * 0.9**leaves if more else 0.0
            np.testing.assert_allclose(found.found.x, wanted, rtol=1e-5)
            assert found.edges == (edges + leaves if more else 0)


def test_a_chain_has_no_more_events_than_its_type_has_bits():
    """Between two mirrors it goes to and fro as often as it may."""
    text = ABOVE % -1 + (
        "  ceiling: {shape: {type: rectangle, flip_normals: true}, bsdf: {type: mirror}, "
        "transform: [{scale: 90}, "
        "{translate: [0, 0, 2]}]}\n"
    )
    d = np.tile([[0.6, 0.0, -0.8]], (N, 1))
    found = led(text, d, (0, 0), most=99, rng=np.random.default_rng(3))
    count = np.broadcast_to(found.type.count, N)
    assert found.fine.all()
    assert sorted({*count.tolist()}) == [*range(1, MOST_EVENTS + 1)]
