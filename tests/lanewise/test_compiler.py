"""What compiling is spared: a kernel for each constant, and questions that were asked before."""

import operator
from collections import Counter

import numpy as np
from numba import types
from numba.core import event

from lanewise.application import variable
from lanewise.jit import instantiate, kernel
from lanewise.view import View
from lanewise.wide import lane, wide


@kernel
def write_number(table, k, x):
    table[k] = x


@kernel
def spread_and_read(n, x):
    # `wide` has to know how many lanes.
    return lane(wide(n, x), n - 1)


@kernel
def write_numbers(table):
    write_number(table, 0, 5)
    write_number(table, 1, 6)
    write_number(table, 2, table[0])
    write_number(table, 3, spread_and_read(8, table[1]))
    write_number(table, 4, spread_and_read(16, table[0]))


class Compilations(event.Listener):
    """Counts how often each function is compiled."""

    def __init__(self):
        self.of = Counter()

    def on_start(self, event):
        self.of[event.data["dispatcher"].py_func.__name__] += 1

    def on_end(self, event):
        pass


def test_a_kernel_is_compiled_once_for_all_numbers_unless_it_must_know_them(tmp_path, monkeypatch):
    monkeypatch.setenv(variable("CACHE"), str(tmp_path))
    call, table = instantiate(write_numbers), View(np.zeros(5, np.float32))
    with event.install_listener("numba:compile", Compilations()) as seen:
        call(table)
    assert table.array.tolist() == [5.0, 6.0, 5.0, 6.0, 5.0]
    # For whole numbers and for float32, not for 0 and 5, 1 and 6, 2, 3 and 4.
    assert seen.of["write_number"] == 2


@kernel
def add_once(table):
    table[0] = table[1] + table[2]


@kernel
def add_again(table):
    table[3] = table[4] + table[2]


def test_what_a_sum_is_is_found_out_once(tmp_path, monkeypatch):
    monkeypatch.setenv(variable("CACHE"), str(tmp_path))
    asked, ask = [], types.Function.get_call_type

    def listen(function, context, arguments, keywords):
        asked.append(function.typing_key)
        return ask(function, context, arguments, keywords)

    table = View(np.arange(5, dtype=np.float32))
    instantiate(add_once)(table)
    monkeypatch.setattr(types.Function, "get_call_type", listen)
    instantiate(add_again)(table)
    assert (table.array[0], table.array[3]) == (3.0, 6.0)
    assert asked.count(operator.add) == 0
