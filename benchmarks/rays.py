"""Ray sets for a mesh in the unit ball: coherent, one bounce, random.

A set is (origins, directions), both (n, 3) float32 with unit directions.
"""

from collections.abc import Callable

import numpy as np

Rays = tuple[np.ndarray, np.ndarray]
# (origins, directions) -> (t, triangle), triangle -1 where the ray misses
Intersect = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


def ray_sets(
    vertices: np.ndarray, faces: np.ndarray, intersect: Intersect, side: int = 1024
) -> dict[str, Rays]:
    """Make all three sets.

    Parameters
    ----------
    vertices, faces : arrays
        The mesh.
    intersect : function
        Finds the hits from which the bounce rays start.
    side : int
        The camera has side x side pixels; there are about as many random rays.
    """
    coherent = camera_rays(side)
    rng = np.random.default_rng(1)
    return {
        "coherent": coherent,
        "bounce": bounce_rays(vertices, faces, coherent, intersect, rng),
        "random": random_rays(side * side, rng),
    }


def camera_rays(side: int) -> Rays:
    """Look from a pinhole at distance 3, field of view 45 degrees, row by row."""
    centre = ((np.arange(side) + 0.5) / side * 2 - 1) * np.tan(np.radians(22.5))
    x, y = np.meshgrid(centre, -centre)
    directions = _unit(np.stack([x, y, np.full_like(x, -1.0)], -1).reshape(-1, 3))
    origins = np.broadcast_to([0.0, 0.0, 3.0], directions.shape)
    return _float32(origins, directions)


def bounce_rays(
    vertices: np.ndarray,
    faces: np.ndarray,
    rays: Rays,
    intersect: Intersect,
    rng: np.random.Generator,
) -> Rays:
    """Scatter one cosine-distributed ray from each hit, on the side where the ray came from."""
    origins, directions = rays
    t, triangle = intersect(origins, directions)
    hit = triangle >= 0
    corner = vertices[faces[triangle[hit]]].astype(np.float64)
    normal = _unit(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]))
    incoming = directions[hit]
    normal[(normal * incoming).sum(1) > 0] *= -1
    # A point on the unit sphere around the tip of the normal is cosine-distributed; 0.999 keeps
    # the sum away from 0.
    outgoing = _unit(normal + 0.999 * _unit(rng.normal(size=normal.shape)))
    start = origins[hit] + t[hit, None] * incoming + 1e-4 * normal
    return _float32(start, outgoing)


def random_rays(count: int, rng: np.random.Generator) -> Rays:
    """Shoot from the sphere of radius 2 at uniform points of the unit ball."""
    origins = 2 * _unit(rng.normal(size=(count, 3)))
    targets = _unit(rng.normal(size=(count, 3))) * rng.random((count, 1)) ** (1 / 3)
    return _float32(origins, _unit(targets - origins))


def _unit(vectors: np.ndarray) -> np.ndarray:
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    # A degenerate triangle has no normal; any direction will do for a benchmark.
    return np.where(lengths > 0, vectors / np.maximum(lengths, 1e-30), [0.0, 0.0, 1.0])


def _float32(origins: np.ndarray, directions: np.ndarray) -> Rays:
    return np.ascontiguousarray(origins, np.float32), np.ascontiguousarray(directions, np.float32)
