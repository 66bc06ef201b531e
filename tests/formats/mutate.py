"""Broken scenes by the thousand: mutations of the built-in ones and of mesh files.

`mutations` yields the same cases for the same seed on every machine.
"""

from __future__ import annotations

import random
import struct
from collections.abc import Iterator
from importlib import resources
from typing import NamedTuple

import numpy as np

from alight.formats import builtin_names
from alight.meshes.ply import NAMES

# fmt: off
WORDS = (
    "0", "-1", "1e30", "1e-30", "nan", ".inf", "1e999", "99999999999999999999", "-0", "null",
    "true", "~", "''", '"x"', "[]", "{}", "[1,2,3]", "&a", "*a", "!!binary", "?", "-", ":", "#",
    "|", ">", "%", "@", "`", "---", "...", "sphere", "plane", "mesh", "diffuse", "dielectric",
    "two_sided", "area", "point", "constant", "translate", "matrix", "look_at", "nodes", "bsdfs",
    "prototypes", "type", "shape", "light", "\t", "\n", "",
)
# fmt: on


STL = b"""solid square
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 1 1 0
endloop
endfacet
facet normal 0 0 1
outer loop
vertex -0 0 0
vertex 1 1 0
vertex 0 1 0
endloop
endfacet
endsolid square
"""


def binary_stl() -> bytes:
    """The same square."""
    facets = ([0, 0, 0, 1, 0, 0, 1, 1, 0], [-0.0, 0, 0, 1, 1, 0, 0, 1, 0])
    body = b"".join(struct.pack("<12fH", 0, 0, 1, *corners, 0) for corners in facets)
    return b"made by hand".ljust(80) + struct.pack("<I", 2) + body


class Mutation(NamedTuple):
    """One case: the scene's text, and its mesh file: ``mesh.ply``, ``mesh.obj`` or ``mesh.stl``."""

    text: str
    mesh_name: str
    mesh: bytes
    #: Of the scene; its ending may decide the format.
    name: str = "scene.yaml"


def mutations(seed: int, n: int) -> Iterator[Mutation]:
    """Yield `n` mutated scenes, about a third of them with a mutated mesh file.

    Parameters
    ----------
    seed : int
        Fixes every choice.
    n : int
        How many.
    """
    rng = random.Random(seed)
    texts = [read_builtin(name) for name in builtin_names()]
    meshes = {"mesh.ply": [mesh_file(""), mesh_file("<"), mesh_file(">")], "mesh.obj": [OBJ]}
    for _ in range(n):
        mesh_name = rng.choice(list(meshes))
        mesh = rng.choice(meshes[mesh_name])
        if rng.random() < 0.35:
            mesh = mutate_bytes(mesh, rng)
            yield Mutation(mesh_scene(mesh_name), mesh_name, mesh)
        else:
            text = rng.choice([*texts, mesh_scene(mesh_name)])
            for _ in range(rng.choice((1, 1, 1, 2, 5))):
                text = rng.choice(TEXT_MUTATIONS)(text, rng)
            yield Mutation(text, mesh_name, mesh)


def read_builtin(name: str) -> str:
    return resources.files("alight.scene.builtin").joinpath(f"{name}.yaml").read_text("utf-8")


def mesh_scene(mesh_name: str) -> str:
    return (
        "alight: 1\ncamera: {type: pinhole, transform: {translate: [0, 0, 4]}}\n"
        "environment: {type: constant, radiance: 0.5}\nfilm: {size: [8, 8]}\nnodes:\n  m:\n"
        f"    shape: {{type: mesh, file: {mesh_name}}}\n    light: {{type: area, radiance: 1}}\n"
    )


def _swap_word(text: str, rng: random.Random) -> str:
    """Replace one word or number by another."""
    ends = [i for i, c in enumerate(text) if c in " ,:[]{}\n"]
    at = rng.randrange(len(ends) - 1)
    return text[: ends[at] + 1] + rng.choice(WORDS) + text[ends[at + 1] :]


def _delete(text: str, rng: random.Random) -> str:
    start = rng.randrange(len(text))
    return text[:start] + text[start + rng.choice((1, 1, 3, 20, 200)) :]


def _insert(text: str, rng: random.Random) -> str:
    at = rng.randrange(len(text))
    return text[:at] + rng.choice((*WORDS, chr(rng.randrange(1, 0xD7FF)))) + text[at:]


def _move_line(text: str, rng: random.Random) -> str:
    lines = text.split("\n")
    line = lines.pop(rng.randrange(len(lines)))
    lines.insert(rng.randrange(len(lines) + 1), line)
    return "\n".join(lines)


def _repeat_line(text: str, rng: random.Random) -> str:
    lines = text.split("\n")
    at = rng.randrange(len(lines))
    return "\n".join(lines[:at] + [lines[at]] * rng.choice((2, 50)) + lines[at + 1 :])


def _indent_line(text: str, rng: random.Random) -> str:
    lines = text.split("\n")
    at = rng.randrange(len(lines))
    lines[at] = rng.choice(("  " + lines[at], lines[at][2:], "\t" + lines[at]))
    return "\n".join(lines)


def _misspell(text: str, rng: random.Random) -> str:
    at = rng.randrange(len(text) - 1)
    return text[:at] + text[at + 1] + text[at] + text[at + 2 :]


def _change_digit(text: str, rng: random.Random) -> str:
    digits = [i for i, c in enumerate(text) if c.isdigit()]
    at = rng.choice(digits) if digits else 0
    return text[:at] + rng.choice("0123456789-.e") + text[at + 1 :]


TEXT_MUTATIONS = (
    _swap_word,
    _swap_word,
    _delete,
    _insert,
    _move_line,
    _repeat_line,
    _indent_line,
    _misspell,
    _change_digit,
    _change_digit,
)


def mutate_bytes(data: bytes, rng: random.Random) -> bytes:
    """Flip, cut, insert or repeat bytes."""
    for _ in range(rng.choice((1, 1, 2, 8))):
        at = rng.randrange(len(data)) if data else 0
        kind = rng.randrange(5)
        if kind == 0:
            data = data[:at] + bytes([rng.randrange(256)]) + data[at + 1 :]
        elif kind == 1:
            data = data[:at]
        elif kind == 2:
            word = rng.choice((b"999999999", b" nan ", b"-1", b"list", b"\xff" * 4, b"\n", b"/"))
            data = data[:at] + word + data[at + rng.choice((0, len(word))) :]
        elif kind == 3:
            data = data[:at] + data[at + rng.randrange(1, 30) :]
        else:
            data = data[:at] + data[at : at + 40] * 3 + data[at + 40 :]
    return data


def mesh_file(order: str) -> bytes:
    """Write a tetrahedron with normals, texture coordinates and colours."""
    names = [("x", "y", "z"), *(NAMES[name][0] for name in ("normals", "uvs", "colors"))]
    columns = [column for group in names for column in group]
    kind = {"": "ascii", "<": "binary_little_endian", ">": "binary_big_endian"}[order]
    header = f"ply\nformat {kind} 1.0\nelement vertex 4\n"
    header += "".join(f"property float {column}\n" for column in columns)
    header += "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
    rows = np.random.default_rng(0).random((4, len(columns)))
    faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
    if not order:
        lines = [" ".join(f"{x:.6g}" for x in row) for row in rows]
        lines += ["3 " + " ".join(map(str, face)) for face in faces]
        return (header + "\n".join(lines) + "\n").encode()
    body = rows.astype(order + "f4").tobytes()
    body += b"".join(b"\x03" + np.array(face, order + "i4").tobytes() for face in faces)
    return header.encode() + body


OBJ = b"""# a square with everything
mtllib none.mtl
o square
v 0 0 0 1 0 0
v 1 0 0 0 1 0
v 1 1 0 0 0 1
v 0 1 0 0.5 0.5 0.5
vt 0 0
vt 1 0
vt 1 1
vt 0 1
vn 0 0 1
usemtl white
s off
f 1/1/1 2/2/1 3/3/1
f -4/-4/-1 -2/-2/-1 -1/-1/-1
"""
