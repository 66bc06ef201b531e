"""Light scattered inside bodies against exact albedos, furnaces, and walks step by step."""

import numpy as np
import pytest

import alight
from alight.bsdfs.interiors.subsurface import Subsurface, entering_row, pack, single_albedo
from alight.integrators.volpath import VolPath
from alight.laws.statistics import LARGEST_Z
from alight.media.homogeneous import Homogeneous
from alight.scene.flatten import flatten

COLORS = (0.95, 0.5, 0.1)
RADIUS = (0.1, 0.05, 0.02)
SIDE = 16


def scene(shape, bsdf, transform=(), integrator=None, others=None, **node):
    """One body before a white sky."""
    look = {"look_at": {"origin": [0, 0, 3], "target": [0, 0, 0]}}
    return alight.load(
        {
            "alight": 1,
            "camera": {"fov": 20, "transform": look},
            "film": {"size": [SIDE, SIDE], "filter": {"type": "box"}},
            "sampler": {"type": "independent"},
            "integrator": integrator or {"type": "path"},
            "environment": {"type": "constant", "radiance": 1},
            "nodes": {
                "body": {"shape": shape, "bsdf": bsdf, "transform": list(transform), **node},
                **(others or {}),
            },
        }
    )


def body(**keys):
    return {"type": "subsurface", "color": list(COLORS), "radius": list(RADIUS), "ior": 1, **keys}


def test_materials_share_the_rule_for_their_means(monkeypatch):
    """Its nodes take longer to find than all else that is worked out for a material."""
    entering_row(0.213, 1.31)
    monkeypatch.delattr(np.polynomial.legendre, "leggauss")
    _, mean = entering_row(0.217, 1.32)
    assert 0.8 < mean < 1.0


def mean_and_error(what, spp, seed=1):
    """Of the whole picture, for each channel."""
    film = alight.render(what, spp=spp, seed=seed, replicates=16)
    assert film.invalid == 0
    image, error = np.asarray(film.mean, float), np.asarray(film.standard_error, float)
    return image.mean((0, 1)), np.sqrt(np.sum(error**2, axis=(0, 1))) / image[..., 0].size


def exact_albedo(single):
    """What an endless body reflects of diffuse light: 1 - 2 sqrt(1 - a) int H(mu) mu d mu.

    Chandrasekhar 1960, Radiative Transfer, section 33, with his H function for isotropic
    scattering.
    """
    x, w = np.polynomial.legendre.leggauss(64)
    mu, w = 0.5 * (x + 1.0), 0.5 * w
    root, H = np.sqrt(1.0 - single), np.ones(64)
    for _ in range(3000):
        H = 1.0 / (root + 0.5 * single * (mu * H * w / (mu[:, None] + mu)).sum(1))
    return 1.0 - 2.0 * root * np.sum(H * mu * w)


@pytest.mark.parametrize("color", [0.0, 0.05, 0.2, 0.5, 0.8, 0.95, 0.99])
def test_the_inverse_of_the_albedo_is_that_of_the_exact_one(color):
    single = float(single_albedo(np.float64(color)))
    assert exact_albedo(single) == pytest.approx(color, abs=0.0025)


@pytest.mark.parametrize("integrator", ["path", pytest.param("volpath", marks=pytest.mark.proofs)])
def test_a_half_space_has_the_colour_that_is_asked_for(integrator):
    """Three edges are enough: to where light leaves, to where it enters, and to the sky."""
    half = scene("plane", body(), integrator={"type": integrator, "max_depth": 3})
    mean, error = mean_and_error(half, 128)
    exact = [exact_albedo(float(single_albedo(np.float64(color)))) for color in COLORS]
    assert np.all(np.abs(mean - exact) < LARGEST_Z * error)
    assert np.all(error < 0.01)


def test_the_smallest_radii_leave_the_colour_as_it_is():
    """Walks of the length of rounding errors neither leak out nor begin too deep."""
    tiny = scene("sphere", body(radius=1e-9), integrator={"type": "path", "max_depth": 3})
    mean, error = mean_and_error(tiny, 128)
    exact = [exact_albedo(float(single_albedo(np.float64(color)))) for color in COLORS]
    assert np.all(np.abs(mean - exact) < LARGEST_Z * error + 0.005)
    assert np.all(error < 0.01)


def test_long_walks_through_a_white_half_space_come_back():
    """Of those that end after 10,000 scatterings 1.2 % of the light would be lost."""
    white = body(color=1.0, radius=0.01)
    mean, error = mean_and_error(scene("plane", white, integrator={"type": "path"}), 512)
    assert np.all(mean > 0.993)
    assert np.all(error < 0.003)


@pytest.mark.parametrize("ior", [pytest.param(1.0, marks=pytest.mark.proofs), 1.5])
def test_a_white_body_vanishes_in_a_white_furnace(ior):
    cube = scene("cube", body(color=1.0, ior=ior, roughness=0.6), [{"scale": 0.5}])
    mean, error = mean_and_error(cube, 128)
    # The table of the coat errs by 0.0005.
    assert np.all(np.abs(mean - 1.0) < LARGEST_Z * error + (0.0005 if ior > 1.0 else 0.0))
    assert np.all(error < 0.01)


@pytest.mark.parametrize("shape", ["slab", pytest.param("sphere", marks=pytest.mark.proofs)])
def test_walks_agree_with_a_medium_between_matte_surfaces(shape):
    """The same body as a medium: every scattering is a vertex there, drawn in one way only."""
    transform = [{"scale": [0.5, 0.5, 0.03]}, {"rotate": {"axis": "y", "angle": 30}}]
    place = ("sphere", []) if shape == "sphere" else ("cube", transform)
    of_one = [float(single_albedo(np.float64(color))) for color in COLORS]
    sheet = {"type": "diffuse_transmission", "reflectance": 0, "transmittance": 1}
    medium = {
        "type": "homogeneous",
        "sigma_t": [1.0 / radius for radius in RADIUS],
        "albedo": of_one,
    }
    walked, error = mean_and_error(scene(place[0], body(), place[1]), 128)
    other = scene(place[0], sheet, place[1], {"type": "volpath"}, interior=medium)
    stepped, of_steps = mean_and_error(other, 256, seed=2)
    assert np.all(np.abs(walked - stepped) < LARGEST_Z * np.hypot(error, of_steps))
    assert np.all(np.hypot(error, of_steps) < 0.03 * stepped)


@pytest.mark.proofs
def test_all_ways_to_find_light_agree():
    """A half-space lets light in from below if shadow rays pass it."""
    means = []
    for sampling in ("mis", "bsdf", "emitter"):
        integrator = {"type": "path", "light_sampling": sampling}
        mean, error = mean_and_error(scene("plane", body(), integrator=integrator), 128)
        means.append((mean, error))
    for mean, error in means[1:]:
        assert np.all(np.abs(mean - means[0][0]) < LARGEST_Z * np.hypot(error, means[0][1]))


def test_lamps_that_shine_from_below_a_body_are_not_sampled_where_light_leaves():
    """A light tree would like those on the viewer's side, and he is inside."""
    lamps = {
        name: {
            "shape": {"type": "sphere", "radius": 0.05},
            "light": {"type": "area", "radiance": radiance},
            "transform": [{"translate": [0.4, 0.3, z]}],
        }
        for name, radiance, z in (("above", 50.0, 0.8), ("below", 500.0, -0.8))
    }
    by_light = {"light_choice": "tree", "light_sampling": "emitter", "hide_emitters": True}
    half = body(color=0.8, radius=0.01)
    lit = scene("plane", half, integrator={"type": "path", **by_light}, others=lamps)
    mean, error = mean_and_error(lit.replaced(environment=None), 32)
    assert np.all(error < 0.03 * mean)


def test_fog_around_a_body_does_not_fill_it():
    plain = scene("sphere", body())
    foggy = plain.replaced(
        medium=Homogeneous(), integrator=VolPath(), camera=plain.camera, environment=None
    )
    assert flatten(plain).shapes[0].border is None
    assert flatten(foggy).shapes[0].border == (0, 1)


def test_the_scale_multiplies_the_radius():
    """What scatters is one over it: each channel has its own."""
    packed: dict = {}

    class Packer:
        def numbers(self, name, *values):
            packed[name] = values

        def color(self, name, value):
            packed[name] = value

        curve = color

    pack(Subsurface(radius=(0.1, 0.2, 0.5), scale=0.25), Packer())
    assert packed["extinction"] == pytest.approx((40.0, 20.0, 8.0))


def test_the_layer_of_albedo_is_the_colour_below_a_coat_that_has_none():
    """F at right angles, by the index alone, and the body's colour of the rest."""
    coated = {"type": "subsurface", "color": list(COLORS), "ior": 1.5}
    seen = scene("plane", coated, integrator={"type": "ambient_occlusion"})
    albedo = alight.render(seen, spp=1, aovs="albedo").aov("albedo")[8, 8]
    np.testing.assert_allclose(albedo, 0.04 + 0.96 * np.array(COLORS), atol=0.004)
