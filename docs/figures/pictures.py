"""What the figures share: where they go, pictures in a row, a mesh to look at."""

from pathlib import Path

import numpy as np

import alight
from alight.formats import loads
from alight.outputs import write_image

IMAGES = Path(__file__).resolve().parents[1] / "images"
SPP = 256


def render(text: str, spp: int = SPP) -> np.ndarray:
    """Render a scene given as text: linear sRGB, shape (height, width, 3)."""
    return alight.render(loads("alight: 1\n" + text), spp=spp).image


def save_beside(name: str, *images: np.ndarray, gap: int = 8) -> None:
    """Write pictures of equal height in a row, with white gaps of `gap` pixels."""
    white = np.ones((images[0].shape[0], gap, 3), np.float32)
    row = [part for image in images for part in (white, image)][1:]
    write_image(IMAGES / f"{name}.png", np.concatenate(row, axis=1))


def icosphere(levels: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n, 3) on the unit sphere and faces (20 * 4^levels, 3), counter-clockwise."""
    golden = (1 + 5**0.5) / 2
    corners = [(sign_a * 1.0, sign_b * golden, 0.0) for sign_a in (-1, 1) for sign_b in (-1, 1)]
    vertices = np.array([np.roll(corner, turn) for turn in range(3) for corner in corners])
    edge = 2.0 + 1e-6
    faces = []
    for i in range(12):
        for j in range(i + 1, 12):
            for k in range(j + 1, 12):
                p, q, r = vertices[[i, j, k]]
                if max(np.linalg.norm(p - q), np.linalg.norm(q - r), np.linalg.norm(r - p)) < edge:
                    outwards = np.dot(np.cross(q - p, r - p), p) > 0
                    faces.append((i, j, k) if outwards else (i, k, j))
    faces = np.array(faces)
    for _ in range(levels):
        # Each triangle becomes four: its corners and the middles of its sides.
        a, b, c = (vertices[faces[:, i]] for i in range(3))
        points = np.concatenate([a, b, c, (a + b) / 2, (b + c) / 2, (c + a) / 2])
        n = np.arange(len(faces))
        a, b, c, ab, bc, ca = (n + i * len(faces) for i in range(6))
        quads = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
        faces = np.concatenate([np.stack(quad, axis=1) for quad in quads])
        vertices, inverse = np.unique(points.round(9), axis=0, return_inverse=True)
        faces = inverse.reshape(-1)[faces]
    return vertices / np.linalg.norm(vertices, axis=1, keepdims=True), faces
