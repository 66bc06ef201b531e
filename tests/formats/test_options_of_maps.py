"""Options of pictures in MTL files: what is left out of them has the default of the format.

Source: Wavefront Technologies, MTL material format: ``-s u v w`` with 1, ``-o u v w`` with 0.
"""

import numpy as np
import pytest
from PIL import Image

from alight.formats.obj.maps import read_map
from alight.formats.reading.reach import Reach
from alight.formats.reading.report import Report
from alight.textures.uv import parse_uv_transform


@pytest.mark.parametrize(
    ("options", "wanted"),
    [
        ("-s 2", [[2, 0, 0], [0, 1, 0]]),
        ("-s 2 3", [[2, 0, 0], [0, 3, 0]]),
        ("-s 2 3 4", [[2, 0, 0], [0, 3, 0]]),
        ("-o 0.5", [[1, 0, 0.5], [0, 1, 0]]),
        ("-o 0.5 0.25", [[1, 0, 0.5], [0, 1, 0.25]]),
        ("-o 0.5 0.25 -s 2 3", [[2, 0, 0.5], [0, 3, 0.25]]),
        ("-s 2 3 -o 0.5 0.25", [[2, 0, 0.5], [0, 3, 0.25]]),
    ],
)
def test_pictures_are_scaled_and_then_shifted(options, wanted, tmp_path):
    Image.new("L", (2, 2), 9).save(tmp_path / "p.png")
    report = Report()
    found = read_map("map_kd", f"{options} p.png".split(), "a:1:1", Reach(tmp_path), report)
    np.testing.assert_allclose(parse_uv_transform(found.data["to_uv"]).matrix[:2], wanted)
    assert not report.issues
