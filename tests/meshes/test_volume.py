"""The volume that triangles enclose, whose sign tells inside from outside."""

import numpy as np
import pytest

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
