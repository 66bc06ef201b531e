"""Light paths of textured lamps start by their light, whichever shape it is spread over."""

from dataclasses import replace

import numpy as np
import pytest

from alight.compiled.scene import compile_scene
from alight.core.vec import Vec3, luminance
from alight.formats import loads
from alight.laws.emission import RECEIVERS, rays_of, same_by_both
from alight.lights.tables import CHOICE
from alight.scene.flatten import flatten
from tests.lights.test_area_maps import SHAPES, TEXEL, TURNED
from tests.motion.test_kernels import seen

NEAREST = "interpolation: nearest"
FLAT = {"flat": "sphere, transform: {scale: [1, 1, 0.2]}"}


def lamps(*radiances, shape="rectangle"):
    """A scene of one lamp for each radiance, two metres apart."""
    text = "alight: 1\ncamera: {transform: {translate: [0, 0, 40]}}\nnodes:\n"
    for k, radiance in enumerate(radiances):
        light = f"light: {{type: area, radiance: {radiance}}}"
        text += f"  n{k}: {{children: {{a: {{shape: {(SHAPES | FLAT)[shape]}, {light}}}}}, "
        text += f"transform: {{translate: [{2 * k}, 0, 0]}}}}\n"
    return compile_scene(flatten(loads(text)), structure="list", emits=True)


def picture(pixels=TEXEL, more=NEAREST):
    return f"{{type: bitmap, pixels: {pixels}, {more}}}"


def brightness(rays):
    return luminance(Vec3(*rays.flux)).astype(float)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("more", [NEAREST, TURNED], ids=["nearest", "turned"])
def test_rays_bring_what_light_sampling_finds(shape, more):
    scene = lamps(picture(more=more), shape=shape)
    same_by_both(rays_of(scene), scene, RECEIVERS)


@pytest.mark.parametrize("shape", SHAPES)
def test_rays_have_nearly_the_same_flux(shape):
    # By even points a relative variance of 50: one texel of 64 has nine tenths of the light.
    flux = brightness(rays_of(lamps(picture(), shape=shape)))
    assert flux.std() < 0.6 * flux.mean()


def test_cells_of_a_map_have_the_light_of_their_area():
    # Squares of a flat ellipsoid differ in area by up to five times.
    striped = picture([[1.0, 30.0] * 8] * 16)
    flux = brightness(rays_of(lamps(striped, shape="flat")))
    assert flux.std() < 0.1 * flux.mean()


def test_lamps_are_chosen_by_the_part_of_the_picture_that_they_show():
    half = "to_uv: {scale: [0.5, 1]}, interpolation: nearest"
    scene = lamps(picture([[3.0, 100.0]], half), picture([[1.0, 0.0]], half))
    chances = np.diff(scene.tables.lights.emission.array[CHOICE : CHOICE + 3])
    assert chances[0] / chances[1] == pytest.approx(3.0, rel=1e-4)


def test_moving_lamps_emit_where_their_texels_are():
    text = f"""
alight: 1
camera: {{transform: {{translate: [0, 0, 40]}}}}
nodes:
  train:
    transform:
      keyframes:
        - {{time: 0, rotate: {{axis: y, angle: 20}}, translate: [-2, 1, 1]}}
        - {{time: 1, rotate: {{axis: z, angle: 160}}, translate: [2, 0, 1]}}
    children: {{panel: {{shape: rectangle, light: {{type: area, radiance: {picture()}}}}}}}
"""
    scene = compile_scene(flatten(loads(text)), structure="list", emits=True)
    scene = replace(scene, tables=seen(scene, np.full(1, 0.4)))
    same_by_both(rays_of(scene), scene, RECEIVERS)
