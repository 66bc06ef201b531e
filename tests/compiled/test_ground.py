"""Where the ground is on which shadows are caught."""

from types import SimpleNamespace

import numpy as np

from alight.compiled import ground


def test_the_ground_is_below_the_middle_of_all_shapes(monkeypatch):
    """Its light is measured there: at the lowest point's height, in the middle along x and z."""
    asked = []
    monkeypatch.setattr(
        ground, "measured_ground", lambda program, tables, point: asked.append(point)
    )
    shapes = SimpleNamespace(lowest=-2.0, center=np.array([3.0, 5.0, 7.0]))
    flat = SimpleNamespace(shapes=[], lights=[])
    ground.ground_of(flat, shapes, SimpleNamespace(media=(), motion=False), ())
    [point] = asked
    assert point.tolist() == [3.0, -2.0, 7.0]
