"""Pictures in other colour spaces than sRGB: their colours are converted, and it is said."""

import numpy as np
import pytest

from alight.scene.files import Files
from alight.scene.images import loaded, read_image
from alight.textures.bitmap import Bitmap

OpenEXR = pytest.importorskip("OpenEXR")

#: x and y of red, green and blue, and the white, as the standards give them.
SRGB = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.329)
AP0 = (0.73470, 0.26530, 0.0, 1.0, 0.00010, -0.07700, 0.32168, 0.33767)
AP1 = (0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767)
BT2020 = (0.708, 0.292, 0.170, 0.797, 0.131, 0.046, 0.3127, 0.329)
P3 = (0.680, 0.320, 0.265, 0.690, 0.150, 0.060, 0.314, 0.351)
ODD = (0.6, 0.3, 0.2, 0.7, 0.1, 0.05, 0.3127, 0.329)


#: Published matrices to linear sRGB: of ACES with Bradford's adaptation, and of ITU-R BT.2087.
FROM_AP1 = [[1.70505, -0.62179, -0.08326], [-0.13026, 1.14080, -0.01055],
            [-0.02400, -0.12897, 1.15297]]  # fmt: skip
FROM_BT2020 = [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]]


def read(folder, chromaticities, pixels):
    """What is read of a file, and what is said."""
    path = folder / "a.exr"
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    if chromaticities:
        header["chromaticities"] = chromaticities
    with OpenEXR.File(header, {"RGB": pixels}) as file:
        file.write(str(path))
    notes = []
    return read_image(path, "a.exr", notes.append).texels, notes


def notes_of(folder, chromaticities):
    grey = np.full((2, 4, 3), 0.25, np.float32)
    texels, notes = read(folder, chromaticities, grey)
    # White stays white, whatever the file's own is.
    np.testing.assert_allclose(texels, grey, atol=1e-6)
    return notes


@pytest.mark.parametrize(
    ("chromaticities", "name"),
    [(AP0, "ACES2065-1"), (AP1, "ACEScg"), (BT2020, "Rec. 2020"), (P3, "P3"),
     (ODD, "xy 0.6 0.3, 0.2 0.7, 0.1 0.05")],
)  # fmt: skip
def test_other_primaries_are_told(tmp_path, chromaticities, name):
    (note,) = notes_of(tmp_path, chromaticities)
    assert note.startswith(f'"a.exr": its primaries are not those of sRGB ({name})')


@pytest.mark.parametrize(
    ("chromaticities", "matrix"), [(AP1, FROM_AP1), (BT2020, FROM_BT2020)], ids=["AP1", "BT2020"]
)
def test_colours_are_converted(tmp_path, chromaticities, matrix):
    colors = np.array([[[0.5, 0.4, 0.3], [0.3, 0.35, 0.4]]], np.float32)
    texels, notes = read(tmp_path, chromaticities, colors)
    np.testing.assert_allclose(texels, colors @ np.array(matrix).T, atol=1e-4)
    assert notes[0].endswith("its colours were converted")
    # What sRGB cannot show is cut off, which is said too.
    texels, notes = read(tmp_path, chromaticities, np.array([[[0.0, 1.0, 0.0]]], np.float32))
    assert texels.min() == 0.0
    assert "negative light" in notes[1]


def test_primaries_on_a_line_are_told(tmp_path):
    line = (0.6, 0.3, 0.4, 0.3, 0.2, 0.3, 0.3127, 0.329)
    assert "span no space" in notes_of(tmp_path, line)[0]


@pytest.mark.parametrize("chromaticities", [None, SRGB])
def test_those_of_srgb_are_not(tmp_path, chromaticities):
    assert notes_of(tmp_path, chromaticities) == []


#: xy of daylight of 5 000 K, and Bradford's matrix from it to D65 in XYZ (CIE 15, Lindbloom).
D50 = (0.34567, 0.35851)
FROM_D50 = [[0.9555766, -0.0230393, 0.0631636], [-0.0282895, 1.0099416, 0.0210077],
            [0.0122982, -0.0204830, 1.3299098]]  # fmt: skip


def test_those_of_srgb_with_another_white_are_converted(tmp_path):
    """White stays white, and colours are those of primaries which add up to that white."""
    said = (*SRGB[:6], *D50)
    (note,) = notes_of(tmp_path, said)
    assert note.startswith('"a.exr": its primaries are not those of sRGB (sRGB with the white')
    columns = np.array([[x / y, 1.0, (1.0 - x - y) / y] for x, y in np.reshape(SRGB[:6], (3, 2))]).T
    of_white = [np.linalg.solve(columns, [x / y, 1.0, (1 - x - y) / y]) for x, y in (D50, SRGB[6:])]
    file, ours = (columns * weights for weights in of_white)
    colors = np.array([[[0.5, 0.4, 0.3], [0.3, 0.35, 0.4]]], np.float32)
    texels, _ = read(tmp_path, said, colors)
    wanted = colors @ (np.linalg.inv(ours) @ np.array(FROM_D50) @ file).T
    np.testing.assert_allclose(texels, wanted, atol=2e-4)
    assert np.abs(texels - colors).max() > 0.005


def test_a_white_that_is_rounded_is_that_of_srgb(tmp_path):
    assert notes_of(tmp_path, (*SRGB[:6], 0.313, 0.329)) == []


def test_numbers_that_are_no_colours_stay_as_they_are(tmp_path):
    """Of one file, read once for each use."""
    numbers = np.array([[[0.7, 0.4, 0.95]]], np.float32)
    read(tmp_path, AP0, numbers)
    files = Files(tmp_path)
    data, color = (
        loaded(Bitmap(file="a.exr", color_space=space), files).pixels.texels
        for space in ("linear", "auto")
    )
    assert np.array_equal(data, numbers)
    assert np.abs(color - numbers).max() > 0.1
    assert len(files.notes) == 1
