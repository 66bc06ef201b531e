"""Rays, surfaces and lights of what moves: kernels in the twin, and compiled ones against them."""

from collections import namedtuple

import numpy as np
import pytest

from alight.accel import intersect_closest, is_occluded
from alight.compiled.motion import MotionTable
from alight.compiled.program import Program
from alight.core.constants import INFINITY
from alight.core.motion import general_matrix_at, matrix_at, rigid_matrix_at
from alight.core.vec import Vec3
from alight.formats import loads
from alight.lights.hits import light_pdf, pdf_of_shape
from alight.lights.sampling import sample_chosen, sample_light
from alight.scene import flatten, keyframes, rotate, scale, translate
from alight.scene.motion import NOWHERE
from alight.shapes.hit import Hit, ShapeHit, spawn_origin
from alight.shapes.model import SHAPES
from alight.shapes.surfaces import make_surface
from lanewise.jit import instantiate, kernel
from lanewise.simd import LANES, lanes, load_lanes, store_lanes, to_float, where
from lanewise.view import View
from tests.motion.moving import HEAD, PICTURE, choosing_by, compiled

#: What kernels see of a scene that moves, at times of the rays.
Seen = namedtuple("Seen", "shapes materials lights accel camera filter motions time")

#: One of each kind, each in a motion of its own; one in two, and one that changes its shape.
ALL = """
nodes:
  ball:
    transform: {keyframes: [{time: 0, translate: [-2, 0, 0]}, {time: 1, translate: [0, 1, 1]}]}
    shape: {type: sphere, radius: 0.7}
  wheel:
    transform: {keyframes: [{time: 0, rotate: {axis: [1, 2, 3], angle: 10}},
                            {time: 0.3, rotate: {axis: [1, 2, 3], angle: 150}},
                            {time: 1, rotate: {axis: x, angle: 40}, translate: [0, 2, 0]}]}
    children:
      spoke:
        transform: {keyframes: [{time: 0, translate: [2, 0, 0]},
                                {time: 1, rotate: {axis: z, angle: 80}, translate: [3, 0, 1]}]}
        children:
          box: {shape: cube, transform: {scale: [0.4, 0.8, 0.5]}}
          plate: {shape: disk, transform: {translate: [0, 0, 1.5]}}
  tube:
    transform: {keyframes: [{time: 0, scale: [1, 0.5, 1]}, {time: 1, scale: [0.6, 1, 1.5]}]}
    shape: {type: cylinder, radius: 0.5, p0: [0, -3, -1], p1: [1, -3, 1]}
  leaf:
    transform: {keyframes: [{time: 0, scale: -1, translate: [0, 0, 3]},
                            {time: 1, scale: -1.5, rotate: {axis: y, angle: 90}}]}
    shape: {type: mesh, vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
            faces: [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]}
  still: {shape: {type: sphere, radius: 0.5, center: [3, -3, 0]}}
  floor: {shape: rectangle, transform: [{scale: 5}, {translate: [0, 0, -4]}]}
environment: {type: constant}
"""


def seen(scene, time):
    """The tables at some times."""
    return Seen(*scene.tables, np.asarray(time, np.float32))


def rays(n, seed=0):
    """Origins around a scene of about 4 m, directions into it, times."""
    rng = np.random.default_rng(seed)
    o = rng.normal(size=(3, n))
    o *= 8.0 / np.linalg.norm(o, axis=0)
    d = rng.uniform(-3.0, 3.0, (3, n)) - o
    d /= np.linalg.norm(d, axis=0)
    return o.astype(np.float32), d.astype(np.float32), rng.random(n).astype(np.float32)


def twin_of(root, scene):
    """The kernel in NumPy; what dead lanes compute is of no interest."""
    return np.errstate(all="ignore")(instantiate(root, scene.program, compiled=False))


@kernel
def trace_rays(scene, given, out):
    """7 rows of floats: o, d and time; out, 6 rows: t, shape, prim, u, v, whether any is met."""
    n = given.size // 7
    for i in range(0, n, LANES):
        o = Vec3(load_lanes(given, i), load_lanes(given, n + i), load_lanes(given, 2 * n + i))
        d = Vec3(
            load_lanes(given, 3 * n + i), load_lanes(given, 4 * n + i), load_lanes(given, 5 * n + i)
        )
        at = Seen(
            scene.shapes, scene.materials, scene.lights, scene.accel, scene.camera, scene.filter,
            scene.motions, load_lanes(given, 6 * n + i),
        )  # fmt: skip
        always = d.x == d.x
        hit = intersect_closest(at, o, d, lanes(INFINITY), always)
        store_lanes(out, i, hit.t)
        store_lanes(out, n + i, to_float(hit.shape))
        store_lanes(out, 2 * n + i, to_float(hit.prim))
        store_lanes(out, 3 * n + i, hit.u)
        store_lanes(out, 4 * n + i, hit.v)
        met = is_occluded(at, o, d, lanes(INFINITY), always)
        store_lanes(out, 5 * n + i, where(met, 1.0, lanes(0.0)))


def traced(scene, run, given):
    """What `trace_rays` writes, (6, n)."""
    out = View(np.zeros((6, given.shape[1]), np.float32))
    run(scene.tables, View(given), out)
    return out.shaped


def check_same(found, expected):
    """The same hits, bit for bit; local coordinates may differ by the fused operations of NumPy."""
    exact = [0, 1, 2, 5]
    np.testing.assert_array_equal(found[exact], expected[exact])
    np.testing.assert_allclose(found[3:5], expected[3:5], atol=1e-6)


@pytest.mark.parametrize("what", ["all", pytest.param("rigid", marks=pytest.mark.proofs)])
def test_tree_list_and_twin_find_the_same_bits(what):
    """All kinds at once, at times of their own: one by one, in the tree, and in NumPy."""
    text = ALL if what == "all" else "\n".join(ALL.split("\n")[:6] + ALL.split("\n")[-4:])
    given = np.ascontiguousarray(np.concatenate([*rays(4096)[:2], rays(4096)[2][None]]))
    in_list, in_tree = compiled(text), compiled(text, structure="bvh")
    assert ("rigid" in in_list.program.motion) == (what == "rigid")
    assert "tree" in in_tree.program.accel
    assert "tree" not in in_list.program.accel
    expected = traced(in_list, twin_of(trace_rays, in_list), given)
    met = np.isfinite(expected[0])
    assert 0.3 < met.mean() < 0.95
    assert set(expected[1][met]) == set(range(len(in_list.tables.motions.of_shape.array)))
    np.testing.assert_array_equal(expected[5] > 0.0, met)
    tree = traced(in_tree, instantiate(trace_rays, in_tree.program), given)
    check_same(tree, expected)
    if what == "rigid":
        listed = traced(in_list, instantiate(trace_rays, in_list.program), given)
        check_same(listed, expected)
        np.testing.assert_array_equal(listed, tree)


def test_a_mesh_in_the_tree_moves_as_its_triangles_written_out():
    """At one time, which a shutter of no length makes a scene that rests, the hits are the same."""
    rng = np.random.default_rng(3)
    corners = rng.normal(size=(90, 3)).round(3).tolist()
    faces = rng.integers(0, 90, (40, 3)).tolist()
    mesh = f"{{type: mesh, vertices: {corners}, faces: {faces}}}"
    frames = "{keyframes: [{time: 0, rotate: {axis: x, angle: 20}}, {time: 1, scale: [1, 2, 1.5]}]}"
    head = """
alight: 1
film: {size: [8, 8]}
camera: {type: pinhole, shutter: %s}
environment: {type: constant}
nodes: {a: {transform: %s, shape: %s}}
"""
    moving = compiled(head % ("[0, 1]", frames, mesh))
    o, d, _ = rays(2048, seed=2)
    for time in (0.0, 0.37, 0.9):
        still = compiled(head % (f"[{time}, {time}]", frames, mesh))
        assert still.program.motion == ()
        closest = twin_of(intersect_closest, still)
        every = np.ones(o.shape[1], bool)
        far = np.full(o.shape[1], np.inf, np.float32)
        expected = closest(still.tables, Vec3(*o), Vec3(*d), far, every)
        found = twin_of(intersect_closest, moving)(
            seen(moving, np.full(o.shape[1], time)), Vec3(*o), Vec3(*d), far, every
        )
        same = expected.prim == found.prim
        assert same.mean() > 0.998
        met = same & np.isfinite(expected.t)
        assert met.mean() > 0.2
        np.testing.assert_allclose(found.t[met], expected.t[met], rtol=2e-5)


def test_rays_that_leave_a_moving_surface_do_not_meet_it_again():
    """Convex shapes far from the origin, turned, stretched and mirrored: none shadows itself."""
    inside = ALL[ALL.index("  ball") : ALL.index("  still")].replace("\n", "\n    ")
    scene = compiled(f"""
nodes:
  far:
    transform: {{translate: [500, -300, 200]}}
    children:
    {inside}
environment: {{type: constant}}
""")
    n = 8192
    o, d, time = rays(n, seed=5)
    o += np.array([[500.0], [-300.0], [200.0]], np.float32)
    at, every = seen(scene, time), np.ones(n, bool)
    far = np.full(n, np.inf, np.float32)
    closest = twin_of(intersect_closest, scene)
    hit = closest(at, Vec3(*o), Vec3(*d), far, every)
    met = np.isfinite(hit.t)
    assert met.mean() > 0.15
    hit = Hit(np.where(met, hit.t, 0.0).astype(np.float32), hit.u, hit.v, hit.shape, hit.prim)
    surface = twin_of(make_surface, scene)(at, hit, Vec3(*o), Vec3(*d), met)
    rng = np.random.default_rng(6)
    w = rng.normal(size=(3, n))
    w = Vec3(*(w / np.linalg.norm(w, axis=0)).astype(np.float32))
    # On the outer side; the sphere of directions as good as fills the half space.
    side = w.x * surface.ng.x + w.y * surface.ng.y + w.z * surface.ng.z
    flip = np.where(side < 0.0, np.float32(-1.0), np.float32(1.0))
    w = Vec3(w.x * flip, w.y * flip, w.z * flip)
    start = spawn_origin(surface.p, surface.error, surface.ng, w)
    again = closest(at, start, w, far, met)
    own = met & np.isfinite(again.t) & (again.shape == hit.shape)
    assert own.sum() == 0
    # And the point is where the ray met it.
    p = np.stack([surface.p.x, surface.p.y, surface.p.z]) - (o + hit.t * d)
    assert np.abs(p[:, met]).max() < 1e-3
    assert (surface.error[met] < 1e-2).all()


LAMPS = """
nodes:
  ball: {transform: {keyframes: [{time: 0}, {time: 1, translate: [0, 1, 1]}]},
         shape: {type: sphere, radius: 0.7}, light: area}
  wheel:
    transform: {keyframes: [{time: 0}, {time: 1, rotate: {axis: [1, 2, 3], angle: 140}}]}
    children:
      plate: {shape: disk, light: area, transform: [{scale: [1, 2, 1]}, {translate: [0, 0, 2]}]}
      leaf: {shape: rectangle, light: area, transform: {translate: [0, 2, -1]}}
      tube: {shape: {type: cylinder, radius: 0.5, p0: [0, -3, -1], p1: [1, -3, 1]}, light: area}
      mesh:
        transform: {translate: [2, 2, 0]}
        light: area
        shape: {type: mesh, vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
                faces: [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]}
  still: {shape: {type: sphere, radius: 0.5, center: [-3, -3, 0]}, light: area}
"""


@pytest.mark.parametrize("text", [ALL, LAMPS], ids=["all", "lamps"])
def test_every_shape_that_can_move_is_in_the_scene(text):
    """A new shape has to be written into it; rectangles move as those of a cube, too."""
    first = {name: model.EXAMPLES[0] for name, model in SHAPES.items() if not model.is_many}
    kinds = {name for name, shape in first.items() if shape.finite and not shape.parts()}
    moving = [one.shape for one in flatten(loads(HEAD + text)).shapes if one.motion is not None]
    moving += [part for shape in moving for part, _ in shape.parts()]
    assert {shape.type_name() for shape in moving} >= kinds


@pytest.mark.parametrize("choice, light", [("power", "area"), ("tree", "area"), ("tree", PICTURE)])
def test_each_sample_of_a_moving_light_is_found_by_its_ray_with_the_same_density(choice, light):
    """Direction, distance, density and side agree with what intersection finds there and then."""
    scene = compiled(choosing_by(choice) + LAMPS.replace("light: area", f"light: {light}"))
    n = 8192
    o, _, time = rays(n, seed=8)
    rng = np.random.default_rng(9)
    u = rng.random((3, n)).astype(np.float32)
    at, every = seen(scene, time), np.ones(n, bool)
    up = Vec3(*np.tile(np.float32([[0], [0], [1]]), n))
    s = twin_of(sample_light, scene)(at, Vec3(*o), up, u[0], (u[1], u[2]), every)
    lit = (s.pdf > 0.0) & (s.cosine > 0.1)
    assert lit.mean() > 0.3
    far = np.full(n, np.inf, np.float32)
    hit = twin_of(intersect_closest, scene)(at, Vec3(*o), s.wi, far, lit)
    # What another lamp hides is met before it.
    met = lit & np.isfinite(hit.t) & (hit.t > s.distance * (1.0 - 1e-3))
    assert met.sum() > 0.7 * lit.sum()
    np.testing.assert_allclose(hit.t[met], s.distance[met], rtol=1e-4)
    finite = Hit(np.where(met, hit.t, 0.0).astype(np.float32), hit.u, hit.v, hit.shape, hit.prim)
    surface = twin_of(make_surface, scene)(at, finite, Vec3(*o), s.wi, met)
    density = twin_of(light_pdf, scene)(at, surface.light, Vec3(*o), s.wi, finite.t, surface)
    np.testing.assert_allclose(density[met], s.pdf[met], rtol=3e-3)
    assert len(set(surface.light[met])) == 6


def test_lamps_at_rest_read_the_motion_of_none_that_is_not_there():
    """One motion of two lamps: lanes of the other one read some row, which the table must have."""
    text = """
nodes:
  one: {transform: {keyframes: [{time: 0}, {time: 1, translate: [0, 1, 1]}]},
        shape: {type: sphere, radius: 0.7}, light: area}
  other: {shape: {type: sphere, radius: 0.5, center: [-3, -3, 0]}, light: area}
"""
    scene, n = compiled(text), 256
    o, d, time = rays(n, seed=10)
    at, ones = seen(scene, time), np.ones(n, np.float32)
    index, u = np.arange(n, dtype=np.uint32) % 2, np.full((3, n), 0.25, np.float32)
    hit = ShapeHit(np.zeros(n, np.uint32), Vec3(*d), ones, ones)
    try:
        density = twin_of(pdf_of_shape, scene)(at, index, Vec3(*o), hit)
        s = twin_of(sample_chosen, scene)(at, index, Vec3(*o), u[0], (u[1], u[2]))
        told = np.isfinite(density) & (s.distance > 0.0)
    except IndexError as error:
        told = np.array(str(error)) == ""
    assert told.all()


# ---------------------------------------------------------------- matrices and boxes


def random_transform(rng, spread=2.0):
    """A transform that keeps its side."""
    axis, angle = rng.normal(size=3), rng.uniform(-170.0, 170.0)
    size = rng.uniform(0.3, 2.0, 3)
    turn = rotate(tuple(rng.normal(size=3)), rng.uniform(-90.0, 90.0))
    return (
        translate(*rng.normal(size=3) * spread) @ rotate(tuple(axis), angle) @ turn @ scale(*size)
    )


def random_placement(rng, links, shutter=(0.0, 1.0)):
    """A chain of moving and resting levels."""
    here = NOWHERE
    for _ in range(links):
        inner = rng.uniform(0.4, 0.6, rng.integers(0, 3))
        times = np.sort([rng.uniform(-0.5, 0.4), *inner, rng.uniform(0.6, 1.5)])
        frames = [(t, random_transform(rng)) for t in times]
        here = here.then(keyframes(frames), shutter)
        if rng.random() < 0.5:
            here = here.then(random_transform(rng), shutter)
    return here, shutter


def points_of(box, rng, n=200):
    """Corners of a box and points in it, (n + 8, 4)."""
    corners = np.array(np.meshgrid(*zip(*box, strict=True))).reshape(3, -1).T
    inside = rng.uniform(box[0], box[1], (n, 3))
    return np.hstack([np.concatenate([corners, inside]), np.ones((n + 8, 1))])


@pytest.mark.parametrize("links", [1, 2, 3])
def test_every_point_is_inside_of_the_box_at_every_time(links):
    """Random keyframes, chains, turns by nearly half a circle; the box is not much too large."""
    rng = np.random.default_rng(links)
    loose = []
    for _ in range(25):
        here, _ = random_placement(rng, links)
        motion = here.motion
        box = np.sort(rng.normal(size=(2, 3)), axis=0)
        points = points_of(box, rng)
        low, high = motion.bounds(*box)
        reached = []
        for time in np.concatenate([rng.random(100), motion.times]):
            p = points @ motion.at(min(time, 1.0)).T
            reached += [p[:, :3].min(axis=0), p[:, :3].max(axis=0)]
        least, most = np.min(reached, axis=0), np.max(reached, axis=0)
        assert (low <= least).all()
        assert (most <= high).all()
        loose.append(((high - low) / (most - least)).max())
    assert np.median(loose) < 1.05


@pytest.mark.parametrize("links", [1, 3])
def test_kernels_and_host_know_the_same_matrix(links):
    """The rows in float32 against the chain in float64, at any time; rigid ones too."""
    rng = np.random.default_rng(10 + links)
    tables, motions = MotionTable(), []
    for i in range(12):
        if links == 1 and i < 6:
            turn = [(t, rotate((1, 2, t), (100.0 + i) * t)) for t in (0.0, 0.4, 1.0)]
            here = NOWHERE.then(translate(1, 2, 3), (0.0, 1.0)).then(keyframes(turn), (0.0, 1.0))
        else:
            here, _ = random_placement(rng, links)
        motions.append(here.motion)
        assert tables.number(here.motion) == i + 1
    rows = tables.tables([0], [0], 0)
    at = instantiate(matrix_at, Program(motion=("shapes",)), compiled=False)
    time = rng.random(16).astype(np.float32)
    for number, motion in enumerate(motions):
        found = at(rows, np.uint32([number] * 16), time)
        for lane, t in enumerate(time):
            expected = motion.at(float(t))
            matrix = np.array(
                [[row.x[lane], row.y[lane], row.z[lane]] for row in (found.x, found.y, found.z)]
            )
            shift = np.array([found.b.x[lane], found.b.y[lane], found.b.z[lane]])
            size = max(np.abs(expected).max(), 1.0) ** links
            np.testing.assert_allclose(matrix, expected[:3, :3], atol=4e-6 * size)
            np.testing.assert_allclose(shift, expected[:3, 3], atol=2e-5 * size)


def test_rigid_kernels_make_the_matrix_of_general_ones():
    """The short text for what only shifts and turns."""
    turn = [(t, translate(t, 2, 3) @ rotate((1, 2, 3), 300.0 * t)) for t in (0.0, 0.5, 1.0)]
    tables = MotionTable()
    tables.number(NOWHERE.then(keyframes(turn), (0.0, 1.0)).motion)
    assert tables.is_rigid
    rows, time = tables.tables([0], [0], 0), np.linspace(0.0, 0.999, 16, dtype=np.float32)
    number = np.zeros(16, np.uint32)
    a, b = rigid_matrix_at(rows, number, time), general_matrix_at(rows, number, time)
    for one, other in zip((a.x, a.y, a.z, a.b), (b.x, b.y, b.z, b.b), strict=True):
        for axis in "xyz":
            np.testing.assert_allclose(getattr(one, axis), getattr(other, axis), atol=1e-6)


@pytest.mark.parametrize("instant", [1e-45, 1e-30, 1e-9])
def test_keyframes_that_float32_cannot_tell_apart_are_one(instant):
    """A step within no time; the matrix at the opening is finite all the same."""
    frames = [(0.0, translate(0, 0, 0)), (instant, translate(1, 0, 0)), (1.0, translate(2, 0, 0))]
    tables = MotionTable()
    tables.number(NOWHERE.then(keyframes(frames), (0.0, 1.0)).motion)
    with np.errstate(all="raise", under="ignore"):
        rows = tables.tables([0], [0], 0)
    at = instantiate(matrix_at, Program(motion=("shapes",)), compiled=False)
    time = np.linspace(0.0, 0.9375, 16, dtype=np.float32)
    shift = at(rows, np.zeros(16, np.uint32), time).b.x
    np.testing.assert_allclose(shift[1:], 1.0 + time[1:], atol=1e-6)
    assert 0.0 <= shift[0] <= 1.0
