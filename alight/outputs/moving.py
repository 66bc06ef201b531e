"""Moving pictures: APNG by our own encoder, GIF by Pillow, MP4 by the FFmpeg of imageio-ffmpeg."""

from __future__ import annotations

import importlib.util
import queue
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import chain
from pathlib import Path
from typing import Self

import numpy as np

from alight.core.errors import OutputError
from alight.core.extras import install_command
from alight.outputs import apng
from alight.outputs.atomic import replacing

#: Endings of files that hold many pictures.
SUFFIXES = (".gif", ".apng", ".mp4")

#: Frames that wait for an encoder.
_WAITING = 2

#: sRGB has the primaries of BT.709, so its matrix makes luma and chroma of pictures. Without these
#: tags players guess by the size.
_COLORS = (
    "-vf", "scale=out_color_matrix=bt709:out_range=tv", "-colorspace", "bt709",
    "-color_primaries", "bt709", "-color_trc", "iec61966-2-1", "-color_range", "tv",
)  # fmt: skip

#: Seconds after which it is looked whether an encoder still lives.
_LOOK_EVERY = 0.1


def is_moving(path: Path) -> bool:
    """Whether a file of this name holds many pictures."""
    return path.suffix.lower() in SUFFIXES


def check_encoder(path: Path) -> None:
    """Refuse MP4 without its encoder, before any time is spent.

    Raises
    ------
    OutputError
    """
    if path.suffix.lower() == ".mp4" and importlib.util.find_spec("imageio_ffmpeg") is None:
        command = install_command("video", "imageio-ffmpeg")
        raise OutputError(f"cannot write {path}: MP4 needs the package imageio-ffmpeg: {command}")


def played_fps(path: Path, fps: int) -> float:
    """Frames per second at which a file plays: GIF counts in hundredths of a second, from two on.

    Examples
    --------
    >>> played_fps(Path("a.gif"), 24), played_fps(Path("a.mp4"), 24)
    (25.0, 24)
    """
    return 100.0 / max(2, round(100 / fps)) if path.suffix.lower() == ".gif" else fps


class MovingFile:
    """A file that takes its frames while others are still rendered, on a thread of its own.

    A context: left without an exception, the file is whole; else it is what it was before.

    Parameters
    ----------
    path : Path
        Ends in one of `SUFFIXES`.
    fps : int
        See `played_fps`.
    length : int
        How many frames will come.
    """

    def __init__(self, path: Path, fps: int, length: int) -> None:
        self._frames: queue.Queue[np.ndarray | BaseException | None] = queue.Queue(_WAITING)
        self._pool = ThreadPoolExecutor(1)
        self._done = self._pool.submit(write_moving, path, self._arriving(), fps, length)

    def _arriving(self) -> Iterator[np.ndarray]:
        while (frame := self._frames.get()) is not None:
            if isinstance(frame, BaseException):
                raise frame
            yield frame

    def _put(self, frame: np.ndarray | BaseException | None) -> None:
        while not self._done.done():
            try:
                return self._frames.put(frame, timeout=_LOOK_EVERY)
            except queue.Full:
                continue
        return None

    def add(self, frame: np.ndarray) -> None:
        """Take the next frame, of uint8, shape (h, w, 3).

        Raises
        ------
        OutputError
            If the file cannot be written.
        """
        self._put(frame)
        if self._done.done():
            self._done.result()

    def __enter__(self) -> Self:
        """Nothing to open."""
        return self

    def __exit__(self, kind: object, raised: BaseException | None, trace: object) -> None:
        """Wait until the file is whole, or gone."""
        self._put(raised)
        self._pool.shutdown()
        if raised is None:
            self._done.result()


def write_moving(path: Path, frames: Iterable[np.ndarray], fps: int, length: int) -> None:
    """Write pictures one after the other, whole or not at all.

    Parameters
    ----------
    path : Path
        Ends in one of `SUFFIXES`.
    frames : iterable of ndarray of uint8, shape (h, w, 3)
    fps : int
        See `played_fps`.
    length : int
        How many frames there are.
    """
    suffix = path.suffix.lower()
    with replacing(path) as beside:
        if suffix == ".mp4":
            _write_mp4(beside, frames, fps)
        elif suffix == ".apng":
            apng.write(beside, frames, fps, length)
        else:
            _write_gif(beside, frames, round(1000 / played_fps(path, fps)))


def _write_gif(path: Path, frames: Iterable[np.ndarray], duration: int) -> None:
    from PIL import Image

    # Pillow keeps them until the end, one byte for each pixel.
    images = map(Image.fromarray, frames)
    with path.open("wb") as file:
        next(images).save(
            file, "GIF", save_all=True, append_images=images, duration=duration, loop=0, disposal=1
        )


def _write_mp4(path: Path, frames: Iterable[np.ndarray], fps: int) -> None:
    from imageio_ffmpeg import write_frames  # pyright: ignore[reportMissingImports]

    arriving = iter(frames)
    first = next(arriving)
    # H.264 has half as many colours along each side: an odd last row or column goes.
    h, w = (side // 2 * 2 for side in first.shape[:2])
    if not h * w:
        raise OutputError(f"MP4 needs at least 2x2 pixels, got {first.shape[1]}x{first.shape[0]}")
    writer = write_frames(
        str(path), (w, h), fps=fps, codec="libx264", quality=8, macro_block_size=2,
        output_params=["-f", "mp4", *_COLORS], ffmpeg_log_level="error",
    )  # fmt: skip
    writer.send(None)
    try:
        for frame in chain([first], arriving):
            writer.send(np.ascontiguousarray(frame[:h, :w]))
    finally:
        writer.close()
