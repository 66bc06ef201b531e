"""Boxes contain their shapes, however these are turned, stretched, slanted and moved.

Here, of shapes whose outermost points have a formula, that they are not larger than need be, too.
Of all others, `alight.laws.shapes` proves that hits lie in the box.
"""

from types import SimpleNamespace

import numpy as np
import pytest

from alight.compiled.shapes import compile_shapes
from alight.core.constants import gamma
from alight.laws.materials import stacked
from alight.scene import keyframes, rotate, scale, translate
from alight.scene.files import Files
from alight.scene.flatten import NO_GEOMETRY, PlacedShape
from alight.scene.meshes import geometry
from alight.scene.motion import NOWHERE
from alight.shapes.mesh import Mesh, triangle_error
from alight.shapes.model import SHAPES
from alight.shapes.sphere import INVERSE, MATRIX, on_ellipsoid
from lanewise.vec3 import Vec3
from lanewise.view import View

_CORNERS = np.array(np.meshgrid([-1.0, 1.0], [-1.0, 1.0], [-1.0, 1.0])).reshape(3, -1)


# ---------------------------------------------------------------- points that reach farthest


def farthest(rows):
    """Unit vectors (d, 6) along the rows (3, d) of a matrix and against them.

    They are where the coordinates of its image of the unit sphere (or circle) are extreme.
    """
    along = (rows / np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), 1e-30)).T
    return np.concatenate([along, -along], axis=1)


def of_a_sphere(spec, a):
    return spec.radius * farthest(a) + np.array(spec.center)[:, None]


def of_a_disk(spec, a):
    return np.vstack([farthest(a[:, :2]), np.zeros((1, 6))])


def of_a_cylinder(spec, a):
    p0, axis = np.array(spec.p0), np.subtract(spec.p1, spec.p0)
    across = np.linalg.svd(axis[None])[2][1:].T
    rim = p0[:, None] + spec.radius * (across @ farthest(a @ across))
    return np.concatenate([rim, rim + axis[:, None]], axis=1)


#: (shape, 3 x 3 matrix) -> points (3, n) of the shape in its own space, among them those whose
#: images reach farthest along each axis of the world. Of every finite shape that is one thing.
OUTLINES = {
    "sphere": of_a_sphere,
    "rectangle": lambda spec, a: _CORNERS * [[1.0], [1.0], [0.0]],
    "disk": of_a_disk,
    "cube": lambda spec, a: _CORNERS,
    "mesh": lambda spec, a: spec.vertices.T.astype(float),
    "cylinder": of_a_cylinder,
}
SPECS = [
    spec
    for model in SHAPES.values()
    for spec in model.EXAMPLES
    if spec.finite and not model.is_many
]
NAMES = [f"{spec.type_name()}-{i}" for i, spec in enumerate(SPECS)]
each_shape = pytest.mark.parametrize("spec", SPECS, ids=NAMES)


def turn(rng):
    """A random rotation."""
    return rotate(tuple(rng.normal(size=3)), rng.uniform(-180.0, 180.0))


def placements(count, seed):
    """Matrices: turned by an eighth of a circle about each axis, then any."""
    rng = np.random.default_rng(seed)
    for axis in np.eye(3):
        yield rotate(tuple(axis), 45.0).matrix
    for _ in range(count):
        size = np.exp(rng.uniform(-2.0, 2.0, 3)) * rng.choice([-1.0, 1.0], 3)
        place = translate(*rng.normal(size=3) * 10.0 ** rng.uniform(-1.0, 2.0))
        yield (place @ turn(rng) @ scale(*size) @ turn(rng)).matrix


def compiled(spec, matrix, motion=None):
    """The tables of one shape."""
    geometries, index = [], NO_GEOMETRY
    if isinstance(spec, Mesh):
        geometries, index = [geometry(spec, Files())], 0
    placed = PlacedShape("shape", spec, matrix, 0, None, index, motion=motion)
    return compile_shapes(SimpleNamespace(shapes=[placed], geometries=geometries))


def outline(spec, matrix):
    """The points in the world, (3, n)."""
    points = OUTLINES[spec.type_name()](spec, matrix[:3, :3])
    return matrix[:3, :3] @ points + matrix[:3, 3:]


def check_contains(low, high, points, loosest):
    """A box holds the points but for the rounding of its numbers, and is not much larger."""
    least, most = points.min(axis=1), points.max(axis=1)
    size = np.linalg.norm(most - least)
    rounding = 3e-7 * (np.abs(points).max() + size)
    assert np.all(low <= least + rounding), (low - least) / size
    assert np.all(high >= most - rounding), (most - high) / size
    assert np.all(least - low <= loosest * size + 10.0 * rounding), (least - low) / size
    assert np.all(high - most <= loosest * size + 10.0 * rounding), (high - most) / size


@each_shape
def test_the_box_is_that_of_the_points_farthest_out(spec):
    for matrix in placements(25, 1):
        points = outline(spec, matrix)
        shapes = compiled(spec, matrix)
        boxes = [(low, high) for _, _, _, low, high in shapes.analytic]
        corners = shapes.triangles.vertices
        boxes += [(corners.min(axis=0), corners.max(axis=0))] if len(corners) else []
        low, high = np.min([b[0] for b in boxes], axis=0), np.max([b[1] for b in boxes], axis=0)
        check_contains(low, high, points, 1e-5)
        # And the sphere around the scene is the one around this box.
        far = np.abs(points - shapes.center[:, None]).max(axis=1)
        rounding = 3e-7 * np.abs(points).max()
        assert np.linalg.norm(far) <= shapes.radius * (1.0 + 1e-5) + rounding


@each_shape
def test_the_box_of_what_moves_holds_it_at_every_time(spec):
    rng = np.random.default_rng(2)
    for matrix in placements(4, 3):
        frames = [
            (t, translate(*rng.normal(size=3)) @ turn(rng) @ scale(*np.exp(rng.normal(size=3))))
            for t in (0.0, 0.45, 1.0)
        ]
        motion = NOWHERE.then(keyframes(frames), (0.0, 1.0)).motion
        moving = compiled(spec, matrix, motion).moving
        low = np.min([part.low for part in moving], axis=0)
        high = np.max([part.high for part in moving], axis=0)
        times = np.linspace(0.0, 1.0, 64)
        reached = np.concatenate([outline(spec, motion.at(t) @ matrix) for t in times], axis=1)
        # The box at rest is moved as a box: it may be as much larger as its corners stand out.
        check_contains(low, high, reached, 1.0)


# ---------------------------------------------------------------- bounds of errors


def test_the_error_of_a_triangle_reaches_along_its_normal_and_as_far_as_its_edges():
    rng = np.random.default_rng(8)
    v0, v1, v2, n = rng.normal(size=(4, 3, 500)).astype(np.float32)
    found = triangle_error(*(Vec3(*v) for v in (v0, v1, v2, n)))
    reach = np.sum(np.abs(n) * np.max(np.abs([v0, v1, v2]), axis=0), axis=0)
    extent = np.max(np.abs([v1 - v0, v2 - v0]), axis=(0, 1))
    np.testing.assert_allclose(found, gamma(16) * reach + gamma(6) * extent, rtol=1e-5)


def test_the_error_of_an_ellipsoid_is_that_of_its_gradient():
    """|n . dp| with dp of each operation: the rows of |M^-1| weigh point and image by |q|."""
    rng, n = np.random.default_rng(9), 500
    inverse, q, p = rng.normal(size=(3, 3)), rng.normal(size=(3, n)), rng.normal(size=(3, n))
    matrix = np.linalg.inv(inverse)
    data = np.zeros(64, np.float32)
    data[:3] = rng.normal(size=3)
    data[MATRIX : MATRIX + 9], data[INVERSE : INVERSE + 9] = matrix.ravel(), inverse.ravel()
    o, k = Vec3(*p.astype(np.float32)), np.zeros(n, np.uint32)
    d = Vec3(*q.astype(np.float32))
    found = on_ellipsoid(View(data), k, o, d, np.ones(n, np.float32))
    image = inverse @ (p + q - data[:3, None])
    image /= np.linalg.norm(image, axis=0)
    point = data[:3, None] + matrix @ image
    weight, size = np.abs(inverse.T) @ np.abs(image), np.linalg.norm(inverse.T @ image, axis=0)
    reach = np.abs(matrix) @ np.abs(image)
    expected = gamma(4) * np.sum(weight * np.abs(point), axis=0)
    expected += gamma(12) * np.sum(weight * reach, axis=0) + gamma(32)
    np.testing.assert_allclose(found[3], expected / size, rtol=1e-3)
    np.testing.assert_allclose(stacked(found[0], n), point, rtol=1e-3, atol=1e-4)
