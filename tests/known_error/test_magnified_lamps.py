"""What glass makes of a lamp, by first-order optics: how large its image is, and how bright."""

import numpy as np
import pytest

import alight
from alight.compiled.scene import compile_scene
from alight.core.vec import Vec3
from alight.rendering.light_behind_glass import DIRECTIONS, _magnified, light_behind_glass
from alight.rendering.pilot_rays import POINTS, Pilot
from alight.rendering.sight import Sight
from alight.scene import flatten

#: Lamp above a matte floor, of which little is seen: metres, W/(m^2 sr).
RADIUS, HEIGHT, RADIANCE, ALBEDO, INDEX = 0.002, 2.0, 1e6, 0.4, 1.5


def compiled(shape, place, lamp=(0, 0, HEIGHT)):
    nodes = {
        "floor": {"shape": "plane", "bsdf": {"type": "diffuse", "reflectance": ALBEDO}},
        "lamp": {
            "shape": {"type": "sphere", "radius": RADIUS},
            "transform": {"translate": list(lamp)},
            "light": {"type": "area", "radiance": RADIANCE},
        },
        "glass": {
            "shape": shape,
            "transform": place,
            "bsdf": {"type": "dielectric", "int_ior": INDEX},
        },
    }
    look = {"origin": [0, 0, 0.7], "target": [0, 0, 0], "up": [0, 1, 0]}
    scene = alight.load({
        "alight": 1, "film": {"size": [16, 16]}, "integrator": {"type": "path"}, "nodes": nodes,
        "camera": {"type": "orthographic", "height": 0.1, "transform": {"look_at": look}},
    })  # fmt: skip
    flat = flatten(scene)
    return flat, compile_scene(flat)


def found(shape, place, lamp=(0, 0, HEIGHT)):
    """Mean radiance of the floor, and mean probability to meet the lamp, over those without glass.

    A cosine-distributed path meets a small lamp above it with the probability r^2 / h^2.
    """
    table = light_behind_glass(Sight(*compiled(shape, place, lamp)))[-POINTS * DIRECTIONS :]
    plain = (RADIUS / HEIGHT) ** 2
    return table[:, 2].sum() / POINTS / (ALBEDO * RADIANCE * plain), table[:, 5].mean() / plain


@pytest.mark.parametrize("off", [0.0, 0.1, -0.1])
def test_a_ball_shows_a_lamp_inside_by_the_formula_of_one_refracting_surface(off):
    """The lamp is so far above the middle; its image is virtual (Hecht, Optics, section 5.2)."""
    radius = 0.2
    inside = radius + off
    distance = 1.0 / (INDEX / inside - (INDEX - 1.0) / radius)
    lateral = INDEX * distance / inside
    nearer = HEIGHT / (HEIGHT - inside + distance)
    light, q = found({"type": "sphere", "radius": radius}, {"translate": [0, 0, HEIGHT - off]})
    assert q == pytest.approx((lateral * nearer) ** 2, rel=0.02)
    # Radiance over the square of the index is what stays the same.
    assert light == pytest.approx((lateral * nearer / INDEX) ** 2, rel=0.02)


def test_a_slab_lifts_a_lamp():
    thick = 0.3
    nearer = HEIGHT / (HEIGHT - thick * (1.0 - 1.0 / INDEX))
    light, q = found("cube", [{"scale": [9, 9, thick / 2]}, {"translate": [0, 0, 1]}])
    np.testing.assert_allclose([light, q], nearer**2, rtol=0.02)


def test_where_no_refracted_ray_arrives_the_lamp_is_taken_as_it_is():
    """From below, so flat that light is mirrored back: warnings are errors here."""
    aside, high = 4.0, 1.6
    place = [{"scale": [9, 9, 0.75]}, {"translate": [0, 0, 0.73]}]
    light, q = found("cube", place, (aside, 0, high))
    plain = high * HEIGHT**2 / (high**2 + aside**2) ** 1.5
    np.testing.assert_allclose([light, q], plain, rtol=0.05)


@pytest.mark.parametrize("tilt", [0.0, 0.005])
def test_a_ball_shows_what_is_far_in_any_direction_straight_up_too(tilt):
    """Rays that begin a distance a before a lens of focal length f are 1 - a/f as far apart."""
    radius, below = 0.2, 0.35
    _, scene = compiled({"type": "sphere", "radius": radius}, {"translate": [0, 0, 1]})
    pilot = Pilot(scene, np.random.default_rng(1))
    o = Vec3(*(np.full(1, x, np.float32) for x in (0.0, 0.0, 1.0 - below)))
    d = Vec3(*(np.full(1, x, np.float32) for x in (np.sin(tilt), 0.0, np.cos(tilt))))
    wider, index = _magnified(pilot, o, d, np.full(1, np.inf), np.full(1, 0.01), pilot.times(1))
    focal = INDEX * radius / (2.0 * (INDEX - 1.0))
    assert wider[0] == pytest.approx((1.0 - below / focal) ** -2, rel=0.02)
    assert index[0] == pytest.approx(1.0, rel=1e-4)
