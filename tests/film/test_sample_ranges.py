"""Sets of sample indices against Python sets."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from alight.core.errors import FilmError
from alight.films.sample_ranges import (
    EMPTY,
    SampleRanges,
    cells_of,
    cells_with,
    empty_cells,
    union_of_cells,
)

index_sets = st.sets(st.integers(0, 60))


def ranges_of(indices):
    return SampleRanges([(i, i + 1) for i in indices])


def indices_of(ranges):
    return {i for first, end in ranges for i in range(first, end)}


@given(index_sets)
def test_ranges_are_sorted_disjoint_and_as_few_as_possible(indices):
    ranges = ranges_of(indices)
    assert indices_of(ranges) == indices
    assert ranges.count == len(indices)
    ends = [edge for pair in ranges for edge in pair]
    assert ends == sorted(set(ends))


@given(index_sets, index_sets)
def test_union_and_overlap_are_those_of_sets(a, b):
    assert indices_of(ranges_of(a).overlap(ranges_of(b))) == a & b
    if a & b:
        with pytest.raises(FilmError, match="counted twice"):
            ranges_of(a).union(ranges_of(b))
    else:
        assert ranges_of(a).union(ranges_of(b)) == ranges_of(a | b)


def test_equal_unions_are_one_object():
    a, b = SampleRanges([(0, 8)]), SampleRanges([(8, 16)])
    assert a.union(b) is SampleRanges([(0, 8)]).union(SampleRanges([(8, 16)]))


@pytest.mark.parametrize("wrong", [(-1, 4), (5, 4)])
def test_impossible_ranges_are_refused(wrong):
    with pytest.raises(FilmError, match="0 <= first <= end"):
        SampleRanges([wrong])


def test_text_names_the_last_sample():
    assert str(SampleRanges([(0, 32), (64, 65)])) == "0 to 31, 64"
    assert str(EMPTY) == "none"


def test_cells_cover_the_film_from_its_corner():
    assert empty_cells(17, 8).shape == (1, 3)
    assert cells_of(4, 8, 5, 16) == (slice(1, 3), slice(0, 2))


def grid(cells):
    made = empty_cells(16, 16)
    made.reshape(-1)[:] = cells
    return made


few = st.builds(SampleRanges, st.sampled_from([(), [(0, 4)], [(8, 12)]]))
more = st.builds(SampleRanges, st.sampled_from([(), [(4, 8)], [(12, 16)]]))


@given(
    *(
        one.flatmap(lambda one, kind=kind: st.lists(st.just(one) | kind, min_size=4, max_size=4))
        for kind, one in ((few, few), (more, more))
    )
)
def test_cells_are_united_whether_or_not_they_are_alike(a, b):
    united = union_of_cells(grid(a), grid(b))
    assert united.ravel().tolist() == [x.union(y) for x, y in zip(a, b, strict=True)]


@given(st.lists(st.sampled_from([(0, 4), (4, 4), (0, 8)]), min_size=4, max_size=4))
def test_cells_are_made_whether_or_not_they_are_alike(pairs):
    cells = cells_with(np.array(pairs).reshape(2, 2, 2))
    made = [SampleRanges([(first, first + count)]) for first, count in pairs]
    assert cells.shape == (2, 2) and cells.ravel().tolist() == made


def test_cells_are_united_one_by_one():
    a, b = empty_cells(16, 8), empty_cells(16, 8)
    a[0, 0], b[0, 1] = SampleRanges([(0, 4)]), SampleRanges([(0, 4)])
    assert union_of_cells(a, b).tolist() == [[SampleRanges([(0, 4)])] * 2]
