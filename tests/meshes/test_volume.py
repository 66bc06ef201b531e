"""The volume that triangles enclose, whose sign tells inside from outside."""

import numpy as np
import pytest

from alight.meshes.tessellation import welded
from alight.meshes.volume import enclosed_volume

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], np.float32)
SIDES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], np.int32)


def test_a_tetrahedron_has_a_sixth_of_its_cube():
    far = CORNERS * np.float32(3.0) + np.float32(100.0)
    assert enclosed_volume(far, SIDES) == pytest.approx(27.0 / 6.0, rel=1e-5)
    assert enclosed_volume(far, SIDES[:, ::-1]) == pytest.approx(-27.0 / 6.0, rel=1e-5)
    assert enclosed_volume(far, SIDES[:3]) == 0.0


@pytest.mark.parametrize("seed", range(6))
def test_a_card_with_two_faces_encloses_nothing_however_it_is_turned(seed):
    """Its volume is 0 but for rounding, and closed it is."""
    turn, _ = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))
    card = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) @ turn + 7.0 * turn[0]
    front = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    faces = np.concatenate([front, front[:, ::-1]])
    assert enclosed_volume(card.astype(np.float32), faces) == 0.0


def test_numbers_that_were_changed_are_read_again():
    """The volume is kept for arrays that cannot change, and those that could once."""
    corners, sides = CORNERS.copy(), SIDES.copy()
    for array in (corners, sides):
        array.setflags(write=False)
    before = enclosed_volume(corners, sides)
    corners.setflags(write=True)
    corners *= 2.0
    assert enclosed_volume(corners, sides) == pytest.approx(8.0 * before)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("axis", range(3))
def test_what_is_flat_is_so_at_any_scale(scale, axis):
    """A plate encloses something, and one without a thickness does not."""
    unit = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)], np.float64)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))], np.int32)
    for thickness in (1e-3, 0.0):
        sides = np.roll([1.0, 1.0, thickness], axis) * scale
        found = enclosed_volume((unit * sides).astype(np.float32), faces)
        np.testing.assert_allclose(found, sides.prod(), rtol=1e-3)


@pytest.mark.parametrize("place", [-3.0, -0.5, 0.0, 2.0])
def test_seams_close_wherever_a_mesh_stands(place):
    rng = np.random.default_rng(2)
    points = rng.uniform(0.0, 1.0, (40, 3)) + place
    # Each of them twice, 2e-7 apart.
    twice = np.concatenate([points, points + 2e-7 * rng.uniform(-1.0, 1.0, points.shape)])
    found = welded(twice.astype(np.float32))
    np.testing.assert_array_equal(found[:40], found[40:])
    np.testing.assert_allclose(found, twice, atol=1e-6)
    assert len(np.unique(found, axis=0)) == 40
