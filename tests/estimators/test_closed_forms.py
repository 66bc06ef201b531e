"""The rendering equation is solved: scenes whose radiance is known by pen and paper."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

import alight
from alight.rendering import main_loop

#: Seeds are fixed. Each test looks at one number or a few; 4.5 standard errors are exceeded by
#: chance once in 150 000 such numbers.
SIGMAS = 4.5

# A kernel is compiled for the models that a scene uses. Where a scene here has a small thing that
# nobody can see (outside of a closed box, below a plane), it is there to share another's kernel.

CAMERA = """
camera: {type: pinhole, fov: 60, transform: [{look_at: {origin: %s, target: %s, up: [0, 1, 0]}}]}
film: {size: [24, 24]}
sampler: {type: independent}
"""


def render(tmp_path, text, *, spp=256, **options):
    path = tmp_path / "scene.yaml"
    path.write_text("alight: 1\n" + text)
    return alight.render(alight.load(path), spp=spp, **options)


def assert_mean(film, expected):
    """The picture's mean is the expected colour, by the spread of all pixels' samples."""
    pixels = film.image.reshape(-1, 3).astype(np.float64)
    mean, error = pixels.mean(0), pixels.std(0, ddof=1) / np.sqrt(len(pixels))
    expected = np.broadcast_to(np.asarray(expected, float), (3,))
    off = np.abs(mean - expected)
    assert np.all(off <= SIGMAS * error + 3e-6 * expected), (mean, expected, error)
    # The test can see an error of 1 %: its own noise is far below it.
    assert np.all(SIGMAS * error < 0.01 * expected), error / expected


def furnace(integrator, reflectance=0.5):
    return (
        CAMERA % ([0.2, 0.1, 0.3], [1, 0.5, -1])
        + f"""
integrator: {integrator}
nodes:
  box:
    shape: {{type: cube, flip_normals: true}}
    bsdf: {{type: diffuse, reflectance: {reflectance}}}
    light: {{type: area, radiance: [1, 2, 3]}}
  outside: {{shape: {{type: sphere, center: [0, 9, 0], radius: 0.01}}}}
  lamp: {{light: {{type: point, intensity: 1e-6}}, transform: {{translate: [0, 9, 0]}}}}
"""
    )


@pytest.mark.parametrize(
    "integrator", ["{type: path}", "{type: volpath}", '{type: path, guiding: "on"}']
)
def test_filters_with_negative_lobes_keep_the_radiance_of_a_furnace(
    tmp_path, integrator, monkeypatch
):
    """Paths of negative weight go on like all others; without their light it would be too much."""
    # In a furnace, guides have nothing to learn.
    monkeypatch.setattr(main_loop, "trained", partial(main_loop.trained, rounds=2))
    text = furnace(integrator).replace(
        "film: {size: [24, 24]}", "film: {size: [24, 24], filter: mitchell}"
    )
    assert_mean(render(tmp_path, text, spp=1024), np.array([1, 2, 3]) / (1 - 0.5))


@pytest.mark.parametrize("strategy", ["mis", "bsdf", "emitter"])
def test_furnace_box_returns_le_over_one_minus_albedo(tmp_path, strategy):
    text = furnace(f"{{type: path, light_sampling: {strategy}}}")
    assert_mean(render(tmp_path, text), np.array([1, 2, 3]) / (1 - 0.5))


@pytest.mark.parametrize("depth", [1, 2, 3, 6])
@pytest.mark.parametrize("strategy", ["mis", "bsdf", "emitter"])
def test_depth_cap_gives_the_partial_geometric_series(tmp_path, strategy, depth):
    text = furnace(f"{{type: path, light_sampling: {strategy}, max_depth: {depth}, rr_depth: 9}}")
    series = (1 - 0.5**depth) / (1 - 0.5)
    assert_mean(render(tmp_path, text, spp=64), np.array([1, 2, 3]) * series)


@pytest.mark.parametrize("rr_depth", [1, 5])
def test_roulette_does_not_change_the_mean(tmp_path, rr_depth):
    text = furnace(f"{{type: path, rr_depth: {rr_depth}}}", reflectance=0.2)
    assert_mean(render(tmp_path, text, spp=128), np.array([1, 2, 3]) / (1 - 0.2))


@pytest.mark.parametrize("strategy", ["mis", "bsdf", "emitter"])
def test_point_light_in_a_diffuse_sphere_is_one(tmp_path, strategy):
    """E = I / r^2 everywhere; L = rho/pi E / (1 - rho) = 1 for rho = 1/2, I = pi (as in pbrt)."""
    text = (
        CAMERA % ([0.3, 0.2, 0.1], [1, 0.4, -0.7])
        + f"""
integrator: {{type: path, light_sampling: {strategy}}}
nodes:
  sphere:
    shape: {{type: sphere, flip_normals: true}}
    bsdf: {{type: diffuse, reflectance: 0.5}}
  lamp: {{light: {{type: point, intensity: 3.14159265358979}}}}
  outside:
    transform: [{{scale: 1e-3}}, {{translate: [0, 9, 0]}}]
    shape: {{type: cube, flip_normals: true}}
    light: {{type: area, radiance: 1}}
"""
    )
    assert_mean(render(tmp_path, text), 1.0)


def test_light_scaled_by_powers_of_ten_scales_the_picture(tmp_path):
    base = furnace("{type: path, max_depth: 4}")
    reference = render(tmp_path, base, spp=16).image.astype(np.float64)
    for scale in (1e-6, 1e6):
        radiance = [scale, 2 * scale, 3 * scale]
        text = base.replace("radiance: [1, 2, 3]", f"radiance: {radiance}")
        text = text.replace("intensity: 1e-6", f"intensity: {1e-6 * scale:.20f}")
        image = render(tmp_path, text, spp=16).image.astype(np.float64)
        np.testing.assert_allclose(image, reference * scale, rtol=1e-5)


def plane_under(light):
    return (
        (CAMERA % ([0, 1e-3, 0], [0, 0, 0]))
        .replace("up: [0, 1, 0]", "up: [0, 0, 1]")
        .replace("fov: 60", "fov: 1e-3")
        + f"""
integrator: {{type: direct}}
nodes:
  floor:
    transform: [{{rotate: {{axis: [1, 0, 0], angle: -90}}}}]
    shape: {{type: plane}}
    bsdf: {{type: diffuse, reflectance: 1}}
  lamp:
{light}
"""
    )


#: Lamps that light the back of the plane.
BELOW = "".join(
    f"  {shape} below: {{shape: {shape}, light: {{type: area}}, bsdf: {{type: diffuse}}, "
    "transform: [{scale: 1e-3}, {translate: [0, -9, 0]}]}\n"
    for shape in ("disk", "sphere", "rectangle")
)


def test_disk_light_above_a_plane(tmp_path):
    """Form factor of a coaxial disk seen from a point below: r^2 / (r^2 + h^2)."""
    light = """
    transform: [{scale: 0.7}, {rotate: {axis: [1, 0, 0], angle: 90}}, {translate: [0, 1.5, 0]}]
    shape: {type: disk}
    bsdf: {type: diffuse, reflectance: 0}
    light: {type: area, radiance: 2}
"""
    expected = 2 * 0.7**2 / (0.7**2 + 1.5**2)
    assert_mean(render(tmp_path, plane_under(light + BELOW), spp=64), expected)


def test_sphere_light_above_a_plane(tmp_path):
    """A sphere wholly above the horizon sends E = pi L (r/d)^2 on the plane below it."""
    light = """
    transform: [{scale: 0.5}, {translate: [0, 2, 0]}]
    shape: {type: sphere}
    bsdf: {type: diffuse, reflectance: 0}
    light: {type: area, radiance: 3}
"""
    assert_mean(render(tmp_path, plane_under(light + BELOW), spp=64), 3 * (0.5 / 2) ** 2)


def test_rectangle_light_above_a_plane(tmp_path):
    """A rectangle 2a x 2b centred at height c: four times the corner form factor (Howell B-3)."""
    a, b, c = 0.8, 0.5, 1.2
    light = f"""
    transform: [{{scale: [{a}, {b}, 1]}}, {{rotate: {{axis: [1, 0, 0], angle: 90}}}},
                {{translate: [0, {c}, 0]}}]
    shape: {{type: rectangle}}
    bsdf: {{type: diffuse, reflectance: 0}}
    light: {{type: area, radiance: 1}}
"""
    x, y = a / c, b / c
    corner = (
        x / np.sqrt(1 + x * x) * np.arctan(y / np.sqrt(1 + x * x))
        + y / np.sqrt(1 + y * y) * np.arctan(x / np.sqrt(1 + y * y))
    ) / (2 * np.pi)
    assert_mean(render(tmp_path, plane_under(light + BELOW), spp=64), 4 * corner)


@pytest.mark.parametrize("strategy", ["mis", "bsdf", "emitter"])
def test_constant_environment_on_a_white_plane_is_itself(tmp_path, strategy):
    text = plane_under("    light: {type: point, intensity: 0}").replace(
        "integrator: {type: direct}", f"integrator: {{type: direct, light_sampling: {strategy}}}"
    )
    text += "environment: {type: constant, radiance: [0.5, 1, 2]}\n"
    assert_mean(render(tmp_path, text, spp=4096), [0.5, 1, 2])


WHITE_THINGS = """
integrator: {type: path, light_sampling: %s, max_depth: 64}
bsdfs:
  white: {type: diffuse, reflectance: 1}
  glazed: {type: plastic, int_ior: 1.8, diffuse_reflectance: 1, nonlinear: true}
  veil: {type: mask, opacity: 0.6, bsdf: {type: two_sided, bsdf: white}}
  mix: {type: blend, weight: 0.3, bsdfs: [glazed, {type: mirror, reflectance: 1}]}
nodes:
  sky: {light: {type: constant, radiance: 1}}
  glazed: {shape: {type: sphere, center: [-0.8, 0, 0], radius: 0.7}, bsdf: glazed}
  veil: {shape: {type: sphere, center: [0.8, 0, 0], radius: 0.7}, bsdf: veil}
  mix: {shape: {type: sphere, center: [0, 1.2, -0.3], radius: 0.6}, bsdf: mix}
"""


@pytest.mark.parametrize(
    "strategy",
    ["mis", *(pytest.param(name, marks=pytest.mark.proofs) for name in ("bsdf", "emitter"))],
)
def test_white_things_of_several_lobes_vanish_in_a_white_sky(tmp_path, strategy):
    """With MIS every sample needs the densities of both strategies: each alone is a proof."""
    text = CAMERA % ([0, 0.4, 3], [0, 0.4, 0]) + WHITE_THINGS % strategy
    assert_mean(render(tmp_path, text), 1.0)


def test_open_plane_has_no_ambient_occlusion(tmp_path):
    text = plane_under("    light: {type: point, intensity: 1}").replace(
        "integrator: {type: direct}", "integrator: {type: ambient_occlusion}"
    )
    film = render(tmp_path, text, spp=4)
    np.testing.assert_array_equal(film.image, 1.0)


def test_random_walk_agrees_with_the_series(tmp_path):
    text = furnace("{type: random_walk, max_depth: 3}")
    assert_mean(render(tmp_path, text), np.array([1, 2, 3]) * (1 + 0.5 + 0.25))
