"""Media against pen and paper: furnaces, transmittance, single scattering."""

import numpy as np
import pytest

import alight
from alight.formats import loads
from tests.media.scenes import (
    EXTINCTION,
    HIGH,
    RADIUS,
    TO_SUN,
    agree,
    bodies,
    columns,
    interpolated,
    places,
    sun,
)

ALL = np.ones((HIGH, HIGH), bool)


def render(scene, spp=256, **options):
    return alight.render(scene, spp=spp, **options).image


@pytest.fixture(scope="module")
def absorbed():
    """The bodies, if they scatter nothing, before white."""
    return render(bodies(0.0), 1024)


@pytest.mark.parametrize("g", [0.0, 0.8])
def test_media_that_only_scatter_vanish_in_a_white_furnace(g):
    """Behind borders that are not there, in glass, and on a grid; channels differ."""
    image = render(bodies(1.0, g=g))
    for body in columns():
        agree(image[:, body], np.ones((HIGH, HIGH, 3)), ALL, 0.02)


def test_transmittance_of_a_ball_is_beers_law(absorbed):
    x, y = places(8)
    chord = 2.0 * np.sqrt(np.maximum(RADIUS**2 - x**2 - y**2, 0.0))
    expected = np.exp(-chord[..., None] * np.array(EXTINCTION)).mean(2)
    image = absorbed[:, columns()[1]]
    # Pixels beside the ball are 1, without noise.
    np.testing.assert_allclose(image[0, 0], 1.0, rtol=1e-5)
    agree(image, expected, chord.min(-1) > 0.0, 0.015)


def test_transmittance_of_a_grid_is_the_integral_of_its_densities(absorbed):
    x, y = places(4)
    inside = (np.abs(x) < 0.8) & (np.abs(y) < 0.8)
    z = (np.arange(200) + 0.5) / 200 * 1.6 - 0.8
    x, y = x[..., None] + 2.0, y[..., None]
    depth = interpolated(x, y, z).mean(-1) * 1.6 * inside
    expected = np.exp(-depth[..., None] * np.array(EXTINCTION)).mean(2)
    agree(absorbed[:, columns()[2]], expected, inside.all(-1), 0.015)


#: Of the media in the light of the sun.
G, ALBEDO = 0.4, np.array([0.9, 0.6, 0.3])


@pytest.fixture(scope="module")
def scattered_once():
    """The bodies in the light of a sun of irradiance 2, which is scattered once."""
    scene = sun(bodies(tuple(ALBEDO), g=G), 2.0)
    return render(scene.replaced(integrator=scene.integrator.replaced(max_depth=2)), 1024)


def towards_the_eye():
    """Radiance over optical depth where the sun comes to undimmed."""
    phase = (1 - G * G) / (4 * np.pi * (1 + G * G + 2 * G * TO_SUN[2]) ** 1.5)
    return 2.0 * ALBEDO * np.array(EXTINCTION) * phase


def test_light_scattered_once_is_the_integral_along_the_ray(scattered_once):
    """The sun reaches the ball through a border that is not there, and leaves it again."""
    x, y = places(4)
    half = np.sqrt(np.maximum(RADIUS**2 - x**2 - y**2, 0.0))[..., None]
    # Points of Gauss between the front and the back of the ball.
    nodes, weights = np.polynomial.legendre.leggauss(24)
    z = half * nodes
    p = np.stack(np.broadcast_arrays(x[..., None], y[..., None], z), -1)
    along = p @ TO_SUN
    way = -along + np.sqrt(np.maximum(along**2 + RADIUS**2 - (p**2).sum(-1), 0.0))
    dimmed = np.exp(-(way + half - z)[..., None] * np.array(EXTINCTION))
    line = (dimmed * (weights * half)[..., None]).sum(-2)
    image = scattered_once[:, columns()[1]]
    agree(image, towards_the_eye() * line.mean(2), half.min((-1, -2)) > 0.0, 0.01)


def test_light_scattered_once_on_a_grid_is_the_integral_along_the_ray(scattered_once):
    """On its way in and on its way out it meets the densities that are there."""
    side, n = 0.8, 32
    middles = (np.arange(n) + 0.5) / n
    x, y = (at[..., None] for at in places(2))
    # Pixels within the box as a whole: 12 of them on either side of the middle.
    inside = (np.maximum(abs(x), abs(y)) < 12.0 / 16.0).all((-1, -2))
    x, y = x[inside] + 2.0, y[inside]
    z = side - 2.0 * side * middles
    density = interpolated(x, y, z)
    step = 2.0 * side / n
    before = (np.cumsum(density, -1) - 0.5 * density) * step
    # To the top of the box or to its front, whichever is nearer.
    way = np.minimum((side - y) / TO_SUN[1], (side - z) / TO_SUN[2])
    towards = way[..., None] * middles
    lit = interpolated(
        x[..., None], y[..., None] + towards * TO_SUN[1], z[:, None] + towards * TO_SUN[2]
    )
    depth = before + lit.mean(-1) * way
    dimmed = np.exp(-depth[..., None] * np.array(EXTINCTION)) * (density * step)[..., None]
    expected = np.zeros((HIGH, HIGH, 3))
    expected[inside] = towards_the_eye() * dimmed.sum(-2).mean(1)
    agree(scattered_once[:, columns()[2]], expected, inside, 0.02)


def test_leaving_a_body_leads_into_its_exterior():
    """Fog around the camera, a ball in it, and a smaller one inside: each with its own."""
    scene = bodies(0.0)
    small = loads(
        """
alight: 1
medium: {type: homogeneous, sigma_t: [0.1, 0.2, 0.3], albedo: 0}
media: {inner: {type: homogeneous, sigma_t: [0.3, 1, 2], albedo: 0}}
nodes: {ball: {shape: {type: sphere, radius: 0.5}, bsdf: {type: "null"}, interior: inner}}
""",
        check=False,
    )
    inner = small.nodes["ball"].replaced(exterior="inside")
    scene = scene.replaced(
        medium=small.medium,
        media={**scene.media, **small.media},
        nodes={**scene.nodes, "inner": inner, "wall": wall()},
    )
    x, y = places(8)
    outer = 2.0 * np.sqrt(np.maximum(RADIUS**2 - x**2 - y**2, 0.0))
    inside = 2.0 * np.sqrt(np.maximum(0.25 - x**2 - y**2, 0.0))
    way = np.stack([5.0 - outer, outer - inside, inside], -1)
    depth = way @ np.array([[0.1, 0.2, 0.3], EXTINCTION, [0.3, 1.0, 2.0]])
    image = render(scene)[:, columns()[1]]
    agree(image, np.exp(-depth).mean(2), ALL, 0.02)


def wall():
    """A lamp of radiance 1 across the view, 5 m from the camera."""
    scene = loads(
        """
alight: 1
nodes:
  wall:
    transform: [{scale: 4}, {translate: [0, 0, -1]}]
    shape: rectangle
    bsdf: {type: "null"}
    light: {type: area, radiance: 1}
""",
        check=False,
    )
    return scene.nodes["wall"]
