"""Shapes of pbrt at random: each vertex lies where its (u, v) says, and faces the way of pbrt.

Source: pbrt 3 and 4, "file formats"; PBR3 chapter 3, PBR4 sections 6.2 to 6.7: p(u, v), and the
normal dp/du x dp/dv, which ReverseOrientation and a mirrored transform turn round.
"""

import numpy as np
import pytest

from tests.formats.pbrt.reading import node, read, read_old
from tests.formats.pbrt.test_laws_of_cameras_and_films import listed

TAU = 2.0 * np.pi


def around(radius, z, angle):
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), z + 0.0 * radius])


def sphere(n, u, v):
    low, high = np.arccos(n["zmin"] / n["radius"]), np.arccos(n["zmax"] / n["radius"])
    theta = low + v * (high - low)
    return around(n["radius"] * np.sin(theta), n["radius"] * np.cos(theta), u * n["phi"])


def cylinder(n, u, v):
    return around(n["radius"] + 0.0 * v, n["zmin"] + v * (n["zmax"] - n["zmin"]), u * n["phi"])


def disk(n, u, v):
    radius = n["radius"] + v * (n["innerradius"] - n["radius"])
    return around(radius, n["height"] + 0.0 * v, u * n["phi"])


def cone(n, u, v):
    return around(n["radius"] * (1.0 - v), v * n["height"], u * n["phi"])


def paraboloid(n, u, v):
    z = n["zmin"] + v * (n["zmax"] - n["zmin"])
    return around(n["radius"] * np.sqrt(z / n["zmax"]), z, u * n["phi"])


def hyperboloid(n, u, v):
    begin, end = (np.array(n[name])[:, None] for name in ("p1", "p2"))
    x, y, z = (1.0 - v) * begin + v * end
    c, s = np.cos(u * n["phi"]), np.sin(u * n["phi"])
    return np.stack([x * c - y * s, x * s + y * c, z])


#: Formula, and its numbers with where they may lie; "phi" is phimax.
SHAPES = {
    "sphere": (sphere, {"radius": (2.0, 3.0), "zmin": (-1.9, -0.5), "zmax": (0.0, 1.9)}),
    "cylinder": (cylinder, {"radius": (0.5, 2.0), "zmin": (-2.0, -0.5), "zmax": (0.0, 2.0)}),
    "disk": (disk, {"radius": (1.0, 2.0), "innerradius": (0.1, 0.9), "height": (-1.0, 1.0)}),
    "cone": (cone, {"radius": (0.5, 2.0), "height": (0.5, 2.0)}),
    "paraboloid": (
        paraboloid, {"radius": (0.5, 2.0), "zmin": (0.1, 0.4), "zmax": (0.6, 2.0)},
    ),
    "hyperboloid": (hyperboloid, {}),
}  # fmt: skip
OF_3 = ("cone", "paraboloid", "hyperboloid")


def drawn(kind, seed):
    """The words of a shape at random, and its numbers."""
    rng = np.random.default_rng([seed, len(kind)])
    numbers = {name: rng.uniform(*ends) for name, ends in SHAPES[kind][1].items()}
    words = [f'"float {name}" {value:.9g}' for name, value in numbers.items()]
    if kind == "hyperboloid":
        numbers = {"p1": rng.uniform(0.5, 1.5, 3), "p2": rng.uniform(0.5, 1.5, 3) * [-1, 1, -1]}
        words = [f'"point3 {name}" [{listed(p)}]' for name, p in numbers.items()]
    degrees = rng.uniform(60.0, 350.0)
    words.append(f'"float phimax" {degrees:.9g}')
    return " ".join(words), {**numbers, "phi": np.radians(degrees)}


def orientation(mesh, formula):
    """+1 for each face that looks to dp/du x dp/dv, -1 for the others; 0 where that is 0."""
    a, b, c = (mesh.vertices[mesh.faces[:, i]].astype(float) for i in range(3))
    faces = np.cross(b - a, c - a) * (-1.0 if mesh.flip_normals else 1.0)
    u, v = mesh.uvs[mesh.faces].mean(axis=1).T.astype(float)
    h = 1e-5
    along_u = (formula(u + h, v) - formula(u - h, v)).T
    along_v = (formula(u, v + h) - formula(u, v - h)).T
    return np.sign((faces * np.cross(along_u, along_v)).sum(axis=1))


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("kind", SHAPES)
def test_vertices_lie_where_their_coordinates_say(kind, seed):
    words, numbers = drawn(kind, seed)
    load = read_old if kind in OF_3 else read

    def formula(u, v):
        return SHAPES[kind][0](numbers, u, v)

    mesh = node(load(f'Shape "{kind}" {words}')).shape
    u, v = mesh.uvs.T.astype(float)
    np.testing.assert_allclose(mesh.vertices, formula(u, v).T, atol=2e-5)
    assert 0.0 <= mesh.uvs.min() < 0.01
    assert 0.99 < mesh.uvs.max() <= 1.0
    # All of it is there: corners of (u, v) too.
    assert {(0.0, 0.0), (1.0, 1.0)} <= {tuple(row) for row in mesh.uvs.round(6).tolist()}
    # pbrt turns what is mirrored or reversed, and what is both not at all.
    for before, sign in (("", 1.0), ("ReverseOrientation", -1.0), ("Scale 1 1 -1", -1.0),
                         ("ReverseOrientation Scale -1 1 1", 1.0)):  # fmt: skip
        turned = node(load(f'{before}\nShape "{kind}" {words}')).shape
        found = orientation(turned, formula)
        assert (found != -sign).all()
        # Every other triangle of a tip has no area.
        assert (found == sign).mean() > (0.4 if kind == "cone" else 0.9)


def test_height_fields_rise_where_their_numbers_say():
    rng = np.random.default_rng(1)
    nu, nv, heights = 4, 3, rng.normal(size=(3, 4))
    given = f'"integer nu" {nu} "integer nv" {nv} "float Pz" [{listed(heights)}]'
    mesh = node(read_old(f'Shape "heightfield" {given}')).shape
    column, row = np.rint(mesh.vertices[:, :2] * [nu - 1, nv - 1]).astype(int).T
    np.testing.assert_allclose(mesh.vertices[:, 2], heights[row, column], rtol=1e-6)
    np.testing.assert_allclose(mesh.vertices[:, 0], column / (nu - 1), atol=1e-6)
    np.testing.assert_allclose(mesh.vertices[:, 1], row / (nv - 1), atol=1e-6)
    assert len({*zip(column.tolist(), row.tolist(), strict=True)}) == nu * nv
    assert (orientation(mesh, lambda u, v: np.stack([u, v, 0.0 * u])) == 1.0).all()


def spline(points, degree, x):
    """The uniform B-spline of Cox and de Boor at places x, whole numbers between its pieces."""
    knots = np.arange(len(points) + degree + 1) - degree
    basis = ((knots[:-1, None] <= x) & (x < knots[1:, None])).astype(float)
    for p in range(1, degree + 1):
        left = (x - knots[: -p - 1, None]) / p * basis[:-1]
        basis = left + (knots[p + 1 :, None] - x) / p * basis[1:]
    return basis.T @ points


def bezier(points, x):
    """Cubics one after the other, which share their ends, at places x."""
    piece = np.minimum(x.astype(int), (len(points) - 1) // 3 - 1)
    s = (x - piece)[:, None]
    a, b, c, d = (points[3 * piece + i] for i in range(4))
    return (1 - s) ** 3 * a + 3 * s * (1 - s) ** 2 * b + 3 * s * s * (1 - s) * c + s**3 * d


@pytest.mark.parametrize("degree", [2, 3])
@pytest.mark.parametrize("count", [4, 6])
def test_splines_are_the_curves_that_their_points_define(degree, count):
    points = np.random.default_rng(count).normal(size=(count, 3))
    given = f'"integer degree" {degree} "string basis" "bspline" "point3 P" [{listed(points)}]'
    widths = '"float width0" 0.3 "float width1" 0.1'
    curve = node(read(f'Shape "curve" {widths} {given}')).shape
    pieces = count - degree
    assert len(curve.points) == 3 * pieces + 1
    x = np.linspace(0.0, pieces, 31)[:-1]
    found = bezier(curve.points.astype(float), x)
    np.testing.assert_allclose(found, spline(points, degree, x), atol=1e-5)
    np.testing.assert_allclose(curve.radii, np.linspace(0.15, 0.05, 3 * pieces + 1), rtol=1e-5)
