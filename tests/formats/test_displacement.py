"""Displacement of files by its formula: how far points move, what that costs, who is left out."""

import numpy as np
import pytest

from alight.formats.geometry.bounds import Bounds
from alight.formats.geometry.displacement import (
    MOST_OF_ALL,
    MOST_OF_MESH,
    Heights,
    Lifting,
    _pieces,
)
from alight.formats.reading.report import Report
from alight.shapes.mesh import Mesh

PICTURE = {"type": "bitmap", "file": "p.png"}


@pytest.mark.parametrize("seed", range(20))
def test_heights_are_a_factor_and_an_offset_and_reach_as_far_as_they_can(seed):
    rng = np.random.default_rng(seed)
    factor, offset = rng.normal(size=2) * 10.0 ** rng.uniform(-3, 3, 2)
    made = Heights.of(PICTURE, factor, offset)
    values = np.linspace(0.0, 1.0, 11)
    moved = made.scale * (values - made.midlevel)
    scale = abs(factor) + abs(offset)
    np.testing.assert_allclose(moved, factor * values + offset, atol=1e-12 * scale)
    np.testing.assert_allclose(made.reach, np.abs(factor * values + offset).max(), rtol=1e-12)
    # Of a number it is what that says.
    number = Heights(float(rng.normal()), factor, offset)
    np.testing.assert_allclose(number.reach, abs(factor * (number.value - offset)), rtol=1e-12)


@pytest.mark.parametrize("factor", [0.0, 1e-20])
def test_a_picture_that_is_less_than_rounding_is_a_number(factor):
    made = Heights.of(PICTURE, factor, 0.25)
    assert not isinstance(made.value, dict)
    assert made.scale * (made.value - made.midlevel) == 0.25 == made.reach


def cut(corners, edge):
    """Triangles when the longest edge is halved until none is longer."""
    waiting, count = [*corners], 0
    while waiting:
        a = waiting.pop()
        sides = np.linalg.norm(np.roll(a, -1, axis=0) - a, axis=1)
        k = int(sides.argmax())
        if sides[k] <= edge:
            count += 1
            continue
        p, q, r = a[k], a[(k + 1) % 3], a[(k + 2) % 3]
        middle = 0.5 * (p + q)
        waiting += [np.array([p, middle, r]), np.array([middle, q, r])]
    return count


@pytest.mark.parametrize("stretch", [1.0, 10.0])
def test_pieces_are_about_as_many_as_there_are(stretch):
    rng = np.random.default_rng(5)
    corners = rng.normal(size=(8, 3, 3)) * [stretch, 1.0, 1.0]
    for edge in (0.4, 1.0):
        count = cut(corners, edge)
        assert 0.5 * count < _pieces(corners, edge) < 4.0 * count
    # Where nothing is cut there is a piece each, and a small share.
    assert 8.0 <= _pieces(corners * 1e-3, 1.0) < 9.0


def test_pieces_of_a_triangle_by_its_area_and_its_longest_side():
    """Half of 3 times 4 over a fifth of the square of an edge; the longest side is 5."""
    rng = np.random.default_rng(1)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    corners = (np.array([[[0, 0, 0], [3, 0, 0], [0, 4, 0]]]) @ turn)[:, rng.permutation(3)]
    np.testing.assert_allclose(_pieces(corners, 0.5), 6.0 / (0.2 * 0.25) + 2.0 * 5.0 / 0.5 + 1.0)
    np.testing.assert_allclose(_pieces(corners, 6.0), 6.0 / (0.2 * 36.0) + 1.0)


#: Of the triangles of `square`.
CORNERS = np.array([[[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 0, 0], [1, 1, 0], [0, 1, 0]]], float)


def square(side=1.0):
    """A square in z = 0 of two triangles."""
    points = side * np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
    uvs = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
    return Mesh(vertices=points, faces=np.array([[0, 1, 2], [0, 2, 3]]), uvs=uvs)


def test_a_mesh_keeps_its_heights_and_what_it_reaches_is_seen():
    lifting, bounds = Lifting(Report(), {}), Bounds()
    world = np.diag([2.0, 3.0, 5.0, 1.0])
    world[:3, 3] = 7.0, 8.0, 9.0
    heights = Heights(PICTURE, 0.5, 0.75)
    made = lifting.lift(square(), heights, bounds, world)
    assert (made.displacement_scale, made.displacement_midlevel) == (0.5, 0.75)
    assert lifting.textures == {made.displacement: PICTURE}
    # The same picture has one name, another one its own.
    again = lifting.lift(square(), heights._replace(scale=0.1), bounds, world)
    other = lifting.lift(square(), Heights({**PICTURE, "file": "q.png"}, 0.1), bounds, world)
    assert made.displacement == again.displacement != other.displacement
    # From -0.375 to 0.375 to all sides of the square.
    low, high = np.array([-0.375, -0.375, -0.375]), np.array([1.375, 1.375, 0.375])
    stretch, shift = np.diag(world)[:3], world[:3, 3]
    np.testing.assert_allclose(bounds.low, low * stretch + shift)
    np.testing.assert_allclose(bounds.high, high * stretch + shift)


def test_meshes_are_cut_until_memory_holds_no_more():
    lifting = Lifting(Report(), {})
    edges = []
    for _ in range(100):
        made = lifting.lift(square(), Heights(1.0, 0.1), Bounds(), np.eye(4))
        if made.displacement is None:
            break
        edges.append(made.displacement_edge)
    one = _pieces(CORNERS, edges[0])
    assert one <= MOST_OF_MESH
    # All have the same edge, a part of the diagonal or as much longer as is needed.
    assert len(set(edges)) == 1
    steps = np.log(edges[0] / (np.sqrt(2.0) / 256)) / np.log(1.25)
    assert abs(steps - round(steps)) < 1e-9
    finer = _pieces(CORNERS, edges[0] / 1.25)
    assert round(steps) == 0 or finer > MOST_OF_MESH
    assert len(edges) == MOST_OF_ALL // one
