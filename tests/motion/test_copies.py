"""Copies that move alike, and several meshes in the list of what moves."""

import numpy as np

from tests.motion.moving import compiled
from tests.motion.test_kernels import rays, trace_rays, traced, twin_of

#: Two meshes, which share one table of corners, and something between them.
PARTS = (
    """{type: mesh, vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
        faces: [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]}""",
    "disk",
    """{type: mesh, vertices: [[-1, 0, 1], [-2, 0, 1], [-1, 1, 0], [-1, 0, 2]],
        faces: [[1, 2, 3], [0, 3, 2]]}""",
)


def in_step(*shapes):
    """A scene of shapes that all move in the same way."""
    moved = "{keyframes: [{time: 0, scale: 2}, {time: 1, scale: 3, translate: [0, 1, 0]}]}"
    nodes = (f"  n{i}: {{shape: {s}, transform: {moved}}}\n" for i, s in enumerate(shapes))
    return compiled("nodes:\n" + "".join(nodes))


def test_of_copies_that_move_alike_the_first_is_met_as_if_it_were_alone():
    """A tie goes to the lowest shape; a mesh finds its own triangles behind those of another."""
    o, d, time = rays(1024)
    given = np.ascontiguousarray(np.concatenate([o, d, time[None]]))
    scene, alone = in_step(*PARTS, *PARTS), in_step(PARTS[2])
    assert "tree" not in scene.program.accel
    t, shape, prim, *_ = traced(scene, twin_of(trace_rays, scene), given)
    assert set(shape[np.isfinite(t)]) == {0.0, 1.0, 2.0}
    alone = traced(alone, twin_of(trace_rays, alone), given)
    mine = shape == 2.0
    np.testing.assert_array_equal(t[mine], alone[0, mine])
    np.testing.assert_array_equal(prim[mine], alone[2, mine])
    assert np.all(t <= alone[0])
