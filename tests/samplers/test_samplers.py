"""What every sampler promises, and what each one's name promises."""

import numpy as np
import pytest
from scipy import stats

from alight.compiled.program import Program
from alight.core.jit import instantiate, kernel
from alight.core.machine import lanes_of_machine
from alight.core.simd import LANES, load_lanes, store_lanes
from alight.core.view import View
from alight.samplers import MODELS
from alight.samplers.halton import PRIMES, Halton
from alight.samplers.multijittered import Multijittered
from alight.samplers.sampling import get_1d, get_2d, sampler_key, sampler_state
from alight.samplers.sobol import Sobol
from alight.samplers.stratified import Stratified

EXAMPLES = [example for module in MODELS for example in module.EXAMPLES]
#: Beyond the dimensions that Halton has primes for.
FAR = 1000


def twin(spec, pair=True):
    """``get_2d`` or ``get_1d`` of a sampler on NumPy arrays."""
    function = get_2d if pair else get_1d
    return instantiate(function, Program(sampler=sampler_key(spec)), compiled=False)


def u32(values):
    return np.asarray(values).astype(np.uint32)


def sequence(n, first=0, pixel=(3, 7), scramble=1, seed=5):
    """State of n successive samples of one pixel."""
    index = u32(np.arange(first, first + n))
    x, y = (u32(np.full(n, coordinate)) for coordinate in pixel)
    return sampler_state(x, y, index, scramble, seed)


def replicates(n, pixels):
    """State of n samples in each of `pixels` pixels; results reshape to (pixels, n)."""
    x = u32(np.repeat(np.arange(pixels), n))
    return sampler_state(x & u32(63), x >> u32(6), u32(np.tile(np.arange(n), pixels)), 0, 5)


# ---------------------------------------------------------------- every sampler


@pytest.mark.parametrize("spec", EXAMPLES, ids=repr)
def test_numbers_lie_in_the_unit_interval(spec):
    index = u32([0, 1, 2, 15, 16, 17, 255, 2**16, 2**24 + 1, 2**31 - 1, 2**31, 2**32 - 1])
    for pixel in range(64):
        state = sampler_state(u32(index * 0 + pixel), index, index, 3, 2**32 - 1)
        for dimension in (0, 1, 8, 38, 39, 40, FAR):
            values = [twin(spec, False)(state, dimension), *twin(spec)(state, dimension)]
            for u in values:
                assert u.dtype == np.float32
                assert ((u >= 0.0) & (u < 1.0)).all()
    many = sequence(1 << 16)
    u = np.stack([*twin(spec)(many, 4), twin(spec, False)(many, 4)])
    assert ((u >= 0.0) & (u < 1.0)).all()
    # The ends of the interval are reached.
    assert u.min() < 1e-4
    assert u.max() > 1.0 - 1e-4


@pytest.mark.parametrize("spec", EXAMPLES, ids=repr)
def test_each_number_alone_is_uniform(spec):
    """Over many pixels, whatever the sample index: no index is worth more than another."""
    n = 1 << 14
    pixel = u32(np.arange(n))
    for index in (0, 1, 13, 100_000):
        state = sampler_state(pixel & u32(127), pixel >> u32(7), u32(np.full(n, index)), 2, 9)
        for dimension in (0, 8, FAR):
            x, y = twin(spec)(state, dimension)
            counts = np.histogram2d(x, y, bins=16, range=[[0, 1], [0, 1]])[0]
            assert stats.chisquare(counts.ravel()).pvalue > 1e-5
            u = twin(spec, False)(state, dimension)
            assert stats.kstest(u, "uniform").pvalue > 1e-5


@pytest.mark.parametrize("spec", EXAMPLES, ids=repr)
def test_extending_repeats_nothing_and_changes_nothing(spec):
    """Samples 32 ... 63 of a sequence of 64 are those that start at 32."""
    whole, rest = twin(spec)(sequence(64), 10), twin(spec)(sequence(32, first=32), 10)
    for a, b in zip(whole, rest, strict=True):
        np.testing.assert_array_equal(a[32:], b)
        assert np.unique(a).size == 64


@pytest.mark.parametrize("spec", EXAMPLES, ids=repr)
def test_dimension_may_differ_between_lanes(spec):
    state = sequence(96)
    dimensions = u32(np.tile([0, 8, 38, 39, 40, FAR], 16))
    both = twin(spec)(state, dimensions)
    one = twin(spec, False)(state, dimensions)
    for d in np.unique(dimensions):
        at = dimensions == d
        for a, b in zip(both, twin(spec)(state, int(d)), strict=True):
            np.testing.assert_array_equal(a[at], b[at])
        np.testing.assert_array_equal(one[at], twin(spec, False)(state, int(d))[at])


def walsh(u):
    """The first 7 Walsh functions of u (signs made of its first 3 binary digits); (7, ...)."""
    digits = [(u * 2**k).astype(np.uint32) & u32(1) for k in (1, 2, 3)]
    parity = [sum(digits[k] for k in range(3) if mask >> k & 1) & 1 for mask in range(1, 8)]
    return 1.0 - 2.0 * np.stack(parity).astype(np.float32)


def gains(u, v):
    """Variance of the mean of w_a(u) w_b(v), as a share of plain Monte Carlo's; (7, 7).

    `u` and `v` have shape (pixels, n). Shared structure makes some of the products add up: two
    equal sequences give n.
    """
    n = u.shape[1]
    sums = np.einsum("apn,bpn->abp", walsh(u), walsh(v)) / n
    return (sums**2).mean(axis=-1) * n


# Consecutive samples of a progressive sequence lie in opposite halves in *every* dimension, so
# their products of two first digits agree: 2. (Products of three cancel: on average nothing is
# lost.) The others permute whole blocks: n / (n - 1).
WORST_GAIN = {"sobol": 2.0, "halton": 2.0, "stratified": 16 / 15, "multijittered": 16 / 15}


@pytest.mark.parametrize("spec", [module.EXAMPLES[0] for module in MODELS], ids=repr)
def test_worst_pairs_of_dimensions_are_not_correlated(spec):
    """All pairs among 13 dimensions of a path, all products of Walsh functions."""
    n, pixels = 16, 2048
    state = replicates(n, pixels)
    values = []
    for dimension in (0, 2, 9, 12, 25, FAR):
        values += [c.reshape(pixels, n) for c in twin(spec)(state, dimension)]
    values.append(twin(spec, False)(state, 14).reshape(pixels, n))
    # All but the two numbers of one pair.
    others = [(i, j) for i in range(13) for j in range(i) if i // 2 != j // 2]
    worst = np.stack([gains(values[i], values[j]) for i, j in others])
    limit = WORST_GAIN.get(spec.type_name(), 1.0)
    # The square of a normal variable varies by sqrt(2) of its mean; 3 600 figures, 5 sigma.
    assert worst.max() < limit * (1 + 5 * np.sqrt(2 / pixels))
    assert abs(worst.mean() - 1.0) < 0.2


@pytest.mark.parametrize("what", ["x", "y", "scramble", "seed"])
@pytest.mark.parametrize("spec", [module.EXAMPLES[0] for module in MODELS], ids=repr)
def test_neighbours_are_not_correlated(spec, what):
    """The same dimension of neighbouring pixels, replicates and seeds.

    Errors of estimates must not be correlated: standard errors come from differences between
    replicates, and a pattern shared by neighbouring pixels would be seen.
    """
    n, pixels = 16, 4096
    state = replicates(n, pixels)
    moved = state._replace(**{what: getattr(state, what) + 1})
    neighbour = sampler_state(*moved[:5])
    for dimension in (0, 12, FAR):
        here, there = twin(spec)(state, dimension), twin(spec)(neighbour, dimension)
        for f in (lambda x, y: x * x, lambda x, y: y * y, lambda x, y: np.exp(x) * np.cos(y)):
            values = np.stack([f(*pair) for pair in (here, there)]).astype(np.float64)
            means = values.reshape(2, pixels, n).mean(axis=2)
            assert abs(np.corrcoef(means)[0, 1]) < 5 / np.sqrt(pixels)


def smooth(x, y):
    return np.exp(x) * np.cos(y + 0.5 * x * y)


def mean_squared_errors(spec_of, counts, pair, pixels=256):
    """Of a smooth integrand, at each number of samples."""
    out = []
    node, weight = np.polynomial.legendre.leggauss(20)
    node, weight = 0.5 + 0.5 * node, 0.5 * weight
    exact_2d = weight @ smooth(node[:, None], node) @ weight
    for n in counts:
        state = replicates(n, pixels)
        if pair:
            x, y = (c.astype(np.float64) for c in twin(spec_of(n))(state, 0))
            f, exact = smooth(x, y), exact_2d
        else:
            f = np.exp(twin(spec_of(n), False)(state, 8).astype(np.float64))
            exact = np.e - 1.0
        out.append(((f.reshape(pixels, n).mean(axis=1) - exact) ** 2).mean())
    return np.array(out)


@pytest.mark.parametrize("pair", [False, True], ids=["1-D", "2-D"])
@pytest.mark.parametrize("module", MODELS, ids=lambda m: m.__name__.rpartition(".")[2])
def test_error_falls_at_the_declared_rate(module, pair):
    """Least-squares slope over N = 16 ... 1024; strata of blocks grow with N."""
    counts = np.array([16, 64, 256, 1024])
    example = module.EXAMPLES[0]

    def spec_of(n):
        strata = hasattr(example, "strata")
        return example.replaced(strata=int(np.sqrt(n))) if strata else example

    errors = mean_squared_errors(spec_of, counts, pair)
    slope = np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert abs(slope - module.EXPECTED_RATE[pair]) < 0.3


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
    from alight.core.simd import reverse_bits
    from alight.samplers.sobol import _second_dimension

    k = u32(np.arange(4096))
    found = reverse_bits(_second_dimension(k ^ (k >> u32(1)))) / 2.0**32
    expected = stats.qmc.Sobol(2, scramble=False, bits=32).random(4096)[:, 1]
    np.testing.assert_array_equal(found, expected)


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


@kernel
def three_numbers(inputs, scramble, seed, out):
    """A pair and a single number for each packet of x, y, index, dimension."""
    for i in range(0, out.size // 3, LANES):
        k = 4 * i
        state = sampler_state(
            load_lanes(inputs, k), load_lanes(inputs, k + LANES),
            load_lanes(inputs, k + 2 * LANES), scramble, seed,
        )  # fmt: skip
        dimension = load_lanes(inputs, k + 3 * LANES)
        x, y = get_2d(state, dimension)
        k = 3 * i
        store_lanes(out, k, x)
        store_lanes(out, k + LANES, y)
        store_lanes(out, k + 2 * LANES, get_1d(state, dimension))


@pytest.mark.parametrize("spec", [module.EXAMPLES[-1] for module in MODELS], ids=repr)
def test_compiled_numbers_are_the_twins(spec):
    n, lanes = 2048, lanes_of_machine()
    rng = np.random.default_rng(1)
    inputs = u32(rng.integers(0, 2**32, (4, n)))
    inputs[2, : n // 2] &= u32(255)
    inputs[3] &= u32(63)
    blocks = np.ascontiguousarray(inputs.reshape(4, -1, lanes).swapaxes(0, 1))
    out = View(np.zeros(3 * n, np.float32))
    program = Program(sampler=sampler_key(spec))
    instantiate(three_numbers, program)(View(blocks), 3, 77, out)
    found = out.array.reshape(-1, 3, lanes).swapaxes(0, 1).reshape(3, n)
    state = sampler_state(inputs[0], inputs[1], inputs[2], 3, 77)
    expected = np.stack([*twin(spec)(state, inputs[3]), twin(spec, False)(state, inputs[3])])
    if spec.type_name() in ("independent", "sobol"):
        np.testing.assert_array_equal(found, expected)
    else:
        # A fused multiply and add rounds once where NumPy rounds twice.
        np.testing.assert_allclose(found, expected, atol=2.0**-22)
