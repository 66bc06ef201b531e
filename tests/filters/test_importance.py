"""Filter importance sampling: samples have the filter's density, weights average to 1."""

import itertools
from collections import namedtuple

import numpy as np
import pytest
from scipy import integrate, stats

from alight.compiled.program import Program
from alight.filters import MODELS
from alight.filters.box import Box
from alight.filters.gaussian import Gaussian
from alight.filters.importance import compile_filter, sample_filter
from alight.filters.inverse_cdf import tabulate
from alight.filters.mitchell import Mitchell, polynomial
from alight.filters.tent import Tent
from lanewise.jit import instantiate, kernel
from lanewise.machine import lanes_of_machine
from lanewise.simd import LANES, load_lanes, store_lanes
from lanewise.view import View

Tables = namedtuple("Tables", "filter")

EXAMPLES = [example for module in MODELS for example in module.EXAMPLES]
# At the ends of what descriptions allow: a mere spike, no outer part, all lobes.
CORNERS = [
    Gaussian(stddev=0.1, radius=16.0),
    Mitchell(b=0.0, c=0.0),
    Mitchell(b=0.0, c=1.0),
    Mitchell(b=1.0, c=1.0, radius=0.5),
]


def factor(spec):
    """One factor g of f(x, y) = g(x) g(y), from its definition, for distances within the radius."""
    if isinstance(spec, Box):
        return lambda x: np.ones_like(x)
    if isinstance(spec, Tent):
        return lambda x: spec.radius - np.abs(x)
    if isinstance(spec, Gaussian):
        s, r = spec.stddev, spec.radius
        return lambda x: np.exp(-(x**2) / (2 * s * s)) - np.exp(-(r**2) / (2 * s * s))
    b, c, half = spec.b, spec.c, spec.radius / 2

    def mitchell(x):
        x = np.abs(x) / half
        near = (12 - 9 * b - 6 * c) * x**3 + (-18 + 12 * b + 6 * c) * x**2 + (6 - 2 * b)
        far = (-b - 6 * c) * x**3 + (6 * b + 30 * c) * x**2 + (-12 * b - 48 * c) * x
        return np.where(x < 1, near, far + 8 * b + 24 * c)

    return mitchell


def moment(spec, power, signed=True):
    """Integral of x^power g (or |g|) over the filter."""
    g = factor(spec)
    x = np.linspace(-spec.radius, spec.radius, 200_001)
    y = g(x) if signed else np.abs(g(x))
    return integrate.simpson(y * x**power, x=x)


def samples(spec, n=1 << 18):
    """Offsets and weights for stratified u and u with random partners."""
    u = ((np.arange(n) + 0.5) / n).astype(np.float32)
    v = np.random.default_rng(4).permutation(u)
    run = instantiate(sample_filter, Program(filter=spec.type_name()), compiled=False)
    dx, dy, weight = run(Tables(compile_filter(spec)), (u, v))
    return dx, dy, np.broadcast_to(weight, u.shape).astype(np.float64)


@pytest.mark.parametrize("spec", EXAMPLES + CORNERS, ids=repr)
def test_offsets_stay_within_the_radius(spec):
    u = np.float32([0.0, 2.0**-24, 0.25, 0.5 - 2.0**-25, 0.5, 0.75, 1.0 - 2.0**-24])
    run = instantiate(sample_filter, Program(filter=spec.type_name()), compiled=False)
    dx, dy, _ = run(Tables(compile_filter(spec)), (u, u[::-1].copy()))
    for d in (dx, dy):
        assert d.dtype == np.float32
        assert (np.abs(d) <= np.float32(spec.radius)).all()
    # A larger u never gives a smaller offset, so that strata of u are strata of the pixel.
    assert (np.diff(dx) >= 0.0).all()


@pytest.mark.parametrize("spec", EXAMPLES + CORNERS, ids=repr)
def test_distribution_is_that_of_the_filter(spec):
    """The largest difference of the distribution functions is the stated one, on both axes."""
    x = np.linspace(-spec.radius, spec.radius, 400_001)
    density = np.abs(factor(spec)(x))
    cdf = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]))])
    cdf /= cdf[-1]
    dx, dy, _ = samples(spec)
    n = dx.size
    for d in (dx, dy):
        found = np.interp(np.sort(d.astype(np.float64)), x, cdf)
        assert np.abs(found - (np.arange(n) + 0.5) / n).max() < 2.5e-4


@pytest.mark.parametrize("spec", EXAMPLES + CORNERS, ids=repr)
def test_weights_average_to_one(spec):
    """Weights are +-(integral of |f|) / (integral of f) with the signs in the right proportion."""
    _, _, weight = samples(spec)
    ratio = (moment(spec, 0, signed=False) / moment(spec, 0)) ** 2
    np.testing.assert_allclose(np.abs(weight), ratio, rtol=2e-3)
    # u and v are paired at random: the product of two signs has a mean of a mean.
    deviation = np.sqrt((ratio**2 - 1.0) / weight.size)
    assert abs(weight.mean() - 1.0) <= 4 * deviation + 1e-6


@pytest.mark.parametrize("spec", EXAMPLES + CORNERS, ids=repr)
def test_moments_are_those_of_the_filter(spec):
    """First moments 0, second ones those of the signed filter, which decide its sharpness."""
    dx, dy, weight = samples(spec)
    expected = moment(spec, 2) / moment(spec, 0)
    scale = moment(spec, 2, signed=False) / moment(spec, 0, signed=False)
    for d, other in ((dx, dy), (dy, dx)):
        d = d.astype(np.float64)
        noise = 5 * np.std(weight * d * d) / np.sqrt(d.size) if weight.std() > 0 else 0.0
        assert abs((weight * d).mean()) < 5 * np.std(weight * d) / np.sqrt(d.size)
        assert abs((weight * d * d).mean() - expected) < 1e-3 * scale + noise
        assert abs((weight * d * other).mean()) < 5 * np.std(weight * d * other) / np.sqrt(d.size)


def test_signs_of_mitchell_are_those_of_the_filter():
    spec = Mitchell()
    g = factor(spec)
    dx, dy, weight = samples(spec)
    f = g(dx.astype(np.float64)) * g(dy.astype(np.float64))
    # Off the zero itself, which float32 does not hit.
    clear = np.abs(f) > 1e-4
    np.testing.assert_array_equal(np.sign(weight[clear]), np.sign(f[clear]))
    assert (weight < 0).mean() > 0.05


@pytest.mark.parametrize("b", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("c", [0.0, 0.3, 1.0])
def test_mitchell_changes_its_sign_once(b, c):
    from alight.filters.mitchell import sign_change

    x = np.linspace(0.0, 2.0, 5001)
    m, zero = polynomial(x, b, c), sign_change(b, c)
    assert (m[x < zero] >= 0.0).all()
    assert (m[x > zero] <= 1e-12).all()
    assert (c > 0.0) == (m.min() < 0.0)


def test_one_stratum_of_u_is_one_part_of_the_gaussian():
    """Chi-squared test of random samples against the density, 2-D."""
    spec = Gaussian(stddev=0.7, radius=2.0)
    u = np.random.default_rng(5).random((2, 200_000), np.float32)
    run = instantiate(sample_filter, Program(filter="gaussian"), compiled=False)
    dx, dy, _ = run(Tables(compile_filter(spec)), (u[0], u[1]))
    edges = np.linspace(-2.0, 2.0, 17)
    counts = np.histogram2d(dx, dy, bins=[edges, edges])[0]
    g = factor(spec)
    mass = np.array([integrate.quad(g, a, b)[0] for a, b in itertools.pairwise(edges)])
    mass /= mass.sum()
    assert stats.chisquare(counts.ravel(), np.outer(mass, mass).ravel() * u.shape[1]).pvalue > 1e-4


def test_table_of_a_parabola_is_exact_at_the_radius():
    """Where g falls linearly to 0, the distance is linear in the root of the probability."""
    table = tabulate(lambda x: 1.0 - np.abs(x), 1.0)
    assert table[0] == 1.0
    np.testing.assert_allclose(table[2:-1], 1.0 - np.arange(513) / 512, atol=1e-5)


@kernel
def three_numbers(scene, inputs, out):
    """Offsets and weight for each packet of pairs."""
    for i in range(0, out.size // 3, LANES):
        u2 = load_lanes(inputs, 2 * i), load_lanes(inputs, 2 * i + LANES)
        dx, dy, weight = sample_filter(scene, u2)
        store_lanes(out, 3 * i, dx)
        store_lanes(out, 3 * i + LANES, dy)
        store_lanes(out, 3 * i + 2 * LANES, weight)


@pytest.mark.parametrize("spec", [module.EXAMPLES[0] for module in MODELS], ids=repr)
def test_compiled_samples_are_the_twins(spec):
    n, lanes = 1024, lanes_of_machine()
    u = np.random.default_rng(6).random((2, n), np.float32)
    u[0, :3] = 0.0, 0.5, 1.0 - 2.0**-24
    tables, program = Tables(compile_filter(spec)), Program(filter=spec.type_name())
    blocks = np.ascontiguousarray(u.reshape(2, -1, lanes).swapaxes(0, 1))
    out = View(np.zeros(3 * n, np.float32))
    instantiate(three_numbers, program)(tables, View(blocks), out)
    found = out.array.reshape(-1, 3, lanes).swapaxes(0, 1).reshape(3, n)
    dx, dy, weight = instantiate(sample_filter, program, compiled=False)(tables, (u[0], u[1]))
    np.testing.assert_allclose(found[0], dx, atol=1e-6)
    np.testing.assert_allclose(found[1], dy, atol=1e-6)
    np.testing.assert_allclose(found[2], np.broadcast_to(weight, n), rtol=1e-6)
