"""What the table of a light tree says of lamps at a point, which paths never meet."""

import numpy as np
import pytest

from alight.lights.tree.traversal import mis_probability
from alight.lights.tree.ways import with_ways
from tests.lights.test_light_tree import UP, choices, crowd, far_lamps, points, run


@pytest.mark.parametrize("p", [(1.0, 2.0, 0.3), (3.5, 3.6, 0.7), (400.0, -3.0, 2.0)])
@pytest.mark.parametrize(
    ("made", "first"), [(lambda: crowd("tree"), 24), (far_lamps, 1)], ids=["crowd", "far lamps"]
)
def test_lamps_at_a_point_are_as_probable_as_light_sampling_says(made, first, p):
    world = made()
    scene = world.scene._replace(lights=with_ways(world.scene.lights))
    found, _ = choices(world, p, UP)
    chosen = (found.pmf > 0.0) & (world.scene.lights.data.array[found.index * 16 + 3] == 0.0)
    lamps, at = np.unique(np.where(chosen, found.index, 0), return_index=True)
    at = at[lamps >= first]
    assert len(at) > 1
    lamps, on = found.index[at].astype(np.uint32), np.ones(len(at), bool)
    asked = run(mis_probability, scene, lamps, lamps * 0, points(p, len(at)), on)
    np.testing.assert_allclose(asked, found.mis_pmf[at], rtol=1e-5)
