"""The least and the largest of three numbers, whichever stands where."""

from itertools import permutations, product

import numpy as np
import pytest

from alight.core.vec import Vec3, max_component, min_component
from lanewise.jit import instantiate

ROWS = np.float32([*permutations((-2.0, 0.5, 3.0)), *product((-1.0, 4.0), repeat=3)])


@pytest.mark.parametrize(("text", "wanted"), [(min_component, np.min), (max_component, np.max)])
def test_it_is_that_of_numpy(text, wanted):
    found = instantiate(text, compiled=False)(Vec3(*ROWS.T))
    np.testing.assert_array_equal(found, wanted(ROWS, axis=1))
