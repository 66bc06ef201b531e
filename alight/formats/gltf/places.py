"""Places of nodes: what glTF allows them to be, and what it ignores of them.

A node's matrix must be a scale, then a rotation, then a shift; a shear that is left over goes into
the vertices. Cameras and lights stand where their nodes do and look the way these do, but are not
scaled by them.

Source: Khronos Group, glTF 2.0 specification, sections 3.5.3 and 3.10.2; KHR_lights_punctual.
"""

from __future__ import annotations

import numpy as np

from alight.scene.transform import Matrix

#: Largest cosine between the images of two axes that still counts as a right angle.
SKEWED = 1e-5
#: Scales along different axes that differ by more are lost when others take a matrix apart.
STRETCHED = 1e6


def unscaled(to_world: Matrix) -> Matrix:
    """The rotation and the shift of a matrix, as a camera or light has them.

    Parameters
    ----------
    to_world : (4, 4) float64
        Not singular.

    Returns
    -------
    (4, 4) float64
        Its z axis is that of `to_world`, its y axis in the plane of those of `to_world`; it is
        right-handed, also where `to_world` mirrors.
    """
    _, y, z = to_world[:3, :3].T
    z = z / np.linalg.norm(z)
    y = y / np.linalg.norm(y)
    y = y - (y @ z) * z
    y /= np.linalg.norm(y)
    result = np.eye(4)
    result[:3] = np.column_stack([np.cross(y, z), y, z, to_world[:3, 3]])
    return result


def is_skewed(to_world: Matrix) -> bool:
    """Whether the axes are no longer at right angles."""
    axes = to_world[:3, :3] / np.linalg.norm(to_world[:3, :3], axis=0)
    return bool(np.abs(axes.T @ axes - np.eye(3)).max() > SKEWED)


def fits_node(to_world: Matrix) -> bool:
    """Whether others can take a matrix apart into a scale, a rotation and a shift."""
    lengths = np.linalg.norm(to_world[:3, :3], axis=0)
    return not is_skewed(to_world) and bool(lengths.max() <= STRETCHED * lengths.min())


def unskewed(to_world: Matrix) -> tuple[Matrix, Matrix]:
    """A place in two steps, of which a node of glTF can take the second.

    Parameters
    ----------
    to_world : (4, 4) float64

    Returns
    -------
    placed : (4, 4) float64
        A rotation, perhaps with a mirror, and a shift.
    first : (3, 3) float64
        What comes before it: scale and shear, without a mirror.
    """
    rotation, first = np.linalg.qr(to_world[:3, :3])
    signs = np.sign(np.diag(first))
    placed = np.eye(4)
    placed[:3] = np.column_stack([rotation * signs, to_world[:3, 3]])
    return placed, signs[:, None] * first
