"""PNG (ISO/IEC 15948): sRGB, 8 or 16 bits a channel, straight alpha, provenance as text.

The encoder is our own because Pillow has no 16-bit RGB.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from alight.core.srgb import decode_srgb
from alight.outputs.display import Development
from alight.outputs.picture import Picture

SUFFIXES = (".png",)
IS_DISPLAY = True
KEEPS_LAYERS = False
KEEPS_ALPHA = True
KEEPS_DPI = True

#: Rows that are tone-mapped at a time.
_BAND = 64

#: Effort of zlib, 1 to 9. Its default, 6, takes more than three times as long for files that are
#: 5 % smaller, and every frame of an animation waits for it.
LEVEL = 4

SIGNATURE = b"\x89PNG\r\n\x1a\n"


def write(path: Path, picture: Picture, display: Development) -> None:
    """Write the tone-mapped picture."""
    image, bits = picture.straight, display.bits
    # Band by band: the steps of tone mapping would take several times the picture's own memory.
    bands = []
    for y in range(0, len(image), _BAND):
        rows = slice(y, y + _BAND)
        colors, alpha = picture.rows(rows).over_display(display.apply(image[rows]))
        bands.append(_with_alpha(_whole_numbers(colors, bits), alpha, bits))
    whole = np.concatenate(bands)
    path.write_bytes(_encode(whole, bits, picture.attributes, display.dpi))


def read(path: Path) -> np.ndarray:
    """Read linear values, shape (h, w, 3)."""
    return read_with_pillow(path)


def read_with_pillow(path: Path) -> np.ndarray:
    """Read linear values of any sRGB picture of whole numbers, without its alpha."""
    from alight.outputs.texels import read_texels

    texels = read_texels(path, lambda width, height: None)
    if texels.dtype not in (np.uint8, np.uint16):
        raise ValueError(f"is not a {path.suffix[1:].upper()} picture")
    channels = np.atleast_3d(texels)
    colors = channels[..., : 3 if channels.shape[2] > 2 else 1]
    shape = (*colors.shape[:2], 3)
    return decode_srgb(np.broadcast_to(colors, shape) / float(np.iinfo(texels.dtype).max))


def encode_png(
    encoded: np.ndarray,
    *,
    bits: int,
    text: Mapping[str, str] | None = None,
    alpha: np.ndarray | None = None,
) -> bytes:
    """Encode a whole PNG file.

    Parameters
    ----------
    encoded : ndarray of float, shape (h, w, 3)
        sRGB-encoded values in [0, 1].
    bits : int
        8 or 16.
    text : mapping of str to str, optional
        Stored as ``alight.<key>``.
    alpha : ndarray of float, shape (h, w), optional
        Coverage, of straight colours.
    """
    return _encode(_with_alpha(_whole_numbers(encoded, bits), alpha, bits), bits, text)


def _with_alpha(whole: np.ndarray, alpha: np.ndarray | None, bits: int) -> np.ndarray:
    """Add the channel of coverage. It is a share, not light: no curve."""
    if alpha is None:
        return whole
    shares = _whole_numbers(np.clip(alpha, 0.0, 1.0), bits)
    return np.concatenate([whole, shares[..., None]], axis=-1)


def _whole_numbers(encoded: np.ndarray, bits: int) -> np.ndarray:
    return np.rint(encoded * (2**bits - 1)).astype(np.uint16 if bits == 16 else np.uint8)


def _encode(
    whole: np.ndarray, bits: int, text: Mapping[str, str] | None, dpi: float | None = None
) -> bytes:
    channels = whole.shape[2]
    # Big-endian, as the standard asks; joining bands makes it the machine's order.
    whole = whole.astype(">u2") if bits == 16 else whole
    rows = np.ascontiguousarray(whole).view(np.uint8).reshape(len(whole), -1)
    chunks = [header(whole.shape, bits)]
    if dpi is not None:
        per_metre = round(dpi / 0.0254)
        chunks.append(chunk(b"pHYs", struct.pack(">IIB", per_metre, per_metre, 1)))
    for key, value in (text or {}).items():
        keyword = f"alight.{key}"[:79].encode("latin-1", "replace")
        # Keyword, no compression, no language, no translated keyword, then UTF-8.
        chunks.append(chunk(b"iTXt", keyword + b"\x00\x00\x00\x00\x00" + value.encode()))
    chunks.append(chunk(b"IDAT", compressed(rows, channels * bits // 8)))
    chunks.append(chunk(b"IEND", b""))
    return SIGNATURE + b"".join(chunks)


def header(shape: tuple[int, ...], bits: int) -> bytes:
    """Give the first chunks, of a picture of sRGB of shape (h, w, channels)."""
    h, w, channels = shape
    first = struct.pack(">IIBBBBB", w, h, bits, {3: 2, 4: 6}[channels], 0, 0, 0)
    return chunk(b"IHDR", first) + chunk(b"sRGB", b"\x00")


def compressed(rows: np.ndarray, pixel_bytes: int) -> bytes:
    """Give the data of rows of bytes, shape (h, bytes of a row)."""
    return zlib.compress(_filtered(rows, pixel_bytes), LEVEL)


def _filtered(rows: np.ndarray, pixel_bytes: int) -> bytes:
    """Give the scan lines with the filter (none, left, up) whose differences are smallest."""
    left = np.zeros_like(rows)
    left[:, pixel_bytes:] = rows[:, :-pixel_bytes]
    up = np.zeros_like(rows)
    up[1:] = rows[:-1]
    candidates = (rows, rows - left, rows - up)
    # The size of a difference modulo 256, without a wider copy: min(x, 256 - x).
    cost = [np.minimum(c, -c).sum(axis=1, dtype=np.int64) for c in candidates]
    best = np.argmin(cost, axis=0)
    lines = np.zeros((len(rows), 1 + rows.shape[1]), np.uint8)
    lines[:, 0] = best
    for kind, candidate in enumerate(candidates):
        chosen = best == kind
        lines[chosen, 1:] = candidate[chosen]
    return lines.tobytes()


def chunk(kind: bytes, data: bytes) -> bytes:
    """Give a chunk with its length and its check sum."""
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
