"""The tables of `alight.lights.targets`."""

from __future__ import annotations

import numpy as np

from alight.compiled.boxes import Box
from alight.compiled.light_tree import LightRow, by_power, find_leaves
from alight.compiled.shapes import CompiledShapes
from alight.core.vec import luminance
from alight.lights.bright_disk import Disk
from alight.lights.model import LIGHTS
from alight.lights.targets import FINE, SPHERE
from alight.shapes.hit import INFO as SHAPE_INFO
from alight.shapes.model import SHAPES
from lanewise.vec3 import Vec3


def targets(
    rows: list[LightRow], powers: np.ndarray, shapes: CompiledShapes, casters: np.ndarray
) -> np.ndarray:
    """The choice of a target, the spheres of all lights, which one is a disk of the sky, and boxes.

    Photons are still to come (`alight.compiled.photons`).

    Parameters
    ----------
    rows : list of LightRow
        One a light.
    powers : (n,) float64, W
    shapes : CompiledShapes
    casters : (k, 7) float64, metres
        Boxes around what casts caustics, as it rests, and the numbers of motions + 1.

    Returns
    -------
    (n + 1 + 4 n + 2 + 7 k,) float32
    """
    placed = np.array([row.shape >= 0 for row in rows], bool)
    points = {i: powers[i] for i, row in enumerate(rows) if _is_aimed_at(row) and powers[i] > 0.0}
    powers = np.where(placed, powers, 0.0)
    spheres = np.zeros((len(rows), SPHERE))
    leaves = find_leaves([row._replace(motion=None) for row in rows], powers, shapes)
    for number in np.flatnonzero(powers > 0.0):
        mine = leaves.row == number
        if mine.any():
            low, high = leaves.low[mine].min(axis=0), leaves.high[mine].max(axis=0)
            if rows[number].motion is not None:
                low, high = _at_rest(rows[number], shapes, (low, high))
            spheres[number] = *(0.5 * (low + high)), _radius(0.5 * (high - low))
    powers = np.where(spheres[:, 3] > 0.0, powers, 0.0)
    for number, power in points.items():
        far = LIGHTS[rows[number].kind].INFINITELY_FAR
        spheres[number] = *rows[number].numbers[:3], -FINE if far else FINE
        powers[number] = power
    # Of the sky's disks the brightest one.
    disks = [(_power(row, row.disk, shapes.radius), i) for i, row in enumerate(rows) if row.disk]
    power, far = max(disks, default=(0.0, 0))
    if power > 0.0:
        disk = rows[far].disk
        assert disk is not None
        spheres[far] = *disk.axis, -np.sin(disk.half_angle)
        powers[far] = power
    if not rows:
        return np.zeros(0, np.float32)
    return np.concatenate(
        [by_power(powers), spheres.ravel(), [far, len(casters)], casters.ravel()]
    ).astype(np.float32)


def _at_rest(row: LightRow, shapes: CompiledShapes, swept: Box) -> Box:
    """The box of a lamp that moves before it does; swept: that of its leaves."""
    model = SHAPES[shapes.rows[row.shape].kind]
    if model.bounds is None:
        return swept
    start = shapes.tables.info.array[row.shape * SHAPE_INFO + 3]
    return model.bounds(shapes.tables.data.array[start:])


def _is_aimed_at(row: LightRow) -> bool:
    """Whether it is a delta light, of which is known where it is."""
    model = LIGHTS[row.kind]
    return model.DELTA and (model.INFINITELY_FAR or row.cone is not None)


def _power(row: LightRow, disk: Disk, radius: float) -> float:
    """Of the disk alone, W."""
    mean = Vec3(*(a * b for a, b in zip(row.color, disk.mean, strict=True)))
    return LIGHTS[row.kind].power(float(luminance(mean)), 0.0, radius)


def _radius(half: np.ndarray) -> float:
    """Of a sphere around a box of half these sizes; what is as deep as wide is taken for a ball."""
    round_ = half.min() > 0.9 * half.max()
    return float(half.max() if round_ else np.linalg.norm(half))
