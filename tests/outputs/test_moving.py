"""Files of many pictures: every frame once, for its time, while the next ones are made."""

import struct
import subprocess
import sys
import weakref
import zlib
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from alight.core.errors import OutputError
from alight.outputs.moving import MovingFile, played_fps, write_moving


def frames(count, height=4, width=6):
    random = np.random.default_rng(1)
    return [random.integers(0, 256, (height, width, 3), np.uint8) for _ in range(count)]


def test_apng_keeps_frames_that_are_alike_and_their_exact_time(tmp_path):
    first, second = frames(2)
    path, all_of_them = tmp_path / "a.apng", [first, first, second]
    with MovingFile(path, 24, 3) as film:
        for frame in all_of_them:
            film.add(frame)
    with Image.open(path) as image:
        assert image.n_frames == 3
        for number, frame in enumerate(all_of_them):
            image.seek(number)
            assert np.array_equal(np.asarray(image), frame)
            assert image.info["duration"] == pytest.approx(1000 / 24)
    data = path.read_bytes()
    delays = [data[i + 24 : i + 28] for i in range(len(data)) if data[i : i + 4] == b"fcTL"]
    assert delays == [struct.pack(">HH", 1, 24)] * 3


def test_every_chunk_of_an_apng_says_what_the_standard_asks(tmp_path):
    """PNG, third edition, 11.3.6, field by field, by a reader of our own."""
    wide, path = [frame[:5, :7] for frame in frames(3, 16, 16)], tmp_path / "a.apng"
    with MovingFile(path, 30, 3) as film:
        for frame in wide:
            film.add(frame)
    data, at, chunks = path.read_bytes(), 8, []
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    while at < len(data):
        (size,) = struct.unpack_from(">I", data, at)
        kind, body = data[at + 4 : at + 8], data[at + 8 : at + 8 + size]
        (check,) = struct.unpack_from(">I", data, at + 8 + size)
        assert check == zlib.crc32(kind + body)
        chunks.append((kind, body))
        at += 12 + size
    kinds = [kind for kind, _ in chunks]
    kinds.remove(b"sRGB")
    assert kinds == [b"IHDR", b"acTL", b"fcTL", b"IDAT", *[b"fcTL", b"fdAT"] * 2, b"IEND"]
    said = dict(reversed(chunks))
    # 8 bits of red, green and blue, not interlaced.
    assert struct.unpack(">IIBBBBB", said[b"IHDR"]) == (7, 5, 8, 2, 0, 0, 0)
    # Three frames, shown again and again.
    assert struct.unpack(">II", said[b"acTL"]) == (3, 0)
    numbers = []
    for kind, body in chunks:
        if kind in (b"fcTL", b"fdAT"):
            numbers += struct.unpack_from(">I", body)
        if kind == b"fcTL":
            assert struct.unpack(">IIIIHHBB", body[4:]) == (7, 5, 0, 0, 1, 30, 0, 0)
    assert numbers == [*range(5)]


def test_frames_do_not_wait_in_memory_for_the_end(tmp_path):
    alive: list[weakref.ref] = []
    with MovingFile(tmp_path / "a.apng", 24, 40) as film:
        for _ in range(40):
            frame = frames(1, 128, 128)[0]
            alive.append(weakref.ref(frame))
            film.add(frame)
        # Two wait, one is compressed, one is ours.
        assert sum(one() is not None for one in alive) <= 5


def test_a_film_that_cannot_be_written_says_so_and_blocks_nobody(tmp_path):
    with (
        pytest.raises(OutputError, match="does not exist"),
        MovingFile(tmp_path / "none" / "a.apng", 24, 99) as film,
    ):
        for _ in range(99):
            film.add(frames(1)[0])


def test_an_interrupted_film_leaves_the_last_one(tmp_path):
    path = tmp_path / "a.gif"
    path.write_bytes(b"old")
    with pytest.raises(KeyboardInterrupt), MovingFile(path, 24, 9) as film:
        film.add(frames(1)[0])
        raise KeyboardInterrupt
    assert path.read_bytes() == b"old"
    assert [one.name for one in tmp_path.iterdir()] == ["a.gif"]


@pytest.mark.parametrize(("fps", "played"), [(24, 25), (25, 25), (30, 100 / 3), (1000, 50)])
def test_the_nearest_that_gif_has(tmp_path, fps, played):
    path = tmp_path / "a.gif"
    assert played_fps(path, fps) == pytest.approx(played)
    with MovingFile(path, fps, 2) as film:
        for frame in frames(2):
            film.add(frame)
    with Image.open(path) as image:
        assert 1000.0 / image.info["duration"] == pytest.approx(played)


@pytest.mark.parametrize("matrix", ["bt709", "auto"])
def test_an_mp4_has_the_colours_of_its_frames(tmp_path, matrix):
    """By the matrix that the file names, which players of high definition take in any case."""
    ffmpeg = pytest.importorskip("imageio_ffmpeg").get_ffmpeg_exe()
    colors = [(255, 0, 0), (0, 200, 0), (0, 0, 255), (90, 120, 150)]
    path = tmp_path / "a.mp4"
    write_moving(path, [np.full((16, 24, 3), c, np.uint8) for c in colors], 24, 4)
    words = ["-i", path, "-vf", f"scale=in_color_matrix={matrix}"]
    raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    done = subprocess.run([ffmpeg, "-loglevel", "error", *words, *raw], capture_output=True)
    seen = np.frombuffer(done.stdout, np.uint8).reshape(4, 16, 24, 3)
    np.testing.assert_allclose(seen[:, 8, 12], colors, atol=4)


def test_an_mp4_says_how_its_colours_are_meant(tmp_path, monkeypatch):
    given = {}

    def write_frames(path, size, **words):
        given.update(words, size=size)
        Path(path).touch()
        while True:
            yield

    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", SimpleNamespace(write_frames=write_frames))
    write_moving(tmp_path / "a.mp4", frames(2, 5, 7), 24, 2)
    words = given["output_params"]
    assert given["size"] == (6, 4)
    assert words[words.index("-colorspace") + 1] == "bt709"
    assert "out_color_matrix=bt709" in words[words.index("-vf") + 1]
    with pytest.raises(OutputError, match="MP4 needs at least 2x2 pixels, got 7x1"):
        write_moving(tmp_path / "b.mp4", frames(1, 1, 7), 24, 1)
    assert [one.name for one in tmp_path.iterdir()] == ["a.mp4"]
