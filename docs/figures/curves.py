"""The picture of docs/curves.md: fur on a ball.

Usage: python docs/figures/curves.py [SPP]
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

import alight

STRANDS, POINTS, CLUMPS = 16_000, 7, 220
TARGET = Path(__file__).resolve().parents[1] / "images" / "curves-fur.png"

SCENE = """
alight: 1
film: {size: [416, 440]}
camera: {fov: 28, transform: {look_at: {origin: [0, 1.6, 6], target: [0, -0.12, 0]}}}
integrator: {type: path, max_depth: 16}
environment: {type: constant, radiance: [0.30, 0.33, 0.38]}
nodes:
  fur:
    shape: {type: curves, file: fur.npz}
    bsdf: {type: hair, color: [0.75, 0.42, 0.2], beta_m: 0.35, beta_n: 0.5}
  core: {shape: {type: sphere, radius: 0.97}, bsdf: {type: diffuse, reflectance: [0.2, 0.1, 0.05]}}
  floor:
    shape: rectangle
    transform: [{scale: 20}, {rotate: {axis: x, angle: -90}}, {translate: [0, -1.33, 0]}]
  key:
    shape: {type: rectangle, flip_normals: true}
    light: {type: area, radiance: [2.6, 2.5, 2.3]}
    transform: [{scale: 3.5}, {look_at: {origin: [4, 5, 4], target: [0, 0, 0]}}]
"""


def units(rng: np.random.Generator, n: int) -> np.ndarray:
    """Random directions, (n, 3)."""
    v = rng.normal(size=(n, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def fur() -> dict[str, np.ndarray]:
    """Strands that grow outwards, lean to the middles of clumps and hang a little."""
    rng = np.random.default_rng(3)
    i = np.arange(STRANDS) + 0.5
    z, turn = 1.0 - 2.0 * i / STRANDS, np.pi * (1.0 + np.sqrt(5.0)) * i
    ring = np.sqrt(1.0 - z * z)
    root = np.stack([ring * np.cos(turn), z, ring * np.sin(turn)], axis=1)
    middles = units(rng, CLUMPS)
    middle = middles[(root @ middles.T).argmax(axis=1)]
    tip = 0.62 * 1.42 * middle + 0.38 * 1.45 * root - [0.0, 0.15, 0.0]
    tip = tip + 0.04 * rng.normal(size=tip.shape)
    u = np.linspace(0.0, 1.0, POINTS)
    lean = (u**1.7)[:, None]
    points = (1.0 - lean) * root[:, None] * (0.98 + 0.32 * u)[:, None] + lean * tip[:, None]
    wave = 0.012 * u * np.sin(9.0 * u + 2.0 * np.pi * rng.random((STRANDS, 1)))
    points = points + wave[..., None] * np.cross(root, middle)[:, None]
    # A spline begins after its first point.
    points = np.concatenate([2.0 * points[:, :1] - points[:, 1:2], points], axis=1)
    radii = np.tile(0.0042 * np.concatenate([[1.0], 1.0 - 0.75 * u**1.5]), STRANDS)
    counts = np.full(STRANDS, POINTS + 1)
    return {"points": points.reshape(-1, 3), "radii": radii, "counts": counts}


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        np.savez(Path(folder) / "fur.npz", **fur())
        path = Path(folder) / "fur.yaml"
        path.write_text(SCENE, encoding="utf-8")
        alight.render(path, spp=int([*sys.argv, "1024"][1]), output=TARGET)
