"""Primitives in Draco streams, made by the encoder of the package that alight decodes with."""

from __future__ import annotations

import numpy as np

from tests.formats.gltf.maker import COMPONENTS, FACES, POINTS, TYPES, UVS, Maker

NAME = "KHR_draco_mesh_compression"
COLORS = np.array([[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [9, 9, 9, 255]], "u1")
#: By the identifiers that `square` gives the attributes of its stream.
GENERIC = {"TEXCOORD_0": 8, "NORMAL": 1, "COLOR_0": 5, "JOINTS_0": 3, "WEIGHTS_0": 4}


def encoded(points=POINTS, faces=FACES, attributes=None, **options):
    """A stream, and the identifiers of its attributes by their names."""
    import DracoPy

    attributes = attributes or {}
    generic = {GENERIC[name]: np.ascontiguousarray(t) for name, t in attributes.items()}
    stream = DracoPy.encode(
        np.ascontiguousarray(points), np.asarray(faces, "u4").reshape(-1, 3),
        generic_attributes=generic or None, **options,
    )  # fmt: skip
    held = {item["unique_id"] for item in DracoPy.decode(stream).attributes}
    names = {name: GENERIC[name] for name in attributes}
    return stream, names | {"POSITION": (held - set(generic)).pop()}


def announced(m: Maker, table, **more) -> int:
    """An accessor without bytes; its index."""
    table = np.asarray(table)
    columns = 1 if table.ndim == 1 else table.shape[1]
    item = {
        "count": len(table), "componentType": COMPONENTS[table.dtype.str[1:]],
        "type": TYPES[columns], **more,
    }  # fmt: skip
    m.json["accessors"].append(item)
    return len(m.json["accessors"]) - 1


def square(m: Maker, attributes=None, *, required=True, **options) -> int:
    """Append a mesh of two triangles as a stream; its index."""
    attributes = {"TEXCOORD_0": UVS} if attributes is None else attributes
    stream, names = encoded(attributes=attributes, **options)
    put = announced if required else Maker.accessor
    tables = {"POSITION": POINTS, **attributes}
    shares = [name for name, table in tables.items() if table.dtype.kind == "u"]
    normalized = {name: {"normalized": True} for name in shares if name != "JOINTS_0"}
    primitive = {
        "attributes": {
            name: put(m, table, **normalized.get(name, {})) for name, table in tables.items()
        },
        "indices": put(m, FACES),
        "extensions": {NAME: {"bufferView": m.view(stream), "attributes": names}},
    }
    m.json["extensionsUsed"] = [NAME]
    if required:
        m.json["extensionsRequired"] = [NAME]
    m.json["meshes"].append({"primitives": [primitive]})
    return len(m.json["meshes"]) - 1
