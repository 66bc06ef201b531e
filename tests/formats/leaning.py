"""Where the normals of a picture lean on a shape, found by the light that the shape reflects."""

import numpy as np

from alight.bsdfs.dispatch import evaluate_bsdf
from alight.core.vec import Vec3
from tests.physics.test_maps_on_charts import N, hit_surfaces
from tests.shapes.tracing import rows

#: Not all in one plane, and near enough to the normals that none is behind one of them.
LIGHTS = np.array([[0.6, 0.0, 0.8], [0.0, 0.6, 0.8], [0.0, 0.0, 1.0]])


def normals_of(shape, texture):
    """Unit normals (n, 3) of a square in the plane z = 0 with a map, where rays meet it.

    White matte stuff sends up 1 / pi of the cosine between its normal and each of three lights.
    """
    run, surface, found = hit_surfaces(shape, np.eye(4), True, texture)
    up = np.float32([[0.0], [0.0], [1.0]]) * np.ones((3, N), np.float32)
    seen = []
    for wi in LIGHTS:
        local = [wi @ rows(axis) for axis in (surface.s, surface.t, surface.ns)]
        every = np.ones(N, bool)
        value, _ = run(evaluate_bsdf, surface, Vec3(*up), Vec3(*np.float32(local)), every)
        seen.append(np.pi * np.asarray(value.x, float)[found])
    assert found.sum() > 0.2 * N
    return np.linalg.solve(LIGHTS, seen).T
