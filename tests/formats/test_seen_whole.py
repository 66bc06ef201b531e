"""The automatic camera sees every point of a scene, whatever its shapes and transforms."""

import numpy as np
import pytest

from alight.cameras.basis import perspective_half_extents, project_points
from alight.formats.geometry.bounds import Bounds
from alight.scene import flatten
from tests.formats.bare import load
from tests.formats.usd.stage import stage_text

UP = np.array([0.0, 0.0, 1.0])
SIZES = [None, (600, 60), (60, 600)]


def points_of(shape, n=400):
    """Points of a shape with a formula, or of a mesh, in its own space."""
    rng = np.random.default_rng(n)
    around, along = rng.uniform(0.0, 2.0 * np.pi, n), rng.uniform(-1.0, 1.0, n)
    ring = np.stack([np.cos(around), np.sin(around), 0.0 * around], axis=1)
    kind = shape.type_name()
    if kind == "sphere":
        unit = ring * np.sqrt(1.0 - along**2)[:, None] + np.outer(along, [0, 0, 1])
        return np.asarray(shape.center) + shape.radius * unit
    if kind == "disk":
        return ring
    if kind == "cylinder":
        assert shape.p0 == (0.0, 0.0, 0.0)
        assert shape.p1 == (0.0, 0.0, 1.0)
        return shape.radius * ring + np.outer(np.sign(along) > 0, [0, 0, 1])
    if kind == "mesh":
        return shape.vertices
    square = np.array([[x, y, 0.0] for x in (-1, 1) for y in (-1, 1)])
    return np.concatenate([square - UP, square + UP]) if kind == "cube" else square


def farthest_out(path, size):
    """Where the points of a scene are in its picture at any time, and how much of it they fill."""
    changes = [] if size is None else [f"film.size=[{size[0]}, {size[1]}]"]
    flat = flatten(load(path, changes))
    placed, size = flat.camera, flat.film.size
    extents = perspective_half_extents(placed.camera.fov, placed.camera.fov_axis, *size)
    seen = []
    for item in flat.shapes:
        points = points_of(item.shape) @ item.to_world[:3, :3].T + item.to_world[:3, 3]
        for time in (0.0,) if item.motion is None else np.linspace(0.0, 1.0, 33):
            moved = np.eye(4) if item.motion is None else item.motion.at(time)
            world = points @ moved[:3, :3].T + moved[:3, 3]
            film = project_points(world, extents, size, placed.to_world, perspective=True)
            assert (film[:, 2] > 0.0).all()
            seen.append(film[:, :2] / size)
    seen = np.concatenate(seen)
    return seen.min(axis=0), seen.max(axis=0)


def demand_seen(path, size, fills=0.5):
    low, high = farthest_out(path, size)
    assert (low >= 0.0).all()
    assert (high <= 1.0).all()
    assert (high - low).max() > fills


def random_matrix(rng):
    linear = np.linalg.qr(rng.normal(size=(3, 3)))[0] @ np.diag(rng.uniform(0.2, 2.0, 3))
    linear = linear @ np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return np.block([[linear, rng.uniform(-3.0, 3.0, (3, 1))], [np.zeros((1, 3)), np.ones(1)]])


# ---------------------------------------------------------------- Mitsuba


def matrix_xml(matrix):
    return f'<matrix value="{" ".join(str(x) for x in matrix.ravel())}"/>'


def to_world(rng):
    return f'<transform name="to_world">{matrix_xml(random_matrix(rng))}</transform>'


def shape_xml(rng, kind, inner=""):
    inner = inner or to_world(rng)
    return f'<shape type="{kind}">{inner}</shape>'


def moving(rng):
    frames = "".join(
        f'<transform time="{t}"><rotate y="1" angle="{rng.uniform(-85, 85)}"/>'
        f'<translate x="{rng.uniform(-9, 9)}" y="{rng.uniform(-9, 9)}"/></transform>'
        for t in (0, 0.4, 1)
    )
    return f'<animation name="to_world">{frames}</animation>'


KINDS = ("sphere", "cube", "rectangle", "disk", "cylinder")


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("kind", KINDS)
def test_shapes_of_mitsuba(kind, size, tmp_path):
    for seed in range(4):
        xml = shape_xml(np.random.default_rng(seed), kind)
        (tmp_path / "a.xml").write_text(f'<scene version="3.0.0">{xml}</scene>')
        demand_seen(tmp_path / "a.xml", size, 0.85)


@pytest.mark.parametrize("seed", range(4))
def test_instances_and_motion_of_mitsuba(seed, tmp_path):
    rng = np.random.default_rng(100 + seed)
    group = "".join(shape_xml(rng, kind) for kind in rng.choice(KINDS, 3))
    instance = '<shape type="instance">{}<ref id="g"/></shape>'
    body = f'<shape type="shapegroup" id="g">{group}</shape>'
    body += "".join(instance.format(to_world(rng)) for _ in range(3))
    body += instance.format(moving(rng)) + shape_xml(rng, rng.choice(KINDS), moving(rng))
    (tmp_path / "a.xml").write_text(f'<scene version="0.6.0">{body}</scene>')
    demand_seen(tmp_path / "a.xml", SIZES[seed % 3])


# ---------------------------------------------------------------- OpenUSD


def usd_matrix(matrix):
    rows = ", ".join(f"({', '.join(str(x) for x in row)})" for row in matrix.T)
    return (
        f"matrix4d xformOp:transform = ({rows})\n"
        'uniform token[] xformOpOrder = ["xformOp:transform"]\n'
    )


GPRIMS = {
    "Sphere": "double radius = 1.5",
    "Cube": "double size = 3",
    "Cylinder": 'double height = 3\nuniform token axis = "X"',
    "Cone": 'double radius = 2\nuniform token axis = "Y"',
    "Capsule": "double height = 3",
    "Plane": 'double width = 3\nuniform token axis = "Y"',
}


@pytest.mark.parametrize("up", ["Y", "Z"])
@pytest.mark.parametrize("kind", GPRIMS)
def test_gprims_of_usd(kind, up, tmp_path):
    pytest.importorskip("pxr")
    for seed in range(3):
        outer, inner = (
            usd_matrix(random_matrix(np.random.default_rng(s))) for s in (seed, seed + 9)
        )
        text = f'def Xform "x" {{\n{outer}\ndef {kind} "g" {{\n{GPRIMS[kind]}\n{inner}\n}}\n}}\n'
        (tmp_path / "a.usda").write_text(stage_text(text, up, 0.01))
        demand_seen(tmp_path / "a.usda", SIZES[seed], 0.85)


def test_instances_of_gprims(tmp_path):
    pytest.importorskip("pxr")
    rng = np.random.default_rng(3)
    text = """
    def PointInstancer "p" {
        rel prototypes = [</p/ball>]
        int[] protoIndices = [0, 0, 0]
        point3f[] positions = [(0, 0, 0), (9, 1, 0), (0, 4, -3)]
        def Sphere "ball" {
        double radius = 2
        %s
        }
    }
    """ % usd_matrix(random_matrix(rng))  # noqa: UP031
    (tmp_path / "a.usda").write_text(stage_text(text))
    demand_seen(tmp_path / "a.usda", None)


# ---------------------------------------------------------------- what adds nothing


def test_what_is_infinite_flat_or_wrong_adds_nothing():
    bounds = Bounds()
    bounds.add({"type": "plane"}, np.eye(4))
    bounds.add({"type": "sphere", "radius": -1.0}, np.eye(4))
    assert not bounds.parts
    bounds.add({"type": "sphere"}, np.diag([1.0, 1.0, 0.0, 1.0]))
    np.testing.assert_array_equal(bounds.low, 0.0)
