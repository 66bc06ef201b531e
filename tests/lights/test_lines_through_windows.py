"""Lines from the surroundings through windows, and what of a map is its sun."""

import numpy as np
import pytest

from alight.core.vec import Vec3
from alight.laws.statistics import LARGEST_Z
from alight.lights.ball import disk_area
from alight.lights.bright_disk import brightest_disk
from alight.lights.emission.from_environments import draw_line, line_pdf
from lanewise.jit import instantiate
from tests.rendering.many_paths import compiled

WINDOW = (
    "  window{0}: {{light: {{type: portal}}, transform: [{{scale: 0.3}}, {{translate: {1}}}]}}\n"
)
SCENE = """
alight: 1
camera: {{type: pinhole, transform: {{translate: [0, 0, 3]}}}}
integrator: {{type: light}}
environment: {{type: constant}}
nodes:
  ball: {{shape: sphere}}
{0}"""
N = 1 << 14


@pytest.mark.parametrize("count", [0, 1, 2, 3])
def test_the_mean_of_one_over_the_density_is_the_area_of_the_disk(count):
    places = [[0.6 * i, 0.2, 0.8 - 0.3 * i] for i in range(count)]
    scene = compiled(SCENE.format("".join(WINDOW.format(*pair) for pair in enumerate(places))))
    rng = np.random.default_rng(count)
    way = np.array([0.3, -0.2, -0.9]) / np.linalg.norm([0.3, -0.2, -0.9])
    d = Vec3(*(np.full(N, c, np.float32) for c in way))
    u2 = tuple(rng.random(N, np.float32) for _ in range(2))
    draw, pdf, area = (
        np.errstate(all="ignore")(instantiate(root, scene.program, compiled=False))
        for root in (draw_line, line_pdf, disk_area)
    )
    p, meets = draw(scene.tables, d, u2)
    density = np.broadcast_to(pdf(scene.tables, p, d), N).astype(float)
    values = np.where(np.broadcast_to(meets, N), 1.0 / density, 0.0)
    expected = float(np.ravel(area(scene.tables))[0])
    spread = max(values.std() / np.sqrt(N), 1e-5 * expected)
    assert abs(values.mean() - expected) < LARGEST_Z * spread


@pytest.mark.parametrize("row", [0, 1, 60, 128])
def test_a_sun_has_the_light_of_its_texels(row):
    """Of rows that reach half a step to both sides, at the poles to one."""
    pixels, own = np.zeros((129, 256, 3), np.float32), np.array([1.0, 2.0, 4.0])
    # All of a pole's row is one point.
    columns = slice(None) if row in (0, 128) else slice(5, 6)
    pixels[row, columns] = own
    step = np.pi / 128.0
    upper, lower = np.clip([(row - 0.5) * step, (row + 0.5) * step], 0.0, np.pi)
    share = 0.5 * (np.cos(upper) - np.cos(lower)) / 256.0 * (256 if row in (0, 128) else 1)
    disk = brightest_disk(pixels, np.eye(3))
    assert disk is not None
    np.testing.assert_allclose(disk.mean, own * share, rtol=1e-6)
    theta, phi = row * step, 5.5 * 2.0 * np.pi / 256.0
    place = [np.sin(theta) * np.sin(phi), np.cos(theta), -np.sin(theta) * np.cos(phi)]
    np.testing.assert_allclose(disk.axis, place, atol=1e-6)


@pytest.mark.parametrize(("beside", "belongs"), [(0.3, True), (0.12, True), (0.09, False)])
def test_a_sun_has_all_texels_that_shine_a_tenth_as_bright(beside, belongs):
    """Its middle lies between them, nearer to what is brighter."""
    pixels = np.zeros((129, 256, 3), np.float32)
    pixels[64, 5], pixels[64, 6] = 1.0, beside
    disk = brightest_disk(pixels, np.eye(3))
    assert disk is not None
    share = np.sin(0.5 * np.pi / 128.0) / 256.0
    np.testing.assert_allclose(disk.mean, share * (1.0 + beside * belongs), rtol=1e-6)
    phi = np.array([5.5, 6.5]) * 2.0 * np.pi / 256.0
    weights = np.array([1.0, beside * belongs])
    middle = np.array([np.sin(phi) @ weights, 0.0, -np.cos(phi) @ weights])
    np.testing.assert_allclose(disk.axis, middle / np.linalg.norm(middle), atol=1e-6)
