"""Scenes of 8 x 8 pixels in which something moves, drawn by the NumPy twin."""

from __future__ import annotations

import numpy as np

from alight.compiled.scene import compile_scene
from alight.films import fixed_point
from alight.formats import loads
from alight.integrators.walk import make_settings
from alight.rendering.tiles.tile import make_kernels, render_tile
from alight.rendering.tiles.tile_kernel import Tile
from alight.scene import flatten

SIZE = 8

#: One pixel is a square of 1 m in the plane z = 0, seen from above.
HEAD = """
alight: 1
film: {size: [8, 8]}
sampler: independent
integrator: {type: path, max_depth: 1}
camera: {type: orthographic, height: 8, transform: {translate: [0, 0, 9]}}
"""

#: A lamp with one bright texel.
PICTURE = "{type: area, radiance: {type: bitmap, pixels: [[1, 1, 50]]}}"


def choosing_by(choice):
    """`HEAD` with a way to choose lights."""
    return HEAD.replace("max_depth: 1", f"max_depth: 1, light_choice: {choice}")


def compiled(text, aovs=(), structure="list"):
    """A scene from the lines behind `HEAD`, or a whole one."""
    whole = text if "camera:" in text else HEAD + text
    return compile_scene(flatten(loads(whole, "scene.yaml")), aovs=aovs, structure=structure)


def partial_film(text, spp, aovs=(), seed=0):
    """What one tile of the twin adds up."""
    scene = compiled(text, aovs)
    settings = make_settings(scene.integrator, seed=seed, replicates=4)
    kernels = make_kernels(scene, compiled=False)
    ranges = np.array([[[0, spp]]], np.int64)
    film, _ = render_tile(kernels, scene, settings, Tile(0, 0, SIZE, SIZE), ranges)
    fixed_point.carry(film.sums)
    return film


def picture(text, spp, seed=0):
    """Mean of the first channel, (8, 8), and that of each replicate, (8, 8, 4)."""
    film = partial_film(text, spp, seed=seed)
    sums = fixed_point.to_float(film.sums)[..., 0]
    return sums.sum(axis=2) / spp, 4.0 * sums / spp


def centres():
    """x and y of points in each pixel, (8, 8, n): a fine grid."""
    steps = (np.arange(24) + 0.5) / 24.0
    x = np.arange(SIZE)[None, :, None, None] + steps[None, None, None, :] - SIZE / 2.0
    y = SIZE / 2.0 - np.arange(SIZE)[:, None, None, None] - steps[None, None, :, None]
    x, y = np.broadcast_arrays(x, y)
    return x.reshape(SIZE, SIZE, -1), y.reshape(SIZE, SIZE, -1)


def check_shares(found, expected, spp):
    """Shares of samples against probabilities: each pixel, and chi-square of all."""
    sigma = np.sqrt(expected * (1.0 - expected) / spp)
    certain = sigma < 1e-3
    np.testing.assert_allclose(found[certain], expected[certain], atol=2e-3)
    z = ((found - expected) / np.where(certain, 1.0, sigma))[~certain]
    assert len(z) > 4
    assert np.abs(z).max() < 4.5
    assert abs((z**2).sum() - len(z)) < 4.0 * np.sqrt(2.0 * len(z))
    assert abs(z.sum()) < 4.0 * np.sqrt(len(z))
