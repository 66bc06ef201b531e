"""Items of work: each sample once, neighbours together."""

import numpy as np

from alight.rendering.executors.blocks import Block
from alight.rendering.executors.gpu_executor import GpuExecutor, groups, work_of
from alight.rendering.tiles.tile_kernel import Tile
from tests.gpu.processor import render_on_the_processor

BLOCKS = [
    Block(Tile(3, 8, 20, 17), np.arange(12).reshape(2, 3, 2)),
    Block(Tile(20, 8, 24, 17), np.full((2, 1, 2), (5, 4))),
]


def samples_of(work):
    """Pixel and sample of all items."""
    return [(x, y, first + k) for x, y, first, count, _ in work.tolist() for k in range(count)]


def test_each_sample_is_rendered_once():
    wanted = []
    for tile, ranges in BLOCKS:
        for y in range(tile.y0, tile.y1):
            for x in range(tile.x0, tile.x1):
                first, count = ranges[y // 8 - tile.y0 // 8, x // 8 - tile.x0 // 8].tolist()
                wanted += [(x, y, first + k) for k in range(count)]
    for asked in (1, 2, 3, 100):
        work, shares = work_of(BLOCKS, asked)
        assert shares == min(asked, 11)
        assert sorted(samples_of(work)) == sorted(wanted)
        assert (work[:, 3] > 0).all()
        # Each share of a pixel has a place of its own.
        assert len(np.unique(work[:, 4])) == len(work)


def test_places_are_pixels_in_the_order_of_their_tiles():
    work, _ = work_of(BLOCKS, 1)
    for x, y, _, _, place in work.tolist():
        tile = BLOCKS[x >= 20].tile
        before = 0 if x < 20 else 17 * 9
        assert place == before + (y - tile.y0) * (tile.x1 - tile.x0) + x - tile.x0


def test_threads_that_run_together_have_neighbours():
    work, _ = work_of([Block(Tile(0, 0, 32, 32), np.full((4, 4, 2), (0, 1)))], 1)
    for warp in work[:, :2].reshape(-1, 32, 2):
        assert tuple(np.ptp(warp, axis=0)) == (7, 3)


def test_groups_are_as_large_as_there_is_room():
    block = Block(Tile(0, 0, 8, 8), np.zeros((1, 1, 2)))
    assert [len(group) for group in groups([block] * 5, 128)] == [2, 2, 1]
    assert [len(group) for group in groups([block] * 2, 1)] == [1, 1]
    assert list(groups([], 128)) == []


def test_each_table_has_the_room_that_it_needs(monkeypatch):
    """With fewer replicates and more pixels some tables shrink, and others grow."""
    render_on_the_processor(monkeypatch)
    executor = GpuExecutor()
    for sizes in ([96, 32, 24, 16], [96, 32, 48, 32], [48, 16, 48, 32]):
        executor._make_room(3, sizes)
        there = [len(executor._gpu.memory[address]) for address in executor._film]
        assert all(room >= size for room, size in zip(there, sizes, strict=True))
    # The work, too; what was too small is given back.
    assert len(executor._gpu.memory) == 5
