"""A product shot: a glTF model, made here by turning an outline, in alight's studio.

Writes vase.gltf and vase.png. Any .gltf or .glb will do: a model without lights and camera stands
in the studio, framed whole.
"""

import base64
import json
from pathlib import Path

import numpy as np

import alight

#: Radius and height along the outline of the vase, from the middle of its foot to the inside.
OUTLINE = np.array(
    [[0.02, 0], [0.4, 0], [0.45, 0.05], [0.33, 0.2], [0.42, 0.4], [0.55, 0.65], [0.61, 0.95],
     [0.55, 1.2], [0.4, 1.45], [0.27, 1.65], [0.23, 1.85], [0.33, 2.0], [0.3, 2.0], [0.2, 1.85]]
)  # fmt: skip


def turned(outline, around=96):
    """Positions, normals and triangles of an outline that turns about the y axis."""
    angle = np.arange(around) / around * 2 * np.pi
    # The outline's tangent (dr, dy), turned by a right angle, points outwards.
    dr, dy = np.gradient(outline, axis=0).T

    def ring(r, y):
        r, y = r[:, None], y[:, None]
        parts = r * np.sin(angle), np.broadcast_to(y, (len(y), around)), r * np.cos(angle)
        return np.stack(parts, axis=-1).reshape(-1, 3)

    normals = ring(dy, -dr)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    i, k = np.indices((len(outline) - 1, around))
    a, b = i * around + k, i * around + (k + 1) % around
    c, d = a + around, b + around
    faces = np.stack([a, b, d, a, d, c], axis=-1).reshape(-1, 3)
    return ring(*outline.T).astype("<f4"), normals.astype("<f4"), faces.astype("<u4")


def gltf(positions, normals, faces):
    """A document with everything inside: one mesh of one glazed material."""
    parts = [part.tobytes() for part in (positions, normals, faces)]
    starts = np.cumsum([0, *map(len, parts)]).tolist()
    data = base64.b64encode(b"".join(parts)).decode()
    bounds = {"min": positions.min(axis=0).tolist(), "max": positions.max(axis=0).tolist()}
    vertices = {"componentType": 5126, "count": len(positions), "type": "VEC3"}
    indices = {"componentType": 5125, "count": faces.size, "type": "SCALAR"}
    primitive = {"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2, "material": 0}
    glaze = {"baseColorFactor": [0.02, 0.12, 0.3, 1], "metallicFactor": 0, "roughnessFactor": 0.15}
    return {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "vase"}],
        "meshes": [{"primitives": [primitive]}],
        "materials": [{"pbrMetallicRoughness": glaze, "doubleSided": True}],
        "buffers": [
            {"byteLength": starts[-1], "uri": f"data:application/octet-stream;base64,{data}"}
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": start, "byteLength": len(part)}
            for start, part in zip(starts, parts, strict=False)
        ],
        "accessors": [
            {"bufferView": 0, **vertices, **bounds},
            {"bufferView": 1, **vertices},
            {"bufferView": 2, **indices},
        ],
    }


if __name__ == "__main__":
    Path("vase.gltf").write_text(json.dumps(gltf(*turned(OUTLINE))), encoding="utf-8")
    film = alight.render("vase.gltf", size="96x96", spp=32, tone_map="agx", output="vase.png")
    print(f"vase.png: error {film.error.relrmse.value:.1%}")
