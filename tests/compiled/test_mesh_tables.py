"""Rows of meshes stand where each mesh looks for them, whatever attributes some of them lack."""

import itertools

import numpy as np
import pytest

from alight.compiled.mesh_tables import joined_if_any

FULL = [np.arange(6.0).reshape(3, 2), 10.0 + np.arange(4.0).reshape(2, 2)]
#: Zeros that take no memory, for a mesh without the attribute.
NONE = [np.broadcast_to(np.float32(0.0), (rows, 2)) for rows in (3, 2)]


@pytest.mark.parametrize("parts", list(itertools.product(*zip(FULL, NONE, strict=True))))
def test_an_attribute_has_a_row_for_each_vertex_unless_all_meshes_lack_it(parts):
    table = joined_if_any(list(parts), 2)
    assert table.dtype == np.float32
    lacking = all(one is other for one, other in zip(parts, NONE, strict=True))
    expected = np.zeros((1, 2)) if lacking else np.concatenate(parts)
    np.testing.assert_array_equal(table, expected)
