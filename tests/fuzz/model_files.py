"""Mutated glTF files (values of the JSON, bytes of the whole), OBJ files, and their materials."""

from __future__ import annotations

import copy
import json
import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from tests.formats.gltf.maker import everything
from tests.formats.mutate import TEXT_MUTATIONS, Mutation, mutate_bytes

VALUES: tuple[Any, ...] = (
    0, 1, -1, 2, 0.5, -0.5, 1e-30, 1e15, 1e30, -1e30, 1e300, 10**30, 7, 255, 5126, 5121, 65536,
    2**31, 2**40, True, None, "", "x", "../x", "SCALAR", "VEC2", "VEC3", "MAT4", "BLEND", "MASK",
    "data:;base64,AAAA", "texture.png", [], {}, [0], [0, 0, 0], [1, 1, 1, 1], [1e30, 0, 0],
    [0, 0, 0, 1], {"index": 0}, {"index": 1, "texCoord": 1}, [0.0] * 16,
)  # fmt: skip

_OBJ = b"""mtllib scene.mtl
v 0 0 0
v 1 0 0 1 0 0
v 1 1 0
v 0 1 0
v 0 0 1
vt 0 0
vt 1 0.5
vt 0.5 1
vn 0 0 1
o body
usemtl paint
f 1/1/1 2/2/1 3/3/1
f 1 3 4
g lamp
s 1
usemtl glow
f 1/1 2/2 5/3
usemtl glass
f -1//1 -2//1 -3//1
usemtl leaf
f 2/1 3/2 5/3 4/1
"""
_MTL = b"""newmtl paint
Ka 0 0 0
Kd 0.8 0.4 0.2
Ks 0.5 0.5 0.5
Ns 96
map_Kd -s 2 2 1 -o 0.5 0.25 0 -clamp on texture.png
map_bump -bm 0.2 texture.png
newmtl glow
Ke 4 3 2
map_Ke texture.png
Pr 0.4
Pm 0.9
map_Pr -mm 0.1 0.5 -imfchan g texture.png
newmtl glass
illum 7
Ni 1.5
Tf 0.9 1 0.9
d 0.1
newmtl leaf
d 0.5
map_d texture.png
norm texture.png
Pc 0.5
Ps 0.2
aniso 0.5
"""


def copy_models(folder: Path) -> None:
    """Put the valid files that mutated ones name into a folder."""
    (folder / "scene.mtl").write_bytes(_MTL)
    (folder / "broken.obj").write_bytes(_OBJ.replace(b"scene.mtl", b"broken.mtl"))
    pixels = np.random.default_rng(2).integers(0, 256, (5, 7, 4)).astype(np.uint8)
    Image.fromarray(pixels).save(folder / "texture.png")


def models(seed: int, n: int) -> Iterator[Mutation]:
    """Yield `n` files; the text of each case is the name of the file to open."""
    rng = random.Random(seed)
    document = everything()
    text, binary = json.loads(document.gltf()), document.glb()
    for _ in range(n):
        kind = rng.random()
        if kind < 0.45:
            changed = copy.deepcopy(text)
            for _ in range(rng.choice((1, 1, 1, 2, 4))):
                _change(changed, rng)
            yield Mutation("scene.gltf", "scene.gltf", json.dumps(changed).encode())
        elif kind < 0.6:
            yield Mutation("scene.glb", "scene.glb", _damaged(binary, rng))
        elif kind < 0.8:
            yield Mutation("scene.obj", "scene.obj", _damaged_text(_OBJ, rng))
        else:
            yield Mutation("broken.obj", "broken.mtl", _damaged_text(_MTL, rng))


def _damaged(data: bytes, rng: random.Random) -> bytes:
    if rng.random() < 0.3:
        return mutate_bytes(data, rng)
    changed = bytearray(data)
    for _ in range(rng.choice((1, 1, 3, 9))):
        changed[rng.randrange(len(data))] = rng.randrange(256)
    return bytes(changed)


def _damaged_text(data: bytes, rng: random.Random) -> bytes:
    if rng.random() < 0.4:
        return _damaged(data, rng)
    text = data.decode()
    for _ in range(rng.choice((1, 1, 2, 4))):
        text = rng.choice((_swap_word, _swap_word, *TEXT_MUTATIONS))(text, rng)
    return text.encode("utf-8", "replace")


def _swap_word(text: str, rng: random.Random) -> str:
    words = text.split(" ")
    chosen = (
        "0",
        "-1",
        "1e30",
        "nan",
        "inf",
        "9999999",
        "texture.png",
        "",
        "x",
        "2",
        "-s",
        "1e-30",
    )
    words[rng.randrange(len(words))] = rng.choice(chosen)
    return " ".join(words)


def _change(value: Any, rng: random.Random) -> None:
    """Replace, remove, double or add something at a random place."""
    places: list[tuple[Any, Any]] = []
    stack = [value]
    while stack:
        top = stack.pop()
        keys = list(top) if isinstance(top, dict) else range(len(top))
        for key in keys:
            places.append((top, key))
            if isinstance(top[key], dict | list):
                stack.append(top[key])
    # The bytes of the buffer are for the other kind of damage.
    places = [p for p in places if not (p[1] == "uri" and len(str(p[0]["uri"])) > 99)]
    owner, key = rng.choice(places)
    way = rng.random()
    if way < 0.2:
        del owner[key]
    elif way < 0.3 and isinstance(owner, list):
        owner.append(copy.deepcopy(owner[key]))
    elif way < 0.4:
        other, name = rng.choice(places)
        owner[key] = copy.deepcopy(other[name]) if name in _keys(other) else 0
    else:
        owner[key] = copy.deepcopy(rng.choice(VALUES))


def _keys(owner: Any) -> Any:
    return owner if isinstance(owner, dict) else range(len(owner))
