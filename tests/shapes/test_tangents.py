"""The tangent of a surface is the way that its texture's u grows, on charts of every kind."""

import numpy as np
import pytest

from alight.shapes.derivatives import uv_derivatives
from alight.shapes.mesh import Mesh
from lanewise.jit import instantiate
from tests.shapes.test_derivatives import BODIES
from tests.shapes.tracing import PLACEMENTS, PROGRAM, World, directions, rows, unit

N = 3000


def charts(seed, normals):
    """A bumpy square whose triangles lie in the picture anyhow: turned, slanted, mirrored."""
    rng = np.random.default_rng(seed)
    places, faces = [], []
    for x, y in np.ndindex(4, 4):
        for corners in (((0, 0), (1, 0), (1, 1)), ((0, 0), (1, 1), (0, 1))):
            faces.append(len(places) + np.arange(3))
            places += [((x + a) / 2 - 1, (y + b) / 2 - 1, 0.1 * rng.normal()) for a, b in corners]
    tilted = rng.normal((0.0, 0.0, 1.0), 0.3, (len(places), 3))
    return Mesh(
        vertices=places,
        faces=faces,
        uvs=rng.normal(size=(len(places), 2)),
        normals=tilted if normals else None,
    )


CHARTS = {"charts": charts(1, normals=False), "smooth charts": charts(2, normals=True)}
SURFACES = BODIES | CHARTS
each_placement = pytest.mark.parametrize("matrix", PLACEMENTS.values(), ids=PLACEMENTS)


def check_tangents(shape, matrix, world, number=0):
    """Look at a shape from around, as shape `number` of a world; which charts are right-handed."""
    rng = np.random.default_rng(3)
    target = unit(rng.normal(size=(3, N)))
    if shape.type_name() != "sphere":
        target = rng.uniform(-0.7, 0.7, (3, N))
        target[2] *= 0.0 if shape.type_name() != "cylinder" else 1.0
    d = directions(N, rng)
    o = matrix[:3, :3] @ target + matrix[:3, 3:] - 3.0 * d
    hit = World((shape, matrix)).trace(o, d)
    found = np.isfinite(hit.t)
    g = world.surface_at(hit._replace(shape=np.full(N, number, np.uint32)), o, d, found)
    derivatives = instantiate(uv_derivatives, PROGRAM, compiled=False)
    along, across = (rows(v) for v in derivatives(world.scene, g))
    s, t, n = rows(g.s), rows(g.t), rows(g.ns)
    # The part of it that the shading normal leaves.
    flat = along - (along * n).sum(0) * n
    size = np.linalg.norm(flat, axis=0)
    clear = found & (size > 0.02 * np.linalg.norm(along, axis=0)) & (size > 1e-6)
    assert clear.sum() > 0.3 * N
    cosine = (s * flat).sum(0)[clear] / size[clear]
    assert np.quantile(cosine, 0.005) > 0.999, cosine.min()
    np.testing.assert_allclose(np.cross(s, t, axis=0)[:, clear], n[:, clear], atol=1e-5)
    return (np.cross(along, across, axis=0) * n).sum(0)[clear] > 0.0


@pytest.mark.parametrize("shape", SURFACES.values(), ids=SURFACES)
@pytest.mark.parametrize("flip", [False, True], ids=["", "flipped"])
@each_placement
def test_the_tangent_is_the_way_that_u_grows(shape, flip, matrix):
    shape = shape.replaced(flip_normals=flip)
    check_tangents(shape, matrix, World((shape, matrix)))


@pytest.mark.parametrize("shape", CHARTS.values(), ids=CHARTS)
@each_placement
def test_so_it_is_where_several_share_their_charts(shape, matrix):
    world = World(*[(shape, matrix)] * 3)
    assert len(world.shapes.instances) == 3
    right_handed = check_tangents(shape, matrix, world, 1)
    assert 0.2 < right_handed.mean() < 0.8
