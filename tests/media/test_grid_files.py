"""Files of grids: what is read, and what is refused in words."""

import io
import struct

import numpy as np
import pytest

from alight.core.errors import OutputError, SceneError
from alight.outputs import read_image
from alight.scene.volumes import read_volume

VALUES = np.arange(12, dtype=np.float32).reshape(3, 2, 2)


def npy(values=VALUES):
    stream = io.BytesIO()
    np.save(stream, values)
    return stream.getvalue()


def vol(version=3, kind=1, sides=(2, 2, 3), channels=1, data=None):
    head = b"VOL" + struct.pack("<B5i6f", version, kind, *sides, channels, 0, 0, 0, 1, 1, 1)
    return head + (VALUES.tobytes() if data is None else data)


@pytest.mark.parametrize(("name", "data"), [("a.npy", npy()), ("a.vol", vol())])
def test_both_formats_hold_the_same_numbers(name, data, tmp_path):
    (tmp_path / name).write_bytes(data)
    np.testing.assert_array_equal(read_volume(tmp_path / name).values[..., 0], VALUES)


BROKEN = {
    # NumPy reads its headers as Python text.
    "header.npy": (npy().replace(b"'shape': (", b"'shape': (("), '"header.npy": is broken ('),
    "words.npy": (npy().replace(b"False", b"Fal$e"), '"words.npy": '),
    "short.npy": (npy()[:-3], '"short.npy": '),
    "huge.npy": (npy().replace(b"(3, 2, 2)", b"(9**9,2,)"), '"huge.npy": '),
    "flat.npy": (npy(VALUES[0]), "must have the shape (nz, ny, nx) or (nz, ny, nx, 3), got (2, 2)"),
    "negative.npy": (npy(-VALUES), "finite, >= 0 and at most 1e+15, got -1.0 at z 0, y 0, x 1"),
    "objects.npy": (npy(np.array([[["x"]]])), "must be an array of numbers"),
    "empty.vol": (b"", "is not a VOL file"),
    "version.vol": (vol(version=2), "must have version 3 and float32 values, got 2 and 1"),
    "kind.vol": (vol(kind=2), "must have version 3 and float32 values, got 3 and 2"),
    "channels.vol": (vol(channels=2), "must have 1 or 3 channels, got 2"),
    "short.vol": (vol(data=b"1234"), "must hold 12 values after its header, got 1"),
    "huge.vol": (vol(sides=(2**30, 2**30, 2)), "cells along each side"),
    "none.vol": (vol(sides=(0, 2, 2)), "must have 1 to"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_broken_files_are_refused_in_words(name, tmp_path):
    data, words = BROKEN[name]
    (tmp_path / name).write_bytes(data)
    with pytest.raises(SceneError) as caught:
        read_volume(tmp_path / name, name)
    [issue] = caught.value.issues
    assert issue.path == "file" and words in issue.message and "\n" not in issue.message


def test_pictures_with_such_a_header_are_refused_too(tmp_path):
    (tmp_path / "a.npy").write_bytes(BROKEN["header.npy"][0])
    with pytest.raises(OutputError, match=r"^cannot read .*a\.npy: is broken"):
        read_image(tmp_path / "a.npy")
