"""What the campaign of random slips writes, and that it leaves no kernel out."""

from __future__ import annotations

import ast
from itertools import islice
from pathlib import Path

import pytest

import alight
from lanewise import jit, machine_code
from tests.mutants.campaign import sample
from tests.mutants.equivalent import EQUIVALENT
from tests.mutants.operators import planted, sites_of
from tests.mutants.selection import select_tests
from tests.mutants.trial import BY_TEXT, ONE_FOLDER

PACKAGE = Path(alight.__file__).parent

#: A line of kernel text, and what the operators make of it.
LINES = (
    ("x = a * b", {"x = (a)", "x = (b)"}),
    ("x = a / b", {"x = (a)"}),
    ("x = a - b", {"x = ((a) + (b))"}),
    ("x = -a", {"x = (a)"}),
    ("x = f(a, b)", {"x = f(b, a)"}),
    ("x = dot(a, b)", set()),
    ("x = where(m, a, b)", {"x = where(m, b, a)"}),
    ("x = minimum(a, b)", {"x = (-minimum(-(a), -(b)))"}),
    ("x = np.sin(a)", {"x = np.cos(a)"}),
    ("s, c = sincos(a)", {"c, s = sincos(a)"}),
    ("x = a.y", {"x = a.z"}),
    ("x = 2.0", {"x = 2.04"}),
    ("x = 1", {"x = 2", "x = 0"}),
    ("x = 1e-30", set()),
    ("x = local_floats(2)", {"x = local_floats(1)"}),
    ("x = a < 0", {"x = (a <= 0)", "x = a < 1"}),
    ("x = a < b", set()),
    ("assert a < 0, a + b", set()),
    ("raise ValueError(f'{a + 1}')", set()),
    ("x: Literal[1] = a", set()),
    ("'''A docstring of 2 words.'''", set()),
)


@pytest.mark.parametrize(("line", "expected"), LINES, ids=[line for line, _ in LINES])
def test_operators_write_these_slips(line, expected, tmp_path):
    path = tmp_path / "models" / "one.py"
    path.parent.mkdir()
    path.write_text(f"@kernel\ndef k(a, b):\n    {line}\n\n\ndef plain(a, b):\n    {line}\n")
    source = path.read_bytes()
    found = [planted(source, site).decode().splitlines() for site in sites_of(tmp_path)]
    assert {lines[2].strip() for lines in found} == expected
    # What is neither kernel text nor a statistic stays.
    assert all(lines[6].strip() == line for lines in found)


@pytest.fixture(scope="module")
def sites():
    """All of the package."""
    return sites_of(PACKAGE)


def test_every_slip_can_be_parsed_and_has_a_name_of_its_own(sites):
    sources = {site.file: (PACKAGE / site.file).read_bytes() for site in sites}
    for site in islice(sample(sites, 7), 300):
        ast.parse(planted(sources[site.file], site))
    assert len({site.name for site in sites}) == len(sites)


def test_every_file_has_tests_that_concern_it(sites):
    root = Path(__file__).parents[2]
    for file in {site.file for site in sites}:
        near, far = select_tests(root, file)
        assert len(near) + len(far) >= 4, file


def test_a_larger_sample_begins_with_the_smaller_one(sites):
    first = [site.name for site in islice(sample(sites, 3), 50)]
    assert [site.name for site in islice(sample(sites, 3), 80)][:50] == first
    assert [site.name for site in islice(sample(sites, 4), 50)] != first
    assert len({name.partition("/")[0] for name in first}) >= 8


def test_equivalent_slips_are_still_there_and_have_reasons(sites):
    names = {site.name for site in sites}
    gone = [name for name in EQUIVALENT if name not in names]
    assert not gone, f"the text has changed: {gone}"
    assert all(len(reason) > 20 for reason in EQUIVALENT.values())


def test_what_the_campaign_adds_to_lanewise_runs_there(monkeypatch, tmp_path):
    # A name that is not imported there would fail every test that compiles: they would all be left
    # out, as failing without a slip.
    monkeypatch.setenv("KERNELS_OF_THE_CAMPAIGN", str(tmp_path))
    scope = dict(vars(machine_code))
    exec(ONE_FOLDER, scope)
    assert scope["cache_folder"]() == tmp_path

    scope = dict(vars(jit))
    exec(BY_TEXT, scope)
    identities = set()
    for constant in (1.0, 2.0, 1.0):

        @jit.kernel
        def root(x, constant=constant):
            return x + constant

        identities.add(scope["instantiate"](root).identity)
    assert len(identities) == 2
