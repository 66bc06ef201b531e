"""Scenes with a broken picture: files of every kind that textures read, mutated byte by byte."""

from __future__ import annotations

import io
import random
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image

from alight.outputs import write_image
from alight.outputs.png import encode_png
from tests.formats.mutate import Mutation, mutate_bytes

_HEAD = """alight: 1
camera: {type: pinhole, transform: {translate: [0, 0, 3]}}
film: {size: [8, 8]}
"""
_TEXTURE = """environment: {type: constant, radiance: 0.5}
textures:
  picture: {type: bitmap, file: FILE}
nodes:
  wall: {shape: rectangle, bsdf: {type: diffuse, reflectance: picture}}
"""
_ENVIRONMENT = """environment: {type: environment, file: FILE}
nodes:
  wall: {shape: rectangle, bsdf: {type: diffuse, reflectance: 0.5}}
"""


def pictures(seed: int, n: int) -> Iterator[Mutation]:
    """Yield `n` scenes, each with the content of its picture."""
    rng = random.Random(seed)
    files = picture_files()
    for _ in range(n):
        name = rng.choice(list(files))
        scene = _HEAD + rng.choice((_TEXTURE, _ENVIRONMENT)).replace("FILE", name)
        yield Mutation(scene, name, mutate_bytes(files[name], rng))


def picture_files() -> dict[str, bytes]:
    """Small pictures by file name: every format, whole numbers and floats, grey and colour."""
    rng = np.random.default_rng(5)
    small = rng.integers(0, 256, (6, 9, 3)).astype(np.uint8)
    linear = rng.random((5, 9, 3)).astype(np.float32)
    files = {
        "rgb.png": _pillow(Image.fromarray(small), "PNG"),
        "grey.png": _pillow(Image.fromarray(small[..., 0]), "PNG"),
        "palette.png": _pillow(Image.fromarray(small).quantize(8), "PNG"),
        "wide.png": encode_png(linear, bits=16),
        "rgb.jpg": _pillow(Image.fromarray(small), "JPEG"),
        "run-lengths.hdr": _run_lengths(),
    }
    with tempfile.TemporaryDirectory() as folder:
        for name in ("zip.exr", "flat.hdr", "rgb.pfm", "rgb.npy"):
            files[name] = write_image(Path(folder) / name, linear).read_bytes()
    return files


def _pillow(image: Image.Image, kind: str) -> bytes:
    encoded = io.BytesIO()
    image.save(encoded, kind)
    return encoded.getvalue()


def _run_lengths() -> bytes:
    """A Radiance file of 9 x 3 texels whose channels are a run of 5 and 4 bytes as they are."""
    channel = bytes((128 + 5, 100, 4, 10, 20, 30, 40))
    exponents = bytes((128 + 9, 128))
    line = bytes((2, 2, 0, 9)) + 3 * channel + exponents
    return b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 3 +X 9\n" + 3 * line
