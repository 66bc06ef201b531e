"""Built-in scenes: pictures that are computed, and an exposure that shows what there is to see."""

from dataclasses import replace

import numpy as np
import pytest

from alight.compiled.scene import compile_scene
from alight.core.errors import SceneError
from alight.films import fixed_point
from alight.formats import load, loads, save
from alight.integrators.walk import make_settings
from alight.rendering.tiles.tile import make_kernels, render_tile
from alight.rendering.tiles.tile_kernel import Tile
from alight.scene import flatten
from alight.scene.builtin import pictures

SIDE = 8
#: Not those whose thousands of shapes the twin would test one by one, nor those whose light BSDF
#: sampling alone must find.
SCENES = (
    "blurred-foreground",
    "coated-plastics",
    "cornell-box",
    "depth-of-field",
    "door-ajar",
    "environment-map",
    "infinite-plane",
    "lambert-and-uniform-scatter",
    "lamp-and-glass",
    "material-ball",
    "mirror-and-glass",
    "motion-blur",
    "phong-exponents",
    "rough-glass",
    "rough-metals",
    "soft-shadows",
    "veach-plates",
)


def small_picture(name: str, spp: int = 2) -> np.ndarray:
    """Mean radiance of a few pixels, shape (SIDE, SIDE, 3), by the NumPy twin."""
    flat = flatten(load(name))
    film = flat.film.model_copy(update={"size": (SIDE, SIDE), "crop": None, "replicates": 1})
    scene = compile_scene(replace(flat, film=film), structure="list")
    settings = make_settings(scene.integrator, seed=0, replicates=1)
    settings = settings._replace(max_depth=min(settings.max_depth, 4))
    kernels = make_kernels(scene, compiled=False)
    samples = np.array([[[0, spp]]], np.int64)
    partial, _ = render_tile(kernels, scene, settings, Tile(0, 0, SIDE, SIDE), samples)
    assert partial.invalid == 0
    fixed_point.carry(partial.sums)
    return fixed_point.to_float(partial.sums)[:, :, 0, :3] / spp


@pytest.mark.parametrize("name", SCENES)
def test_scenes_are_well_exposed(name):
    shown = np.clip(small_picture(name), 0.0, 1.0)
    grey = shown.mean()
    assert 0.04 < grey < 0.75
    assert (shown.min(axis=2) >= 1.0).mean() < 0.2, "burnt out"


def test_the_sky_shines_from_where_it_says():
    sky = pictures.builtin_texels("builtin:sky").astype(float)
    height, width = sky.shape[:2]
    theta = np.arange(height) * np.pi / (height - 1)
    phi = (np.arange(width) + 0.5) * 2 * np.pi / width
    area = (np.sin(theta)[:, None] * (np.pi / (height - 1)) * (2 * np.pi / width))[:, :, None]
    sun = (sky > 100.0).all(axis=2)
    y, x = np.nonzero(sun)
    assert abs(90.0 - np.degrees(theta[y]).mean() - pictures.SUN_HEIGHT) < 0.2
    assert abs(np.degrees(phi[x]).mean() - pictures.SUN_AZIMUTH) < 0.2
    # The irradiance of a disk is its radiance times pi sin^2(radius), also where texels are coarse.
    expected = np.asarray(pictures.SUN) * np.pi * np.sin(np.radians(pictures.SUN_RADIUS)) ** 2
    beyond = area * np.where(sky.max(axis=2)[:, :, None] > 12.0, sky, 0.0)
    assert np.allclose(beyond.sum(axis=(0, 1)), expected, rtol=0.1)
    # Below the horizon there is only ground.
    assert np.allclose(sky[height // 2 + 4 :], pictures.GROUND, rtol=1e-6)


def test_a_misspelt_picture_names_the_nearest():
    text = 'alight: 1\ncamera: {}\nenvironment: {type: environment, file: "builtin:skye"}\n'
    with pytest.raises(SceneError, match='did you mean "sky"'):
        loads(text)


def test_computed_pictures_keep_their_name_in_saved_scenes(tmp_path):
    scene = load("environment-map")
    save(scene, tmp_path / "copy.yaml")
    again = load(tmp_path / "copy.yaml")
    assert again.environment == scene.environment
    assert [path.name for path in tmp_path.iterdir()] == ["copy.yaml"]
