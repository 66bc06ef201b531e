"""Cryptomattes: exact coverage of objects and materials, as files of the specification hold it."""

import itertools
import json
import struct

import numpy as np
import OpenEXR
import pytest

import alight
from alight.compiled.scene import compile_scene
from alight.core.errors import FilmError
from alight.films import Film, fixed_point
from alight.films.mattes import MATTES
from alight.formats import loads
from alight.integrators.walk import make_settings
from alight.laws.statistics import LARGEST_Z
from alight.outputs import cryptomatte
from alight.rendering.executors import block_tasks
from alight.rendering.executors.blocks import Block
from alight.rendering.layers import AOVS
from alight.rendering.tiles.tile import make_kernels, render_tile
from alight.rendering.tiles.tile_kernel import Tile
from alight.scene import flatten

SIZE, SPP = 12, 8
WHOLE = Tile(0, 0, SIZE, SIZE)

HEAD = f"""
alight: 1
film: {{size: [{SIZE}, {SIZE}]}}
sampler: independent
integrator: ambient_occlusion
camera: {{type: orthographic, height: 1, transform: {{translate: [0, 0, 5]}}}}
bsdfs:
  wood: {{type: diffuse, reflectance: 0}}
  red: {{type: diffuse, reflectance: 0}}
"""

#: A slanted board, a cube on an arm, an instance, a ball of its own material; a gap on the right.
THINGS = (
    HEAD
    + """
prototypes:
  leg: {shape: rectangle, transform: {scale: [0.03, 0.3, 1]}}
nodes:
  table:
    bsdf: wood
    children:
      top: {shape: rectangle, transform: [{scale: 0.3}, {rotate: {axis: z, angle: 20}}]}
      left: {instance: leg, transform: {translate: [-0.2, 0.1, 1]}}
      right: {instance: leg, transform: {translate: [0.2, 0.1, 1]}}
  blume ü: {shape: {type: sphere, radius: 0.17}, bsdf: red, transform: {translate: [0.1, 0, 1]}}
  block:
    shape: cube
    bsdf: {type: diffuse, reflectance: 0}
    transform: [{scale: 0.1}, {rotate: {axis: y, angle: 30}}, {translate: [-0.4, -0.3, 0]}]
  tableau: {shape: rectangle, transform: [{scale: 0.1}, {translate: [0.2, -0.4, 0]}]}
"""
)

#: A veil of which samples pass a part, before a board that moves; a lamp that is not seen.
VEILED = (
    HEAD.replace("integrator: ambient_occlusion", "integrator: {type: path, hide_emitters: true}")
    .replace("height: 1,", "height: 1, shutter: [0, 1],")
    .replace("film: {", "film: {filter: mitchell, ")
    + """
nodes:
  veil:
    shape: rectangle
    bsdf: {type: mask, opacity: 0.4, bsdf: red}
    transform: [{scale: [0.4, 0.15, 1]}, {translate: [0, 0, 1]}]
  board:
    shape: rectangle
    bsdf: wood
    transform:
      keyframes:
        - {time: 0, scale: 0.3, translate: [-0.2, 0, 0]}
        - {time: 1, scale: 0.3, translate: [0.2, 0, 0]}
  lamp:
    shape: rectangle
    light: {type: area, radiance: 1}
    transform: [{scale: 0.1}, {translate: [0.1, 0.2, 2]}]
"""
)


def filmed(text, aovs, ranges=((0, SPP),), tile=WHOLE):
    """Films by the NumPy twin, one for each range of samples."""
    scene = compile_scene(flatten(loads(text, "scene.yaml")), structure="list", aovs=aovs)
    settings = make_settings(scene.integrator, seed=1, replicates=4)
    kernels, films = make_kernels(scene, compiled=False), []
    for pair in ranges:
        film = Film(
            SIZE, SIZE, aovs={name: AOVS[name] for name in aovs}, surfaces=scene.surfaces.names
        )
        shape = (-(-tile.y1 // 8) - tile.y0 // 8, -(-tile.x1 // 8) - tile.x0 // 8, 2)
        held = np.broadcast_to(np.array(pair, np.int64), shape).copy()
        film.add_tile(render_tile(kernels, scene, settings, tile, held)[0])
        films.append(film)
    return films


@pytest.fixture(scope="module")
def things():
    return filmed(THINGS, (*MATTES, "alpha"))[0]


def same_sums(a, b):
    return all(np.array_equal(x, y) for x, y in zip(a.coverage.sums, b.coverage.sums, strict=True))


def total_of(film):
    """Sums of all surfaces in each pixel, canonical."""
    total, rows = np.zeros((SIZE * SIZE, 2), np.int64), film.coverage.sums
    np.add.at(total, rows.pixels, rows.sums)
    fixed_point.carry(total)
    return total.reshape(SIZE, SIZE, 2)


def decoded(path):
    """Mattes of a file by the procedure of the specification, written for this test alone."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        header = dict(file.header())
        planes = {name: channel.pixels for name, channel in file.channels().items()}
    found = {}
    for key, layer in header.items():
        if not (key.startswith("cryptomatte/") and key.endswith("/name")):
            continue
        stem = key.removesuffix("/name")
        assert len(stem) == len("cryptomatte/") + 7
        assert header[f"{stem}/hash"] == "MurmurHash3_32"
        assert header[f"{stem}/conversion"] == "uint32_to_float32"
        own = sorted(name for name in planes if name.startswith(layer))
        layers = sorted({name.rpartition(".")[0] for name in own})
        pairs = [(f"{name}.{i}", f"{name}.{c}") for name in layers for i, c in ("rg", "ba")]
        for name, digits in json.loads(header[f"{stem}/manifest"]).items():
            number = struct.unpack("<f", struct.pack("<I", int(digits, 16)))[0]
            matte = sum(np.where(planes[i] == number, planes[c], 0.0) for i, c in pairs)
            found[layer, name] = matte
        found[layer, None] = [(planes[i], planes[c]) for i, c in pairs]
    return found


def test_hashes_are_those_of_the_published_algorithm():
    known = {
        "": 0, "a": 0x3C2569B2, "hello": 0x248BFA47, "hello, world": 0x149BBB7F,
        "The quick brown fox jumps over the lazy dog": 0x2E4FF723,
    }  # fmt: skip
    for name, value in known.items():
        assert cryptomatte.murmur_hash(name.encode()) == value
    # As text, not as escapes.
    assert "ü" in cryptomatte.header_of("CryptoObject", ["ü"])["cryptomatte/3ae39a5/manifest"]
    # The one key that every writer has: that of its layer.
    assert "cryptomatte/3ae39a5/name" in cryptomatte.header_of("CryptoObject", [])


def test_every_id_is_an_ordinary_number():
    names = [f"thing {number}" for number in range(3000)]
    mended = [n for n in names if cryptomatte.id_of(n) != cryptomatte.murmur_hash(n.encode())]
    assert len(mended) > 5
    for name in names:
        bits = cryptomatte.id_of(name)
        assert 0 < (bits >> 23) & 255 < 255
        assert bits ^ cryptomatte.murmur_hash(name.encode()) in (0, 1 << 23)


def test_mattes_of_a_file_are_those_of_the_film(things, tmp_path):
    found = decoded(things.save(tmp_path / "things.exr"))
    objects = ("table/top", "table/left/leg", "table/right/leg", "blume ü", "block", "tableau")
    materials = ("wood", "red", "block", "default")
    named = {layer: {n for one, n in found if one == layer and n} for layer in MATTES.values()}
    assert named == {"CryptoObject": set(objects), "CryptoMaterial": set(materials)}
    for layer, called in MATTES.items():
        whole = 0.0
        for name in named[called]:
            np.testing.assert_array_equal(found[called, name], things.mask(name, layer))
            assert found[called, name].max() > 0.2
            whole = whole + found[called, name]
        # With the background, all of every pixel.
        np.testing.assert_allclose(whole, things.aov("alpha")[..., 0], atol=1e-6)
        ranks = [coverage for _, coverage in found[called, None]]
        assert len(ranks) == cryptomatte.RANKS
        assert all((a >= b).all() for a, b in itertools.pairwise(ranks))
        assert all(((ids == 0) == (c == 0)).all() for ids, c in found[called, None])


def test_a_matte_is_the_picture_of_that_object_alone_in_white(things):
    white = THINGS.replace("bsdf: red", "bsdf: {type: diffuse, reflectance: 1}")
    white = white.replace("tableau: {", "tableau: {bsdf: wood, ")
    albedo = filmed(white, ("albedo", *MATTES))[0].aov("albedo")[..., 0]
    np.testing.assert_array_equal(things.mask("blume ü"), albedo)
    assert albedo.max() == 1.0


def test_a_name_stands_for_all_below_it(things):
    parts = [things.mask(f"table/{name}") for name in ("top", "left", "right/leg")]
    np.testing.assert_allclose(things.mask("table"), sum(parts), atol=1e-6)
    np.testing.assert_array_equal(things.mask("table"), things.mask("wood", "cryptomatte_material"))


@pytest.mark.parametrize("text", [THINGS, VEILED], ids=["things", "veiled"])
def test_all_surfaces_together_are_the_layer_of_coverage(text):
    film = filmed(text, (*MATTES, "alpha"))[0]
    np.testing.assert_array_equal(total_of(film), film.aov_sums["alpha"][..., 0, :])


def test_what_is_partly_there_covers_its_part():
    film = filmed(VEILED.replace("mitchell", "box"), tuple(MATTES), [(0, 64)])[0]
    inside = film.mask("veil")[5:7, 3:9]
    z = (inside.mean() - 0.4) / np.sqrt(0.4 * 0.6 / (64 * inside.size))
    assert abs(z) < LARGEST_Z
    behind = (film.mask("veil") + film.mask("board"))[5:7, 5:7]
    np.testing.assert_allclose(behind, 1.0, atol=1e-6)
    # Where only the board is: at which part of the time, averaged over a pixel.
    x = ((np.arange(SIZE * 16) + 0.5) / 16 / SIZE - 0.5)[:, None]
    there = np.abs(x - (np.arange(512) + 0.5) / 512 * 0.4 + 0.2) < 0.3
    part = there.mean(axis=1).reshape(SIZE, 16).mean(axis=1)
    z = (film.mask("board")[3] - part) / np.sqrt(np.maximum(part * (1 - part), 1e-3) / 64)
    assert np.abs(z).max() < LARGEST_Z
    # Lights that are hidden are not there.
    assert (film.mask("lamp") == 0.0).all()


def test_what_passes_a_veil_in_the_picture_passes_it_in_the_matte():
    """Sample by sample: a white board below black veils, behind a lamp that is hidden.

    Light comes from aside, past the veils, and all but never from the lamp.
    """
    text = HEAD.replace(
        "ambient_occlusion", "{type: path, max_depth: 5, hide_emitters: true}"
    ).replace("film: {", "film: {filter: box, ")
    text += """
nodes:
  sun:
    light: {type: directional, irradiance: 1}
    transform: {look_at: {origin: [0, 0, 0], target: [0, -2, 1]}}
  lamp:
    shape: rectangle
    light: {type: area, radiance: 1e-9}
    transform: [{scale: [0.2, 0.4, 1]}, {translate: [-0.2, 0, 1]}]
  veils:
    bsdf: {type: mask, opacity: 0.4, bsdf: red}
    children:
      upper: {shape: rectangle, transform: {scale: 0.4}}
      lower: {shape: rectangle, transform: [{scale: 0.3}, {translate: [0, 0, -0.2]}]}
  board:
    shape: rectangle
    bsdf: {type: diffuse, reflectance: 1}
    transform: [{scale: [0.4, 0.2, 1]}, {translate: [0, 0, -1]}]
"""
    film = filmed(text, (*MATTES, "alpha"))[0]
    board, light = film.mask("board"), film.mean[..., 0]
    assert board[6, 2:5].min() > 0.0
    assert len(np.unique(board)) > 4
    np.testing.assert_allclose(light, board * (5.0**-0.5 / np.pi), rtol=0.01, atol=1e-6)


def test_unknown_names_are_told_with_the_nearest(things):
    with pytest.raises(FilmError, match='unknown object "tabel/top"; did you mean "table/top"'):
        things.mask("tabel/top")
    with pytest.raises(FilmError, match='did you mean "table/left"'):
        things.mask("table/lefd")
    with pytest.raises(FilmError, match='unknown material "wod"; did you mean "wood"'):
        things.mask("wod", "cryptomatte_material")
    with pytest.raises(FilmError, match='did you mean "cryptomatte_material"'):
        things.mask("wood", "cryptomatte_materials")


def test_parts_merge_to_the_bits_of_the_whole(things):
    first, second, third = filmed(THINGS, (*MATTES, "alpha"), [(0, 3), (3, 1), (4, 4)])
    for order in ((first, second, third), (third, first, second)):
        merged = Film.merge(*order)
        assert same_sums(merged, things)
        np.testing.assert_array_equal(merged.aov_sums["alpha"], things.aov_sums["alpha"])
    assert same_sums(things.snapshot(), things)


def test_tiles_add_up_to_the_bits_of_the_whole(things):
    scene_tiles = [Tile(x, y, min(x + 8, SIZE), min(y + 8, SIZE)) for x in (8, 0) for y in (8, 0)]
    made = None
    for tile in scene_tiles:
        film = filmed(THINGS, (*MATTES, "alpha"), tile=tile)[0]
        made = made or film.empty_like()
        made.coverage.add(film.coverage.sums)
    assert same_sums(made, things)


def test_a_film_file_keeps_the_whole_table(things, tmp_path):
    again = Film.load(things.save(tmp_path / "things.alight"))
    assert again.coverage.names == things.coverage.names
    assert same_sums(again, things)
    nothing = Film.load(things.empty_like().save(tmp_path / "nothing.alight"))
    assert len(nothing.coverage.sums.pixels) == 0
    assert (nothing.mask("table") == 0.0).all()


def refusal(*films):
    """Why films do not merge; nothing if they do."""
    try:
        Film.merge(*films)
    except FilmError as error:
        return str(error)
    return ""


def test_films_of_things_with_other_names_do_not_merge(things):
    other = filmed(THINGS.replace("tableau:", "tablet:"), (*MATTES, "alpha"), [(SPP, 1)])[0]
    assert 'names differ (object "tablet", not "tableau")' in refusal(things, other)
    without = Film(SIZE, SIZE, scene_hash=things.scene_hash)
    said = "set of layers differs (none, not alpha, cryptomatte_material, cryptomatte_object)"
    assert said in refusal(things, without)
    fewer, more = (Film(4, 4, surfaces=[("thing", "wood")] * count) for count in (1, 2))
    assert "number of surfaces differs (2, not 1)" in refusal(fewer, more)


def test_more_objects_than_ranks_lose_the_least_in_the_file_alone(things):
    sliced = HEAD + "nodes:\n" + "".join(
        f"  s{i}: {{shape: rectangle, transform: [{{scale: [{0.004 + 0.001 * i}, 1, 1]}}, "
        f"{{translate: [{-0.5 + 1 / SIZE * (0.5 + i) / 10}, 0, 0]}}]}}\n"
        for i in range(10)
    )  # fmt: skip
    film = filmed(sliced, tuple(MATTES), [(0, 60)])[0]
    every = np.array([film.mask(f"s{i}")[0, 0] for i in range(10)])
    assert (every > 0).sum() > cryptomatte.RANKS
    picture = film.picture()
    kept = [picture.layers[f"CryptoObject{k // 2:02d}.{'ga'[k % 2]}"][0, 0] for k in range(6)]
    np.testing.assert_array_equal(kept, np.sort(every)[::-1][:6])


def test_a_worker_answers_with_the_table():
    scene = compile_scene(
        flatten(loads(THINGS, "scene.yaml")), structure="list", aovs=("cryptomatte_object",)
    )
    settings = make_settings(scene.integrator, seed=1, replicates=4)
    shared = block_tasks.SharedScene(scene, settings, make_kernels(scene, compiled=False))
    tile = Tile(0, 0, 8, 8)
    task = block_tasks.BlockTask(1, (Block(tile, np.array([[[0, SPP]]])),))
    layout = block_tasks.Layout(4, 3, {}, len(scene.surfaces.names))
    answer = block_tasks.render_blocks(shared, task)
    partial, _ = block_tasks.read_blocks(layout, task, answer)[0]
    expected, _ = render_tile(shared.kernels, scene, settings, tile, task.blocks[0].ranges)
    for a, b in zip(partial.coverage, expected.coverage, strict=True):
        np.testing.assert_array_equal(a, b)
    with pytest.raises(FilmError, match="weighs what is not there"):
        block_tasks.read_blocks(layout._replace(surfaces=2), task, answer)


def test_a_worker_answers_where_there_is_no_surface():
    text = HEAD + "environment: {type: constant, radiance: 1}\n"
    scene = compile_scene(flatten(loads(text, "scene.yaml")), structure="list", aovs=tuple(MATTES))
    settings = make_settings(scene.integrator, seed=1, replicates=4)
    shared = block_tasks.SharedScene(scene, settings, make_kernels(scene, compiled=False))
    task = block_tasks.BlockTask(1, (Block(Tile(0, 0, 8, 8), np.array([[[0, 1]]])),))
    layout = block_tasks.Layout(4, 3, {}, 0)
    answer = block_tasks.render_blocks(shared, task)
    partial, _ = block_tasks.read_blocks(layout, task, answer)[0]
    film = Film(SIZE, SIZE, aovs=dict.fromkeys(MATTES, ()), surfaces=())
    film.add_tile(partial)
    assert film.counts.sum() == 64
    assert len(film.coverage.sums.pixels) == 0


def test_a_checkpoint_of_things_with_other_names_is_not_resumed(tmp_path):
    path = tmp_path / "things.checkpoint"
    scene = loads(THINGS, "scene.yaml")
    alight.render(scene, spp=1, aovs="cryptomatte", threads=1, checkpoint=path)
    renamed = loads(THINGS.replace("tableau:", "tablet:"), "scene.yaml")
    with pytest.raises(FilmError, match=r'cannot resume .*names differ \(object "tablet"'):
        alight.resume(path, scene=renamed, spp=2)
    film = alight.resume(path, scene=scene, spp=2)
    assert same_sums(film, alight.render(scene, spp=2, aovs="cryptomatte", threads=1))


def test_renders_hold_the_bits_of_the_twin(things):
    film = alight.render(
        loads(THINGS, "scene.yaml"), spp=SPP, seed=1, aovs="cryptomatte", threads=2
    )
    assert same_sums(film, things)


def test_films_without_mattes_say_how_to_get_them():
    film = Film(4, 4)
    with pytest.raises(FilmError, match='render it with aovs="cryptomatte"'):
        film.mask("table")
