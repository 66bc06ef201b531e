"""Triangle meshes for the benchmarks: procedural, deterministic, no files needed.

Each function returns (vertices, faces): (n, 3) float32 in metres and (m, 3) int32. `blob` is the
mesh of the render and build benchmarks; the three of `RAY_MESHES` are for ray tests only, so that
nothing is tuned on what is measured. Those three are scaled into the unit ball.
"""

from collections.abc import Callable
from pathlib import Path
from tempfile import gettempdir

import numpy as np

Mesh = tuple[np.ndarray, np.ndarray]


def displaced_icosphere(subdivisions: int = 8) -> Mesh:
    """Make a unit sphere with 5 % waves; 20 * 4^subdivisions triangles (1 310 720 by default)."""
    path = Path(gettempdir()) / f"alight-benchmark-icosphere-{subdivisions}.npz"
    if not path.exists():
        import trimesh

        sphere = trimesh.creation.icosphere(subdivisions=subdivisions)
        points = np.asarray(sphere.vertices, np.float64)
        height = 1 + 0.05 * np.prod(np.sin(20 * points), axis=1)
        vertices = (points * height[:, None]).astype(np.float32)
        np.savez(path, vertices=vertices, faces=np.asarray(sphere.faces, np.int32))
    with np.load(path) as stored:
        return stored["vertices"], stored["faces"]


def blob(subdivisions: int = 8) -> Mesh:
    """Place the displaced icosphere as it stands in the Cornell box."""
    vertices, faces = displaced_icosphere(subdivisions)
    return (vertices * np.float32(0.55) + np.array([0, -0.35, 0], np.float32)), faces


def terrain(side: int = 700) -> Mesh:
    """Make a height field of 2 (side - 1)^2 triangles: a sum of waves."""
    rng = np.random.default_rng(7)
    x, z = np.meshgrid(np.linspace(-1, 1, side), np.linspace(-1, 1, side))
    y = np.zeros_like(x)
    for octave in range(9):
        angle, phase = rng.uniform(0, 2 * np.pi, 2)
        frequency = 2.0 * 1.7**octave
        y += np.sin(frequency * (x * np.cos(angle) + z * np.sin(angle)) + phase) / 1.7**octave
    # Leaning towards +z, where the camera of the ray tests stands.
    lean = np.sqrt(0.5)
    points = np.stack([x, lean * (0.15 * y - z), lean * (0.15 * y + z)], -1)
    return _into_unit_ball(points.reshape(-1, 3), _grid(side, side))


def torus_knot(turns: int = 6000, sides: int = 96) -> Mesh:
    """Make a tube along a (3, 7) torus knot: long thin triangles, about 1.15 million."""
    t = np.linspace(0, 2 * np.pi, turns + 1)
    radius = 1 + 0.45 * np.cos(7 * t)
    centre = np.stack([radius * np.cos(3 * t), radius * np.sin(3 * t), 0.45 * np.sin(7 * t)], -1)
    tangent = np.gradient(centre, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    side = np.cross(tangent, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(side, tangent)
    angle = np.linspace(0, 2 * np.pi, sides + 1)
    thickness = 0.12 + 0.02 * np.sin(40 * t)[:, None, None]
    ring = np.cos(angle)[:, None] * side[:, None] + np.sin(angle)[:, None] * up[:, None]
    vertices = centre[:, None] + thickness * ring
    return _into_unit_ball(vertices.reshape(-1, 3), _grid(turns + 1, sides + 1))


def hairball(triangles: int = 800_000) -> Mesh:
    """Scatter slivers and leaves without order: random triangles, sizes over two decades."""
    rng = np.random.default_rng(11)
    root = rng.normal(size=(triangles, 3))
    root *= (rng.random(triangles) ** (1 / 3) / np.linalg.norm(root, axis=1))[:, None]
    size = 0.002 * 100 ** rng.random(triangles) ** 3
    sliver = rng.uniform(0.02, 1.0, triangles)
    first = rng.normal(size=(triangles, 3)) * size[:, None]
    second = rng.normal(size=(triangles, 3)) * (size * sliver)[:, None]
    vertices = np.stack([root, root + first, root + second], 1).reshape(-1, 3)
    faces = np.arange(3 * triangles, dtype=np.int32).reshape(-1, 3)
    return _into_unit_ball(vertices, faces)


RAY_MESHES: dict[str, Callable[[], Mesh]] = {
    "terrain": terrain,
    "torus-knot": torus_knot,
    "hairball": hairball,
}


def _grid(rows: int, columns: int) -> np.ndarray:
    """Two triangles for each cell of a grid of vertices."""
    index = np.arange(rows * columns, dtype=np.int32).reshape(rows, columns)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    return np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], 2).reshape(-1, 3)


def _into_unit_ball(vertices: np.ndarray, faces: np.ndarray) -> Mesh:
    centre = (vertices.min(0) + vertices.max(0)) / 2
    moved = vertices - centre
    scaled = moved / np.linalg.norm(moved, axis=1).max()
    return np.ascontiguousarray(scaled, np.float32), np.ascontiguousarray(faces, np.int32)
