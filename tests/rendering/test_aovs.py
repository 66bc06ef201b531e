"""Layers for denoisers: albedo and normal through mirrors and glass, against closed forms."""

import numpy as np

import alight
from alight.compiled.scene import compile_scene
from alight.films import FIRST_SAMPLE_LAYERS, fixed_point
from alight.formats import loads
from alight.guiding.tables import LEAF, LEAF_ROW, NODE, Guide
from alight.integrators.aov import LAYERS, MOST_BOUNCES
from alight.integrators.walk import make_settings
from alight.rendering.tiles.tile import make_kernels, render_tile
from alight.rendering.tiles.tile_kernel import Tile
from alight.rendering.training.guide_training import with_guide
from alight.scene import flatten
from lanewise.view import View

HEAD = """
alight: 1
film: {size: [8, 8]}
sampler: independent
integrator: ambient_occlusion
camera: {type: orthographic, height: 1, transform: {translate: [0, 0, 5]}}
bsdfs:
  red: {type: diffuse, reflectance: [0.8, 0.2, 0.1]}
  blue: {type: diffuse, reflectance: [0.1, 0.2, 0.9]}
"""

#: A mirror turned by 45 degrees sends the camera's rays along +x, onto a red wall.
MIRROR = (
    HEAD
    + """
nodes:
  mirror:
    shape: rectangle
    bsdf: {type: mirror, reflectance: [0.9, 0.6, 0.5]}
    transform: [{scale: 3}, {rotate: {axis: y, angle: 45}}]
  wall:
    shape: plane
    bsdf: red
    transform: [{rotate: {axis: y, angle: -90}}, {translate: [4, 0, 0]}]
"""
)

#: Water over a red ground, seen from straight above; a blue ceiling is what it mirrors.
ETA = 1.333
WATER = (
    HEAD
    + f"""
nodes:
  water: {{shape: plane, bsdf: {{type: dielectric, int_ior: {ETA}, ext_ior: 1}}}}
  ground: {{shape: plane, bsdf: red, transform: {{translate: [0, 0, -1]}}}}
  ceiling:
    shape: plane
    bsdf: blue
    transform: [{{rotate: {{axis: x, angle: 180}}}}, {{translate: [0, 0, 9]}}]
"""
)

#: Squares of two triangles, side by side, and what they are made of in another order.
SQUARES = (
    HEAD
    + "nodes:\n"
    + "".join(
        f"""
  square {i}:
    bsdf: {color}
    shape:
      type: mesh
      vertices: [[{x}, -1, 0], [{x + 0.25}, -1, 0], [{x + 0.25}, 1, 0], [{x}, 1, 0]]
      faces: [[0, 1, 2], [0, 2, 3]]
"""
        for i, (x, color) in enumerate(
            [(-0.5, "red"), (-0.25, "blue"), (0.0, "blue"), (0.25, "red")]
        )
    )
)

#: A closed corridor: two mirrors face each other for ever.
CORRIDOR = (
    HEAD
    + """
nodes:
  far: {shape: plane, bsdf: {type: mirror, reflectance: 0.5}}
  near:
    shape: plane
    bsdf: {type: mirror, reflectance: 0.5}
    transform: [{rotate: {axis: x, angle: 180}}, {translate: [0, 0, 9]}]
"""
)

BLEND = (
    HEAD
    + """
nodes:
  ground:
    shape: plane
    bsdf: {type: blend, weight: 0.25, bsdfs: [{type: diffuse, reflectance: 0.4}, {type: mirror}]}
  ceiling:
    shape: plane
    bsdf: blue
    transform: [{rotate: {axis: x, angle: 180}}, {translate: [0, 0, 9]}]
"""
)

#: A pane over water, between walls that shine in their colours and hardly reflect.
PANE = (
    HEAD.replace(
        "ambient_occlusion",
        "{type: path, light_sampling: bsdf, max_depth: 9, russian_roulette: none}",
    )
    + """
  dark red: {type: diffuse, reflectance: [8.e-6, 2.e-6, 1.e-6]}
  dark blue: {type: diffuse, reflectance: [1.e-6, 2.e-6, 9.e-6]}
nodes:
  pane: {shape: plane, bsdf: {type: dielectric, int_ior: 2, ext_ior: 1}}
  water:
    shape: plane
    bsdf: {type: dielectric, int_ior: 2, ext_ior: 1}
    transform: {translate: [0, 0, -1]}
  ground:
    shape: rectangle
    bsdf: dark red
    light: {type: area, radiance: [0.8, 0.2, 0.1]}
    transform: [{scale: 50}, {translate: [0, 0, -3]}]
  ceiling:
    shape: rectangle
    bsdf: dark blue
    light: {type: area, radiance: [0.1, 0.2, 0.9]}
    transform: [{scale: 50}, {rotate: {axis: x, angle: 180}}, {translate: [0, 0, 9]}]
"""
)


def layers(text, *names, spp=4, compiled=False, guide=None):
    """Means (8, 8, channels) of layers by the NumPy twin; "" is the picture."""
    aovs = tuple(filter(None, names))
    scene = compile_scene(flatten(loads(text, "scene.yaml")), structure="list", aovs=aovs)
    scene = scene if guide is None else with_guide(scene, guide)
    settings = make_settings(scene.integrator, seed=1, replicates=4, guide=guide)
    kernels = make_kernels(scene, compiled=compiled)
    ranges = np.array([[[0, spp]]], np.int64)
    film, _ = render_tile(kernels, scene, settings, Tile(0, 0, 8, 8), ranges)
    found = []
    for name in names:
        sums = film.aovs[name].copy() if name else film.sums.sum(axis=2)
        fixed_point.carry(sums)
        found.append(fixed_point.to_float(sums) / spp)
    return found


def test_a_mirror_shows_what_it_mirrors_times_its_colour():
    names = ("albedo", "normal", "albedo_through", "normal_through")
    albedo, normal, seen, seen_normal = layers(MIRROR, *names)
    np.testing.assert_allclose(albedo, np.broadcast_to([0.9, 0.6, 0.5], albedo.shape), rtol=1e-6)
    half = np.sqrt(0.5)
    np.testing.assert_allclose(normal, np.broadcast_to([half, 0, half], normal.shape), atol=1e-6)
    expected = np.array([0.9, 0.6, 0.5]) * [0.8, 0.2, 0.1]
    np.testing.assert_allclose(seen, np.broadcast_to(expected, seen.shape), rtol=1e-6)
    # Of the wall in the world, not mirrored back, and not dimmed by the mirror.
    np.testing.assert_allclose(seen_normal, np.broadcast_to([-1, 0, 0], normal.shape), atol=1e-6)


def test_glass_shows_fresnels_blend_of_what_it_reflects_and_refracts():
    spp = 256
    albedo, normal = layers(WATER, "albedo_through", "normal_through", spp=spp)
    fresnel = ((ETA - 1) / (ETA + 1)) ** 2
    red, blue = np.array([0.8, 0.2, 0.1]), np.array([0.1, 0.2, 0.9])
    # Radiance that has come out of the water is 1 / eta^2 of that below.
    expected = fresnel * blue + (1 - fresnel) * red / ETA**2
    deviation = np.sqrt(fresnel * (1 - fresnel) / (64 * spp))
    z = (albedo.mean(axis=(0, 1)) - expected) / (deviation * np.abs(blue - red / ETA**2))
    assert np.abs(z).max() < 4.0
    share = 0.5 * (1.0 - normal.mean(axis=(0, 1))[2])
    assert abs(share - fresnel) < 4.0 * deviation


def test_the_layers_take_the_way_of_the_picture_sample_by_sample():
    """A denoiser is told of what is seen: by the same random numbers at each glass."""
    picture, albedo = layers(PANE, "", "albedo_through", spp=1)
    ways = np.unique(picture.round(3).reshape(-1, 3), axis=0)
    assert len(ways) == 2
    np.testing.assert_allclose(picture, 1e5 * albedo, rtol=1e-3)


def test_mirrors_without_end_stop_after_the_stated_number_of_bounces():
    (albedo,) = layers(CORRIDOR, "albedo_through")
    np.testing.assert_allclose(albedo, 0.5 ** (MOST_BOUNCES + 1), rtol=1e-6)


def test_of_a_blend_with_a_mirror_each_part_counts_once():
    spp = 256
    (albedo,) = layers(BLEND, "albedo_through", spp=spp)
    expected = 0.75 * 0.4 + 0.25 * np.array([0.1, 0.2, 0.9])
    error = np.sqrt(0.25 * 0.75 / (64 * spp)) * np.abs([0.1 - 0.4, 0.2 - 0.4, 0.9 - 0.4])
    assert np.all(np.abs(albedo.mean(axis=(0, 1)) - expected) < 4.0 * error + 1e-6)


def test_without_delta_lobes_both_kinds_of_layers_are_the_same():
    text = HEAD + "nodes: {ground: {shape: plane, bsdf: red}}\n"
    names = ("albedo", "normal", "albedo_through", "normal_through")
    first, normal, through, seen = layers(text, *names)
    np.testing.assert_array_equal(first, through)
    np.testing.assert_array_equal(normal, seen)


HOLES = """
alight: 1
camera: {fov: 40, transform: {look_at: {origin: [0, 0, 2], target: [0, 0, 0]}}}
film: {size: [8, 8], filter: tent}
sampler: sobol
integrator: {type: path, max_depth: 8, hide_emitters: %s}
environment: {type: constant, radiance: 1}
nodes:
  leaf:
    shape: {type: rectangle}
    transform: [{scale: 0.4}, {translate: [-0.3, 0, 0.3]}]
    bsdf: {type: mask, opacity: 0.4, bsdf: {type: diffuse, reflectance: 0}}
  wall: {shape: {type: sphere, radius: 0.5}, bsdf: {type: diffuse, reflectance: 0}}
"""
LAMP = """  lamp:
    shape: {type: rectangle}
    transform: [{scale: 0.3}, {translate: [0.3, 0.2, 0.9]}]
    bsdf: {type: diffuse, reflectance: 0}
    light: {type: area, radiance: 1}
"""


def test_alpha_and_the_light_beside_black_surfaces_are_all_of_a_pixel():
    """Sample by sample: each meets black, or sees the sky through holes and past edges."""
    picture, alpha = layers(HOLES % "false", "", "alpha", spp=16)
    assert np.allclose(picture + alpha, 1.0, atol=1e-6)
    assert 0.2 < alpha.mean() < 0.8


def test_a_transparent_background_shows_no_light_and_hides_it_from_alpha():
    picture, alpha = layers(HOLES % "true" + LAMP, "", "alpha", spp=16)
    # Through the holes of the leaf, too.
    assert (picture == 0.0).all()
    (without,) = layers(HOLES % "true", "alpha", spp=16)
    assert np.array_equal(alpha, without)
    (shown,) = layers(HOLES % "false" + LAMP, "alpha", spp=16)
    assert (shown >= alpha).all() and (shown > alpha).any()


def guide_of_two_leaves(left, right):
    """Where x < 0 and elsewhere, with these shares; it knows no directions."""
    leaves = np.zeros((2, LEAF_ROW), np.float32)
    leaves[:, 0] = left, right
    tables = (
        np.array([-1, -1, -1, 0.5, 0.5, 0.5], np.float32),
        np.array([1, LEAF, LEAF + 1], np.uint32),
        np.zeros(2, np.uint32),
        leaves,
        np.zeros((1, NODE), np.uint32),
        np.ones((1, 1), np.float32),
        np.array([1, 0, 0], np.uint32),
    )
    return Guide(*map(View, tables))


def test_the_guides_share_is_that_of_the_leaf_where_light_is_scattered():
    """Behind mirrors, where there is one; of a pixel filter that does not reach over the middle."""
    guide = guide_of_two_leaves(0.25, 0.75)
    head = HEAD.replace("size: [8, 8]", "size: [8, 8], filter: box")
    head = head.replace("ambient_occlusion", "{type: path, max_depth: 3}")
    ground = head + "nodes: {ground: {shape: plane, bsdf: red}}\n"
    (share,) = layers(ground, "guide_share", guide=guide)
    np.testing.assert_allclose(share[:, :4], 0.25, rtol=1e-6)
    np.testing.assert_allclose(share[:, 4:], 0.75, rtol=1e-6)
    # All of the wall is on the right; a mirror alone asks nobody.
    for text, expected in ((MIRROR, 0.75), (CORRIDOR, 0.0)):
        (share,) = layers(text.replace(HEAD, head), "guide_share", guide=guide)
        np.testing.assert_allclose(share, expected, rtol=1e-6)
    # Of a blend with a mirror, a quarter is what the mirror shows: the ceiling has the same leaves.
    (share,) = layers(BLEND.replace(HEAD, head), "guide_share", guide=guide)
    np.testing.assert_allclose(share[:, 4:], 0.75, rtol=1e-6)
    (share,) = layers(ground, "guide_share")
    assert (share == 0.0).all()


def test_compiled_layers_are_the_twins():
    film = alight.render(loads(WATER, "scene.yaml"), spp=4, seed=1, aovs=tuple(LAYERS))
    for name, expected in zip(LAYERS, layers(WATER, *LAYERS), strict=True):
        found = film.aov(name)
        assert found.shape == (8, 8, len(LAYERS[name]))
        if name not in FIRST_SAMPLE_LAYERS:
            np.testing.assert_allclose(found, expected, atol=1e-5)


def test_ids_name_the_shape_the_triangle_and_what_it_is_made_of():
    ids, position, albedo = layers(SQUARES, "id", "position", "albedo", spp=1)
    shape, triangle, material = np.moveaxis(ids, -1, 0)
    x, y = position[..., 0] + 0.5, position[..., 1]
    assert (shape == 1 + np.floor(4.0 * x)).all()
    # Above the diagonal of its square is the second one.
    upper = (y + 1.0) / 2.0 > 4.0 * x - np.floor(4.0 * x)
    assert (triangle == np.where(upper, 2, 1)).all()
    assert {1, 2} == set(triangle.ravel())
    # One number for each colour.
    assert len(np.unique(material)) == 2
    assert len(np.unique(np.column_stack([material.ravel(), albedo.reshape(-1, 3)]), axis=0)) == 2
