"""Cameras: rays through given points of the film, and the change of basis both ways."""

from collections import namedtuple

import numpy as np
import pytest

from alight.cameras import MODELS
from alight.cameras.orthographic import Orthographic
from alight.cameras.pinhole import Pinhole
from alight.cameras.rays import generate_ray, project, unproject
from alight.cameras.thin_lens import ThinLens
from alight.compiled.cameras import compile_camera
from alight.compiled.program import Program
from alight.scene.transform import IDENTITY, look_at, rotate, scale, translate
from lanewise.jit import instantiate, kernel
from lanewise.simd import LANES, load_lanes, store_lanes
from lanewise.view import View

EXAMPLES = [example for module in MODELS for example in module.EXAMPLES]
Tables = namedtuple("Tables", "camera")
SIZE = (64, 48)

MATRICES = {
    "identity": IDENTITY.matrix,
    "look_at": look_at((3.0, 1.0, -2.0), (0.5, 0.0, 0.25)).matrix,
    "enlarged": (translate(1.0, 2.0, 3.0) @ rotate("y", 130.0) @ scale(3.0)).matrix,
    "uneven and mirrored": (rotate("x", 40.0) @ scale(-1.0, 2.0, 0.5)).matrix,
}


@kernel
def rays_of_film(scene, film, out):
    """Six numbers a ray; `film` holds x, y, u and v of each."""
    for i in range(0, film.size // 4, LANES):
        x, y = load_lanes(film, 4 * i), load_lanes(film, 4 * i + LANES)
        u_lens = load_lanes(film, 4 * i + 2 * LANES), load_lanes(film, 4 * i + 3 * LANES)
        o, d = generate_ray(scene, x, y, u_lens)
        k = 6 * i
        store_lanes(out, k, o.x)
        store_lanes(out, k + LANES, o.y)
        store_lanes(out, k + 2 * LANES, o.z)
        store_lanes(out, k + 3 * LANES, d.x)
        store_lanes(out, k + 4 * LANES, d.y)
        store_lanes(out, k + 5 * LANES, d.z)


def twin_rays(camera, matrix, size, film_x, film_y, u_lens=(0.5, 0.5)):
    """Origins and directions, shape (n, 3) each, float64."""
    tables = Tables(compile_camera(camera, matrix, size))
    generate = instantiate(generate_ray, Program(camera=camera.type_name()), compiled=False)
    x, y = np.broadcast_arrays(np.float32(film_x), np.float32(film_y))
    u, v = (np.full(x.shape, c, np.float32) for c in u_lens)
    o, d = generate(tables, x, y, (u, v))
    stack = lambda p: np.stack([np.broadcast_to(c, x.shape) for c in (p.x, p.y, p.z)], -1)  # noqa: E731
    return stack(o).astype(np.float64), stack(d).astype(np.float64)


def film_points(n, size=SIZE, seed=1):
    u = np.random.default_rng(seed).random((4, n)).astype(np.float32)
    return u[0] * np.float32(size[0]), u[1] * np.float32(size[1]), u[2], u[3]


def test_corners_and_sides_of_the_viewport():
    """The corner and the centre of each side of the film, by hand, for a camera turned by 90 deg.

    Looking along world -x with +z up, image right is world +y.
    """
    matrix = look_at((5.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)).matrix
    w = np.array([1.0, 0.0, 0.0])
    u, v = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
    np.testing.assert_allclose(matrix[:3, :3], np.stack([u, v, w], -1), atol=1e-15)
    tangent_y = np.tan(np.radians(30.0))
    tangent_x = tangent_y * 200 / 100
    camera = Pinhole(fov=60.0, fov_axis="y")
    film_x, film_y = np.array([0, 200, 0, 200, 100, 100, 0]), np.array([0, 0, 100, 100, 50, 0, 50])
    o, d = twin_rays(camera, matrix, (200, 100), film_x, film_y)
    x = np.array([-1, 1, -1, 1, 0, 0, -1]) * tangent_x
    y = np.array([1, 1, -1, -1, 0, 1, 0]) * tangent_y
    expected = x[:, None] * u + y[:, None] * v - w
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    np.testing.assert_allclose(o, [[5.0, 0.0, 0.0]] * 7, atol=1e-6)
    np.testing.assert_allclose(d, expected, atol=2e-7)


def test_cornell_mapping():
    """The mapping that the reference scene is defined by: image left is world -x."""
    tangent, n = 0.3571433676669034, 512
    camera = Pinhole(fov=float(2.0 * np.degrees(np.arctan(tangent))))
    c, r = np.meshgrid(np.arange(0, n, 73), np.arange(0, n, 73))
    c, r = c.ravel() + 0.25, r.ravel() + 0.75
    o, d = twin_rays(camera, translate(0.0, 0.0, 3.9).matrix, (n, n), c, r)
    expected = np.stack(
        [(2 * c / n - 1) * tangent, (1 - 2 * r / n) * tangent, -np.ones(c.size)], -1
    )
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    np.testing.assert_allclose(d, expected, atol=1.2e-7)
    np.testing.assert_array_equal(o, np.float64(np.float32([[0.0, 0.0, 3.9]] * c.size)))


@pytest.mark.parametrize(
    ("axis", "size", "sides"),
    [
        ("x", (300, 200), (1.0, 2 / 3)),
        ("y", (300, 200), (1.5, 1.0)),
        ("smaller", (300, 200), (1.5, 1.0)),
        ("larger", (300, 200), (1.0, 2 / 3)),
        ("smaller", (200, 300), (1.0, 1.5)),
        ("larger", (200, 300), (2 / 3, 1.0)),
        ("diagonal", (300, 400), (0.6, 0.8)),
    ],
)
def test_field_of_view_axes(axis, size, sides):
    """With an opening angle of 90 degrees, the side that it spans has half extent 1."""
    from alight.cameras.pinhole import half_extents

    np.testing.assert_allclose(half_extents(Pinhole(fov=90.0, fov_axis=axis), *size), sides)


@pytest.mark.parametrize("matrix", MATRICES.values(), ids=MATRICES.keys())
@pytest.mark.parametrize("camera", EXAMPLES, ids=repr)
def test_rays_and_projection_agree(camera, matrix):
    """Points along the central ray of a film point are projected onto it, at the right depth."""
    x, y, _, _ = film_points(200)
    o, d = twin_rays(camera, matrix, SIZE, x, y)
    np.testing.assert_allclose(np.linalg.norm(d, axis=1), 1.0, atol=2e-7)
    inverse = np.linalg.inv(matrix)
    for t in (0.1, 3.0):
        p = o + t * d
        seen = project(camera, matrix, SIZE, p)
        depth = -(p @ inverse[:3, :3].T + inverse[:3, 3])[:, 2]
        # A narrow field of view magnifies the rounding of p.
        np.testing.assert_allclose(seen[:, 0], x, atol=2e-3)
        np.testing.assert_allclose(seen[:, 1], y, atol=2e-3)
        np.testing.assert_allclose(seen[:, 2], depth, rtol=1e-9)
        assert (depth > 0).all()


@pytest.mark.parametrize("matrix", MATRICES.values(), ids=MATRICES.keys())
@pytest.mark.parametrize("camera", EXAMPLES, ids=repr)
def test_change_of_basis_round_trip(camera, matrix):
    rng = np.random.default_rng(2)
    raster = rng.random((50, 2, 3)) * [2 * SIZE[0], 2 * SIZE[1], 9.0] - [SIZE[0], SIZE[1], -0.1]
    points = unproject(camera, matrix, SIZE, raster)
    np.testing.assert_allclose(project(camera, matrix, SIZE, points), raster, atol=1e-8)


def test_points_behind_a_pinhole_have_no_place_in_the_picture():
    seen = project(Pinhole(), np.eye(4), SIZE, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    assert np.isnan(seen[0, :2]).all()
    np.testing.assert_allclose(seen[1], [32.0, 24.0, 1.0])


@pytest.mark.parametrize("matrix", MATRICES.values(), ids=MATRICES.keys())
def test_thin_lens_is_sharp_at_the_focus_distance_only(matrix):
    camera = ThinLens(fov=50.0, aperture_radius=0.2, focus_distance=2.5)
    _, _, u, v = film_points(300)
    x, y = np.full(300, 11.0), np.full(300, 30.0)
    tables = Tables(compile_camera(camera, matrix, SIZE))
    generate = instantiate(generate_ray, Program(camera="thin_lens"), compiled=False)
    o, d = generate(tables, np.float32(x), np.float32(y), (u, v))
    o, d = (np.stack([p.x, p.y, p.z], -1).astype(np.float64) for p in (o, d))
    # In the camera's own space the lens is a disk of the given radius in the plane z = 0.
    inverse = np.linalg.inv(matrix)
    o_local = o @ inverse[:3, :3].T + inverse[:3, 3]
    d_local = d @ inverse[:3, :3].T
    radius = np.hypot(o_local[:, 0], o_local[:, 1])
    assert np.abs(o_local[:, 2]).max() < 1e-5
    assert radius.max() <= 0.2 + 1e-6
    # Uniform over the disk: E r^2 = R^2 / 2, and variance R^4 / 12.
    assert abs((radius**2).mean() - 0.02) < 4 * np.sqrt(0.2**4 / 12 / 300)
    for depth, sharp in ((2.5, True), (5.0, False)):
        p = o_local + d_local * (-depth / d_local[:, 2])[:, None]
        spread = p[:, :2].std(axis=0).max()
        assert (spread < 1e-5) == sharp
        if sharp:
            seen = project(camera, np.eye(4), SIZE, p)
            np.testing.assert_allclose(seen[:, :2], [[11.0, 30.0]] * 300, atol=1e-3)


def test_orthographic_rays_are_parallel_and_span_the_height():
    camera = Orthographic(height=3.0)
    o, d = twin_rays(camera, np.eye(4), (80, 60), [0.0, 80.0, 40.0], [0.0, 60.0, 30.0])
    np.testing.assert_allclose(d, [[0.0, 0.0, -1.0]] * 3)
    np.testing.assert_allclose(o, [[-2.0, 1.5, 0.0], [2.0, -1.5, 0.0], [0.0, 0.0, 0.0]], atol=1e-6)


def test_an_enlarged_camera_sees_the_same_directions_through_a_larger_lens():
    camera = ThinLens(aperture_radius=0.2, focus_distance=2.0)
    u_lens = (0.9, 0.3)
    x, y = np.array([5.0, 60.0]), np.array([40.0, 3.0])
    o, d = twin_rays(camera, np.eye(4), SIZE, x, y, u_lens)
    o4, d4 = twin_rays(camera, scale(4.0).matrix, SIZE, x, y, u_lens)
    np.testing.assert_allclose(o4, 4.0 * o, rtol=1e-6)
    np.testing.assert_allclose(d4, d, atol=2e-7)


@pytest.mark.parametrize("camera", [module.EXAMPLES[0] for module in MODELS], ids=repr)
def test_compiled_rays_are_the_twins(camera):
    n = 256
    film = np.ascontiguousarray(np.stack(film_points(n), 0))
    matrix = MATRICES["look_at"]
    tables = Tables(compile_camera(camera, matrix, SIZE))
    program = Program(camera=camera.type_name())
    # Blocks of 8 work for every packet width: the kernels run lane by lane.
    results = []
    for compiled in (True, False):
        run = instantiate(rays_of_film, program, compiled=compiled)
        lanes = compiled_lanes() if compiled else int(LANES)
        blocks = film.reshape(4, -1, lanes).swapaxes(0, 1)
        out = View(np.zeros(6 * n, np.float32))
        run(tables, View(np.ascontiguousarray(blocks)), out)
        results.append(out.array.reshape(-1, 6, lanes).swapaxes(0, 1).reshape(6, n))
    np.testing.assert_allclose(results[0], results[1], rtol=2e-6, atol=2e-7)


def compiled_lanes():
    from lanewise.machine import lanes_of_machine

    return lanes_of_machine()
