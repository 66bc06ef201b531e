"""Functions that Numba has for Python's own: the same bits whatever was compiled before."""

import itertools
import math
import re

import numpy as np
import pytest
from numba.extending import overload

from lanewise.application import variable
from lanewise.jit import dispatcher_of, instantiate, kernel
from lanewise.numba_adapter import TypingError, object_code
from lanewise.view import View

PLACES = 11


@kernel
def write_extremes(out, x, k):
    out[0], out[1] = max(x[0], x[1]), min(x[0], x[1])
    out[2], out[3] = max(x[0], x[1], x[2]), min(x[0], x[1], x[2])
    out[4], out[5] = max(k[0], k[1]), min(k[0], 3)
    out[6], out[7] = max(k[1], x[0]), min(x[0] > x[1], k[0] > k[1])
    out[8] = max(x[0], 2.5, x[2])
    out[9], out[10] = max((x[0], x[1], 2.5)), min((x[2], x[1]))


def llvm_of(root, *arguments):
    dispatcher = dispatcher_of(root)
    object_code(dispatcher, arguments)
    [compiled] = dispatcher.overloads.values()
    return str(compiled.library._final_module)


NUMBERS = (1.0, 2.0, 3.0, math.nan, 0.0, -0.0)


@pytest.fixture(scope="module")
def extremes():
    return instantiate(write_extremes), instantiate(write_extremes, compiled=False)


@pytest.mark.parametrize("k", [(1, 2), (5, -2), (2, 2)])
def test_extremes_are_pythons_nan_and_signed_zeros_included(extremes, k):
    for x in itertools.product(NUMBERS, repeat=3):
        compiled, twin = (np.zeros(PLACES, np.float32) for _ in range(2))
        for call, out in zip(extremes, (compiled, twin), strict=True):
            call(View(out), View(np.array(x, np.float32)), View(np.array(k, np.int64)))
        np.testing.assert_array_equal(compiled, twin, err_msg=str((x, k)))
        signs = ~np.isnan(twin)
        np.testing.assert_array_equal(np.signbit(compiled)[signs], np.signbit(twin)[signs])


@kernel
def write_extreme_of_one(out, x, k):
    out[0] = max(x[0])


def test_one_number_has_no_extreme(tmp_path, monkeypatch):
    monkeypatch.setenv(variable("CACHE"), str(tmp_path))
    out = View(np.zeros(1, np.float32))
    with pytest.raises(TypingError, match=r"max\(float32\)"):
        llvm_of(write_extreme_of_one, out, out, out)


def test_extremes_are_no_functions_of_numba(tmp_path, monkeypatch):
    """These would be named by a count and compiled with the fast-math of their first caller."""
    monkeypatch.setenv(variable("CACHE"), str(tmp_path))
    out, x, k = (View(np.zeros(PLACES, kind)) for kind in (np.float32, np.float32, np.int64))
    assert not re.findall(r"numba\w*builtins\w*", llvm_of(write_extremes, out, x, k))


def twisted(x):
    raise NotImplementedError("for kernels")


@overload(twisted)
def _twisted(x):
    def long(x):
        # Too long for LLVM to inline of its own accord.
        for i in range(7):
            for j in range(5):
                if x > i:
                    x = x * 3 + j
                elif x < -j:
                    x = x * 5 - i
                else:
                    x = (x ^ i) * 7 + (x ^ j) * 11
                for n in range(3):
                    x = (x << n) ^ (x >> (n + i)) ^ (x * j + n)
        return x

    return long


@kernel
def twist_thrice(table, n):
    for at in range(n):
        table[at] = twisted(twisted(table[at])) - twisted(table[at] + 1)


def test_other_functions_of_numba_are_inlined_whatever_llvm_estimates(tmp_path, monkeypatch):
    monkeypatch.setenv(variable("CACHE"), str(tmp_path))
    code = llvm_of(twist_thrice, View(np.zeros(2, np.int64)), 2)
    assert not re.findall(r"call [^\n]*long[^\n]*", code)
