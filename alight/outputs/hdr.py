"""Radiance RGBE: three mantissas of 8 bits and one shared exponent; about 1 % of precision.

Written flat, which every reader takes; read flat and run-length encoded by scan line (the "new"
encoding). Ward 1991, "Real pixels", Graphics Gems II; the encodings are those of Radiance's
``color.c``.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from alight.outputs.display import Development
from alight.outputs.picture import Picture

SUFFIXES = (".hdr", ".pic")
IS_DISPLAY = False
KEEPS_LAYERS = False
KEEPS_ALPHA = False
KEEPS_DPI = False

#: Widths for which a scan line may be run-length encoded.
_RLE_WIDTHS = range(8, 32768)

_MOST_HEADER = 2**16


def write(path: Path, picture: Picture, display: Development) -> None:
    """Write the picture; negative values become 0. `display` does not apply."""
    h, w = picture.image.shape[:2]
    header = f"#?RADIANCE\nSOFTWARE=alight\nFORMAT=32-bit_rle_rgbe\n\n-Y {h} +X {w}\n"
    path.write_bytes(header.encode("ascii") + encode_rgbe(picture.image).tobytes())


def encode_rgbe(rgb: np.ndarray) -> np.ndarray:
    """Encode float (h, w, 3) as uint8 (h, w, 4); the largest channel keeps 8 bits, rounded.

    Values below 2^-128 and NaN become 0, those above 2^127 are cut.
    """
    finite = np.clip(np.nan_to_num(rgb.astype(np.float64), nan=0.0), 0.0, 1.69e38)
    largest = finite.max(axis=2)
    _, exponent = np.frexp(largest)
    # A mantissa of 255.5 or more would round to 256: it takes the next exponent.
    exponent += np.rint(np.ldexp(largest, 8 - exponent)) > 255
    mantissas = np.rint(np.ldexp(finite, (8 - exponent)[..., None]))
    rgbe = np.concatenate([mantissas, (exponent + 128)[..., None]], axis=2)
    rgbe[(largest < 2.0**-128)] = 0
    return rgbe.astype(np.uint8)


def decode_rgbe(rgbe: np.ndarray) -> np.ndarray:
    """Decode uint8 (h, w, 4) to float32 (h, w, 3)."""
    scale = np.ldexp(1.0, rgbe[..., 3].astype(np.int32) - (128 + 8))
    scale[rgbe[..., 3] == 0] = 0.0
    return (rgbe[..., :3] * scale[..., None]).astype(np.float32)


def read(path: Path) -> np.ndarray:
    """Read linear values; float32, shape (h, w, 3)."""
    data = path.read_bytes()
    found = _header(data)
    if b"FORMAT=32-bit_rle_xyze" in data[: found.start()]:
        raise ValueError("XYZE pictures are not supported; convert it to RGBE")
    h, w = int(found[1]), int(found[2])
    body = np.frombuffer(data, np.uint8, offset=found.end())
    # A scan line takes at least 1 byte in 64 even if every run is as long as it can be.
    if h < 1 or w < 1 or len(body) * 64 < h * w * 4:
        raise ValueError(f"{len(body)} bytes of pixels are too few for {w}x{h}")
    return decode_rgbe(_scan_lines(body, h, w)) * np.float32(1.0 / _exposure(data[: found.start()]))


def read_size(path: Path) -> tuple[int, int]:
    """Width and height, read without the pixels."""
    with path.open("rb") as file:
        found = _header(file.read(_MOST_HEADER))
    return int(found[2]), int(found[1])


def _header(data: bytes) -> re.Match[bytes]:
    if not data.startswith(b"#?"):
        raise ValueError("not a Radiance file")
    found = re.search(rb"\n\n-Y (\d{1,9}) \+X (\d{1,9})\n", data[:_MOST_HEADER])
    if found is None:
        raise ValueError("the header has no size line of the form '-Y height +X width'")
    return found


def _exposure(header: bytes) -> float:
    """Multiply the EXPOSURE lines: what the values were multiplied by."""
    product = 1.0
    for value in re.findall(rb"\nEXPOSURE=\s*([-+.\deE]+)", header):
        product *= float(value)
    return product if product > 0.0 else 1.0


def _scan_lines(body: np.ndarray, h: int, w: int) -> np.ndarray:
    encoded = len(body) >= 4 and w in _RLE_WIDTHS and body[0] == 2 and body[1] == 2
    if not (encoded and body[2] < 128):
        if len(body) < h * w * 4:
            raise ValueError(f"the file ends early: {len(body)} bytes of pixels, not {h * w * 4}")
        return body[: h * w * 4].reshape(h, w, 4)
    rgbe = np.zeros((h, w, 4), np.uint8)
    at = 0
    for y in range(h):
        if bytes(body[at : at + 4]) != bytes((2, 2, w >> 8, w & 255)):
            raise ValueError(f"scan line {y} does not begin with its width")
        at += 4
        for channel in range(4):
            at = _unpack(body, at, rgbe[y, :, channel], y)
    return rgbe


def _unpack(body: np.ndarray, at: int, line: np.ndarray, y: int) -> int:
    """Fill one channel of a scan line from runs; return where the next one begins."""
    x = 0
    while x < len(line):
        code = int(body[at]) if at < len(body) else 0
        # Above 128: one byte repeated code - 128 times; else `code` bytes as they are.
        run = code - 128 if code > 128 else code
        stored = 1 if code > 128 else code
        if run == 0 or x + run > len(line) or at + 1 + stored > len(body):
            raise ValueError(f"scan line {y} is broken")
        line[x : x + run] = body[at + 1 : at + 1 + stored]
        x, at = x + run, at + 1 + stored
    return at
