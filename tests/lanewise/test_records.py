"""Records as one value: chosen and changed as a whole, compiled and on NumPy arrays."""

from collections import namedtuple
from typing import NamedTuple

import numpy as np
import pytest
from numba import typeof, types
from numba.core.errors import TypingError

from lanewise import kept_functions
from lanewise.jit import instantiate, kernel
from lanewise.lane_types import FLOATS, MASK, UINTS, Vec3Type
from lanewise.record_instructions import _count_rows
from lanewise.records import local_records, put_records, records_at, replace
from lanewise.simd import LANES, as_uint, float_bits, load_lanes, packing, store_lanes, where
from lanewise.vec3 import Vec3
from lanewise.view import View

Key = namedtuple("Key", "word odd")
State = namedtuple("State", "p x key steps pair")
ROWS = 9


@kernel
def state_at(floats, n, i, step):
    """A record of a row of numbers, with a Vec3, a record, a tuple and a uniform number in it."""
    x, y = load_lanes(floats, i), load_lanes(floats, n + i)
    word = float_bits(x + y)
    return State(Vec3(x, y, x - y), x * y, Key(word, (word & 1) != 0), step, (y, x + 2.0 * y))


@kernel
def write_state(out, n, i, s):
    store_lanes(out, i, s.p.x)
    store_lanes(out, n + i, s.p.y)
    store_lanes(out, 2 * n + i, s.p.z)
    store_lanes(out, 3 * n + i, s.x)
    store_lanes(out, 4 * n + i, where(s.key.odd, 1.0, 2.0))
    store_lanes(out, 5 * n + i, s.pair[0])
    store_lanes(out, 6 * n + i, s.pair[1])
    store_lanes(out, 7 * n + i, where(s.steps > 3, 1.0, 0.0) + s.x)


@kernel
def write_words(words, i, s):
    store_lanes(words, i, s.key.word)


@kernel
def choose(floats, n, whole, words, by_field, words_by_field):
    for i in range(0, n, LANES):
        a, b = state_at(floats, n, i, 3), state_at(floats, n, (i + LANES) % n, 4)
        mask = load_lanes(floats, n + i) > 0.0
        s = where(mask, a, b)
        write_state(whole, n, i, s)
        write_words(words, i, s)
        # Field by field, as one would write it without records.
        s = State(
            Vec3(where(mask, a.p.x, b.p.x), where(mask, a.p.y, b.p.y), where(mask, a.p.z, b.p.z)),
            where(mask, a.x, b.x),
            Key(where(mask, a.key.word, b.key.word), where(mask, a.key.odd, b.key.odd)),
            where(mask, a.steps, b.steps),
            (where(mask, a.pair[0], b.pair[0]), where(mask, a.pair[1], b.pair[1])),
        )
        write_state(by_field, n, i, s)
        write_words(words_by_field, i, s)


@kernel
def choose_by_one_bit(floats, n, first, out):
    for i in range(0, n, LANES):
        a, b = state_at(floats, n, i, 3), state_at(floats, n, i, 4)
        b = replace(b, x=2.0 * b.x)
        write_state(out, n, i, where(first > 0, a, b))


@kernel
def replace_some(floats, n, changed, expected):
    for i in range(0, n, LANES):
        s = state_at(floats, n, i, 3)
        # A field may take another type, and a record in it another field.
        t = replace(s, x=1.5, key=replace(s.key, odd=s.x > 0.0), p=s.p + 1.0, steps=5)
        write_state(changed, n, i, t)
        t = State(s.p + 1.0, 1.5, Key(s.key.word, s.x > 0.0), 5, s.pair)
        write_state(expected, n, i, t)


def numbers(n=64):
    return np.random.default_rng(5).normal(size=2 * n).astype(np.float32)


@pytest.mark.parametrize("compiled", [True, False], ids=["machine code", "twin"])
def test_a_whole_record_is_chosen_as_its_fields_are(compiled):
    n = 64
    outs = [View(np.zeros(m * n, k)) for m, k in ((ROWS, np.float32), (1, np.uint32)) * 2]
    instantiate(choose, compiled=compiled)(View(numbers(n)), n, *outs)
    whole, words, by_field, words_by_field = (view.array for view in outs)
    np.testing.assert_array_equal(whole, by_field)
    np.testing.assert_array_equal(words, words_by_field)
    chosen, x = whole.reshape(ROWS, n)[0], numbers(n)[:n]
    mask = numbers(n)[n:] > 0.0
    np.testing.assert_array_equal(chosen[mask], x[mask])
    assert (chosen != x).any()


def test_machine_code_chooses_as_the_twin_does():
    n, found = 64, []
    for compiled in (True, False):
        # The other packet is the next one: with packets of another width it is not the twin's.
        out = View(np.zeros(ROWS * n, np.float32))
        instantiate(choose_by_one_bit, compiled=compiled)(View(numbers(n)), n, 0, out)
        found.append(out.array)
    np.testing.assert_allclose(*found, rtol=1e-6)


@pytest.mark.parametrize("compiled", [True, False], ids=["machine code", "twin"])
def test_one_bit_chooses_for_all_lanes(compiled):
    n, x = 64, numbers(64)[:64] * numbers(64)[64:]
    for first, factor in ((1, 1.0), (0, 2.0)):
        out = View(np.zeros(ROWS * n, np.float32))
        instantiate(choose_by_one_bit, compiled=compiled)(View(numbers(n)), n, first, out)
        rows = out.array.reshape(ROWS, n)
        np.testing.assert_allclose(rows[3], factor * x, rtol=1e-6)
        # steps is 3 or 4: it stays a uniform number.
        np.testing.assert_allclose(rows[7], factor * x + (1 - first), rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("compiled", [True, False], ids=["machine code", "twin"])
def test_replace_changes_the_named_fields_only(compiled):
    n = 64
    changed, expected = (View(np.zeros(ROWS * n, np.float32)) for _ in range(2))
    instantiate(replace_some, compiled=compiled)(View(numbers(n)), n, changed, expected)
    np.testing.assert_array_equal(changed.array, expected.array)
    assert (changed.array.reshape(ROWS, n)[3] == 1.5).all()


@kernel
def misspelt(floats, out):
    s = state_at(floats, 64, 0, 3)
    write_state(out, 64, 0, replace(s, y=s.x))


@pytest.mark.parametrize("compiled", [True, False], ids=["machine code", "twin"])
def test_a_field_that_does_not_exist_is_an_error(compiled):
    out = View(np.zeros(ROWS * 64, np.float32))
    with pytest.raises(
        (TypingError, ValueError, TypeError), match=r"no field y|field names.*y|'y'"
    ):
        instantiate(misspelt, compiled=compiled)(View(numbers()), out)


@kernel
def mixed(floats, out):
    s = state_at(floats, 64, 0, 3)
    store_lanes(out, 0, where(s.x > 0.0, s.key, s.pair)[0])


@pytest.mark.parametrize("compiled", [True, False], ids=["machine code", "twin"])
def test_records_of_different_kinds_cannot_be_blended(compiled):
    out = View(np.zeros(64, np.float32))
    with pytest.raises((TypingError, TypeError)):
        instantiate(mixed, compiled=compiled)(View(numbers()), out)


ROOM = 2 * int(LANES)


@kernel
def store_and_load(floats, n, out):
    i = 0
    state = state_at(floats, n, i, 3)
    memory = local_records(ROOM, state)
    order = packing(state.x > 0.0)
    put_records(memory, ROOM, 0, order, state)
    # The next record starts in the middle of the first.
    put_records(memory, ROOM, 3, order, replace(state, x=-state.x, steps=9))
    found = records_at(memory, ROOM, 3, replace(state, steps=5))
    write_state(out, LANES, 0, replace(found, x=state.x))
    store_lanes(out, 7 * LANES, found.x + where(found.steps == 5, 0.0, 1.0))
    # What lies before was written first, and is still there.
    store_lanes(out, 8 * LANES, records_at(memory, ROOM, 0, state).x)


@pytest.mark.parametrize("compiled", [True, False], ids=["machine code", "twin"])
def test_records_are_stored_reordered_and_loaded_as_they_were(compiled):
    lanes = np.zeros(1, np.uint32)
    instantiate(count_lanes_of_a_packet, compiled=compiled)(View(lanes))
    w, n = int(lanes[0]), 64
    out = View(np.zeros(ROWS * w, np.float32))
    instantiate(store_and_load, compiled=compiled)(View(numbers(n)), n, out)
    p_x, p_y, p_z, x, odd, first, second, changed, before = out.array.reshape(ROWS, w)
    a, b = numbers(n)[:w], numbers(n)[n : n + w]
    order = np.argsort(~(a * b > 0.0), kind="stable")
    np.testing.assert_array_equal(p_x, a[order])
    np.testing.assert_array_equal(p_y, b[order])
    np.testing.assert_allclose(p_z, (a - b)[order], rtol=1e-6, atol=1e-7)
    np.testing.assert_array_equal(x, a * b)
    words = (a + b).view(np.uint32)[order]
    np.testing.assert_array_equal(odd, np.where(words & 1, 1.0, 2.0))
    np.testing.assert_array_equal(first, b[order])
    np.testing.assert_allclose(second, (a + 2.0 * b)[order], rtol=1e-6, atol=1e-7)
    np.testing.assert_array_equal(changed, -(a * b)[order])
    np.testing.assert_array_equal(before[:3], (a * b)[order][:3])


@kernel
def count_lanes_of_a_packet(out):
    out[0] = as_uint(LANES)


def test_a_record_takes_as_many_rows_as_it_has_components():
    """Memory is made for so many; what is uniform stays where it is."""
    vector = Vec3Type(FLOATS)
    inner = types.NamedTuple((vector, MASK, types.int64), namedtuple("Inner", "v mask n"))
    outer = types.NamedTuple((UINTS, inner, vector), namedtuple("Outer", "x inner v"))
    rows = [_count_rows(kind) for kind in (FLOATS, types.int64, vector, inner, outer)]
    assert rows == [1, 0, 3, 4, 8]


class Becomes(NamedTuple):
    """A type that is another one after pickling."""

    name: str

    def __reduce__(self):
        return str, (self.name,)


def test_types_that_pickling_changes_are_not_kept():
    assert not kept_functions.comes_back(Becomes("float32"))


def test_only_types_of_records_that_can_be_found_again_are_kept():
    Local = namedtuple("Local", "x")
    assert kept_functions.comes_back(typeof(Key(1, True)))
    assert not kept_functions.comes_back(typeof(Local(1)))
