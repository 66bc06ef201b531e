"""What AttributeBegin and TransformBegin keep comes back whole at their ends."""

import numpy as np
import pytest

from tests.formats.pbrt.reading import node, read, read_old


@pytest.mark.parametrize(
    ("kind", "read"), [("Attribute", read), ("Transform", read), ("Transform", read_old)]
)
@pytest.mark.parametrize("when", ["StartTime", "EndTime", "All"])
def test_both_times_and_what_is_active_are_kept(kind, read, when):
    """Inside, other times move; outside, all is as it was."""
    before = "Translate 1 2 3\nActiveTransform EndTime\nTranslate 0 0 4\n"
    inside = f"{kind}Begin\nActiveTransform {when}\nTranslate 5 6 7\nRotate 40 1 0 0\n{kind}End\n"
    ball = 'Shape "sphere"'
    frames = [
        [frame.matrix for _, frame in node(read(text)).transform.frames]
        for text in (f"{before}{ball}", f"{before}{inside}{ball}")
    ]
    np.testing.assert_array_equal(frames[0], frames[1])
    # What follows moves the end alone, as before.
    moved = node(read(f"{before}{inside}Translate 8 0 0\n{ball}")).transform.frames
    places = [frame.matrix[:3, 3].tolist() for _, frame in moved]
    assert places == [[1.0, 2.0, 3.0], [9.0, 2.0, 7.0]]
