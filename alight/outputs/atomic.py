"""Writing a file whole or not at all.

The new file is written next to the old one, synced to disk, and then renamed over it: a full
disk, a crash or Ctrl-C leaves the old file as it was, and nothing half-written behind.
"""

from __future__ import annotations

import errno
import os
import platform
import secrets
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from alight.core.errors import OutputError

_REASONS = {
    errno.ENOSPC: "the disk is full",
    errno.EDQUOT: "the disk quota is used up",
    errno.EFBIG: "the file is larger than allowed here",
    errno.EACCES: "no permission to write there",
    errno.EPERM: "no permission to write there",
    errno.EROFS: "the disk is read-only",
    errno.ENOENT: "the folder does not exist",
    errno.ENOTDIR: "a part of the path is a file, not a folder",
    errno.ENAMETOOLONG: "the name is too long",
}


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a temporary path next to `path` to write to, and move it over `path` at the end.

    Raises
    ------
    OutputError
        If anything could not be written. `path` is then what it was before.
    """
    # Through a symbolic link to the file that it names, as an ordinary write would go.
    target = Path(os.path.realpath(path))
    beside = _name_beside(target)
    try:
        yield beside
        _force_to_disk(beside)
        beside.replace(target)
    except OSError as error:
        raise _output_error(path, error) from error
    finally:
        # After a successful rename there is nothing left to remove.
        with suppress(OSError):
            beside.unlink()
    if os.name == "posix":
        # The rename itself is safe only once the folder is on the disk.
        with suppress(OSError):
            _force_to_disk(target.parent)


def _force_to_disk(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def check_folder(path: str | os.PathLike[str]) -> None:
    """Refuse a path that `replacing` could not write to, by trying.

    Raises
    ------
    OutputError
    """
    target = Path(os.path.realpath(path))
    try:
        if target.is_dir():
            raise OutputError(f"cannot write {os.fspath(path)}: it is a folder; add a file name")
        if target.exists() and not os.access(target, os.W_OK):
            raise OutputError(f"cannot write {os.fspath(path)}: the file is write-protected")
        probe = _name_beside(target)
        probe.touch(exist_ok=False)
        probe.unlink()
    except OSError as error:
        raise _output_error(path, error) from error


def remove_abandoned(folder: Path) -> None:
    """Remove temporary files whose writers on this machine were killed."""
    # Elsewhere asking for a process by its number might end it.
    if os.name != "posix":
        return
    for path in folder.glob(f".alight-{_machine()}-*.tmp"):
        writer = path.name.split("-")[2]
        if writer.isdigit() and not _is_running(int(writer)):
            with suppress(OSError):
                path.unlink()


def _is_running(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True


def _machine() -> str:
    # In a folder that machines share, the process of another one may still be writing.
    return f"{zlib.crc32(platform.node().encode()):08x}"


def _name_beside(target: Path) -> Path:
    return target.with_name(f".alight-{_machine()}-{os.getpid()}-{secrets.token_hex(4)}.tmp")


def _output_error(path: str | os.PathLike[str], error: OSError) -> OutputError:
    if isinstance(error, OutputError):
        return error
    reason = _REASONS.get(error.errno or 0, error.strerror or str(error))
    parent = Path(os.path.realpath(path)).parent
    if error.errno == errno.ENOENT:
        reason = f"the folder {parent} does not exist"
    return OutputError(f"cannot write {os.fspath(path)}: {reason}")
