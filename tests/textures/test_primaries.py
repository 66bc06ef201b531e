"""Pictures in other colour spaces than sRGB: told, since their numbers are not converted."""

import numpy as np
import pytest

from alight.scene.images import read_image

OpenEXR = pytest.importorskip("OpenEXR")

#: x and y of red, green and blue, and the white, as the standards give them.
SRGB = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.329)
AP0 = (0.73470, 0.26530, 0.0, 1.0, 0.00010, -0.07700, 0.32168, 0.33767)
AP1 = (0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767)
BT2020 = (0.708, 0.292, 0.170, 0.797, 0.131, 0.046, 0.3127, 0.329)
P3 = (0.680, 0.320, 0.265, 0.690, 0.150, 0.060, 0.314, 0.351)
ODD = (0.6, 0.3, 0.2, 0.7, 0.1, 0.05, 0.3127, 0.329)


def notes_of(folder, chromaticities):
    path = folder / "a.exr"
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    if chromaticities:
        header["chromaticities"] = chromaticities
    pixels = np.full((2, 4, 3), 0.25, np.float32)
    with OpenEXR.File(header, {"RGB": pixels}) as file:
        file.write(str(path))
    notes = []
    np.testing.assert_array_equal(read_image(path, "a.exr", notes.append).texels, pixels)
    return notes


@pytest.mark.parametrize(
    ("chromaticities", "name"),
    [(AP0, "ACES2065-1"), (AP1, "ACEScg"), (BT2020, "Rec. 2020"), (P3, "P3"),
     (ODD, "xy 0.6 0.3, 0.2 0.7, 0.1 0.05")],
)  # fmt: skip
def test_other_primaries_are_told(tmp_path, chromaticities, name):
    (note,) = notes_of(tmp_path, chromaticities)
    assert note.startswith(f'"a.exr": its primaries are not those of sRGB ({name})')


@pytest.mark.parametrize("chromaticities", [None, SRGB])
def test_those_of_srgb_are_not(tmp_path, chromaticities):
    assert notes_of(tmp_path, chromaticities) == []
