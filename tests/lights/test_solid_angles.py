"""Solid angles of lamps, as light sampling finds them, and their areas: closed forms."""

import numpy as np
import pytest

from alight.lights.area import Area
from alight.scene.transform import rotate, scale, translate
from alight.shapes.cube import Cube
from alight.shapes.disk import Disk
from alight.shapes.rectangle import Rectangle
from alight.shapes.sphere import Sphere
from tests.lights.test_light_sampling import ROOF, SHAPES, N, each_placement, sample, viewpoint
from tests.sampling.statistics import LARGEST_Z, z_of_mean
from tests.shapes.tracing import PLACEMENTS, World, directions


def solid_angle(world, p, n=N):
    """Mean of 1 / pdf, and its standard error."""
    light = sample(world, p, n)
    inverse = np.where(light.pdf > 0.0, 1.0 / np.where(light.pdf > 0.0, light.pdf, 1.0), 0.0)
    return inverse.mean(), inverse.std() / np.sqrt(n)


@pytest.mark.parametrize("h", [0.02, 0.5, 3.0, 100.0])
def test_solid_angle_of_a_rectangle(h):
    # Seen from above its middle: 4 arcsin(a b / sqrt((a^2 + h^2) (b^2 + h^2))).
    a, b = 1.5, 0.4
    found, error = solid_angle(World((Rectangle(), scale(a, b, 1).matrix, Area())), (0, 0, h))
    exact = 4.0 * np.arcsin(a * b / np.sqrt((a * a + h * h) * (b * b + h * h)))
    assert abs(found - exact) < LARGEST_Z * error + 1e-4 * exact


@pytest.mark.parametrize("h", [0.5, 3.0, 100.0])
def test_solid_angle_of_a_disk_on_its_axis(h):
    found, error = solid_angle(World((Disk(), np.eye(4), Area())), (0, 0, h), 60_000)
    exact = 2.0 * np.pi * (np.sqrt(h * h + 1.0) - h) / np.sqrt(h * h + 1.0)
    assert abs(found - exact) < LARGEST_Z * error + 1e-4 * exact


@pytest.mark.parametrize("h", [1.0001, 1.01, 2.0, 50.0, 1e4])
def test_solid_angle_of_a_sphere(h):
    found, error = solid_angle(World((Sphere(), np.eye(4), Area())), (0, h, 0))
    sin2 = 1.0 / h**2
    exact = 2.0 * np.pi * sin2 / (1.0 + np.sqrt(1.0 - sin2))
    # Uniform in the cone: no variance at all.
    assert error < 1e-5 * exact
    assert abs(found - exact) < 2e-3 * exact if h < 1.001 else abs(found - exact) < 1e-5 * exact


def test_inside_of_a_flipped_sphere_is_all_around():
    world = World((Sphere(flip_normals=True), PLACEMENTS["moved"], Area()))
    p = viewpoint(PLACEMENTS["moved"], 0.3)
    found, error = solid_angle(world, p, 60_000)
    assert abs(found - 4.0 * np.pi) < LARGEST_Z * error
    dark = World((Sphere(), PLACEMENTS["moved"], Area()))
    assert not np.any(sample(dark, p, N).pdf > 0.0)


#: The sides of two rectangles, and one in the plane of an axis.
TURNED = [scale(0.4).matrix, (rotate("x", 127) @ scale(0.4, 0.3, 1)).matrix,
          (translate(3, -7, 11) @ rotate((1, 2, 3), 40) @ scale(2, 0.1, 1)).matrix]  # fmt: skip


@pytest.mark.parametrize("shape", [Rectangle(), Rectangle(flip_normals=True), Disk()])
@pytest.mark.parametrize("placement", TURNED, ids=["axis", "turned", "moved"])
def test_no_light_reaches_a_flat_lamp_from_itself(shape, placement):
    """Its back may reflect, and would be lit by its front, which it hides."""
    world, worst = World((shape, placement, Area())), 0.0
    for x, y in np.random.default_rng(5).uniform(-0.7, 0.7, (60, 2)):
        light = sample(world, (placement @ [x, y, 0.0, 1.0])[:3], 200)
        arrives = np.where(light.pdf > 0.0, np.abs(light.cosine), 0.0)
        worst = max(worst, np.mean(arrives / np.where(light.pdf > 0.0, light.pdf, 1.0)))
    # Seen from a point before it, it would be pi.
    assert worst < 1e-3


@each_placement
@pytest.mark.parametrize("name", [*SHAPES, "cube"])
def test_area_is_that_of_the_image(name, placement):
    shape = {**SHAPES, "cube": Cube()}[name]
    area = sum(row.areas.sum() for row in World((shape, placement, Area())).shapes.rows)
    linear, rng = placement[:3, :3], np.random.default_rng(4)
    if name == "sphere":
        q = directions(400_000, rng)
        stretch = np.linalg.norm(np.linalg.inv(linear).T @ q, axis=0)
        values = 4.0 * np.pi * abs(np.linalg.det(linear)) * stretch
        assert abs(z_of_mean(values, area)) < LARGEST_Z or np.ptp(values) < 1e-5 * area
        return
    crosses = [np.linalg.norm(np.cross(linear[:, i - 2], linear[:, i - 1])) for i in range(3)]
    if name == "cylinder":
        return  # see tests/shapes/test_cylinder.py
    v = np.asarray(ROOF.vertices, float) @ linear.T
    exact = {
        "rectangle": 4.0 * crosses[2],
        "disk": np.pi * crosses[2],
        "cube": 8.0 * sum(crosses),
        "mesh": sum(
            0.5 * np.linalg.norm(np.cross(v[f[1]] - v[f[0]], v[f[2]] - v[f[0]])) for f in ROOF.faces
        ),
    }
    assert area == pytest.approx(exact[name], rel=1e-6)


def test_area_of_a_spheroid():
    # Oblate, a = 2, c = 1: 2 pi a^2 (1 + (1 - e^2) / e artanh e).
    e = np.sqrt(1.0 - 0.25)
    exact = 8.0 * np.pi * (1.0 + (1.0 - e * e) / e * np.arctanh(e))
    world = World((Sphere(), scale(2, 2, 1).matrix))
    assert world.shapes.rows[0].areas[0] == pytest.approx(exact, rel=1e-6)
