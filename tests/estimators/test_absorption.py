"""What bodies absorb: Beer and Lambert's exponential along every segment that lies in them."""

import numpy as np
import pytest
import yaml

from alight.bsdfs.adapters.mask import Mask
from alight.bsdfs.dielectrics.dielectric import Dielectric
from alight.bsdfs.dielectrics.null import Null
from alight.bsdfs.disney.principled import Principled
from alight.bsdfs.interiors.bodies import body_below
from alight.bsdfs.interiors.subsurface import Subsurface
from alight.core.errors import SceneError
from alight.formats import loads
from tests.twin import picture_of

COLOR = np.array([0.8, 0.5, 0.1])
OTHER = np.array([0.2, 0.9, 0.6])
TOLERANCE = {"rtol": 3e-3}
CLEAR = {"type": "dielectric", "int_ior": 1.0, "ext_ior": 1.0}
BLACK = {"type": "diffuse", "reflectance": 0.0}
SKY = {"type": "constant", "radiance": 1.0}


def glass(color=COLOR, distance=1.0):
    """It does not refract."""
    return CLEAR | {"attenuation_color": list(map(float, color)), "attenuation_distance": distance}


def ball(radius, bsdf, z=0.0, **more):
    return {
        "shape": {"type": "sphere", "center": [0, 0, z], "radius": radius},
        "bsdf": bsdf,
        **more,
    }


def lamp(radius, z=0.0):
    return ball(radius, BLACK, z, light={"type": "area", "radiance": 1.0})


def bulb(z):
    light = {"type": "point", "intensity": 1.0}
    return {"light": light, "transform": {"translate": [0, 0, z]}}


def seen(nodes, z=9.0, integrator="path", spp=16, options=None, **more):
    """What the camera sees at (0, 0, z), looking along -z through a narrow window, in the twin."""
    look = {"look_at": {"origin": [0, 0, z], "target": [0, 0, z - 1]}}
    scene = {
        "alight": 1,
        "integrator": {"type": integrator, **(options or {})},
        "camera": {"fov": 0.2, "transform": look},
        "film": {"size": [2, 2]},
        "nodes": nodes,
        **more,
    }
    return picture_of(loads(yaml.safe_dump(scene)), spp).mean((0, 1))


@pytest.mark.parametrize(
    "model",
    [
        CLEAR,
        {"type": "principled", "base_color": 1.0, "transmission": 1.0, "ior": 1.0,
         "roughness": 0.0},
    ],
)  # fmt: skip
def test_light_through_a_body_falls_exponentially(model):
    body = model | {"attenuation_color": COLOR.tolist(), "attenuation_distance": 2.0}
    np.testing.assert_allclose(
        seen({"body": ball(1.5, body)}, environment=SKY), COLOR**1.5, rtol=3e-3
    )


@pytest.mark.parametrize("integrator", ["path", "volpath"])
def test_a_lamp_inside_is_dimmed_on_its_way_out(integrator):
    nodes = {"body": ball(1.0, glass()), "lamp": lamp(0.3)}
    np.testing.assert_allclose(seen(nodes, integrator=integrator), COLOR**0.7, **TOLERANCE)


def test_each_of_nested_bodies_dims_its_part_of_the_way():
    """A liquid with two bubbles in a glass, and a lamp in the wall of the glass behind it."""
    nodes = {
        "glass": ball(2.0, glass(COLOR)),
        "liquid": ball(1.5, glass(OTHER)),
        "bubble": ball(0.5, dict(CLEAR), 0.9),
        "ice": ball(0.2, dict(CLEAR), 0.1),
        "lamp": lamp(0.1, -1.75),
    }
    # The last segment leaves the liquid and ends on the lamp: neither side says what is between.
    expected = COLOR ** (0.5 + 0.15) * OTHER ** (3.0 - 1.0 - 0.4)
    without_noise = {"max_depth": 16, "russian_roulette": "none"}
    np.testing.assert_allclose(seen(nodes, options=without_noise), expected, rtol=0.01)


@pytest.mark.parametrize(("end", "way"), [("lamp", 0.8), ("sky", 1.5)])
def test_a_camera_inside_sees_through_the_body(end, way):
    nodes = {"outer": ball(2.0, glass(OTHER)), "body": ball(1.5, glass())}
    if end == "lamp":
        found = seen({**nodes, "lamp": lamp(0.2, -1.0)}, z=0.0)
        np.testing.assert_allclose(found, COLOR**way, **TOLERANCE)
    else:
        found = seen(nodes, z=0.0, environment=SKY)
        np.testing.assert_allclose(found, COLOR**way * OTHER**0.5, **TOLERANCE)


@pytest.mark.parametrize("integrator", ["path", "volpath", "direct"])
def test_light_between_two_things_inside_is_dimmed(integrator):
    """A bulb lights a floor, 1.5 m below the camera and as far from the bulb."""
    nodes = {
        "body": ball(3.0, glass()),
        "floor": {
            "shape": "rectangle",
            "bsdf": {"type": "diffuse", "reflectance": 0.5},
            "transform": {"translate": [0, 0, -1.0]},
        },
        "bulb": bulb(0.5),
    }
    found = seen(nodes, z=0.4, integrator=integrator)
    np.testing.assert_allclose(found, 0.5 / np.pi / 1.5**2 * COLOR**2.9, **TOLERANCE)


@pytest.mark.parametrize("opacity", [1.0, 0.4, 0.0])
@pytest.mark.parametrize("integrator", ["path", "volpath"])
def test_holes_lead_into_bodies_and_out_of_them(integrator, opacity):
    nodes = {
        "body": ball(1.0, {"type": "mask", "opacity": opacity, "bsdf": glass()}),
        "lamp": lamp(0.5, -4.0),
    }
    np.testing.assert_allclose(seen(nodes, integrator=integrator), COLOR**2, **TOLERANCE)


def test_shadow_rays_through_holes_are_dimmed_inside():
    """The bulb stands outside of a body of which half is left open, before a floor inside."""
    nodes = {
        "body": ball(1.0, {"type": "mask", "opacity": 0.5, "bsdf": glass()}),
        "floor": {
            "shape": "disk", "bsdf": {"type": "diffuse", "reflectance": 0.5},
            "transform": {"scale": 0.2},
        },
        "bulb": bulb(2.0),
    }  # fmt: skip
    # Glass that does not bend light stops shadow rays all the same.
    expected = 0.5 * 0.5 / np.pi / 2.0**2 * COLOR**2
    for integrator in ("path", "volpath"):
        np.testing.assert_allclose(seen(nodes, integrator=integrator), expected, **TOLERANCE)


def test_haze_elsewhere_leaves_glass_as_it_is():
    nodes = {"body": ball(1.0, glass())}
    cloud = {"shape": "cube", "bsdf": {"type": "null"}, "interior": "haze",
             "transform": {"translate": [5, 0, 0]}}  # fmt: skip
    haze = {"haze": {"type": "homogeneous", "sigma_t": 0.01}}
    found = seen(nodes | {"cloud": cloud}, integrator="volpath", media=haze, environment=SKY)
    np.testing.assert_allclose(found, COLOR**2, **TOLERANCE)


def test_media_in_coloured_glass_extinguish_besides():
    nodes = {"body": ball(1.0, glass(), interior="soot"), "lamp": lamp(0.2)}
    soot = {"soot": {"type": "homogeneous", "sigma_t": 1.0, "albedo": 0.0}}
    found = seen(nodes, integrator="volpath", media=soot, spp=512)
    np.testing.assert_allclose(found, np.exp(-0.8) * COLOR**0.8, rtol=0.15)


def test_what_media_in_coloured_glass_emit_is_dimmed_from_where_it_is():
    fire = {"fire": {"type": "homogeneous", "sigma_t": 1.0, "albedo": 0.0, "emission": 2.0}}
    nodes = {"body": ball(1.0, glass(), interior="fire")}
    found = seen(nodes, integrator="volpath", media=fire, spp=2048)
    # 2 m through both: the integral of 2 exp(-s) COLOR^s.
    rate = 1.0 - np.log(COLOR)
    np.testing.assert_allclose(found, 2.0 / rate * (1.0 - np.exp(-2.0 * rate)), rtol=0.08)


def test_blends_absorb_as_their_bodies_do_by_their_shares():
    r, other = Dielectric(**glass()), Dielectric(**glass(OTHER))
    thin = Principled(thin=True, attenuation_color=COLOR.tolist(), attenuation_distance=1.0)
    blend = loads(yaml.safe_dump({
        "alight": 1, "camera": {},
        "nodes": {"a": {"shape": "sphere", "bsdf": {
            "type": "blend", "weight": 0.25, "bsdfs": [glass(), glass(OTHER)]}}},
    })).nodes["a"].bsdf  # fmt: skip
    expected = 0.75 * np.array(r.coefficients) + 0.25 * np.array(other.coefficients)
    np.testing.assert_allclose(body_below(blend), expected)
    np.testing.assert_allclose(body_below(Mask(opacity=0.1, bsdf=blend)), expected)
    dirty = blend.replaced(bsdfs=(r, Principled(base_color=0.5)))
    np.testing.assert_allclose(body_below(dirty), r.coefficients)
    assert body_below(Null()) is body_below(thin) is body_below(Principled()) is None
    assert body_below(Subsurface()) == (0.0, 0.0, 0.0)


def test_infinite_distance_absorbs_nothing():
    clear = CLEAR | {"attenuation_color": COLOR.tolist()}
    found = seen({"body": ball(1.5, clear)}, environment=SKY)
    np.testing.assert_allclose(found, 1.0, rtol=1e-5)
    written = Dielectric(attenuation_color=COLOR.tolist(), attenuation_distance=".inf")
    assert written.coefficients == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("distance", [0.0, -1.0, float("nan")])
def test_other_distances_are_refused(distance):
    with pytest.raises(SceneError, match="attenuation_distance"):
        Dielectric(attenuation_distance=distance)
