"""The page that follows a ray goes from call to call as the kernels do."""

import re
from collections import namedtuple

import pytest

from alight.accel import intersect_closest, is_occluded, query
from lanewise.jit import Specialised
from tests.docs.names import import_path
from tests.docs.pages import ROOT

ROW = re.compile(r"^\| `(\w+)` \| `(accel|shapes)/(\w+)\.py` \|", re.MULTILINE)
PAGE = (ROOT / "docs" / "following-a-ray.md").read_text(encoding="utf-8")
CALLS = [import_path(f"alight.{folder}.{file}.{name}") for name, folder, file in ROW.findall(PAGE)]

Program = namedtuple("Program", "accel")


def _called_by(kernel):
    """The kernels that a kernel names: as globals, or as what it was written around."""
    if isinstance(kernel, Specialised):
        kernel = kernel.factory(Program(("tree",)))
    named = [kernel.__globals__.get(name) for name in kernel.__code__.co_names]
    return named + [cell.cell_contents for cell in kernel.__closure__ or ()]


@pytest.mark.parametrize("k", range(len(CALLS) - 1))
def test_each_kernel_calls_the_next(k):
    assert CALLS[k + 1] in _called_by(CALLS[k])


def test_both_queries_share_all_but_their_ends():
    assert CALLS[0] is intersect_closest
    assert query.search_scene in _called_by(is_occluded)


def test_there_are_four_stops_between_a_query_and_the_triangles_of_a_block():
    assert [kernel.__name__ for kernel in CALLS[5:]] == ["meet_block", "edge_functions"]
