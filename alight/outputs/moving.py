"""Moving pictures: GIF and APNG by Pillow, MP4 by the FFmpeg of imageio-ffmpeg."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from alight.core.errors import OutputError
from alight.core.extras import install_command
from alight.outputs.atomic import replacing

#: Endings of files that hold many pictures.
SUFFIXES = (".gif", ".apng", ".mp4")


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


def write_moving(path: Path, frames: Iterable[np.ndarray], fps: int) -> None:
    """Write pictures one after the other, whole or not at all.

    Parameters
    ----------
    path : Path
        Ends in one of `SUFFIXES`.
    frames : iterable of ndarray of uint8, shape (h, w, 3)
    fps : int
        GIF counts in hundredths of a second: it is at most 50, and the nearest that there is.
    """
    with replacing(path) as beside:
        if path.suffix.lower() == ".mp4":
            _write_mp4(beside, frames, fps)
        else:
            _write_by_pillow(beside, path.suffix.lower(), frames, fps)


def _write_by_pillow(path: Path, suffix: str, frames: Iterable[np.ndarray], fps: int) -> None:
    from PIL import Image

    first, *rest = (Image.fromarray(frame) for frame in frames)
    words: dict[str, Any] = {"format": "PNG"}
    if suffix == ".gif":
        words = {"format": "GIF", "disposal": 1}
    duration = max(20, round(100 / fps) * 10) if suffix == ".gif" else 1000 / fps
    first.save(path, save_all=True, append_images=rest, duration=duration, loop=0, **words)


def _write_mp4(path: Path, frames: Iterable[np.ndarray], fps: int) -> None:
    from imageio_ffmpeg import write_frames  # pyright: ignore[reportMissingImports]

    writer = None
    for frame in frames:
        # H.264 has half as many colours along each side: an odd last row or column goes.
        h, w = (side // 2 * 2 for side in frame.shape[:2])
        if writer is None:
            writer = write_frames(
                str(path), (w, h), fps=fps, codec="libx264", quality=8, macro_block_size=2,
                output_params=["-f", "mp4"], ffmpeg_log_level="error",
            )  # fmt: skip
            writer.send(None)
        writer.send(np.ascontiguousarray(frame[:h, :w]))
    if writer is not None:
        writer.close()
