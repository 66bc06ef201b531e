"""What tasks share: read where it lies, once in the memory of a machine."""

import hashlib
import mmap
import os
from pathlib import Path

import numpy as np
import pytest

from alight.cluster.shared_file import forget, mapped, packed, unpacked
from alight.cluster.worker import Shared
from lanewise.view import View
from tests.cluster.workers import two_workers

THING = {
    "odd": np.arange(7, dtype=np.uint8), "none": np.zeros(0), "text": "x" * 5,
    "views": [View(np.arange(6.0, dtype=np.float32).reshape(2, 3)), np.arange(5) * 1.5],
}  # fmt: skip


def digest_of(data):
    return hashlib.sha256(data).hexdigest()


def test_arrays_are_views_of_the_bytes_and_aligned():
    data = bytearray(packed(THING))
    found = unpacked(data)
    np.testing.assert_array_equal(found["odd"], THING["odd"])
    assert (found["none"].size, found["text"]) == (0, "xxxxx")
    view, array = found["views"]
    np.testing.assert_array_equal(view.shaped, THING["views"][0].shaped)
    np.testing.assert_array_equal(array, THING["views"][1])
    start = np.frombuffer(data, np.uint8).ctypes.data
    for one in (found["odd"], view.shaped, array):
        assert start <= one.ctypes.data < start + len(data)
        assert (one.ctypes.data - start) % 64 == 0


def test_a_file_is_written_once_and_mapped_by_all(tmp_path):
    data = packed(THING)
    one, other = (mapped(tmp_path, digest_of(data), data) for _ in range(2))
    (path,) = tmp_path.iterdir()
    assert path.stat().st_mode & 0o077 == 0
    assert isinstance(one, mmap.mmap)
    assert one[:] == other[:] == data
    # A process that writes changes nobody else's.
    one[-1] = (one[-1] + 1) % 256
    assert other[:] == data == path.read_bytes()
    forget(tmp_path, digest_of(data))
    assert not list(tmp_path.iterdir())
    assert other[:] == data


def test_a_file_of_other_bytes_is_not_used(tmp_path):
    data = packed(THING)
    (tmp_path / f"alight-{digest_of(data)}").write_bytes(b"\0" * len(data))
    assert mapped(tmp_path, digest_of(data), data) is data


def test_without_a_folder_the_bytes_stay_where_they_are(tmp_path):
    data = packed(THING)
    assert mapped(tmp_path / "none", digest_of(data), data) is data


def test_files_that_nobody_removed_go_after_a_day(tmp_path):
    old, new = tmp_path / "alight-old", tmp_path / "alight-new"
    for path in (old, new):
        path.write_bytes(b"")
    os.utime(old, (0, 0))
    mapped(tmp_path, "0", b"data")
    assert not old.exists()
    assert new.exists()


def pages_of(name):
    """Resident shared memory and private memory of mappings of a file, kB."""
    shared = private = 0
    ours = False
    with Path("/proc/self/smaps").open() as file:
        for line in file:
            word = line.split()
            if "-" in word[0] and not word[0].endswith(":"):
                ours = name in line
            elif ours and word[0].startswith("Shared"):
                shared += int(word[1])
            elif ours and word[0].startswith("Private"):
                private += int(word[1])
    return shared, private


@pytest.mark.skipif(not Path("/proc/self/smaps").exists(), reason="Linux tells pages by mapping")
def test_two_workers_share_pages():
    thing = Shared(np.random.default_rng(0).integers(0, 256, 2**22, np.uint8))
    with two_workers() as client:
        client.register_plugin(thing)
        told = client.run(pages_of, thing.digest)
        client.unregister_worker_plugin(thing.name)
    for shared, private in told.values():
        assert shared > 4000
        assert private < 100
