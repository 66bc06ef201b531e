"""What every sampler promises, and what each one's name promises."""

import numpy as np
import pytest
from scipy import stats

from alight.laws import samplers as laws
from alight.laws.samplers import FAR, compiled_and_twin, replicates, sequence, twin, u32
from alight.samplers import MODELS
from alight.samplers.halton import PRIMES, Halton
from alight.samplers.multijittered import Multijittered
from alight.samplers.sobol import Sobol
from alight.samplers.stratified import Stratified

EXAMPLES = [example for module in MODELS for example in module.EXAMPLES]

# ---------------------------------------------------------------- every sampler


@pytest.mark.parametrize("spec", EXAMPLES, ids=repr)
def test_numbers_lie_in_the_unit_interval(spec):
    laws.numbers_lie_in_the_unit_interval(spec)


@pytest.mark.parametrize("spec", EXAMPLES, ids=repr)
def test_each_number_alone_is_uniform(spec):
    """Over many pixels, whatever the sample index: no index is worth more than another."""
    laws.each_number_alone_is_uniform(spec)


@pytest.mark.parametrize("spec", EXAMPLES, ids=repr)
def test_extending_repeats_nothing_and_changes_nothing(spec):
    laws.extending_changes_nothing(spec)


@pytest.mark.parametrize("spec", EXAMPLES, ids=repr)
def test_dimension_may_differ_between_lanes(spec):
    laws.dimension_may_differ_between_lanes(spec)


@pytest.mark.parametrize("spec", [module.EXAMPLES[0] for module in MODELS], ids=repr)
def test_worst_pairs_of_dimensions_are_not_correlated(spec):
    laws.pairs_of_dimensions_are_not_correlated(spec)


@pytest.mark.parametrize("spec", [module.EXAMPLES[0] for module in MODELS], ids=repr)
def test_neighbours_are_not_correlated(spec):
    laws.neighbours_are_not_correlated(spec)


@pytest.mark.parametrize("spec", [module.EXAMPLES[0] for module in MODELS], ids=repr)
def test_error_falls_at_the_declared_rate(spec):
    laws.error_falls_at_the_declared_rate(spec)


# ---------------------------------------------------------------- each by its name


@pytest.mark.parametrize("model", [Stratified, Multijittered])
@pytest.mark.parametrize("n", [1, 2, 4, 5, 7])
def test_each_cell_of_a_block_is_hit_once(model, n):
    cells = n * n
    for block in (0, 1, 1000):
        state = sequence(cells, first=block * cells)
        x, y = twin(model(strata=n))(state, 4)
        cell = (x * n).astype(int) * n + (y * n).astype(int)
        assert sorted(cell) == list(range(cells))
        u = twin(model(strata=n), False)(state, 4)
        assert sorted((u * cells).astype(int)) == list(range(cells))
        if model is Multijittered:
            for c in (x, y):
                assert sorted((c.astype(np.float64) * cells).astype(int)) == list(range(cells))


def test_blocks_visit_their_cells_in_different_orders():
    x, y = twin(Stratified(strata=4))(sequence(16 * 500), 4)
    order = ((x * 4).astype(int) * 4 + (y * 4).astype(int)).reshape(500, 16)
    assert np.unique(order, axis=0).shape[0] == 500
    # Each cell comes at each place equally often, and each pair of cells in each order.
    counts = np.stack([np.bincount(order[:, k], minlength=16) for k in range(16)])
    assert stats.chisquare(counts.ravel(), ddof=30).pvalue > 1e-4
    place = np.argsort(order, axis=1)
    first = (place[:, :, None] < place[:, None, :]).mean(axis=0)[np.triu_indices(16, 1)]
    assert np.abs(first - 0.5).max() < 5 * 0.5 / np.sqrt(500)


@pytest.mark.parametrize("n", [3, 5, 12, 49, 100])
def test_permutations_of_any_length(n):
    """Each key permutes, and all positions are equally likely."""
    from alight.samplers.permutation import make_permute

    keys = u32(np.random.default_rng(n).integers(0, 2**32, 2000))
    permuted = np.stack([make_permute(n)(u32(np.full(2000, i)), keys) for i in range(n)])
    assert (np.sort(permuted, axis=0) == np.arange(n)[:, None]).all()
    counts = np.stack([np.bincount(row, minlength=n) for row in permuted])
    assert stats.chisquare(counts.ravel(), ddof=2 * n - 2).pvalue > 1e-5


@pytest.mark.parametrize("dimension", [0, 1, 8, 41, FAR])
@pytest.mark.parametrize("first", [0, 1024 * 77])
def test_sobol_pairs_are_nets(dimension, first):
    """Each dyadic rectangle of area 2^-k holds one of 2^k samples: a (0, k, 2)-net in base 2."""
    x, y = (c.astype(np.float64) for c in twin(Sobol())(sequence(1024, first), dimension))
    u = twin(Sobol(), False)(sequence(1024, first), dimension).astype(np.float64)
    for k in range(11):
        n = 2**k
        assert np.unique((u[:n] * n).astype(int)).size == n
        for columns in (2**i for i in range(k + 1)):
            rows = n // columns
            cell = (x[:n] * columns).astype(int) * rows + (y[:n] * rows).astype(int)
            assert np.unique(cell).size == n


def test_second_sobol_dimension_is_the_published_one():
    """Against SciPy's tables (Joe and Kuo 2008), which come in Gray code order."""
    from alight.samplers.sobol import _second_dimension
    from lanewise.simd import reverse_bits

    k = u32(np.arange(4096))
    found = reverse_bits(_second_dimension(k ^ (k >> u32(1)))) / 2.0**32
    expected = stats.qmc.Sobol(2, scramble=False, bits=32).random(4096)[:, 1]
    np.testing.assert_array_equal(found, expected)


def rank(columns):
    """Of a matrix over the field of two elements, from its columns as whole numbers."""
    found = 0
    columns = list(columns)
    while columns:
        pivot = columns.pop()
        if pivot:
            found += 1
            low = pivot & -pivot
            columns = [c ^ pivot if c & low else c for c in columns]
    return found


def test_the_third_seed_of_a_pair_is_independent_of_either_other_one():
    """Any half of it, together with any half of one of the others: 32 bits, all random."""
    from alight.samplers.sobol import _third_seed

    bit, none = u32(1) << u32(np.arange(32)), u32(np.zeros(32))
    # What each bit of the two seeds does to the three: it is linear.
    seeds = [np.concatenate(pair).astype(object) for pair in ((bit, none), (none, bit))]
    third = np.concatenate([_third_seed(bit, none), _third_seed(none, bit)]).astype(object)
    for other in seeds:
        for a in (0, 16):
            for b in (0, 16):
                halves = (third >> a & 0xFFFF) | (other >> b & 0xFFFF) << 16
                assert rank(halves.tolist()) == 32


def test_scrambling_is_the_published_one():
    """Vegdahl (2021), in Python's whole numbers."""
    from alight.samplers.owen import scramble_reversed

    words, seeds = np.random.default_rng(6).integers(0, 2**32, (2, 500))
    for word, seed, found in zip(
        words, seeds, scramble_reversed(u32(words), u32(seeds)), strict=True
    ):
        x = int(word)
        x ^= x * 0x3D20ADEA
        x += int(seed)
        x *= (int(seed) >> 16) | 1
        x ^= x * 0x05526C56
        x ^= x * 0x53A22864
        assert x % 2**32 == found


def test_scrambling_is_nested():
    """A digit is flipped depending on the digits above it only, half the time, independently."""
    from alight.samplers.owen import scramble_reversed

    rng = np.random.default_rng(2)
    n = 20_000
    word, seed = u32(rng.integers(0, 2**32, (2, n)))
    for k in range(12):
        # The same first k digits (lowest bits) and another one behind them.
        other = (word & u32(2**k - 1)) | (~word & u32(2**k)) | u32(rng.integers(0, 2**19, n) << 13)
        a, b = scramble_reversed(word, seed), scramble_reversed(other, seed)
        assert ((a ^ b) & u32(2 ** (k + 1) - 1) == 2**k).all()
        # Behind the first difference the flips of the two are independent.
        agree = (~(a ^ b ^ word ^ other) >> u32(k + 1) & u32(1)).mean()
        assert abs(agree - 0.5) < 5 * 0.5 / np.sqrt(n)
        flipped = ((a ^ word) >> u32(k) & u32(1)).mean()
        assert abs(flipped - 0.5) < 5 * 0.5 / np.sqrt(n)


def test_sobol_digits_are_scrambled_to_the_last():
    """No two pixels share their points, however fine one looks; all 24 digits are random."""
    n = 4096
    x, y = twin(Sobol())(replicates(1, n), 0)
    for c in (x, y):
        digits = (c * np.float32(2**24)).astype(np.uint32)
        share = [(digits >> u32(k) & u32(1)).mean() for k in range(24)]
        assert np.abs(np.array(share) - 0.5).max() < 5 * 0.5 / np.sqrt(n)


@pytest.mark.parametrize("dimension", [0, 1, 2, 5, 20, 39])
def test_halton_is_even_in_its_base(dimension):
    base = PRIMES[dimension]
    u = twin(Halton(), False)(sequence(base**2), dimension).astype(np.float64)
    for n in (base, base**2):
        # One number in each cell; sums of rounded digits may end a little above it.
        np.testing.assert_allclose(np.sort(u[:n]) * n, np.arange(n) + 0.5, atol=0.5 + n * 2.0**-23)


def test_halton_pair_is_even_in_both_bases():
    n = 2**4 * 3**3
    x, y = (c.astype(np.float64) for c in twin(Halton())(sequence(n), 0))
    cell = (x * 16).astype(int) * 27 + (y * 27).astype(int)
    assert sorted(cell) == list(range(n))


def test_halton_divides_exactly():
    from alight.samplers.halton import _divide

    rng = np.random.default_rng(0)
    for prime in PRIMES:
        multiples = rng.integers(1, 2**32 // prime, 2000) * prime
        ends = np.concatenate([np.arange(500), 2**32 - 1 - np.arange(500)])
        n = u32(np.concatenate([rng.integers(0, 2**32, 5000), ends, multiples, multiples - 1]))
        inverse = np.float32(1.0) / np.float32(prime)
        np.testing.assert_array_equal(_divide(n, u32(np.full(n.size, prime)), inverse), n // prime)


# ---------------------------------------------------------------- machine code


@pytest.mark.parametrize("spec", [module.EXAMPLES[-1] for module in MODELS], ids=repr)
def test_compiled_numbers_are_the_twins(spec):
    if spec.type_name() in ("independent", "sobol"):
        found, expected = compiled_and_twin(spec)
        np.testing.assert_array_equal(found, expected)
    else:
        laws.compiled_numbers_are_the_twins(spec)
