"""Scene files of other programs, with keys that are no defaults: what becomes of them, as text."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np

import alight
from alight.scene.dump import dump_scene
from tests.recorded.making import briefly, command, described, in_folder, outcome

#: Scenes whose keys are no defaults.
FOLDER = Path(__file__).parents[1] / "scenes"


def gltf() -> tuple[dict[str, Any], bytes]:
    """A document of glTF with one of most things, and its buffer."""
    tables = {
        "points": np.array([[0, 0, 0], [1, 0, 0.1], [1, 1, 0], [0, 1, 0.2]], "<f4"),
        "uvs": np.array([[0, 1], [1, 1], [1, 0], [0, 0]], "<f4"),
        "faces": np.array([0, 1, 2, 0, 2, 3], "<u2"),
        "times": np.array([0, 0.5, 1.5], "<f4"),
        "moves": np.array([[0, 0, 0], [1, 2, 0], [3, 0, 1]], "<f4"),
    }
    document = json.loads((FOLDER / "document.json").read_text("utf-8"))
    data = b""
    for number, table in enumerate(tables.values()):
        columns = 1 if table.ndim == 1 else table.shape[1]
        view = {"buffer": 0, "byteOffset": len(data), "byteLength": table.nbytes}
        document["bufferViews"].append(view)
        accessor = {
            "bufferView": number,
            "count": len(table),
            "componentType": 5123 if table.dtype.kind == "u" else 5126,
            "type": {1: "SCALAR", 2: "VEC2", 3: "VEC3"}[columns],
        }
        if columns == 3:
            accessor |= {"min": table.min(0).tolist(), "max": table.max(0).tolist()}
        document["accessors"].append(accessor)
        data += table.tobytes() + b"\0" * (-table.nbytes % 4)
    document["buffers"] = [{"byteLength": len(data), "uri": "a.bin"}]
    return document, data


def files() -> dict[str, bytes]:
    """Everything that the scenes need."""
    document, data = gltf()
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    del document["buffers"][0]["uri"]
    inside = json.dumps(document).encode()
    inside += b" " * (-len(inside) % 4)
    chunks = struct.pack("<II", len(inside), 0x4E4F534A) + inside
    chunks += struct.pack("<II", len(data), 0x004E4942) + data
    texts = {p.name: p.read_bytes() for p in FOLDER.iterdir() if p.suffix != ".json"}
    return {
        **texts,
        "a.gltf": text,
        "a.bin": data,
        "a.glb": struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks,
    }


def _pictures() -> None:
    from alight.outputs import write_image

    texels = np.arange(36, dtype=np.float32).reshape(3, 4, 3) / 35
    write_image("a.png", texels)
    write_image("a.exr", texels * 3)
    write_image("b.exr", texels[:, :3] * 2)


def _read(name: str, **words: Any) -> dict[str, Any]:
    scene = alight.load(name, **words)
    return {
        "scene": briefly(dump_scene(scene)),
        "warnings": list(scene.warnings),
        "dropped": list(scene.source.remarks.notes),
        "approximated": len(scene.source.remarks.warnings),
        "read": described(scene.source.remarks.read),
        "spp": scene.source.remarks.spp,
    }


SCENES: dict[str, tuple[str, dict[str, Any]]] = {
    "Mitsuba 3": ("m3.xml", {}),
    "Mitsuba 3, defined": ("m3.xml", {"definitions": {"spp": "5"}}),
    "Mitsuba 0.6": ("m0.xml", {}),
    "pbrt 4": ("p4.pbrt", {}),
    "pbrt 3": ("p2.pbrt", {}),
    "OBJ": ("a.obj", {}),
    "PLY": ("a.ply", {}),
    "STL": ("a.stl", {}),
    **{f"MaterialX {n}": ("a.mtlx", {"variant": f"M{n}"}) for n in range(1, 5)},
    "MaterialX": ("a.mtlx", {}),
    "MaterialX of no name": ("a.mtlx", {"variant": "M9"}),
    "OpenUSD": ("a.usda", {}),
    "OpenUSD later": ("a.usda", {"at": 0.4}),
    "glTF": ("a.gltf", {}),
    "GLB": ("a.glb", {}),
    "glTF, one": ("a.gltf", {"scene_name": "one"}),
    "glTF, in motion": ("a.gltf", {"at": 0.75, "animation": "move"}),
    "glTF, by number": ("a.gltf", {"at": 9.0, "animation": "0", "scene_name": "0"}),
    "glTF, no scene": ("a.gltf", {"scene_name": "al"}),
    "glTF, no animation": ("a.gltf", {"animation": "mov", "at": 1.0}),
    "OBJ at a time": ("a.obj", {"at": 1.0}),
    "definitions": ("a.obj", {"definitions": {"a": "b"}}),
}


def scenes() -> dict[str, Any]:
    """Each scene as native text, and what is said of it."""
    with in_folder(files()):
        _pictures()
        return {name: outcome(_read, path, **words) for name, (path, words) in SCENES.items()}


def converted() -> dict[str, Any]:
    """What ``alight convert`` writes of each: the text, the document of a GLB, arrays of meshes."""
    found: dict[str, Any] = {}
    with in_folder(files()) as folder:
        _pictures()
        for path in ("m3.xml", "p4.pbrt", "a.obj", "a.gltf", "a.usda", "a.mtlx", "a.stl"):
            for suffix in ("yaml", "json", "glb"):
                target = Path(
                    f"out-{path.partition('.')[0]}-{path.partition('.')[2]}-{suffix}/x.{suffix}"
                )
                target.parent.mkdir()
                found[f"{path} to {suffix}"] = command("convert", path, str(target), "--lenient")
                if suffix == "glb" and target.exists():
                    found[f"document of {path}"] = _document(target.read_bytes())
                if suffix == "yaml" and target.exists():
                    found[f"text of {path}"] = len(target.read_text("utf-8").splitlines())
        found["files"] = sorted(
            str(p.relative_to(folder)) for p in folder.rglob("out-*/**/*") if p.is_file()
        )
        found["arrays"] = {
            p.name: described(np.load(p), 9) for p in sorted(folder.rglob("out-*-yaml/**/*.npy"))
        }
        found["wrong"] = [
            command("convert", "a.obj", n) for n in ("x.obj", "x", "none/x.yaml", "x.yml")
        ]
    return found


def _document(data: bytes) -> Any:
    length = int.from_bytes(data[12:16], "little")
    document = json.loads(data[20 : 20 + length])
    for view in document.get("bufferViews", []):
        view.pop("byteOffset", None)
    for part in ("buffers", "images"):
        for one in document.get(part, []):
            one.pop("uri", None)
    return described(document)


CASES = {"scenes": scenes, "converted": converted}
