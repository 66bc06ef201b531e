"""Laws of samplers: uniform, independent where they must be, as good as they declare.

Each law is a function of an example and raises `BrokenLawError`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from alight.compiled.program import Program
from alight.core.registry import versions
from alight.core.spec import Sampler
from alight.laws.report import demand, demand_close
from alight.laws.statistics import SIGNIFICANCE, chi_square_tail, uniform_p_value
from alight.samplers.model import SAMPLERS
from alight.samplers.sampling import get_1d, get_2d, sampler_key, sampler_state
from lanewise.jit import instantiate, kernel
from lanewise.machine import lanes_of_machine
from lanewise.simd import LANES, load_lanes, store_lanes
from lanewise.view import View

#: A dimension of a long path.
FAR = 1000


def program_of(spec: Sampler) -> Program:
    """A program with this sampler and nothing else of interest."""
    return Program(sampler=sampler_key(spec), registered=versions([spec]))


def twin(spec: Sampler, pair: bool = True):
    """``get_2d`` or ``get_1d`` of a sampler on NumPy arrays."""
    return instantiate(get_2d if pair else get_1d, program_of(spec), compiled=False)


def u32(values) -> Any:
    """Values as lanes of u32."""
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


# ---------------------------------------------------------------- every example


def numbers_lie_in_the_unit_interval(spec: Sampler) -> None:
    """Numbers are float32 in [0, 1), and reach both ends."""
    index = u32([0, 1, 2, 15, 16, 17, 255, 2**16, 2**24 + 1, 2**31 - 1, 2**31, 2**32 - 1])
    for pixel in range(64):
        state = sampler_state(u32(index * 0 + pixel), index, index, 3, 2**32 - 1)
        for dimension in (0, 1, 8, 38, 39, 40, FAR):
            for u in (twin(spec, False)(state, dimension), *twin(spec)(state, dimension)):
                demand(u.dtype == np.float32, f"numbers must be float32, are {u.dtype}")
                demand((u >= 0.0) & (u < 1.0), f"a number is outside [0, 1): {u.max()}")
    many = sequence(1 << 16)
    u = np.stack([*twin(spec)(many, 4), twin(spec, False)(many, 4)])
    demand((u >= 0.0) & (u < 1.0), f"a number is outside [0, 1): {u.max()}")
    # P(no number lies below x) = (1 - x)^n, about exp(-n x).
    edge = -np.log(SIGNIFICANCE) / u.size
    demand(u.min() < edge and u.max() > 1.0 - edge, f"{u.min():.3g} to {u.max():.3g} only")


def each_number_alone_is_uniform(spec: Sampler) -> None:
    """Over many pixels, the numbers of each sample index are uniform."""
    n = 1 << 14
    pixel = u32(np.arange(n))
    for index in (0, 1, 13, 100_000):
        state = sampler_state(pixel & u32(127), pixel >> u32(7), u32(np.full(n, index)), 2, 9)
        for dimension in (0, 8, FAR):
            x, y = twin(spec)(state, dimension)
            counts = np.histogram2d(x, y, bins=16, range=[[0, 1], [0, 1]])[0]
            expected = n / counts.size
            statistic = float(((counts - expected) ** 2 / expected).sum())
            p = chi_square_tail(statistic, counts.size - 1)
            demand(p > SIGNIFICANCE, f"sample {index}, dimension {dimension}: p = {p:.2g} of pairs")
            p = uniform_p_value(twin(spec, False)(state, dimension), 256)
            demand(p > SIGNIFICANCE, f"sample {index}, dimension {dimension}: p = {p:.2g}")


def extending_changes_nothing(spec: Sampler) -> None:
    """Samples 32 to 63 of a sequence of 64 are those that start at 32; none repeats."""
    whole, rest = twin(spec)(sequence(64), 10), twin(spec)(sequence(32, first=32), 10)
    for a, b in zip(whole, rest, strict=True):
        demand(a[32:] == b, "a sample depends on where the sequence starts")
        demand(np.unique(a).size == 64, "a number is repeated")


def dimension_may_differ_between_lanes(spec: Sampler) -> None:
    """The dimension may differ between lanes."""
    state = sequence(96)
    dimensions = u32(np.tile([0, 8, 38, 39, 40, FAR], 16))
    both, one = twin(spec)(state, dimensions), twin(spec, False)(state, dimensions)
    for d in np.unique(dimensions):
        at = dimensions == d
        for a, b in zip(both, twin(spec)(state, int(d)), strict=True):
            demand(a[at] == b[at], f"get_2d of dimension {d} depends on the other lanes")
        single = twin(spec, False)(state, int(d))
        demand(one[at] == single[at], f"get_1d of dimension {d} depends on the other lanes")


# ---------------------------------------------------------------- the first example


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


def pairs_of_dimensions_are_not_correlated(spec: Sampler) -> None:
    """Products of functions of two dimensions vary no more than WORST_GAIN says.

    All pairs among 15 dimensions of a path, all products of Walsh functions; plain Monte Carlo has
    the variance 1, which is also the limit where a sampler declares none.
    """
    n, pixels = 16, 2048
    state = replicates(n, pixels)
    values = []
    for dimension in (0, 2, 9, 12, 25, FAR):
        values += [c.reshape(pixels, n) for c in twin(spec)(state, dimension)]
    pairs = len(values)
    values += [twin(spec, False)(state, dimension).reshape(pixels, n) for dimension in (14, 15, 46)]
    # All but the two numbers of one pair.
    others = [
        (i, j) for i in range(len(values)) for j in range(i) if i >= pairs or i // 2 != j // 2
    ]
    worst = np.stack([gains(values[i], values[j]) for i, j in others])
    limit = SAMPLERS[spec.type_name()].WORST_GAIN
    # The square of a normal variable varies by sqrt(2) of its mean; 4 900 figures, 5 sigma.
    most = limit * (1 + 5 * np.sqrt(2 / pixels))
    demand(
        worst.max() < most, f"variance {worst.max():.3g} times Monte Carlo's, at most {most:.3g}"
    )
    mean, spread = worst.mean(), 0.2 * max(1.0, 0.5 * limit)
    demand(abs(mean - 1.0) < spread, f"on average {mean:.3g} times Monte Carlo's variance")


def neighbours_are_not_correlated(spec: Sampler) -> None:
    """The same dimension of neighbouring pixels, replicates and seeds.

    Errors of estimates must not be correlated: standard errors come from differences between
    replicates, and a pattern shared by neighbouring pixels would be seen.
    """
    n, pixels = 16, 4096
    state = replicates(n, pixels)
    integrands = (lambda x, y: x * x, lambda x, y: y * y, lambda x, y: np.exp(x) * np.cos(y))
    for what in ("x", "y", "scramble", "seed"):
        neighbour = sampler_state(*state._replace(**{what: getattr(state, what) + 1})[:5])
        for dimension in (0, 12, FAR):
            here, there = twin(spec)(state, dimension), twin(spec)(neighbour, dimension)
            for f in integrands:
                values = np.stack([f(*pair) for pair in (here, there)]).astype(np.float64)
                means = values.reshape(2, pixels, n).mean(axis=2)
                found = abs(np.asarray(np.corrcoef(means))[0, 1])
                demand(found < 5 / np.sqrt(pixels), f"another {what}: correlation {found:.3g}")


def smooth(x, y):
    """A smooth integrand on the square."""
    return np.exp(x) * np.cos(y + 0.5 * x * y)


def mean_squared_errors(with_block, counts, pair, pixels=256):
    """Of a smooth integrand, at each number of samples."""
    out = []
    node, weight = np.polynomial.legendre.leggauss(20)
    node, weight = 0.5 + 0.5 * node, 0.5 * weight
    exact_2d = weight @ smooth(node[:, None], node) @ weight
    for n in counts:
        state = replicates(n, pixels)
        if pair:
            x, y = (c.astype(np.float64) for c in twin(with_block(n))(state, 0))
            f, exact = smooth(x, y), exact_2d
        else:
            f = np.exp(twin(with_block(n), False)(state, 8).astype(np.float64))
            exact = np.e - 1.0
        out.append(((f.reshape(pixels, n).mean(axis=1) - exact) ** 2).mean())
    return np.array(out)


def error_falls_at_the_declared_rate(spec: Sampler) -> None:
    """The error of smooth integrands falls at the rate EXPECTED_RATE.

    The least-squares slope over N = 16 ... 1024; strata of blocks grow with N.
    """
    counts = np.array([16, 64, 256, 1024])

    for pair, declared in enumerate(SAMPLERS[spec.type_name()].EXPECTED_RATE):
        errors = mean_squared_errors(spec.with_block, counts, bool(pair))
        slope = np.polyfit(np.log(counts), np.log(errors), 1)[0]
        text = f"{pair + 1}-D: slope {slope:.3g}, declared {declared}"
        demand(abs(slope - declared) < 0.3, text)


# ---------------------------------------------------------------- machine code


@kernel
def three_numbers(inputs, scramble, seed, out):
    """A pair and a single number for each packet of x, y, index, dimension."""
    for i in range(0, out.size // 3, LANES):
        k = 4 * i
        state = sampler_state(
            load_lanes(inputs, k),
            load_lanes(inputs, k + LANES),
            load_lanes(inputs, k + 2 * LANES),
            scramble,
            seed,
        )
        dimension = load_lanes(inputs, k + 3 * LANES)
        x, y = get_2d(state, dimension)
        k = 3 * i
        store_lanes(out, k, x)
        store_lanes(out, k + LANES, y)
        store_lanes(out, k + 2 * LANES, get_1d(state, dimension))


def compiled_and_twin(spec: Sampler):
    """Numbers (3, n) by machine code and by NumPy for the same states."""
    n, lanes = 2048, lanes_of_machine()
    rng = np.random.default_rng(1)
    inputs = u32(rng.integers(0, 2**32, (4, n)))
    inputs[2, : n // 2] &= u32(255)
    inputs[3] &= u32(63)
    blocks = np.ascontiguousarray(inputs.reshape(4, -1, lanes).swapaxes(0, 1))
    out = View(np.zeros(3 * n, np.float32))
    instantiate(three_numbers, program_of(spec))(View(blocks), 3, 77, out)
    found = out.array.reshape(-1, 3, lanes).swapaxes(0, 1).reshape(3, n)
    state = sampler_state(inputs[0], inputs[1], inputs[2], 3, 77)
    return found, np.stack([*twin(spec)(state, inputs[3]), twin(spec, False)(state, inputs[3])])


def compiled_numbers_are_the_twins(spec: Sampler) -> None:
    """Machine code gives the numbers of the Python text."""
    found, expected = compiled_and_twin(spec)
    # A fused multiply and add rounds once where NumPy rounds twice.
    demand_close(found, expected, "compiled against Python", atol=2.0**-22)


#: Laws of every example, of the first one, and of the last one's machine code.
LAWS = (
    numbers_lie_in_the_unit_interval,
    each_number_alone_is_uniform,
    extending_changes_nothing,
    dimension_may_differ_between_lanes,
)
FIRST_LAWS = (
    pairs_of_dimensions_are_not_correlated,
    neighbours_are_not_correlated,
    error_falls_at_the_declared_rate,
)
COMPILED_LAWS = (compiled_numbers_are_the_twins,)
