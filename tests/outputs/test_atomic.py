"""Files are written whole or not at all, and what cannot be written is said at once."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from alight.core.errors import OutputError
from alight.outputs import FORMATS, check_writable, image, write_image
from alight.outputs.atomic import replacing

SUFFIXES = [module.SUFFIXES[0] for module in FORMATS]
NOISE = np.random.default_rng(1).random((64, 64, 3))

needs_permissions = pytest.mark.skipif(
    os.name != "posix" or os.geteuid() == 0, reason="root may write anywhere"
)


def names_in(folder):
    return sorted(path.name for path in folder.iterdir())


class Interruption(BaseException):
    """As KeyboardInterrupt, without ending the test run."""


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("failure", [OSError(errno.ENOSPC, "full"), Interruption()])
def test_a_failure_leaves_the_old_picture_and_nothing_else(tmp_path, monkeypatch, suffix, failure):
    path = tmp_path / f"a{suffix}"
    path.write_bytes(b"the good picture")
    module = image.format_of(path)
    write = module.write

    def half_written(beside, *arguments):
        write(beside, *arguments)
        with beside.open("r+b") as file:
            file.truncate(20)
        raise failure

    monkeypatch.setattr(module, "write", half_written)
    with pytest.raises((OutputError, Interruption)):
        write_image(path, NOISE)
    assert path.read_bytes() == b"the good picture"
    assert names_in(tmp_path) == [path.name]


@pytest.mark.parametrize("call", ["fsync", "replace"])
def test_a_failure_at_the_very_end_leaves_the_old_picture(tmp_path, monkeypatch, call):
    path = tmp_path / "a.npy"
    path.write_bytes(b"the good picture")

    def fail(*arguments):
        raise OSError(errno.EIO, "Input/output error")

    monkeypatch.setattr(*((os, "fsync") if call == "fsync" else (Path, "replace")), fail)
    with pytest.raises(OutputError, match=r"cannot write .*a\.npy: Input/output error"):
        write_image(path, NOISE)
    assert path.read_bytes() == b"the good picture"
    assert names_in(tmp_path) == ["a.npy"]


FULL_DISK = """
import resource, sys
import numpy as np
from alight.core.errors import OutputError
from alight.outputs import write_image

# A file may not grow beyond 4 kB: every format meets a real failure of the system's write.
resource.setrlimit(resource.RLIMIT_FSIZE, (4096, resource.RLIM_INFINITY))
try:
    write_image(sys.argv[1], np.random.default_rng(1).random((64, 64, 3)))
except OutputError as error:
    sys.exit(f"one message: {error}")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="needs resource limits")
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_full_disk_gives_one_message_and_leaves_the_old_picture(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    path.write_bytes(b"the good picture")
    done = subprocess.run(
        [sys.executable, "-c", FULL_DISK, path], capture_output=True, text=True, check=False
    )
    expected = f"one message: cannot write {path}: the file is larger than allowed here\n"
    assert done.stderr == expected
    assert path.read_bytes() == b"the good picture"
    assert names_in(tmp_path) == [path.name]


def test_a_link_is_written_through(tmp_path):
    (tmp_path / "there").mkdir()
    real, link = tmp_path / "there" / "real.npy", tmp_path / "link.npy"
    real.write_bytes(b"old")
    link.symlink_to(real)
    write_image(link, NOISE)
    assert link.is_symlink()
    assert np.load(real).shape == (64, 64, 3)


def test_new_files_are_readable_as_others_are(tmp_path):
    (tmp_path / "plain").touch()
    write_image(tmp_path / "a.npy", NOISE)
    assert (tmp_path / "a.npy").stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_long_names_are_written(tmp_path):
    path = tmp_path / ("é" * 120 + ".npy")
    write_image(path, NOISE)
    assert names_in(tmp_path) == [path.name]


def test_what_is_not_the_systems_fault_is_not_renamed(tmp_path):
    with pytest.raises(ZeroDivisionError), replacing(tmp_path / "a.txt") as beside:
        beside.write_text("half")
        raise ZeroDivisionError
    assert names_in(tmp_path) == []


# ---------------------------------------------------------------------------- before rendering


def test_writable_targets_pass_without_a_trace(tmp_path):
    check_writable(tmp_path / "new.png")
    (tmp_path / "old.exr").write_bytes(b"old")
    check_writable(tmp_path / "old.exr")
    assert names_in(tmp_path) == ["old.exr"]
    assert (tmp_path / "old.exr").read_bytes() == b"old"


def test_impossible_targets_are_refused_with_the_reason(tmp_path):
    (tmp_path / "file").touch()
    (tmp_path / "folder.png").mkdir()
    for name, reason in {
        "a.pgn": 'unknown suffix ".pgn"; did you mean ".png"',
        "a": "the name has no suffix",
        "none/a.png": f"the folder {tmp_path / 'none'} does not exist",
        "file/a.png": "a part of the path is a file, not a folder",
        "folder.png": "it is a folder; add a file name",
        "n" * 300 + ".png": "the name is too long",
    }.items():
        with pytest.raises(OutputError) as caught:
            check_writable(tmp_path / name)
        assert reason in str(caught.value)
        assert str(caught.value).startswith(f"cannot write {tmp_path / name}: ")


@needs_permissions
def test_closed_folders_and_protected_files_are_refused(tmp_path):
    (tmp_path / "a.png").touch(mode=0o444)
    with pytest.raises(OutputError, match="write-protected"):
        check_writable(tmp_path / "a.png")
    tmp_path.chmod(0o555)
    with pytest.raises(OutputError, match="no permission"):
        check_writable(tmp_path / "b.png")
