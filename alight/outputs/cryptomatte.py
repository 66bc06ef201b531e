"""Cryptomatte: names as ids, and coverages of ids as ranks, in the channels of a picture.

An id is the MurmurHash3 of a name, its bits read as a float32. A pixel holds its ids with the share
of it that each covers, the largest first; rank 0 and 1 lie in the channels ``r g`` and ``b a`` of
layer 00, rank 2 and 3 in layer 01, and so on. The header says what the ids are called.

Source: Friedman and Jones 2015, Fully automatic ID mattes with support for motion blur and
transparency, and the Cryptomatte specification 1.2 (Psyop); A. Appleby's MurmurHash3_x86_32.
"""

from __future__ import annotations

import json
from collections.abc import Iterable

import numpy as np

#: Ids a pixel that are written: three layers of two, as in the specification's examples.
RANKS = 6

_WORD = 0xFFFFFFFF


def murmur_hash(data: bytes, seed: int = 0) -> int:
    """MurmurHash3_x86_32 of some bytes, an unsigned number of 32 bits."""
    state = seed
    whole = len(data) // 4 * 4
    for at in range(0, whole, 4):
        state ^= _scrambled(int.from_bytes(data[at : at + 4], "little"))
        state = (_rotated(state, 13) * 5 + 0xE6546B64) & _WORD
    state ^= _scrambled(int.from_bytes(data[whole:], "little"))
    state ^= len(data)
    state = ((state ^ (state >> 16)) * 0x85EBCA6B) & _WORD
    state = ((state ^ (state >> 13)) * 0xC2B2AE35) & _WORD
    return state ^ (state >> 16)


def _scrambled(word: int) -> int:
    return (_rotated((word * 0xCC9E2D51) & _WORD, 15) * 0x1B873593) & _WORD


def _rotated(word: int, bits: int) -> int:
    return ((word << bits) | (word >> (32 - bits))) & _WORD


def id_of(name: str) -> int:
    """The bits of a name's id, an unsigned number of 32 bits.

    As a float32 it is an ordinary number: no subnormal one, no infinity and no NaN, which programs
    change or refuse.
    """
    bits = murmur_hash(name.encode())
    if (bits >> 23) & 255 in (0, 255):
        bits ^= 1 << 23
    return bits


def header_of(layer: str, names: Iterable[str]) -> dict[str, str]:
    """What the header of a file says of one Cryptomatte.

    Parameters
    ----------
    layer : str
        For instance ``CryptoObject``.
    names : iterable of str
        Everything that has an id.
    """
    key = f"cryptomatte/{murmur_hash(layer.encode()):08x}"[: len("cryptomatte/") + 7]
    manifest = {name: f"{id_of(name):08x}" for name in names}
    return {
        f"{key}/name": layer,
        f"{key}/hash": "MurmurHash3_32",
        f"{key}/conversion": "uint32_to_float32",
        f"{key}/manifest": json.dumps(manifest, ensure_ascii=False),
    }


def planes_of(layer: str, ids: np.ndarray, coverages: np.ndarray) -> dict[str, np.ndarray]:
    """Ranks as channels.

    Parameters
    ----------
    layer : str
    ids : ndarray of uint32, shape (h, w, `RANKS`)
        Bits of the ids; 0 where there is none.
    coverages : ndarray of float32, shape (h, w, `RANKS`)
    """
    planes = {}
    for rank in range(RANKS):
        pair = "rg" if rank % 2 == 0 else "ba"
        name = f"{layer}{rank // 2:02d}"
        planes[f"{name}.{pair[0]}"] = np.ascontiguousarray(ids[..., rank]).view(np.float32)
        planes[f"{name}.{pair[1]}"] = np.ascontiguousarray(coverages[..., rank])
    return planes


def colors_of(ids: np.ndarray) -> np.ndarray:
    """A bright colour for each id, float32, shape (..., 3), linear sRGB."""
    hue = (ids & 0xFFFF).astype(np.float64)[..., None] / 65536.0
    light = 0.55 + 0.45 * ((ids >> 16) & 0xFF).astype(np.float64)[..., None] / 255.0
    wave = 0.5 + 0.5 * np.cos(2.0 * np.pi * (hue - np.array([0.0, 1.0, 2.0]) / 3.0))
    return (light * (0.04 + 0.96 * wave)).astype(np.float32)
