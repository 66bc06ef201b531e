"""Lists, tree, planes and instances together; ties; rays that make no sense."""

import numpy as np
import pytest

from alight.accel import Instance, build_accelerator
from alight.shapes import disk, plane, rectangle, sphere
from tests.accel.tracing import (
    World,
    icosphere,
    mismatches,
    same_bits,
    soup,
    soup_rays,
    torus,
    triangle_set,
    unit,
)


def placement(rng, size, spread):
    """A random rotation, scaling and shift, 4x4."""
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    matrix = np.eye(4)
    matrix[:3, :3] = q * size
    matrix[:3, 3] = spread * rng.normal(size=3)
    return matrix


def analytic_shapes(rng, n, first_shape):
    """n spheres, rectangles and disks: their descriptions and rows."""
    kinds = (sphere, sphere.Sphere()), (rectangle, rectangle.Rectangle()), (disk, disk.Disk())
    shapes, rows = [], []
    for i in range(n):
        model, spec = kinds[i % 3]
        row = model.pack(spec, placement(rng, 0.2, 1.0))
        offset = sum(len(r) for r in rows)
        shapes.append((spec.type, first_shape + i, offset, *model.bounds(row)))
        rows.append(row)
    return shapes, rows


def mixed_scene(seed):
    """Triangles, analytic shapes and a plane."""
    rng = np.random.default_rng(seed)
    triangles = triangle_set(
        (rng.normal(size=(150, 1, 3)) + 0.3 * rng.normal(size=(150, 3, 3))).reshape(-1, 3),
        np.arange(450).reshape(-1, 3),
        np.repeat([1, 7], 75),
    )
    shapes, rows = analytic_shapes(rng, 30, 10)
    below = np.eye(4)
    below[2, 3] = -2.0
    rows.append(plane.pack(plane.Plane(), below))
    planes = [("plane", 5, sum(len(r) for r in rows[:-1]))]
    return (triangles, shapes, planes), np.concatenate(rows)


def random_rays(seed, n):
    rng = np.random.default_rng(seed)
    return (2 * rng.normal(size=(n, 3))).astype(np.float32), unit(rng.normal(size=(n, 3))).astype(
        np.float32
    )


def test_a_mixed_scene_is_the_same_in_lists_in_the_tree_and_in_the_twin():
    parts, rows = mixed_scene(1)
    o, d = random_rays(2, 20_000)
    worlds = {s: World(*parts, data=rows, structure=s) for s in ("list", "bvh")}
    listed, tree = (w.trace(o, d) for w in worlds.values())
    assert same_bits(listed, tree)
    assert set(listed.shape.tolist()) >= {0, 1, 5, 7, *range(10, 40)}
    twin = worlds["list"].trace(o[:512], d[:512], compiled=False)
    assert all(a[:512].tobytes() == b.tobytes() for a, b in zip(listed, twin, strict=True))


def with_instance(vertices, faces):
    """A torus and a mesh in a tree of its own."""
    map_ = np.eye(4)[:3]
    instance = Instance(geometry=0, shape=5, to_world=map_, to_object=map_)
    main = triangle_set(*torus(30, 20, 0.1), 0)
    return World(main, [], [], [instance], [(vertices, faces)], structure="bvh").accel


def test_trees_of_instances_start_at_cache_lines():
    for level in (1, 2, 3):
        tree = with_instance(*icosphere(level)).tree
        assert tree.nodes.array.ctypes.data % 64 == 0
        assert tree.blocks.array.ctypes.data % 64 == 0


def test_vertices_that_no_face_uses_do_not_enlarge_an_instance():
    vertices, faces = icosphere(2)
    more = np.concatenate([vertices, [[1e6] * 3]]).astype(np.float32)
    boxes = [with_instance(v, faces).box.array for v in (vertices, more)]
    np.testing.assert_array_equal(*boxes)


def test_structures_of_a_scene_follow_from_its_size():
    small = triangle_set(icosphere(0)[0], icosphere(0)[1])
    big = triangle_set(*icosphere(3))
    assert build_accelerator(small)[1] == ("list triangles",)
    assert build_accelerator(big)[1] == ("tree",)
    assert build_accelerator()[1] == ()
    # Walls around a fine mesh stay in the list; the mesh goes into the tree.
    wall = np.array([[-3, -3, -3], [3, -3, -3], [0, 3, -3], [-3, -3, 3], [3, -3, 3], [0, 3, 3]])
    room = triangle_set(
        np.concatenate([wall, big.vertices]),
        np.concatenate([[[0, 1, 2], [3, 4, 5]], big.faces + 6]),
        np.repeat([0, 1], [2, len(big.faces)]),
    )
    _, plan, stats = build_accelerator(room)
    assert plan == ("list triangles", "tree")
    assert stats["listed"] == 2
    o, d = random_rays(3, 10_000)
    assert same_bits(World(room).trace(o, d), World(room, structure="list").trace(o, d))


@pytest.mark.parametrize("structure", ["list", "bvh"])
def test_ties_go_to_the_lowest_shape_then_the_lowest_primitive(structure):
    # Four copies of a square, one of them a rectangle, in shuffled order of shape numbers.
    square = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    faces = np.tile([[0, 1, 2], [0, 2, 3], [0, 1, 2], [0, 2, 3]], (3, 1))
    shapes = np.repeat([9, 4, 6], 4)
    row = rectangle.pack(rectangle.Rectangle(), np.eye(4))
    low, high = rectangle.bounds(row)
    rng = np.random.default_rng(4)
    o = np.concatenate([rng.uniform(-0.9, 0.9, (500, 2)), np.full((500, 1), 2.0)], axis=1)
    d = np.tile([0.0, 0.0, -1.0], (500, 1))
    for number, expected in ((5, 4), (2, 2), (4, 4), (30, 4)):
        world = World(
            triangle_set(square, faces, shapes),
            [("rectangle", number, 0, low, high)],
            data=row,
            structure=structure,
        )
        hits = world.trace(o.astype(np.float32), d.astype(np.float32))
        assert (hits.t == 2.0).all()
        assert (hits.shape == expected).all()
        assert (hits.prim <= 1).all()


@pytest.mark.parametrize("number", [0, 0xFFFF, 0x10000, 0x7FFFFFFF, 0xFFFFFFFE])
def test_a_shape_of_any_number_is_met_up_to_the_end_of_the_ray(number):
    triangle = triangle_set([[-1, -1, 0], [3, -1, 0], [-1, 3, 0]], [[0, 1, 2]], number)
    o, d = np.float32([[0.0, 0.0, 2.0]]), np.float32([[0.0, 0.0, -1.0]])
    hit = World(triangle).trace(o, d, t_max=2.0, compiled=False)
    assert (hit.t, hit.shape, hit.occluded) == (2.0, number, True)


@pytest.mark.parametrize("number", [2, 30])
def test_ties_between_a_list_and_the_tree_go_to_the_lowest_shape(number):
    """A triangle before the very same wall as a fine mesh."""
    at = np.linspace(-1.0, 1.0, 17)
    points = np.stack([*np.meshgrid(at, at), np.zeros((17, 17))], axis=-1).reshape(-1, 3)
    corner = (np.arange(16)[:, None] * 17 + np.arange(16)).reshape(-1, 1)
    faces = np.concatenate([corner + turn for turn in ([0, 1, 18], [0, 18, 17])])
    walls = triangle_set(
        np.concatenate([[[-3, -1, 0], [3, -1, 0], [0, 5, 0]], points]),
        np.concatenate([[[0, 1, 2]], faces + 3]),
        np.repeat([number, 4], [1, len(faces)]),
    )
    world = World(walls)
    assert world.plan == ("list triangles", "tree")
    rng = np.random.default_rng(5)
    o = np.concatenate([rng.uniform(-0.9, 0.9, (500, 2)), np.full((500, 1), 2.0)], axis=1)
    d = np.tile(np.float32([0.0, 0.0, -1.0]), (500, 1))
    hits = world.trace(o.astype(np.float32), d)
    assert (hits.t == 2.0).all()
    assert (hits.shape == min(number, 4)).all()


@pytest.mark.parametrize("structure", ["list", "bvh"])
def test_rays_that_make_no_sense_meet_nothing(structure):
    parts, rows = mixed_scene(5)
    world = World(*parts, data=rows, structure=structure)
    values = [np.nan, np.inf, -np.inf]
    good_o, good_d = np.array([0.1, 0.2, 3.0]), np.array([0.0, 0.0, -1.0])
    o, d, t_max = [], [], []
    for value in values:
        for axis in range(3):
            for which in range(2):
                bad = [good_o.copy(), good_d.copy()]
                bad[which][axis] = value
                o.append(bad[0])
                d.append(bad[1])
                t_max.append(np.inf)
    for bad_d, bad_t in (
        (np.zeros(3), np.inf),
        (-np.zeros(3), np.inf),
        (good_d, np.nan),
        (good_d, 0.0),
        (good_d, -1.0),
        (good_d, -np.inf),
    ):
        o.append(good_o)
        d.append(bad_d)
        t_max.append(bad_t)
    hits = world.trace(
        np.array(o, np.float32), np.array(d, np.float32), np.array(t_max, np.float32)
    )
    assert np.isinf(hits.t).all()
    assert not hits.occluded.any()
    assert (hits.shape == 0).all()
    # The same rays beside good ones leave those alone.
    fine = world.trace(good_o[None].astype(np.float32), good_d[None].astype(np.float32))
    assert np.isfinite(fine.t[0])


@pytest.mark.parametrize("scale", [1e-15, 1e-6, 1e6, 1e12])
def test_scenes_of_any_size(scale):
    triangles = soup(20)
    spread = np.median(np.abs(triangles.vertices))
    vertices = (triangles.vertices / spread * scale).astype(np.float32)
    scaled = triangles._replace(vertices=vertices)
    o, d = soup_rays(21, scaled, 5000)
    listed = World(scaled, structure="list").trace(o, d)
    assert same_bits(listed, World(scaled, structure="bvh").trace(o, d))
    assert np.isfinite(listed.t).mean() > 0.3


def test_absurd_coordinates_do_no_harm():
    triangles = soup(22)
    vertices = triangles.vertices.copy()
    vertices[::7] *= np.float32(1e30)
    vertices[5] = np.nan
    vertices[11] = np.inf
    vertices[::13] = np.float32(1e-40)
    broken = triangles._replace(vertices=vertices)
    o, d = soup_rays(23, triangles, 5000)
    listed = World(broken, structure="list").trace(o, d)
    assert same_bits(listed, World(broken, structure="bvh").trace(o, d))
    far = World(broken, structure="bvh").trace(o * np.float32(1e30), d * np.float32(1e-30))
    assert not np.isnan(far.t).any()


def instanced_scene(seed, copies):
    rng = np.random.default_rng(seed)
    geometries = [icosphere(2), icosphere(1)]
    instances = []
    for i in range(copies):
        matrix = placement(rng, np.exp(rng.normal(-1.7, 0.4)), 1.0)
        matrix[:3, :3] *= rng.uniform(0.5, 2.0, 3)
        instances.append((i % 2, 100 + i, matrix[:3], np.linalg.inv(matrix)[:3]))
    return instances, geometries


def test_instances_are_met_as_if_they_were_written_out():
    instances, geometries = instanced_scene(6, 40)
    parts, rows = mixed_scene(7)
    o, d = random_rays(8, 20_000)
    flat = World(*parts, instances, geometries, data=rows, structure="list").trace(o, d)
    tree = World(*parts, instances, geometries, data=rows).trace(o, d)
    same = (flat.shape == tree.shape) & (flat.prim == tree.prim)
    # They are rounded in different spaces: at edges they may differ.
    assert same.mean() > 0.999
    hit = same & np.isfinite(flat.t)
    np.testing.assert_allclose(flat.t[hit], tree.t[hit], rtol=1e-4, atol=1e-5)
    assert np.array_equal(tree.occluded, np.isfinite(tree.t))
    assert (tree.shape >= 100).sum() > 1000


def test_instances_agree_with_float64_away_from_edges():
    instances, geometries = instanced_scene(9, 30)
    o, d = random_rays(10, 20_000)
    tree = World(None, (), (), instances, geometries).trace(o, d)
    vertices, faces, first, start = [], [], {}, 0
    for geometry, shape, to_world, _ in instances:
        v, f = geometries[geometry]
        first[shape] = sum(len(x) for x in faces)
        vertices.append(v @ to_world[:, :3].T + to_world[:, 3])
        faces.append(f + start)
        start += len(v)
    flat = triangle_set(np.concatenate(vertices), np.concatenate(faces))
    which = np.where(
        np.isfinite(tree.t),
        [first.get(s, 0) + p for s, p in zip(tree.shape.tolist(), tree.prim.tolist(), strict=True)],
        -1,
    )
    wrong, decided = mismatches(flat, o, d, tree.t, which)
    assert wrong == 0
    assert decided > 10_000
