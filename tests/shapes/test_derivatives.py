"""Points move with their texture coordinates as `uv_derivatives` says."""

import numpy as np
import pytest

from alight.shapes.cylinder import Cylinder
from alight.shapes.derivatives import uv_derivatives
from alight.shapes.mesh import Mesh
from lanewise.jit import instantiate
from tests.shapes.test_surfaces import SHAPES
from tests.shapes.tracing import PLACEMENTS, PROGRAM, World, directions, rows, unit

N = 2000
BODIES = SHAPES | {
    "cylinder": Cylinder(p0=(0, 0, -1), p1=(0, 0, 1)),
    "mesh without coordinates": Mesh(
        vertices=((-1, -1, 0), (1, -1, 0), (1, 1, 0)), faces=((0, 1, 2),)
    ),
    "mesh of mirrored coordinates": Mesh(
        vertices=((-1, -1, 0), (1, -1, 0), (1, 1, 0)),
        faces=((0, 1, 2),),
        uvs=((1, 0), (0.1, 0.2), (0, 1)),
    ),
}


@pytest.mark.parametrize("shape", BODIES.values(), ids=BODIES)
@pytest.mark.parametrize("placement", ["moved", "sheared", "mirrored"])
def test_neighbouring_points_differ_by_the_derivatives(shape, placement):
    rng, matrix = np.random.default_rng(1), PLACEMENTS[placement]
    target = unit(rng.normal(size=(3, N)))
    if shape.type_name() != "sphere":
        target = rng.uniform(-0.6, 0.6, (3, N))
        target[2] *= 0.0 if shape.type_name() != "cylinder" else 1.0
    d = directions(N, rng)
    o = matrix[:3, :3] @ target + matrix[:3, 3:] - 3.0 * d
    world = World((shape, matrix))
    hit, g, found = world.surface(o.astype(np.float32), d.astype(np.float32))
    step = 2e-3 * directions(N, rng)
    there, h, too = world.surface((o + step).astype(np.float32), d.astype(np.float32))
    derivatives = instantiate(uv_derivatives, PROGRAM, compiled=False)
    along, across = (rows(v) for v in derivatives(world.scene, g))
    moved = rows(h.p) - rows(g.p)
    du, dv = (np.asarray(b, float) - a for a, b in ((g.u, h.u), (g.v, h.v)))
    size = np.linalg.norm(moved, axis=0)
    near = found & too & (hit.prim == there.prim) & (size > 1e-4) & (size < 5e-3)
    # Not over the seam of an angle, nor at the poles and the centre, where angles turn fast.
    near &= (abs(du) < 0.01) & (abs(dv) < 0.01)
    assert near.mean() > 0.2
    error = np.linalg.norm(moved - along * du - across * dv, axis=0)[near] / size[near]
    assert np.quantile(error, 0.95) < 0.02
