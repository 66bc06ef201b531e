"""Light paths as tasks: whole samples of single replicates, with the bits of a render."""

import numpy as np
import pytest

import alight
from alight.compiled.scene import compile_scene
from alight.core.errors import FilmError
from alight.films import Film, PartialFilm
from alight.films.archive import pack_archive, unpack_archive
from alight.integrators.walk import make_settings
from alight.rendering.executors import light_tasks
from alight.rendering.executors.block_tasks import SharedScene
from alight.rendering.executors.blocks import Block
from alight.rendering.executors.light_tasks import LightQueue, read_light_sums, render_light_task
from alight.rendering.tiles.tile import make_kernels, render_tile
from alight.rendering.tiles.tile_kernel import Tile
from alight.scene import flatten
from tests.cluster.test_block_tasks import held_by

REPLICATES = 3
WINDOW = Tile(3, 2, 19, 13)


def strips(seed, equal):
    """The strips of a pass, with a range for all cells or one for each."""
    rng = np.random.default_rng(seed)
    found = []
    for tile in (Tile(3, 2, 19, 8), Tile(3, 8, 19, 13)):
        ranges = np.full((1, 3, 2), [4, 17]) if equal else rng.integers(0, 20, (1, 3, 2))
        found.append(Block(tile, ranges))
    return found


def blocks_of(task):
    return list(task.blocks())


@pytest.mark.parametrize("equal", [True, False])
@pytest.mark.parametrize("speed", [5.0, 100.0, 1e4])
@pytest.mark.parametrize("answered", [0, 3, 10**6])
def test_tasks_and_what_is_left_of_them_hold_each_sample_once(equal, speed, answered):
    """As many tasks as `answered` are; the cluster is lost with one on its way."""
    whole = strips(7, equal)
    queue, added, found = LightQueue(whole, WINDOW, REPLICATES, 5), [], []

    def add(partial, rays):
        added.append(partial)

    while (task := queue.cut(speed, 2)) is not None:
        if answered == 0:
            break
        answered -= 1
        blocks = blocks_of(task)
        assert {int(i) % REPLICATES for _, r in blocks for i, n in r.reshape(-1, 2) if n} <= {
            task.replicate
        }
        found += blocks
        queue.take(task, stand_in(task), add)
    before = {key for partial in added for key in cells_held(partial)}
    rest = queue.rest([task] if task else [])
    # Only whole samples are added; strips of one that lacks another are rendered again.
    again = held_by(rest)
    assert set(again.values()) <= {1}
    assert before.isdisjoint(again)
    assert before | set(again) == set(held_by(whole))
    if task is None:
        assert not rest
        assert held_by(found) == held_by(whole)


def stand_in(task):
    counts = task.samples_of_pixels()[:, :, None]
    partial = PartialFilm(
        WINDOW.x0, WINDOW.y0, np.zeros((*counts.shape, 3, 2), np.int64), counts, 0, 0,
        task.cells(), {}, replicate=task.replicate,
    )  # fmt: skip
    return light_tasks.LightSums(partial, 0)


def cells_held(partial):
    cells = np.broadcast_to(partial.ranges, (2, 3))
    for (row, column), held in np.ndenumerate(cells):
        for first, end in held:
            for sample in range(first, end):
                yield row, column, sample


@pytest.fixture(scope="module")
def shared():
    """In the twin: there is nothing to compile."""
    changes = ["film.size=[24, 16]", "film.crop=[3, 2, 16, 11]", "integrator.type=light"]
    scene = compile_scene(flatten(alight.load("cornell-box", changes)), structure="list")
    settings = make_settings(scene.integrator, seed=0, replicates=REPLICATES)
    return SharedScene(scene, settings, make_kernels(scene, compiled=False))


def test_answers_add_up_to_the_film_of_a_render(shared, monkeypatch):
    """Samples 4 and 5, strip by strip and carried after each, against one tile of all."""
    monkeypatch.setattr(light_tasks, "_ROOM", 1)
    blocks = [Block(tile, np.broadcast_to([4, 2], (1, 3, 2))) for tile, _ in strips(0, True)]
    queue = LightQueue(blocks, WINDOW, REPLICATES, 5)
    films = [Film(24, 16, crop=(3, 2, 16, 11), replicates=REPLICATES) for _ in range(2)]
    rays = 0

    def add(partial, n):
        nonlocal rays
        rays += n
        films[0].add_tile(partial)

    while (task := queue.cut(30.0, 2)) is not None:
        queue.take(task, read_light_sums(3, task, render_light_task(shared, task)), add)
    window = np.broadcast_to([4, 2], (2, 3, 2))
    partial, own_rays = render_tile(
        shared.kernels, shared.scene, shared.settings._replace(seed=5), WINDOW, window
    )
    films[1].add_tile(partial)
    for plane in ("sums", "counts", "cells"):
        np.testing.assert_array_equal(getattr(films[0], plane), getattr(films[1], plane))
    assert films[1].sums.any()
    assert rays == own_rays


def change(name, amount):
    def spoil(content, arrays):
        arrays[name] = arrays[name].copy()
        arrays[name].flat[0] += amount

    return spoil


NOISE = np.random.default_rng(0).integers(2**62, size=10**5)

SPOILT = {
    "another task": (lambda c, a: c.update(task="0"), "of another task"),
    "a sample too many": (change("counts", 1), "other samples than its task"),
    "limbs that overlap": (change(".low", 1 << 40), "sums that its samples cannot have"),
    "too much light": (change(".high", 1 << 62), "sums that its samples cannot have"),
    "negative rays": (lambda c, a: c.update(rays=-1), "has the tallies"),
    "no sums": (lambda c, a: a.pop(".high"), "cannot be read: KeyError"),
    "too many bytes": (lambda c, a: a.update(more=NOISE), "bytes long"),
}


@pytest.mark.parametrize(("spoil", "message"), SPOILT.values(), ids=SPOILT.keys())
def test_a_malformed_answer_is_refused(spoil, message):
    task = LightQueue(strips(0, True), WINDOW, REPLICATES, 5).cut(1e4, 2)
    zeros = np.zeros((11, 16, 3), np.int64)
    content = {"task": task.digest, "invalid": 0, "saturated": 0, "rays": 1}
    arrays = {"counts": task.samples_of_pixels(), ".high": zeros, ".low": zeros}
    good = b"".join(pack_archive(content, arrays))
    read_light_sums(3, task, good)
    content, arrays = unpack_archive("it", memoryview(good))
    spoil(content, arrays := dict(arrays))
    with pytest.raises(FilmError, match=message):
        read_light_sums(3, task, b"".join(pack_archive(content, arrays)))


def test_a_film_refuses_sums_of_a_replicate_that_it_does_not_have():
    task = LightQueue(strips(0, True), WINDOW, REPLICATES, 5).cut(1e4, 2)
    film = Film(24, 16, crop=(3, 2, 16, 11), replicates=REPLICATES)
    partial = stand_in(task).partial
    with pytest.raises(FilmError, match="has no 3"):
        film.add_tile(partial._replace(replicate=3))
    film.add_tile(partial)
    with pytest.raises(FilmError, match="counted twice"):
        film.add_tile(partial)
