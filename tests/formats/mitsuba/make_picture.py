"""Make the files of ``picture/`` and Mitsuba's picture of them: ``python make_picture.py``.

Needs ``pip install mitsuba``. What is written is the statistics of many seeds, as
``tests/images/make_references.py`` describes them.
"""

import struct
import zlib
from pathlib import Path

import numpy as np
from PIL import Image

from alight.metrics.comparison import PictureStatistics
from alight.outputs import write_image

HERE = Path(__file__).parent / "picture"
FILES = HERE / "files"
SEEDS, SPP = 64, 128

SQUARE = np.array([[-0.9, -0.9, 0], [0.9, -0.9, 0], [0.9, 0.9, 0.2], [-0.9, 0.9, 0]], "<f4")
UVS = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], "<f4")
FACES = np.array([[0, 1, 2], [0, 2, 3]], "<u4")


def letters() -> None:
    """A picture that is another one when it is turned or mirrored in any way."""
    rng = np.random.default_rng(1)
    texels = rng.integers(40, 250, (4, 5, 3)).astype(np.uint8)
    texels[0] = 250, 30, 30
    texels[:, 0] = 30, 230, 60
    Image.fromarray(texels).save(FILES / "letters.png")


def sky() -> None:
    """A small environment, brighter on one side."""
    rng = np.random.default_rng(2)
    texels = rng.random((8, 16, 3)).astype(np.float32)
    texels[2, 3] = 12.0, 10.0, 6.0
    write_image(FILES / "sky.exr", texels)


def meshes() -> None:
    """One mesh of each format."""
    obj = "".join(f"v {x:g} {y:g} {z:g}\n" for x, y, z in SQUARE)
    obj += "".join(f"vt {u:g} {v:g}\n" for u, v in UVS) + "f 1/1 2/2 3/3 4/4\n"
    (FILES / "square.obj").write_text(obj)
    tent = np.array([[-0.9, -0.8, 0], [0.9, -0.8, 0], [0, 0.2, 0.8], [0, 0.9, 0]])
    colors = np.array([[0.9, 0.1, 0.1], [0.1, 0.8, 0.2], [0.8, 0.8, 0.1], [0.1, 0.2, 0.9]])
    header = "ply\nformat ascii 1.0\nelement vertex 4\n"
    header += "".join(f"property float {name}\n" for name in "xyzrgb")
    header += "element face 3\nproperty list uchar int vertex_indices\nend_header\n"
    rows = [" ".join(f"{x:g}" for x in row) for row in np.hstack([tent, colors])]
    faces = ["3 0 1 2", "3 1 3 2", "3 3 0 2"]
    (FILES / "tent.ply").write_text(header + "\n".join([*rows, *faces]) + "\n")
    parts = [serialized(SQUARE * 0.5), serialized(SQUARE)]
    offsets = struct.pack("<QQI", 0, len(parts[0]), 2)
    (FILES / "squares.serialized").write_bytes(b"".join(parts) + offsets)


def serialized(vertices: np.ndarray) -> bytes:
    """One mesh of a serialized file, version 4, single precision, with texture coordinates."""
    data = struct.pack("<I", 0x1002) + b"square\0" + struct.pack("<QQ", len(vertices), len(FACES))
    data += vertices.tobytes() + UVS.tobytes() + FACES.tobytes()
    return struct.pack("<HH", 0x041C, 4) + zlib.compress(data)


def reference() -> None:
    """Render with Mitsuba."""
    import mitsuba

    mitsuba.set_variant("llvm_ad_rgb")
    scene = mitsuba.load_file(str(HERE / "objects.xml"))
    images = [
        np.array(mitsuba.render(scene, spp=SPP, seed=seed), np.float64)[..., :3]
        for seed in range(SEEDS)
    ]
    PictureStatistics.of(np.stack(images)).save(HERE / "objects.npz")


if __name__ == "__main__":
    FILES.mkdir(parents=True, exist_ok=True)
    letters()
    sky()
    meshes()
    reference()
