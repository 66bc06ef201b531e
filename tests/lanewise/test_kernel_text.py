"""Mistakes in kernels: each told with its place, its line and the remedy, never by a crash."""

import inspect
import math

import numpy as np
import pytest

from alight.core.errors import AlightError, KernelError
from alight.core.registry import FAMILIES, modules
from lanewise.jit import instantiate, is_kernel, kernel
from lanewise.kernel_text import mistakes_in
from lanewise.simd import any_lane, lanes, where
from lanewise.view import View


@kernel
def joined(table):
    x = lanes(1.0)
    table[0] = where((x > 0.0) and (x < 2.0), x, 0.0)[0]


@kernel
def denied(table):
    x = lanes(1.0)
    table[0] = where(not (x > 0.0), x, 0.0)[0]


@kernel
def chained(table):
    x = lanes(1.0)
    table[0] = where(0.0 < x < 2.0, x, 0.0)[0]


@kernel
def chosen(table):
    x = lanes(1.0)
    x = x if x > 0.0 else -x
    table[0] = 1.0


@kernel
def branched(table):
    x = lanes(1.0)
    if x > 0.0:
        x = x + 1.0
    table[0] = 1.0


@kernel
def looped(table):
    x = lanes(1.0)
    while x < 2.0:
        x = x + 1.0
    table[0] = 1.0


@kernel
def with_numpy(table):
    x = lanes(-1.0)
    x = np.sqrt(x) + lanes(1.0)
    table[0] = 1.0


@kernel
def with_math(table):
    x = lanes(1.0)
    x = math.pow(x, x)
    table[0] = 1.0


@kernel
def without_counterpart(table):
    x = lanes(1.0)
    x = math.erf(x)
    table[0] = 1.0


@kernel
def nested(table):
    branched(table)


COMPILED = {
    joined: ("joined", "(x > 0.0) and (x < 2.0)", "write (a) & (b)"),
    denied: ("denied", "not (x > 0.0)", "write ~mask"),
    chained: ("chained", "0.0 < x < 2.0", "write (a < b) & (b < c)"),
    chosen: ("chosen", "x if x > 0.0", "write where(mask, a, b)"),
    branched: ("branched", "if x > 0.0:", "if any_lane(mask):"),
    looped: ("looped", "while x < 2.0:", "while any_lane(mask):"),
    with_numpy: ("with_numpy", "np.sqrt(x)", "from lanewise.simd import sqrt"),
    with_math: ("with_math", "math.pow(x, x)", "from alight.core.maths import pow"),
    without_counterpart: ("without_counterpart", "math.erf(x)", "use the functions of lanewise"),
    # The kernel that is wrong is named, not the one that calls it.
    nested: ("branched", "if x > 0.0:", "if any_lane(mask):"),
}


@pytest.mark.parametrize("root", COMPILED, ids=lambda root: root.__name__)
def test_what_numba_cannot_type_is_told_with_line_and_remedy(root):
    name, line, remedy = COMPILED[root]
    with pytest.raises(KernelError) as raised:
        instantiate(root)(View(np.zeros(1, np.float32)))
    message = str(raised.value)
    lines, start = inspect.getsourcelines(globals()[name])
    number = start + next(i for i, text in enumerate(lines) if line in text)
    assert message.startswith(f"{name}: {__file__}:{number}\n")
    assert line in message.splitlines()[1]
    assert remedy in message.splitlines()[2]
    assert len(message.splitlines()) <= 6
    assert isinstance(raised.value, AlightError)


@kernel
def lists(table):
    table[0] = [1.0, 2.0][0]


@kernel
def comprehends(table):
    table[0] = sum(x for x in (1.0, 2.0))


@kernel
def raises(table):
    if table[0] > 0.0:
        raise ValueError("no")


@kernel
def prints(table):
    print(table[0])


@kernel
def formats(table):
    table[0] = float(f"{table[0]}")


@kernel
def misspells(table):
    table[0] = wher(table[0])  # noqa: F821


REFUSED = {
    lists: "use a tuple",
    comprehends: "no comprehensions",
    raises: "never raises",
    prints: "does not print",
    formats: "no text",
    misspells: 'the name "wher" is not defined',
}


@pytest.mark.parametrize("root", REFUSED, ids=lambda root: root.__name__)
def test_what_no_kernel_can_hold_is_refused_before_it_is_compiled(root):
    """Some of it would compile, and crash: kernels run without Python's memory."""
    with pytest.raises(KernelError) as raised:
        instantiate(root)(View(np.zeros(1, np.float32)))
    first, quoted, remedy = str(raised.value).splitlines()[:3]
    assert first.startswith(f"{root.__name__}: {__file__}:")
    assert quoted.strip() in inspect.getsource(root)
    assert REFUSED[root] in remedy


@kernel
def right(table):
    x = lanes(1.0)
    pair = (x, -x)
    if any_lane(x > 0.0):
        x = where((x > 0.0) & ~(x > 2.0), pair[0], pair[1])
    for k in range(1):
        table[k] = 1.0


def test_a_kernel_without_mistakes_is_left_alone():
    assert mistakes_in(right) == []
    table = np.zeros(1, np.float32)
    instantiate(right)(View(table))
    assert table[0] == 1.0


def test_our_own_kernels_hold_nothing_that_a_users_is_refused_for():
    kernels = [
        value
        for family in FAMILIES
        for module in modules(family)
        for value in vars(module).values()
        if is_kernel(value)
    ]
    assert len(kernels) > 200
    assert [text for one in kernels for text in mistakes_in(one)] == []


def test_what_does_not_fit_where_it_is_called_is_told_with_both_places():
    """The line is ours, the kernel the user's: here both are of this file's tests."""
    with pytest.raises(KernelError) as raised:
        instantiate(calls_it)(View(np.zeros(1, np.float32)))
    assert "two, three = one_only(table[0])" in str(raised.value)


@kernel
def one_only(x):
    return x


@kernel
def calls_it(table):
    two, three = one_only(table[0])
    table[0] = two + three
