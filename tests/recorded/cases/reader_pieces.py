"""Pieces of scene files: every element, attribute and word of a dialect, and every error.

`tests/recorded/pieces` has a file for each dialect; empty lines part the pieces. A piece is a file
of its own or, in a dialect that wraps its scenes, what is inside of the wrapper. Kept is what it
adds to an empty scene and what is said of it; of a piece that is refused, all problems.
"""

from __future__ import annotations

import gzip
import re
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
from tests.recorded.making import described, in_folder, summed_up

FOLDER = Path(__file__).parents[1] / "pieces"
#: Larger tables are summed up.
FEW = 12
TEXELS = re.compile(r"(?:[0-9a-f]{2,8} ?)+")


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
    "more.mtlx": '<materialx version="1.38" colorspace="srgb_texture"><constant name="inside" '
    'type="color3"><input name="value" type="color3" value="0.5, 0.7, 0.3"/></constant>'
    "</materialx>",
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
    return dict(leaves(_shortly(dump_scene(scene)))), described(said)


def _shortly(data: Any) -> Any:
    """Plain data whose tables of numbers or texels are a line each: their shape, five numbers."""
    if isinstance(data, Mapping):
        return {key: _shortly(value) for key, value in data.items()}
    if not isinstance(data, (list, tuple)):
        return described(data)
    if data and all(isinstance(row, str) and TEXELS.fullmatch(row) for row in data):
        data = [[int(texel, 16) for texel in row.split()] for row in data]
    try:
        table = np.array(data, np.float64)
    except (TypeError, ValueError):
        return [_shortly(value) for value in data]
    if table.size <= FEW:
        return described(data)
    told = summed_up(table)
    return [*told["shape"], *told["numbers"]]


def _pieces(dialect: str, suffix: str, wrap: Callable[[str], str]) -> Any:
    """What each piece of a dialect adds to a scene."""
    texts = (FOLDER / f"{dialect}.txt").read_text("utf-8").strip().split("\n\n")
    return _added(texts, suffix, wrap)


def _added(texts: list[str], suffix: str, wrap: Callable[[str], str]) -> Any:
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


def _materialx(text: str) -> str:
    return text if text.startswith(("<materialx", "<scene")) else f"{MATERIALX}{text}</materialx>"


MATERIALX = '<materialx version="1.38" colorspace="lin_rec709">'
#: Nodes and their inputs.
NODES = """
absval in, acos in, add in1 in2, asin in, atan2 iny inx, burn fg bg mix, ceil in, clamp in low high,
colorcorrect in hue saturation gamma lift gain contrast contrastpivot exposure,
contrast in amount pivot, cos in, difference fg bg mix, divide in1 in2, dodge fg bg mix,
dotproduct in1 in2, exp in, floor in, fract in, hsvadjust in amount, hsvtorgb in,
ifequal value1 value2 in1 in2, ifgreater value1 value2 in1 in2, ifgreatereq value1 value2 in1 in2,
invert in amount, ln in, luminance in lumacoeffs, magnitude in, max in1 in2, min in1 in2,
minus fg bg mix, mix fg bg mix, modulo in1 in2, multiply in1 in2, normalize in, overlay fg bg mix,
plus fg bg mix, power in1 in2, range in inlow inhigh gamma outlow outhigh doclamp,
remap in inlow inhigh outlow outhigh, rgbtohsv in, round in, safepower in1 in2,
saturate in amount lumacoeffs, screen fg bg mix, sign in, sin in, smoothstep in low high, sqrt in,
subtract in1 in2, tan in, trianglewave in, combine3 in1 in2 in3, combine2 in1 in2, convert in,
dot in, swizzle in channels, switch in1 in2 in3 which, extract in index, none in,
checkerboard color1 color2 uvtiling uvoffset, ramplr valuel valuer, ramptb valueb valuet,
splitlr valuel valuer center,
splittb valueb valuet center, ramp4 valuebl valuebr valuetl valuetr
"""
#: What inputs are given that are no colours.
PLAIN = {
    "channels": ("string", "bgr"), "which": ("integer", "1"), "index": ("integer", "1"),
    "mix": ("float", "0.35"), "center": ("float", "0.3"), "uvtiling": ("vector2", "3, 5"),
    "uvoffset": ("vector2", "0.1, 0.2"), "doclamp": ("boolean", "true"),
    "hue": ("float", "0.2"), "exposure": ("float", "0.3"),
}  # fmt: skip
COLORS = ("0.3, 0.9, 0.5", "0.2, 0.4, 0.7", "0.8, 0.75, 0.95", "0.55, 0.1, 0.45", "1.2, 1.5, 0.85")
PICTURES = (
    '<image name="p" type="color3"><input name="file" type="filename" value="a.png"/></image>'
    '<image name="q" type="float"><input name="file" type="filename" value="a.png"/></image>'
)


def _nodes(kind: str, varying: int | None, half: int) -> str:
    """Shaders coloured by every second node; the input of a number is given by a picture."""
    made = [PICTURES if varying is not None else ""]
    for node in " ".join(NODES.split()).split(", ")[half::2]:
        name, *inputs = node.split()
        given = ""
        for i, key in enumerate(inputs):
            what, value = PLAIN.get(key, (kind, COLORS[i % len(COLORS)]))
            value = value if what != "float" or key in PLAIN else value.split(", ")[i % 3]
            source = f'value="{value}"'
            if varying in (i, i - len(inputs)) and what in ("color3", "float"):
                source = f'nodename="{"p" if what == "color3" else "q"}"'
            given += f'<input name="{key}" type="{what}" {source}/>'
        made.append(
            f'<{name} name="n_{name}" type="{kind}">{given}</{name}>'
            f'<standard_surface name="{name}" type="surfaceshader">'
            f'<input name="base_color" type="{kind}" nodename="n_{name}"/></standard_surface>'
        )
    return "".join(made)


def _every_node() -> Any:
    """Nodes of numbers, and with a picture as first, as second and as last input."""
    kinds = [*(("color3", number) for number in (None, 0, 1, -1)), ("float", 0)]
    texts = [_nodes(*kind, half) for kind in kinds for half in (0, 1)]
    return _of_looks(_added(texts, ".mtlx", _materialx), r"said|.*base_color")


def _every_shader() -> Any:
    """Shaders, graphs and definitions."""
    found = _pieces("materialx", ".mtlx", _materialx)
    return _of_looks(found, r"(?!nodes\..*\.(transform|shape)\b)")


def _of_looks(found: dict[str, Any], kept: str) -> dict[str, Any]:
    """What some of the keys say: where the balls of a library lie is the same each time."""
    return {
        piece: {key: one for key, one in told.items() if re.match(kept, key)}
        for piece, told in found.items()
    }


def _itself(text: str) -> str:
    return text


CASES: Mapping[str, Callable[[], Any]] = {
    "mitsuba": partial(_pieces, "mitsuba", ".xml", partial(_mitsuba, "3.0.0")),
    "mitsuba_06": partial(_pieces, "mitsuba_06", ".xml", partial(_mitsuba, "0.6.0")),
    "pbrt": partial(_pieces, "pbrt", ".pbrt", partial(_pbrt, "")),
    "pbrt_3": partial(_pieces, "pbrt_3", ".pbrt", partial(_pbrt, "WorldEnd")),
    "materialx": _every_shader,
    "materialx_nodes": _every_node,
    **{name: partial(_pieces, name, f".{name}", _itself) for name in ("obj", "ply", "stl")},
}
