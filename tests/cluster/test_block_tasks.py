"""Blocks as tasks: cut without loss, answered exactly, refused when malformed."""

import json

import numpy as np
import pytest

import alight
from alight.compiled.scene import compile_scene
from alight.core.errors import FilmError
from alight.films.archive import pack_archive, unpack_archive
from alight.integrators.walk import make_settings
from alight.rendering.executors import block_tasks
from alight.rendering.executors.block_tasks import (
    BlockTask,
    Layout,
    SharedScene,
    read_blocks,
    render_blocks,
)
from alight.rendering.executors.blocks import Block
from alight.rendering.executors.cluster_executor import BlockQueue
from alight.rendering.tiles.division import tiles_of
from alight.rendering.tiles.tile import make_kernels, render_tile
from alight.rendering.tiles.tile_kernel import Tile
from alight.scene import flatten

LAYOUT = Layout(3, 3, {"depth": ("Z",)})


def blocks_of(window, seed):
    """The tiles of a window, with a range of its own for each cell."""
    rng = np.random.default_rng(seed)
    blocks = []
    for tile in tiles_of(window, 32):
        shape = (-(-tile.y1 // 8) - tile.y0 // 8, -(-tile.x1 // 8) - tile.x0 // 8)
        blocks.append(Block(tile, rng.integers(0, 90, (*shape, 2))))
    return blocks


def held_by(blocks):
    """How often each sample of each cell is in some blocks."""
    found = {}
    for tile, ranges in blocks:
        for (row, column), (first, count) in zip(
            np.ndindex(ranges.shape[:2]), ranges.reshape(-1, 2), strict=True
        ):
            for sample in range(first, first + count):
                key = tile.y0 // 8 + row, tile.x0 // 8 + column, sample
                found[key] = found.get(key, 0) + 1
    return found


@pytest.mark.parametrize("speed", [1e2, 3e3, 1e5, 1e8])
@pytest.mark.parametrize("threads", [1, 7, 400])
def test_tasks_hold_each_sample_once(speed, threads):
    blocks = blocks_of((3, 2, 60, 37), seed=threads)
    queue, found = BlockQueue(blocks, 5), []
    while task := queue.cut(speed, threads):
        found += task.blocks
    assert held_by(found) == held_by(blocks)
    assert set(held_by(found).values()) == {1}


def test_tasks_last_some_seconds_and_the_last_ones_less():
    blocks = [Block(tile, np.full((4, 4, 2), [0, 1000])) for tile in tiles_of((0, 0, 256, 256), 32)]
    queue, speed, sizes = BlockQueue(blocks, 5), 1e6, []
    while task := queue.cut(speed, 4):
        sizes.append(sum(1024 * block.ranges[..., 1].mean() for block in task.blocks) / speed)
    assert 1.0 <= max(sizes) <= 3.0
    assert sizes[-1] < 0.3
    assert np.sum(sizes) == pytest.approx(256 * 256 * 1000 / speed)


def test_samples_are_counted_by_replicate():
    for block in blocks_of((3, 2, 21, 17), seed=1):
        for replicates in (1, 3, 4):
            told = block_tasks.samples_of(block, replicates)
            tile = block.tile
            for y, x in np.ndindex(told.shape[:2]):
                row, column = (tile.y0 + y) // 8 - tile.y0 // 8, (tile.x0 + x) // 8 - tile.x0 // 8
                first, count = block.ranges[row, column]
                own = np.bincount(np.arange(first, first + count) % replicates,
                                  minlength=replicates)  # fmt: skip
                np.testing.assert_array_equal(told[y, x], own)


# ---------------------------------------------------------------------------- answers

TASK = BlockTask(5, (
    Block(Tile(0, 0, 8, 8), np.array([[[2, 4]]])),
    Block(Tile(8, 0, 13, 8), np.array([[[0, 3]]])),
))  # fmt: skip


@pytest.fixture(scope="module")
def shared():
    """In the twin: there is nothing to compile."""
    scene = compile_scene(flatten(alight.load("cornell-box", ["film.size=[16, 8]"])),
                          aovs=("depth",), structure="list")  # fmt: skip
    settings = make_settings(scene.integrator, seed=0, replicates=3)
    return SharedScene(scene, settings, make_kernels(scene, compiled=False))


@pytest.fixture(scope="module")
def answer(shared):
    return render_blocks(shared, TASK)


def test_an_answer_is_the_sums_of_its_blocks(shared, answer):
    told = read_blocks(LAYOUT, TASK, answer)
    settings = shared.settings._replace(seed=5)
    for block, (partial, rays) in zip(TASK.blocks, told, strict=True):
        own, own_rays = render_tile(shared.kernels, shared.scene, settings, *block)
        for sums, found in ((own.sums, partial.sums), (own.aovs["depth"], partial.aovs["depth"])):
            block_tasks.carry(sums)
            np.testing.assert_array_equal(sums, found)
        np.testing.assert_array_equal(own.counts, partial.counts)
        assert (own.invalid, own.saturated, own_rays) == (partial.invalid, partial.saturated, rays)
        assert (partial.x0, partial.y0) == (block.tile.x0, block.tile.y0)


def test_every_flipped_bit_is_found(answer):
    rng = np.random.default_rng(0)
    for at in rng.integers(0, len(answer), 60):
        damaged = bytearray(answer)
        damaged[at] ^= 1 << rng.integers(8)
        with pytest.raises(FilmError):
            read_blocks(LAYOUT, TASK, bytes(damaged))


def spoilt(answer, change):
    content, arrays = unpack_archive("it", memoryview(answer))
    content, arrays = json.loads(json.dumps(content)), dict(arrays)
    change(content, arrays)
    return b"".join(pack_archive(content, arrays))


def add(name, amount):
    def change(content, arrays):
        arrays[name] = arrays[name].copy()
        arrays[name].flat[0] += amount

    return change


def put(name, value):
    def change(content, arrays):
        arrays[name] = arrays[name].copy()
        arrays[name].flat[0] = value

    return change


#: Its magnitude is no int64, and NumPy gives it as negative.
LEAST = np.iinfo(np.int64).min

SPOILT = {
    "another task": (lambda c, a: c.update(task="0"), "of another task"),
    "a block too few": (lambda c, a: c["blocks"].pop(), "answered 1 blocks, not 2"),
    "a sample too many": (add("0.counts", 1), "other samples than its task"),
    "limbs that overlap": (add("0..low", 1 << 40), "sums that its samples cannot have"),
    "a negative limb": (add("1..low", -(1 << 40)), "sums that its samples cannot have"),
    "too much light": (add("1..high", 1 << 50), "sums that its samples cannot have"),
    "too much depth": (add("0.depth.high", 1 << 50), "sums that its samples cannot have"),
    "the least number": (put("0..high", LEAST), "sums that its samples cannot have"),
    "the least depth": (put("0.depth.high", LEAST), "sums that its samples cannot have"),
    "another shape": (lambda c, a: a.update({"0..low": a["0..low"][:4]}), "of shape"),
    "another type": (lambda c, a: a.update({"0..low": a["0..low"] * 1.0}), "float64, not"),
    "no layer": (lambda c, a: a.pop("0.depth.low"), "cannot be read: KeyError"),
    "no content": (lambda c, a: c.clear(), "cannot be read: KeyError"),
    "negative rays": (lambda c, a: c["blocks"][0].update(rays=-1), "has the tallies"),
    "half a ray": (lambda c, a: c["blocks"][0].update(rays=0.5), "has the tallies"),
}


@pytest.mark.parametrize(("change", "message"), SPOILT.values(), ids=SPOILT.keys())
def test_a_malformed_answer_is_refused(answer, change, message):
    assert message in refusal_of(spoilt(answer, change))


def refusal_of(data):
    try:
        read_blocks(LAYOUT, TASK, data)
    except FilmError as error:
        return str(error)
    return "none"


def test_an_answer_that_is_too_long_is_refused(answer):
    assert "bytes long" in refusal_of(answer + bytes(10**6))


@pytest.mark.parametrize("data", [None, "text", b"", b"short", [1]])
def test_what_is_no_answer_is_refused(data):
    with pytest.raises(FilmError):
        read_blocks(LAYOUT, TASK, data)


def test_tasks_of_other_seeds_tiles_and_ranges_have_other_names():
    first, second = TASK.blocks
    other = Block(first.tile, first.ranges + np.array([0, 1]))
    moved = Block(Tile(8, 0, 16, 8), first.ranges)
    tasks = [TASK, TASK._replace(seed=6), BlockTask(5, (first,)), BlockTask(5, (second, first)),
             BlockTask(5, (other, second)), BlockTask(5, (moved, second))]  # fmt: skip
    assert len({task.digest for task in tasks}) == len(tasks)
