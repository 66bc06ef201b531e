"""Media that shine, against pen and paper."""

import numpy as np
import pytest

import alight
from alight.bsdfs.dielectrics.dielectric import Dielectric
from alight.media.coefficients import shines
from alight.media.homogeneous import Homogeneous
from tests.media.scenes import (
    DENSITIES,
    EXTINCTION,
    HIGH,
    RADIUS,
    agree,
    bodies,
    columns,
    interpolated,
    places,
)

GLOW = (3.0, 1.0, 0.5)
SIDE = 0.8
ALL = np.ones((HIGH, HIGH), bool)


def in_the_dark(scene):
    return scene.replaced(environment=scene.environment.replaced(radiance=0.0))


def along_the_box(x, y, values=None):
    """Extinction and emission of a grid's box, front to back, in the middles of short steps."""
    n = 64
    z = SIDE - 2.0 * SIDE * (np.arange(n) + 0.5) / n
    density = interpolated(x[..., None] + 2.0, y[..., None], z)
    ones = np.ones_like(DENSITIES)
    glow = interpolated(x[..., None] + 2.0, y[..., None], z, ones if values is None else values)
    step = 2.0 * SIDE / n
    sigma = density[..., None] * np.array(EXTINCTION)
    before = np.exp(-(np.cumsum(sigma, -2) - 0.5 * sigma) * step)
    # Of a short step not all is absorbed.
    absorbed = 2.0 * np.sinh(0.5 * sigma * step)
    return (before * absorbed * glow[..., None]).sum(-2)


@pytest.fixture(scope="module")
def glowing():
    """The bodies, if they only absorb, in their own light."""
    return alight.render(in_the_dark(bodies(0.0, emission=GLOW)), spp=1024).image


def test_what_only_absorbs_shines_by_what_it_holds_back(glowing):
    """L = Le (1 - T), in each channel."""
    x, y = places(8)
    chord = 2.0 * np.sqrt(np.maximum(RADIUS**2 - x**2 - y**2, 0.0))
    held_back = 1.0 - np.exp(-chord[..., None] * np.array(EXTINCTION)).mean(2)
    agree(glowing[:, columns()[1]], GLOW * held_back, chord.min(-1) > 0.0, 0.015)


def test_a_grid_shines_where_it_is_dense(glowing):
    x, y = places(2)
    inside = (np.maximum(abs(x), abs(y)) < 12.0 / 16.0).all(-1)
    expected = np.array(GLOW) * along_the_box(x, y).mean(2)
    agree(glowing[:, columns()[2]], expected, inside, 0.015)


def test_emission_on_a_grid_is_interpolated():
    """It takes the place of the constant one."""
    values = np.array(DENSITIES)[::-1, ::-1, ::-1] + 0.1
    scene = in_the_dark(bodies(0.0, emission=GLOW))
    grid = scene.media["grid"].replaced(emission_values=values)
    scene = scene.replaced(media={**scene.media, "grid": grid})
    x, y = places(2)
    inside = (np.maximum(abs(x), abs(y)) < 12.0 / 16.0).all(-1)
    expected = along_the_box(x, y, values).mean(2)
    image = alight.render(scene, spp=1024).image
    agree(image[:, columns()[2]], expected, inside, 0.015)


def test_in_a_furnace_as_bright_as_themselves_media_vanish():
    """What is absorbed of a white sky is emitted, whatever the albedo; scattering does nothing.

    In glass the sky is brighter by the square of the index, and so must the medium be.
    """
    scene = bodies((0.9, 0.5, 0.1), g=0.6, emission=1.0)
    glass = scene.nodes["glass"]
    assert isinstance(glass.bsdf, Dielectric)
    hot = scene.media["inside"].replaced(emission=glass.bsdf.int_ior**2)
    scene = scene.replaced(
        media={**scene.media, "hot": hot},
        nodes={**scene.nodes, "glass": glass.replaced(interior="hot")},
    )
    image = alight.render(scene, spp=256).image
    for body in columns():
        agree(image[:, body], np.ones((HIGH, HIGH, 3)), ALL, 0.02)


def test_a_medium_is_a_light():
    assert in_the_dark(bodies(0.5, emission=GLOW)).warnings == ()
    for dark in (bodies(0.5), bodies(1.0, emission=GLOW), bodies(0.5, (0, 0, 0), emission=GLOW)):
        assert len(in_the_dark(dark).warnings) == 1


@pytest.mark.parametrize("channel", range(3))
def test_a_medium_shines_if_any_channel_absorbs(channel):
    albedo = [1.0, 1.0, 1.0]
    assert not shines(Homogeneous(albedo=albedo, emission=GLOW))
    albedo[channel] = 0.5
    assert shines(Homogeneous(albedo=albedo, emission=GLOW))
    assert not shines(Homogeneous(albedo=albedo))
