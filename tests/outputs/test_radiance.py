"""Radiance pictures as its own encoder may write them: runs of all lengths, exposures."""

import numpy as np
import pytest

from alight.outputs import hdr
from alight.outputs.display import Display
from alight.outputs.image import write_image
from alight.outputs.picture import as_picture

OpenEXR = pytest.importorskip("OpenEXR")


def encoded(line, rng):
    """One channel of a scan line as runs: of equal bytes up to 127, and of any up to 128."""
    at, found = 0, b""
    while at < len(line):
        same = 1
        while at + same < len(line) and same < 127 and line[at + same] == line[at]:
            same += 1
        if same > 2:
            found, at = found + bytes([128 + same, line[at]]), at + same
            continue
        length = min(int(rng.choice([1, 2, 100, 127, 128])), len(line) - at)
        found, at = found + bytes([length, *line[at : at + length]]), at + length
    return found


@pytest.mark.parametrize("seed", range(3))
def test_runs_of_all_lengths_are_read(seed, tmp_path):
    rng = np.random.default_rng([109, seed])
    height, width = 3, 700
    rgbe = rng.integers(1, 256, (height, width, 4)).astype(np.uint8)
    # Long runs of equal bytes among those that differ.
    rgbe[:, 150:420], rgbe[1:, 500:503] = rgbe[:, 150:151], 7
    body = b"".join(
        bytes([2, 2, width >> 8, width & 255])
        + b"".join(encoded(bytes(row[:, channel]), rng) for channel in range(4))
        for row in rgbe
    )
    head = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode()
    (tmp_path / "a.hdr").write_bytes(head + body)
    wanted = rgbe[..., :3] * np.exp2(rgbe[..., 3:].astype(float) - 136.0)
    try:
        found = hdr.read(tmp_path / "a.hdr")
    except ValueError as error:
        found = str(error)
    assert not isinstance(found, str), found
    np.testing.assert_allclose(found, wanted, rtol=1e-6)


def test_all_exposures_of_a_picture_are_undone(tmp_path):
    """Each line says what the values were multiplied by, one after the other."""
    pixel = bytes([128, 64, 32, 129])
    head = b"#?RADIANCE\nEXPOSURE=4\nFORMAT=32-bit_rle_rgbe\nEXPOSURE= 0.5\n\n-Y 1 +X 1\n"
    (tmp_path / "a.hdr").write_bytes(head + pixel)
    np.testing.assert_allclose(hdr.read(tmp_path / "a.hdr")[0, 0], [0.5, 0.25, 0.125])


def test_the_resolution_of_an_exr_is_in_dots_per_inch(tmp_path):
    """The standard attribute xDensity: horizontal pixels per inch."""
    picture = as_picture(np.ones((2, 2, 3), np.float32))
    write_image(tmp_path / "a.exr", picture, **vars(Display(dpi=300.0)))
    with OpenEXR.File(str(tmp_path / "a.exr")) as file:
        assert file.header()["xDensity"] == pytest.approx(300.0)
