"""Pictures that are written band by band."""

import numpy as np
from PIL import Image

from alight.outputs import write_image
from alight.outputs.picture import Picture


def test_bands_of_a_png_are_one_picture(tmp_path, monkeypatch):
    rng = np.random.default_rng(8)
    picture = Picture(rng.random((11, 5, 3), np.float32), alpha=rng.random((11, 5), np.float32))
    found = []
    for rows in (64, 4):
        monkeypatch.setattr("alight.outputs.png._BAND", rows)
        write_image(tmp_path / "a.png", picture)
        with Image.open(tmp_path / "a.png") as image:
            found.append(np.asarray(image))
    assert found[0].shape == (11, 5, 4)
    np.testing.assert_array_equal(found[1], found[0])
