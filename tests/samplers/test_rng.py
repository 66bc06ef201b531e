"""The counter-based hash: avalanche, equidistribution, and no ties between neighbouring streams."""

import numpy as np
import pytest
from scipy import stats

from alight.core.rng import (
    M1,
    M2,
    M3,
    M4,
    hash_1,
    hash_2,
    mix,
    pcg4d,
    pixel_keys,
    sample_keys,
    unit_float,
)
from lanewise.jit import instantiate, kernel
from lanewise.simd import LANES, load_lanes, store_lanes
from lanewise.view import View

INPUTS = ("x", "y", "index", "dimension", "scramble", "seed")


def words(x, y, index, dimension, scramble, seed):
    """Both words of the hash, as the independent sampler makes them; shape (2, n)."""
    a, b = pixel_keys(x, y, scramble, seed)
    a, b = sample_keys(a, b, index)
    return np.stack(hash_2(a, b, dimension))


def u32(values):
    return np.asarray(values).astype(np.uint32)


def natural_inputs(n, seed):
    """Inputs as a render has them: small numbers, most of whose bits are 0."""
    rng = np.random.default_rng(seed)
    highest = (4096, 4096, 1024, 64, 4, 100)
    return [rng.integers(0, h, n).astype(np.uint32) for h in highest]


@pytest.mark.parametrize("place", range(6), ids=INPUTS)
def test_every_input_bit_flips_every_output_bit_half_the_time(place):
    n = 1 << 14
    inputs = natural_inputs(n, place)
    before = words(*inputs)
    worst = 0.0
    for bit in range(32):
        changed = list(inputs)
        changed[place] = inputs[place] ^ np.uint32(1 << bit)
        flipped = before ^ words(*changed)
        for k in range(32):
            share = (flipped >> np.uint32(k) & np.uint32(1)).mean(axis=1)
            worst = max(worst, float(np.abs(share - 0.5).max()))
    # 2048 comparisons, each with a standard deviation of 0.5 / sqrt(n); 6 of them: p = 4e-6.
    assert worst < 6 * 0.5 / np.sqrt(n)


def chi_squared_of_pairs(u, v, cells):
    """p-value of the pairs being spread evenly over cells x cells squares."""
    counts = np.bincount(
        (u * cells).astype(int) * cells + (v * cells).astype(int), minlength=cells * cells
    )
    return stats.chisquare(counts).pvalue


@pytest.mark.parametrize("step", [*INPUTS, "index, dimension"])
def test_neighbours_are_independent(step):
    """A number and its neighbour along one of the inputs fill the square evenly, in all places.

    The diagonal neighbour too: the streams of two samples must not be shifted copies.
    """
    n = 1 << 18
    inputs = natural_inputs(n, 7)
    # Each stream once only: repeated ones would make the counts too uneven.
    inputs[0] = np.arange(n, dtype=np.uint32) & np.uint32(511)
    inputs[1] = np.arange(n, dtype=np.uint32) >> np.uint32(9)
    for k in range(2, 6):
        inputs[k][:] = 3
    neighbour = list(inputs)
    for name, sign in zip(step.split(", "), (1, -1), strict=False):
        place = INPUTS.index(name)
        # Beyond the pixels at hand, so that no number is counted twice.
        neighbour[place] = inputs[place] + u32(sign * (512 if place < 2 else 1))
    u, v = unit_float(words(*inputs)), unit_float(words(*neighbour))
    for a in (0, 1):
        for b in (0, 1):
            assert 1e-5 < chi_squared_of_pairs(u[a], v[b], 64) < 1 - 1e-5
            assert abs(np.corrcoef(u[a], v[b])[0, 1]) < 5 / np.sqrt(n)
    assert chi_squared_of_pairs(u[0], u[1], 64) > 1e-5


@pytest.mark.parametrize("along", ["index", "dimension"])
def test_numbers_of_one_pixel_fill_the_interval(along):
    """Kolmogorov and Smirnov's test of 2^16 numbers of one stream, and of their lowest 8 bits."""
    n = 1 << 16
    counter, zero = np.arange(n, dtype=np.uint32), np.zeros(n, np.uint32)
    other = zero + np.uint32(5)
    index, dimension = (counter, other) if along == "index" else (other, counter)
    pair = words(zero + 1, zero + 2, index, dimension, zero, zero)
    assert chi_squared_of_pairs(*unit_float(pair), 32) > 1e-5
    for w in pair:
        assert stats.kstest(unit_float(w), "uniform").pvalue > 1e-5
        low = np.bincount(w & np.uint32(0xFF), minlength=256)
        assert stats.chisquare(low).pvalue > 1e-5


def test_pixels_do_not_share_keys():
    x, y = (c.ravel().astype(np.uint32) for c in np.meshgrid(np.arange(512), np.arange(512)))
    keys = []
    for scramble in range(2):
        a, b = pixel_keys(x, y, scramble, 0)
        keys.append(a.astype(np.uint64) << np.uint64(32) | b)
    both = np.concatenate(keys)
    assert np.unique(both).size == both.size
    # Each half alone: as many ties as among random words (birthday problem).
    n = both.size
    expected = n * (n - 1) / 2 / 2**32
    for half in (both >> np.uint64(32), both & np.uint64(0xFFFFFFFF)):
        ties = n - np.unique(half).size
        assert abs(ties - expected) < 6 * np.sqrt(expected)


def undone(word, *steps):
    """The word that a chain was begun with.

    Its steps in the order in which they were taken: ``("^", k)`` for ``x ^ (x >> k)``, ``("*", m)``
    for an odd factor, ``("+", c)`` for a summand.
    """
    word = u32(word)
    for kind, value in reversed(steps):
        if kind == "^":
            hashed = word
            for _ in range(32 // value):
                word = hashed ^ (word >> u32(value))
        elif kind == "*":
            word = word * u32(pow(value, -1, 2**32))
        else:
            word = word - u32(value)
    return word


def undone_pcg4d(x, y, z, w):
    """The four words before the hash of Jarzynski and Olano (2020), listing 15, run backwards."""
    for last in (False, True):
        w = w - y * z
        z = z - x * y
        y = y - z * x
        x = x - y * w
        steps = [("*", 1664525), ("+", 1013904223)] if last else [("^", 16)]
        x, y, z, w = (undone(word, *steps) for word in (x, y, z, w))
    return x, y, z, w


def test_every_hash_can_be_run_backwards_as_it_was_published():
    """To its arguments, step by step: none is left out, and none is another one."""
    n = 4096
    x, y, seed, scramble, index = (
        np.random.default_rng(5).integers(0, 2**32, (5, n)).astype(np.uint32)
    )
    for found, given in zip(
        undone_pcg4d(*pcg4d(x, y, seed, index)), (x, y, seed, index), strict=True
    ):
        np.testing.assert_array_equal(found, given)
    np.testing.assert_array_equal(
        undone(mix(x), ("^", 16), ("*", M1), ("^", 15), ("*", M2), ("^", 15)), x
    )
    # Keys of a pixel are two of the four words, hashed once more.
    a, b = pixel_keys(x, y, scramble, seed)
    _, _, r, s = pcg4d(x, y, y + scramble, x + seed)
    np.testing.assert_array_equal(undone(a, ("^", 16), ("*", M3), ("^", 15)), r)
    np.testing.assert_array_equal(undone(b, ("^", 16), ("*", M4), ("^", 15)), s)
    of_sample = sample_keys(a, b, index)
    np.testing.assert_array_equal(of_sample[0], mix(a + index))
    np.testing.assert_array_equal(undone(of_sample[1] - b, ("*", M3)), a + index)
    # Words of a stream: the second key comes in half-way, and again for the second word.
    first, second = hash_2(a, b, index)
    np.testing.assert_array_equal(first, hash_1(a, b, index))
    half = undone(first, ("*", M2), ("^", 15))
    half = undone(half, ("^", 15)) - b
    np.testing.assert_array_equal(undone(half, ("^", 16), ("*", M1)), a + index)
    np.testing.assert_array_equal(
        undone(second, ("*", M3), ("^", 16), ("*", M4), ("^", 15)), first + b
    )


def test_unit_float_stays_below_one():
    u = unit_float(np.array([0, 1, 255, 256, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF], np.uint32))
    expected = np.array([0, 0, 0, 2.0**-24, 0.5 - 2.0**-24, 0.5, 1 - 2.0**-24], np.float32)
    assert u.dtype == np.float32
    np.testing.assert_array_equal(u, expected)


@kernel
def all_words(inputs, out):
    """Five words for each packet of six inputs."""
    for i in range(0, out.size // 5, LANES):
        k = 6 * i
        x, y = load_lanes(inputs, k), load_lanes(inputs, k + LANES)
        index, dimension = load_lanes(inputs, k + 2 * LANES), load_lanes(inputs, k + 3 * LANES)
        scramble, seed = load_lanes(inputs, k + 4 * LANES), load_lanes(inputs, k + 5 * LANES)
        a, b = pixel_keys(x, y, scramble, seed)
        a, b = sample_keys(a, b, index)
        first, second = hash_2(a, b, dimension)
        k = 5 * i
        store_lanes(out, k, a)
        store_lanes(out, k + LANES, b)
        store_lanes(out, k + 2 * LANES, first)
        store_lanes(out, k + 3 * LANES, second)
        store_lanes(out, k + 4 * LANES, hash_1(a, b, dimension))


def test_compiled_words_are_the_twins():
    """Machine code and NumPy give the same bits for words from the whole range of u32."""
    from lanewise.machine import lanes_of_machine

    n, lanes = 4096, lanes_of_machine()
    inputs = np.random.default_rng(3).integers(0, 2**32, (6, n)).astype(np.uint32)
    blocks = np.ascontiguousarray(inputs.reshape(6, -1, lanes).swapaxes(0, 1))
    out = View(np.zeros(5 * n, np.uint32))
    instantiate(all_words)(View(blocks), out)
    found = out.array.reshape(-1, 5, lanes).swapaxes(0, 1).reshape(5, n)
    x, y, index, dimension, scramble, seed = inputs
    a, b = sample_keys(*pixel_keys(x, y, scramble, seed), index)
    expected = np.stack([a, b, *hash_2(a, b, dimension), hash_1(a, b, dimension)])
    np.testing.assert_array_equal(found, expected)
