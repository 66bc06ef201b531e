"""Goals cut into passes: every missing sample once, whatever the film holds already."""

import numpy as np
import pytest

from alight.films import Film, SampleRanges
from alight.rendering.schedules.passes import PASS_SECONDS, Pace, Work, first_gap, ranges_of
from alight.rendering.schedules.schedule import Goal
from alight.rendering.tiles.tile_kernel import Tile


@pytest.mark.parametrize(
    ("held", "first", "count", "gap"),
    [
        ([], 0, 8, (0, 8)),
        ([(0, 3)], 0, 8, (3, 8)),
        ([(2, 3), (5, 6)], 0, 8, (0, 2)),
        ([(0, 3), (5, 6)], 0, 8, (3, 5)),
        ([(0, 8)], 0, 8, (8, 8)),
        ([(0, 99)], 3, 4, (7, 7)),
        ([(20, 30)], 3, 4, (3, 7)),
        ([(0, 2)], 3, 4, (3, 7)),
        ([(0, 4), (5, 9)], 4, 1, (4, 5)),
        ([], 5, 0, (5, 5)),
    ],
)
def test_the_first_gap(held, first, count, gap):
    assert first_gap(SampleRanges(held), first, count) == gap


def test_passes_render_every_missing_sample_once():
    rng = np.random.default_rng(2)
    film = Film(40, 24, crop=(9, 8, 31, 16))
    window = (slice(1, 3), slice(1, 5))
    for y, x in np.ndindex(film.cells.shape):
        starts = sorted(rng.choice(30, 4, replace=False).tolist())
        film.cells[y, x] = SampleRanges([tuple(starts[:2]), tuple(starts[2:])])
    goal = Goal(rng.integers(0, 5, (3, 5)), rng.integers(0, 40, (3, 5)))
    before = film.cells.copy()
    while (work := Work(goal, film)).left:
        while work.left:
            taken = work.take(int(rng.integers(1, 9)))
            for y, x in np.ndindex(film.cells.shape):
                first, count = taken[y, x].tolist()
                # `union` refuses a sample that is there already.
                film.cells[y, x] = film.cells[y, x].union(SampleRanges([(first, first + count)]))
    for y, x in np.ndindex(film.cells.shape):
        wanted = set(range(goal.first[y, x], goal.first[y, x] + goal.count[y, x]))
        inside = (y, x) in {(i, j) for i in (1, 2) for j in (1, 2, 3, 4)}
        had = {i for first, end in before[y, x] for i in range(first, end)}
        has = {i for first, end in film.cells[y, x] for i in range(first, end)}
        assert has == (had | wanted if inside else had)
    assert film.cells[window].size == 8


@pytest.mark.parametrize("alike", [True, False])
def test_the_gaps_of_cells_whether_or_not_they_are_alike(alike):
    film = Film(24, 8, crop=(8, 0, 16, 8))
    held = SampleRanges([(0, 3)])
    film.cells[0] = [SampleRanges(), held, held if alike else SampleRanges([(0, 5)])]
    work = Work(Goal(np.zeros((1, 3), int), np.full((1, 3), 8)), film)
    # What lies outside of the crop is not rendered.
    assert work.next.tolist() == [[0, 3, 3 if alike else 5]]
    assert work.end.tolist() == [[0, 8, 8]]


def test_cells_that_lack_less_end_together_with_the_others():
    film = Film(16, 8)
    work = Work(Goal(np.zeros((1, 2), int), np.array([[10, 100]])), film)
    counts = []
    while work.left:
        counts.append(work.take(20)[0, :, 1].tolist())
    assert counts == [[2, 20]] * 5
    # Not one sample more than was asked for.
    assert Work(Goal(np.zeros((1, 2), int), np.array([[7, 3]])), film).take(2).tolist() == [
        [[0, 2], [0, 1]]
    ]


def test_a_tile_gets_the_ranges_of_its_cells():
    ranges = np.arange(3 * 4 * 2).reshape(3, 4, 2)
    np.testing.assert_array_equal(ranges_of(Tile(9, 8, 25, 17), ranges), ranges[1:3, 1:4])


def test_passes_grow_to_their_length_and_end_with_the_time():
    pace = Pace(None)
    assert pace.step == 1
    # Not at once: the first pass is too short to be measured well.
    pace.adapt(1, 0.001, None)
    assert 4 <= pace.step <= 16
    pace.adapt(100, 0.5 * PASS_SECONDS, None)
    assert pace.step == 200
    pace.adapt(200, 1.0, 0.5)
    assert pace.step == 100
    pace.adapt(200, 1.0, -1.0)
    assert pace.step == 1
    fixed = Pace(7)
    fixed.adapt(7, 0.001, 100.0)
    assert fixed.step == 7


def test_passes_are_equal_where_no_time_limit_cuts_them():
    pace = Pace(None)
    pace.adapt(100, PASS_SECONDS, None)
    left, counts = 239, []
    while left:
        counts.append(pace.count(left))
        left -= counts[-1]
    assert counts == [120, 119]
    assert [pace.count(n) for n in (1, 99, 149, 151)] == [1, 99, 149, 76]
    # What the time allows is not stretched.
    pace.adapt(100, PASS_SECONDS, PASS_SECONDS)
    assert [pace.count(n) for n in (99, 149)] == [99, 100]
    assert Pace(7).count(9) == 7
