"""Time and memory from a large glTF file to the first sample.

    python benchmarks/load_gltf.py [--triangles 1000000] [--textures 8] [--side 4096]

A file is made in a temporary folder: one bumpy sphere of so many triangles in eight parts, each
with a JPEG texture of its own. A second process opens it, compiles its tables and renders 8 x 8
pixels at 1 sample; a first run fills the cache of kernels and is not counted. What is reported is
processor time of that process (user, all threads), which other work on the machine changes little,
wall time, and the peak of its memory.
"""

from __future__ import annotations

import argparse
import io
import json
import os
import resource
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np


def make_file(path: Path, triangles: int, textures: int, side: int) -> None:
    """Write a .glb file."""
    from PIL import Image

    views: list[dict] = []
    chunks: list[bytes] = []
    accessors: list[dict] = []
    size = 0

    def view(data: bytes) -> int:
        nonlocal size
        chunks.append(data + b"\0" * (-len(data) % 4))
        views.append({"buffer": 0, "byteOffset": size, "byteLength": len(data)})
        size += len(chunks[-1])
        return len(views) - 1

    def accessor(table: np.ndarray, component: int, kind: str, count: int) -> int:
        accessors.append(
            {"bufferView": view(table.tobytes()), "componentType": component, "type": kind,
             "count": count}
        )  # fmt: skip
        return len(accessors) - 1

    rng = np.random.default_rng(1)
    rows = int(np.sqrt(triangles / textures / 2)) + 1
    primitives = []
    for part in range(textures):
        u, v = np.meshgrid(np.linspace(0, 1, rows), np.linspace(0, 1, rows))
        around, up = 2 * np.pi * (part + u) / textures, np.pi * (v - 0.5)
        radius = 1 + 0.02 * np.sin(40 * around) * np.sin(30 * up)
        p = np.stack([np.cos(up) * np.sin(around), np.sin(up), np.cos(up) * np.cos(around)], -1)
        points = (radius[..., None] * p).reshape(-1, 3).astype("<f4")
        corner = (np.arange(rows - 1)[:, None] * rows + np.arange(rows - 1)).ravel()
        faces = np.stack(
            [corner, corner + 1, corner + rows, corner + 1, corner + rows + 1, corner + rows], -1
        )
        uvs = np.stack([u, 1 - v], -1).reshape(-1, 2).astype("<f4")
        normals = p.reshape(-1, 3).astype("<f4")
        attributes = {
            "POSITION": accessor(points, 5126, "VEC3", len(points)),
            "NORMAL": accessor(normals, 5126, "VEC3", len(points)),
            "TEXCOORD_0": accessor(uvs, 5126, "VEC2", len(points)),
        }
        indices = accessor(faces.ravel().astype("<u4"), 5125, "SCALAR", faces.size)
        primitives.append({"attributes": attributes, "indices": indices, "material": part})
    images = []
    for _ in range(textures):
        small = Image.fromarray(rng.integers(0, 256, (64, 64, 3)).astype(np.uint8))
        file = io.BytesIO()
        small.resize((side, side), Image.Resampling.BICUBIC).save(file, "JPEG", quality=90)
        images.append({"bufferView": view(file.getvalue()), "mimeType": "image/jpeg"})
    document = {
        "asset": {"version": "2.0"}, "nodes": [{"mesh": 0}], "accessors": accessors,
        "meshes": [{"primitives": primitives}], "bufferViews": views, "images": images,
        "buffers": [{"byteLength": size}], "textures": [{"source": i} for i in range(textures)],
        "materials": [
            {"pbrMetallicRoughness": {"baseColorTexture": {"index": i}, "metallicFactor": 0}}
            for i in range(textures)
        ],
    }  # fmt: skip
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    with path.open("wb") as out:
        out.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + size))
        out.write(struct.pack("<II", len(text), 0x4E4F534A) + text)
        out.write(struct.pack("<II", size, 0x004E4942))
        out.writelines(chunks)


def worker(path: str) -> None:
    """Open a file, render, and print the figures."""
    start, wall = time.process_time(), time.perf_counter()
    import alight

    imported = time.process_time()
    scene = alight.load(path, ["film.size=[8, 8]"])
    loaded = time.process_time()
    alight.render(scene, spp=1)
    done = time.process_time()
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    figures = {
        "import": imported - start, "load": loaded - imported, "compile and render": done - loaded,
        "total": done - start, "wall": time.perf_counter() - wall, "peak GB": peak,
    }  # fmt: skip
    print("  ".join(f"{name} {value:.2f}" for name, value in figures.items()))


def main() -> None:
    """Make the file and time it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--triangles", type=int, default=1_000_000)
    parser.add_argument("--textures", type=int, default=8)
    parser.add_argument("--side", type=int, default=4096)
    parser.add_argument("--runs", type=int, default=2)
    parser.add_argument("--worker", default="")
    arguments = parser.parse_args()
    if arguments.worker:
        worker(arguments.worker)
        return
    with tempfile.TemporaryDirectory() as folder:
        small, large = Path(folder) / "small.glb", Path(folder) / "large.glb"
        make_file(small, 2000 * arguments.textures, arguments.textures, 16)
        make_file(large, arguments.triangles, arguments.textures, arguments.side)
        print(f"{large.stat().st_size / 1e6:.0f} MB, {os.cpu_count()} processors")
        for path in [small] + arguments.runs * [large]:
            command = [sys.executable, __file__, "--worker", str(path)]
            print(
                path.name,
                subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip(),
            )


if __name__ == "__main__":
    main()
