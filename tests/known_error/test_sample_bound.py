r"""The bound of a sample, against the sum that its derivation ends with.

.. math:: c_{\max} = L_e \sum_{d=1}^{D} b_{d-1} + L_e\, W\, h \sum_{d=1}^{D-1} b_{d-1}
"""

import math

import numpy as np
import pytest

import alight
from alight.outputs.image import write_image
from alight.rendering.schedules.sample_bound import largest_sample
from alight.scene import flatten

# A closed box that shines, and a ball in it.
BOX = """
alight: 1
camera: {type: pinhole, fov: 60}
film: {size: [8, 8]}
integrator: {type: path}
nodes:
  box:
    shape: {type: cube, flip_normals: true}
    bsdf: {type: diffuse, reflectance: 0.5}
    light: {type: area, radiance: [1, 2, 3]}
  ball:
    shape: {type: sphere, radius: 0.1}
    bsdf: {type: diffuse, reflectance: [0.1, 0.3, 0.2]}
"""


@pytest.fixture
def bound(tmp_path):
    path = tmp_path / "box.yaml"
    path.write_text(BOX)

    def largest(*changes, text=None, by_tree=False):
        path.write_text(text or BOX)
        scene = alight.load(path, list(changes))
        return largest_sample(flatten(scene), by_tree)

    return largest


def summed(radiance, weight, depth, heuristic="power", roulette_from=None):
    """The docstring's sums, term by term."""
    throughputs = [1.0]
    for d in range(1, depth):
        following = weight * throughputs[-1]
        if roulette_from is not None and d >= roulette_from:
            following = max(1.0, following / 0.95)
        throughputs.append(following)
    half = 0.5 if heuristic == "power" else 1.0
    return radiance * (sum(throughputs) + weight * half * sum(throughputs[:-1]))


@pytest.mark.parametrize("depth", [1, 2, 3, 8, 30])
@pytest.mark.parametrize("heuristic", ["power", "balance"])
def test_without_roulette_it_is_a_geometric_series(bound, depth, heuristic):
    found = bound(
        f"integrator.max_depth={depth}", f"integrator.heuristic={heuristic}",
        "integrator.russian_roulette=none",
    )  # fmt: skip
    half = 0.5 if heuristic == "power" else 1.0
    # Light that is met: 1 + 1/2 + ...; light that is sampled: half as much, one edge less.
    met = 2.0 * (1.0 - 0.5**depth)
    sampled = 0.5 * half * 2.0 * (1.0 - 0.5 ** (depth - 1))
    assert found == pytest.approx(3.0 * (met + sampled), rel=1e-12)
    assert found == pytest.approx(summed(3.0, 0.5, depth, heuristic))


@pytest.mark.parametrize("depth", [1, 4, 9])
def test_bsdf_sampling_alone_adds_only_what_paths_meet(bound, depth):
    found = bound(
        f"integrator.max_depth={depth}", "integrator.light_sampling=bsdf",
        "integrator.russian_roulette=none",
    )  # fmt: skip
    assert found == pytest.approx(3.0 * 2.0 * (1.0 - 0.5**depth), rel=1e-12)


@pytest.mark.parametrize("depth", [1, 3, 6, 12])
@pytest.mark.parametrize("first", [1, 2, 5])
@pytest.mark.parametrize("weight", [0.5, 0.99])
def test_roulette_lifts_every_path_to_one_at_least(bound, depth, first, weight):
    found = bound(
        f"integrator.max_depth={depth}", f"integrator.rr_depth={first}",
        f"nodes.box.bsdf.reflectance={weight}",
    )  # fmt: skip
    assert found == pytest.approx(summed(3.0, weight, depth, roulette_from=first), rel=1e-9)


def test_paths_without_a_cap_end_where_little_is_left(bound):
    """Mean light beyond depth D is W^D / (1 - W) of the radiance: one ten-thousandth."""
    for weight in (0.3, 0.8, 0.95):
        found = bound(
            f"nodes.box.bsdf.reflectance={weight}", "integrator.rr_depth=4",
            "integrator.max_depth=null",
        )  # fmt: skip
        depths = [d for d in range(1, 400) if weight**d <= 1e-4 * (1.0 - weight)]
        assert found == pytest.approx(summed(3.0, weight, depths[0], roulette_from=4), rel=1e-9)
    white = "nodes.box.bsdf.reflectance=1"
    assert bound(white, "integrator.max_depth=null") is None
    assert bound(white, "integrator.max_depth=4", "integrator.russian_roulette=none") == (
        pytest.approx(3.0 * (4.0 + 1.5))
    )
    black = [f"nodes.{name}.bsdf.reflectance=0" for name in ("box", "ball")]
    assert bound(*black, "integrator.max_depth=null") == pytest.approx(3.0)


def test_units_and_the_brightest_of_all(bound):
    one = bound("integrator.max_depth=5")
    assert bound("integrator.max_depth=5", "nodes.box.light.radiance=[2,4,6]") == (
        pytest.approx(2.0 * one)
    )
    assert bound("integrator.max_depth=5", "nodes.box.light.radiance=[3,2,1]") == pytest.approx(one)
    # A brighter ball: its light and its weight count wherever it stands in the file.
    changes = ["integrator.max_depth=3", "integrator.russian_roulette=none"]
    lamp = BOX + "    light: {type: area, radiance: 7}\n"
    assert bound(*changes, text=lamp) == pytest.approx(summed(7.0, 0.5, 3))
    assert bound(*changes, "nodes.box.light.radiance=9", text=lamp) == (
        pytest.approx(summed(9.0, 0.5, 3))
    )
    assert bound(*changes, "nodes.ball.bsdf.reflectance=[0.1,0.9,0.2]") == (
        pytest.approx(summed(3.0, 0.9, 3))
    )


def test_samples_of_lights_that_a_tree_chooses_have_no_bound(bound):
    assert bound("integrator.max_depth=5") is not None
    assert bound("integrator.max_depth=5", by_tree=True) is None


SHORT = ("integrator.max_depth=3", "integrator.russian_roulette=none")


@pytest.mark.parametrize(
    ("bsdf", "weight"),
    [
        ("{type: mirror, reflectance: [0.6, 0.8, 0.7]}", 0.8),
        ("{type: conductor, metal: gold, specular_reflectance: [0.6, 0.9, 0.7]}", 0.9),
        ("{type: rough_conductor, metal: gold, specular_reflectance: 0.7}", 0.7),
        ("{type: diffuse, reflectance: 0.3, sampling: uniform}", 0.6),
        ("{type: 'null'}", 1.0),
        ("{type: two_sided, bsdf: {type: mirror, reflectance: 0.75}}", 0.75),
        ("{type: diffuse, reflectance: {type: checkerboard, color0: 0.1, color1: [0.2, 0.9, 0.3]}}",
         0.9),
    ],
)  # fmt: skip
def test_weights_of_materials(bound, bsdf, weight):
    text = BOX.replace("{type: diffuse, reflectance: [0.1, 0.3, 0.2]}", bsdf)
    assert bound(*SHORT, text=text) == pytest.approx(summed(3.0, weight, 3), rel=1e-6)


def test_environments_count_and_do_not_add_up(bound):
    constant = "environment: {type: constant, radiance: [1, 8, 2]}\n"
    assert bound(*SHORT, text=BOX + constant) == pytest.approx(summed(8.0, 0.5, 3))


def test_the_brightest_texel_of_a_scaled_map(tmp_path, bound):
    pixels = np.ones((4, 8, 3), np.float32)
    pixels[1, 2] = (5.0, 2.0, 3.0)
    write_image(tmp_path / "sky.exr", pixels)
    text = BOX + "environment: {type: environment, file: sky.exr, scale: [1, 4, 2]}\n"
    # 5 x 1, 2 x 4 and 3 x 2.
    assert bound(*SHORT, text=text) == pytest.approx(summed(8.0, 0.5, 3), rel=1e-3)


@pytest.mark.parametrize(
    ("changes", "more"),
    [
        (("integrator.light_sampling=emitter",), ""),
        (("film.filter.type=mitchell",), ""),
        (("nodes.ball.bsdf={type: dielectric}",), ""),
        ((), "  lamp: {light: {type: point, intensity: 1}}\n"),
    ],
)
def test_what_is_not_known_to_be_bounded_has_no_bound(bound, changes, more):
    assert bound() is not None
    assert bound(*changes, text=BOX + more) is None


def test_the_mean_of_a_sample_is_below_the_bound(bound):
    """A closed box with radiance Le and albedo rho has the mean Le / (1 - rho) everywhere."""
    for albedo in (0.2, 0.5, 0.9):
        found = bound(f"nodes.box.bsdf.reflectance={albedo}", "integrator.max_depth=null")
        assert math.isfinite(found)
        assert found > 3.0 / (1.0 - max(albedo, 0.3)) * 0.999
