"""Pieces of scene files: every element, attribute and word of a dialect, and every error.

`tests/recorded/pieces` has a file for each dialect; empty lines part the pieces. A piece is a file
of its own or, in a dialect that wraps its scenes, what is inside of the wrapper. Kept is what it
adds to an empty scene and what is said of it; of a piece that is refused, all problems.
"""

from __future__ import annotations

import gzip
import struct
import zlib
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

import alight
from alight.core.errors import AlightError
from alight.scene.dump import dump_scene
from tests.recorded.cases import reader_features
from tests.recorded.cases.reader_edits import leaves
from tests.recorded.making import briefly, described, in_folder

FOLDER = Path(__file__).parents[1] / "pieces"


def _serialized() -> bytes:
    """Two meshes of Mitsuba: single and double precision, with and without what may be left out."""
    points = np.array([[0, 0, 0.1], [1, 0.2, 0], [0.3, 1.1, 0.2], [0.4, 0.3, 1.2]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3]], "<u4").tobytes()
    uvs, colors = points[:, :2] * 0.7 + 0.1, points[::-1] * 0.5
    whole = np.concatenate([t.ravel() for t in (points, points[:, [1, 2, 0]] + 0.2, uvs, colors)])
    meshes = [
        struct.pack("<I", 0x1000 | 0x10) + b"one\0" + struct.pack("<QQ", 4, 2)
        + points.astype("<f4").tobytes() + faces[:24],
        struct.pack("<I", 0x2000 | 0xB) + b"\0" + struct.pack("<QQ", 4, 3)
        + whole.astype("<f8").tobytes() + faces,
    ]  # fmt: skip
    packed = [struct.pack("<HH", 0x041C, 4) + zlib.compress(mesh) for mesh in meshes]
    return b"".join(packed) + struct.pack("<QQI", 0, len(packed[0]), 2)


#: What pieces name, beside the files and pictures of `reader_features`.
FILES: dict[str, str | bytes] = {
    "b.obj": "v 0 0 0.1\nv 1 0.2 0\nv 0.3 1.1 0.2\nvt 0.1 0.2\nvt 0.9 0.3\nvt 0.4 0.8\n"
    "f 1/1 2/2 3/3\n",
    "bright.ply": "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    "property float z\nproperty float red\nproperty float green\nproperty float blue\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0.1 1 2 3\n1 0.2 0 0 0 1\n0.3 1.1 0.2 1 0 0\n3 0 1 2\n",
    "broken.ply": "ply\nformat asci 1.0\nend_header\n",
    "two.serialized": _serialized(),
    "one.txt": "0 0 0 0.1\n\n1 0 0 0.1\n1 1 0 0.1\n",
    "word.txt": "0 0 0 0.1\n1 0 0 -0.1\n",
    "two.txt": "0 0 0.1 0.05\n0.3 0.5 0.2 0.04\n\n\n1 0 0 0.1\n1 1 0 0.2\n1 2 0.3 0.1\n",
    "empty.txt": "\n\n",
    "letters.txt": "0 0 0 a\n",
    "s.spd": "# nanometres\n400 0.1\n500, 0.7 # green\n600 0.3\n700 0.2\n",
    "broken.spd": "400 0.1 500 al\n",
    "odd.spd": "400 0.1 500\n",
    "sub/inner.xml": '<scene version="0.6.0"><shape type="disk" id="inner">'
    '<transform name="toWorld"><translate x="$r"/></transform></shape></scene>',
    "inside.pbrt": 'Translate 1 2 3\nShape "sphere" "float radius" 0.7\n',
    "half.pbrt": 'Shape "sphere"',
    "around.pbrt": 'Include "around.pbrt"\n',
    "latin.pbrt": b"Shape \xe9",
    "flat.dat": "0 1 0 3\n",
    "odd.dat": "1 2 3\n",
    "nan.dat": "1 2 inf 3\n",
    "open.dat": "30 4 1.5 0\n-40 60 1 12\n",
    "wrong.xml": '<scene version="3.0.0"><shape type="sphere"></scene>',
    "loop.xml": '<scene version="3.0.0"><include filename="loop.xml"/></scene>',
}


def _files() -> dict[str, str | bytes]:
    """Everything that pieces name, but pictures."""
    libraries = {path.name: path.read_bytes() for path in FOLDER.glob("*.mtl")}
    packed = gzip.compress(b"newmtl a\nKd 1 0 0\n")[:-9]
    return reader_features._files() | FILES | libraries | {"packed.mtl.gz": packed}


def _pictures() -> None:
    """Those of features, and grey ones: alone, with opacity, in three channels that are alike."""
    reader_features._pictures()
    texels = reader_features._texels(3, 4, 1)
    for name, picture in (
        ("grey", texels[..., 0]),
        ("alpha", np.concatenate([reader_features._texels(3, 4, 3), texels[::-1]], axis=2)),
        ("even", np.repeat(texels, 3, axis=2)),
    ):
        Image.fromarray(picture).save(f"{name}.png")


def _told(name: str) -> tuple[dict[str, Any], list[str]]:
    """A scene by its places, and what is said of it; an error is all that is said."""
    try:
        scene = alight.load(name, lenient=True)
    except AlightError as error:
        return {}, described(str(error)).splitlines()
    said = [*scene.warnings, *scene.source.remarks.notes]
    return dict(leaves(briefly(dump_scene(scene)))), described(said)


def _pieces(dialect: str, suffix: str, wrap: Callable[[str], str]) -> Any:
    """What each piece of a dialect adds to a scene."""
    texts = (FOLDER / f"{dialect}.txt").read_text("utf-8").strip().split("\n\n")
    found: dict[str, Any] = {}
    with in_folder(_files()):
        _pictures()
        empty, _ = _told(_written(wrap(""), suffix))
        for number, text in enumerate(texts, 1):
            now, said = _told(_written(wrap(text), suffix))
            added = {key: one for key, one in now.items() if key not in empty or empty[key] != one}
            found[f"{number}: {text[:40]}"] = added | ({"said": said} if said else {})
    return found


def _written(text: str, suffix: str) -> str:
    path = Path(f"piece{suffix}")
    path.write_text(text, "utf-8")
    return path.name


def _mitsuba(version: str, text: str) -> str:
    """A scene, with a camera where nothing else gives one."""
    if text.startswith(("<scene", "<mitsuba")):
        return text
    camera = "" if "<sensor" in text or "<shape" in text else '<sensor type="perspective"/>'
    return f'<scene version="{version}">{text}{camera}</scene>'


def _pbrt(end: str, text: str) -> str:
    return f"{text}\n{end}" if "WorldBegin" in text else f"WorldBegin\n{text}\n{end}"


def _itself(text: str) -> str:
    return text


CASES: Mapping[str, Callable[[], Any]] = {
    "mitsuba": partial(_pieces, "mitsuba", ".xml", partial(_mitsuba, "3.0.0")),
    "mitsuba_06": partial(_pieces, "mitsuba_06", ".xml", partial(_mitsuba, "0.6.0")),
    "pbrt": partial(_pieces, "pbrt", ".pbrt", partial(_pbrt, "")),
    "pbrt_3": partial(_pieces, "pbrt_3", ".pbrt", partial(_pbrt, "WorldEnd")),
    **{name: partial(_pieces, name, f".{name}", _itself) for name in ("obj", "ply", "stl")},
}
