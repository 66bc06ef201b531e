"""The main loop and the path integrator, looked at from inside: in the NumPy twin."""

from __future__ import annotations

import sys
from collections import defaultdict

import numpy as np
import pytest

import alight
from alight.compiled.scene import compile_scene
from alight.films import fixed_point
from alight.films.sample_ranges import CELL_SIZE
from alight.filters.mitchell import Mitchell, polynomial
from alight.formats import loads
from alight.integrators.walk import (
    CAMERA_DIMENSIONS,
    VERTEX_DIMENSIONS,
    is_staged,
    make_settings,
)
from alight.rendering.tiles.tile import TWINS_LANES, make_kernels, render_tile
from alight.rendering.tiles.tile_kernel import Cursor, Tile, count_cells, next_pixel, next_sample
from alight.samplers import independent
from alight.scene import flatten


def compiled(text, aovs=()):
    """A scene given as text, or the name of a built-in one with 8x8 pixels."""
    if "\n" in text:
        scene = loads("alight: 1\n" + text, "scene.yaml")
    else:
        scene = alight.load(text, ["film.size=[8, 8]", "sampler.type=independent"])
    return compile_scene(flatten(scene), structure="list", aovs=aovs)


#: The first 8x8 pixels.
FIRST = Tile(0, 0, 8, 8)


def twin(scene, spp, tile=FIRST, lanes=None, **settings):
    """The film of a tile, in NumPy."""
    values = make_settings(scene.integrator, seed=0, replicates=4)._replace(**settings)
    ranges = np.array([[[0, spp]]], np.int64)
    kernels = make_kernels(scene, compiled=False, lanes=lanes)
    film, _ = render_tile(kernels, scene, values, tile, ranges)
    fixed_point.carry(film.sums)
    return film


# ---------------------------------------------------------------- which samples


@pytest.mark.parametrize("replicates", [1, 3, 4])
@pytest.mark.parametrize("tile", [Tile(5, 3, 21, 17), Tile(0, 0, 9, 10)], ids=["within", "corner"])
def test_every_sample_of_a_tile_is_visited_once_with_its_index_and_replicate(replicates, tile):
    """Sample i of a pixel is number i // R of replicate i mod R, whatever the tile and the part."""
    values = make_settings(alight.load("cornell-box").integrator, seed=0, replicates=replicates)
    columns, cells = count_cells(tile)
    rng = np.random.default_rng(1)
    ranges = np.stack([rng.integers(0, 50, cells), rng.integers(0, 9, cells)], axis=1)
    expected = {}
    for cell, (first, count) in enumerate(ranges.tolist()):
        left = (tile.x0 // CELL_SIZE + cell % columns) * CELL_SIZE
        top = (tile.y0 // CELL_SIZE + cell // columns) * CELL_SIZE
        for y in range(max(top, tile.y0), min(top + CELL_SIZE, tile.y1)):
            for x in range(max(left, tile.x0), min(left + CELL_SIZE, tile.x1)):
                for i in range(first, first + count):
                    sample = (x, y, i // replicates, i % replicates)
                    expected[sample] = first + count - i, cell
    visited = {}
    cursor = next_pixel(values, tile, ranges.ravel(), Cursor(-1, 0, 0, 0, 0, 0))
    while cursor.cell < cells:
        sample = (cursor.x, cursor.y, cursor.index, cursor.scramble)
        assert sample not in visited
        visited[sample] = cursor.left, cursor.cell
        if cursor.left > 1:
            cursor = next_sample(values, cursor)
        else:
            cursor = next_pixel(values, tile, ranges.ravel(), cursor)
    assert visited == expected


# ---------------------------------------------------------------- random numbers


def test_no_random_number_is_used_for_two_purposes(monkeypatch):
    """Each dimension of each sample is read from one place, and behind the camera only once."""
    places, reads = defaultdict(set), defaultdict(int)

    def recorded(hash_, width):
        def record(a, b, dimension):
            frame = sys._getframe(1)
            while "samplers" in frame.f_code.co_filename:
                frame = frame.f_back
            a_, b_, first = np.broadcast_arrays(a, b, dimension)
            for sample in zip(a_.tolist(), b_.tolist(), first.tolist(), strict=True):
                for k in range(width):
                    key = (*sample[:2], sample[2] + k)
                    places[key].add((frame.f_code.co_filename, frame.f_lineno))
                    reads[key] += 1
            return hash_(a, b, dimension)

        return record

    monkeypatch.setattr(independent, "hash_1", recorded(independent.hash_1, 1))
    monkeypatch.setattr(independent, "hash_2", recorded(independent.hash_2, 2))
    # A whole packet: lanes without a sample have numbers of their own.
    spp = TWINS_LANES // (8 * 8)
    twin(compiled("cornell-box"), spp, max_depth=8, rr_depth=3)
    assert len({key[:2] for key in places}) == 8 * 8 * spp
    shared = {key[2]: found for key, found in places.items() if len(found) > 1}
    assert not shared, shared
    # The camera's are computed for a whole packet whenever one of its lanes starts a path.
    again = {key[2] for key, n in reads.items() if n > 1 and key[2] >= CAMERA_DIMENSIONS}
    assert not again, again
    # Low dimensions are the best: no vertex leaves its place to none.
    used = [key[2] for key in places if key[2] >= CAMERA_DIMENSIONS]
    vertices = {(dimension - CAMERA_DIMENSIONS) // VERTEX_DIMENSIONS for dimension in used}
    assert vertices == set(range(len(vertices)))
    assert max(vertices) > 2


# ---------------------------------------------------------------- layers, invalid samples, filters


CAMERA = "camera: {type: orthographic, height: 8, transform: {translate: [0, 0, 5]}}\n"

#: A glowing ball of dust with a ball in it, before a fence with holes, under a sky and a lamp.
GLOW = (
    CAMERA
    + """film: {size: [8, 8]}
sampler: independent
environment: {type: constant, radiance: 0.5}
integrator: {type: volpath}
media: {fire: {type: homogeneous, sigma_t: 0.5, albedo: 0.6, emission: [1, 2, 3]}}
bsdfs: {holes: {type: "null"}}
nodes:
  dust: {shape: {type: sphere, radius: 3}, bsdf: holes, interior: fire}
  ball: {shape: sphere}
  fence:
    shape: rectangle
    bsdf: {type: mask, opacity: 0.5, bsdf: {type: diffuse}}
    transform: [{scale: 4}, {translate: [0, 0, -3.5]}]
  lamp: {light: {type: point, intensity: 9}, transform: {translate: [0, 3.5, 5]}}
"""
)
#: The same without dust, for the integrator that counts holes as edges.
CLEAR = GLOW.replace(", interior: fire", "").replace("volpath", "path")


@pytest.mark.parametrize(
    "scene",
    ["cornell-box", "mirror-and-glass", GLOW, CLEAR],
    ids=["cornell-box", "mirror-and-glass", "glow", "clear"],
)
def test_the_direct_layer_is_the_picture_of_two_edges(scene):
    whole = twin(compiled(scene, aovs=("direct", "indirect")), 2)
    short = twin(compiled(scene), 2, max_depth=2)
    direct = whole.aovs["direct"].copy()
    fixed_point.carry(direct)
    expected = short.sums.sum(axis=2)
    fixed_point.carry(expected)
    np.testing.assert_array_equal(direct, expected)
    assert whole.aovs["indirect"].any()


#: A ball with random walks in it.
WAXEN = (
    CAMERA
    + """film: {size: [8, 8]}
environment: {type: constant}
nodes: {ball: {shape: sphere, bsdf: {type: subsurface, color: 0.6, radius: 0.5}}}
"""
)


@pytest.mark.parametrize(
    ("scene", "integrator"),
    [(GLOW, "volpath"), (CLEAR, "bidirectional"), (CLEAR, "light"), (WAXEN, "path")],
    ids=["glow", "both ends", "light", "walks"],
)
def test_wide_packets_give_the_bits_of_narrow_ones(scene, integrator):
    scene = scene.replace("{type: volpath}", f"{{type: {integrator}}}")
    scene = compiled(scene.replace("{type: path}", f"{{type: {integrator}}}"))
    narrow, wide = (twin(scene, 5, lanes=lanes) for lanes in (16, TWINS_LANES))
    assert scene.integrator.type_name() == integrator
    assert narrow.sums.any()
    np.testing.assert_array_equal(wide.sums, narrow.sums)
    np.testing.assert_array_equal(wide.counts, narrow.counts)


@pytest.mark.parametrize("spp", [1, 2, 33])
@pytest.mark.parametrize(("integrator", "queues"), [("path", 2), ("random_walk", 1)])
def test_no_sample_is_left_waiting(integrator, queues, spp):
    """The last one neither, where paths wait for others in one queue or in two."""
    text = f"integrator: {integrator}\nfilm: {{size: [8, 8]}}\nnodes:\n  floor: {{shape: plane}}\n"
    scene = compiled(CAMERA + text)
    assert is_staged(scene.program) == (queues == 2)
    film = twin(scene, spp, Tile(0, 0, 1, 1))
    assert film.counts.sum() == spp


@pytest.mark.parametrize("spp", [1, 33])
def test_no_sample_is_left_in_a_body(spp):
    """Light is not absorbed in it: all of it comes back, with nothing but the sky to meet."""
    ball = "shape: sphere, bsdf: {type: subsurface, color: 1, radius: 1, ior: 1}"
    text = f"film: {{size: [8, 8]}}\nnodes:\n  ball: {{{ball}}}\n"
    film = twin(compiled(CAMERA + text + "environment: {type: constant}"), spp, Tile(3, 3, 4, 4))
    assert film.counts.sum() == spp
    assert (film.sums != 0).any()


@pytest.mark.parametrize(
    "light",
    [
        "environment: {type: constant}\nintegrator: {type: path, light_sampling: bsdf}",
        "  lamp: {light: {type: point}, transform: {translate: [0, 0, 5]}}",
    ],
    ids=["found", "sampled"],
)
def test_samples_that_are_not_finite_are_counted_and_add_nothing(light):
    text = "film: {size: [8, 8]}\nnodes:\n  floor: {shape: plane}\n"
    scene = compiled(CAMERA + text + light)
    good = twin(scene, 4)
    assert good.invalid == 0 and (good.sums.sum(axis=2) > 0).any(axis=(2, 3)).all()
    # Numbers that no scene file may hold; they must reach the film through the whole path.
    scene.tables.materials.data.array[:3] = np.nan
    film = twin(scene, 4)
    assert film.invalid == 4 * 64
    assert (film.counts.sum(axis=2) == 4).all()
    assert not film.sums.any()


def test_an_edge_rings_as_the_mitchell_filter_says():
    """Half a bright wall: each column is the integral of the filter on its bright side."""
    scene = compiled(
        CAMERA
        + """
film: {size: [8, 8], filter: {type: mitchell, b: 0, c: 1}}
integrator: {type: path, max_depth: 1}
nodes:
  wall:
    shape: rectangle
    bsdf: {type: diffuse, reflectance: 0}
    light: {type: area, radiance: 1}
    transform: [{scale: [10, 10, 1]}, {translate: [10, 0, 0]}]
"""
    )
    film = twin(scene, 128)
    columns = fixed_point.to_float(film.sums).sum(axis=2).mean(axis=(0, 2)) / 128
    spec = Mitchell(b=0.0, c=1.0)
    x = np.linspace(-spec.radius, spec.radius, 4001)
    f = polynomial(np.abs(x) * 2.0 / spec.radius, spec.b, spec.c)
    expected = [f[x > -offset].sum() / f.sum() for offset in np.arange(8) - 3.5]
    assert min(expected) < -0.02 and max(expected) > 1.02
    # Weights of both signs are noisy; without them the second column would be 0.05, not -0.03.
    np.testing.assert_allclose(columns, expected, atol=0.03)
