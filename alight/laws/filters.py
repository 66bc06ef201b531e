"""Laws of pixel filters: samples are spread as the filter, and their weights have the mean 1.

Each law is a function of an example and raises `BrokenLawError`.
"""

from __future__ import annotations

from collections import namedtuple

import numpy as np

from alight.compiled.program import Program
from alight.core.registry import versions
from alight.core.spec import Filter
from alight.filters.importance import compile_filter, sample_filter
from alight.filters.model import FILTERS
from alight.filters.splatting import choose_pixel
from alight.laws.report import demand, demand_close
from alight.laws.statistics import LARGEST_Z, SIGNIFICANCE, chi_square, z_of_mean
from alight.laws.twins import demand_same_by_machine
from lanewise.jit import instantiate, kernel
from lanewise.simd import LANES, lanes, load_lanes, store_lanes

N = 60_000

#: What filters see of a scene.
_Scene = namedtuple("_Scene", "filter")

#: Cells of the filter's square along each axis, and points of each.
CELLS, POINTS = 16, 64


def samples(spec: Filter) -> np.ndarray:
    """Offsets dx, dy in pixels and weights, (3, N) float64."""
    program = Program(filter=spec.type_name(), registered=versions([spec]))
    run = instantiate(sample_filter, program, compiled=False)
    u2 = tuple(np.random.default_rng(1).random((2, N), np.float32))
    found = run(_Scene(compile_filter(spec)), u2)
    return np.stack([np.broadcast_to(part, N) for part in found]).astype(float)


def weights_have_mean_one(spec: Filter) -> None:
    """The mean weight is 1, no weight exceeds the declared bound, and offsets are finite."""
    dx, dy, weight = samples(spec)
    demand(np.isfinite(dx) & np.isfinite(dy), "an offset is not finite")
    z = z_of_mean(weight, 1.0, 1e-5)
    demand(abs(z) < LARGEST_Z, f"the mean weight is {weight.mean():.5g}")
    if spec.largest_weight is not None:
        most = np.abs(weight).max()
        demand(most <= spec.largest_weight * (1.0 + 1e-6), f"a weight is {most:.5g}")


def pictures_are_not_shifted(spec: Filter) -> None:
    """The weighted mean of the offsets is the pixel's centre."""
    dx, dy, weight = samples(spec)
    for axis, offset in (("x", dx), ("y", dy)):
        z = z_of_mean(weight * offset, 0.0, 1e-6 * np.abs(offset).max())
        shift = (weight * offset).mean()
        demand(abs(z) < LARGEST_Z, f"pictures are shifted by {shift:.3g} pixels along {axis}")


def samples_are_spread_as_the_filter(spec: Filter) -> None:
    """Offsets have the density |f| (chi-square), and weights the sign of f."""
    value = FILTERS[spec.type_name()].value
    dx, dy, weight = samples(spec)
    reach = max(np.abs(dx).max(), np.abs(dy).max())
    # What lies beyond the samples found is one more cell.
    edges = np.linspace(-reach, reach, CELLS + 1)
    wide = 1.5 * reach
    at = np.linspace(-wide, wide, 3 * CELLS * POINTS // 2 + 1)
    at = 0.5 * (at[1:] + at[:-1])
    f = np.asarray(value(spec, at[:, None], at[None, :]), float) * np.ones((at.size, at.size))
    cell = np.clip(np.searchsorted(edges, at) - 1, -1, CELLS)
    inside = (cell >= 0) & (cell < CELLS)
    share = np.zeros((CELLS, CELLS))
    np.add.at(share, np.ix_(cell[inside], cell[inside]), np.abs(f)[np.ix_(inside, inside)])
    share /= np.abs(f).sum()
    counts = np.histogram2d(dx, dy, bins=(edges, edges))[0].ravel()
    counts = np.append(counts, N - counts.sum())
    p = chi_square(counts, share.ravel())
    demand(p > SIGNIFICANCE, f"chi-square test of the offsets: p = {p:.3g}")
    here = np.asarray(value(spec, dx, dy), float) * np.ones(N)
    # Next to a zero of f rounding decides.
    clear = np.abs(here) > 1e-3 * np.abs(here).max()
    demand((np.sign(here) == np.sign(weight))[clear], "a weight has not the sign of the filter")


def splats_get_what_the_filter_gives(spec: Filter) -> None:
    """A point of the film adds to each pixel, in the mean, what the pixel's filter gives it."""
    model = FILTERS[spec.type_name()]
    if model.profile is None:
        return
    fine = np.linspace(-17.0, 17.0, 200_001)
    along = np.asarray(model.value(spec, fine, 0.0), float) * np.ones(fine.size)
    whole = along.sum() * (fine[1] - fine[0])
    program = Program(filter=spec.type_name(), registered=versions([spec]))
    run = instantiate(choose_pixel, program, compiled=False)
    scene, rng = _Scene(compile_filter(spec)), np.random.default_rng(4)
    for x in rng.random(4) + 20.0:
        pixel, weight = run(scene, np.full(N, x, np.float32), rng.random(N, np.float32))
        pixel, weight = np.broadcast_to(pixel, N), np.broadcast_to(weight, N).astype(float)
        for k in range(2, 39):
            wanted = float(np.asarray(model.value(spec, x - k - 0.5, 0.0), float)) / whole
            # Of a pixel that is hardly ever chosen no error can be seen.
            rare = np.sqrt(abs(wanted) / N) + 1e-6
            z = z_of_mean(np.where(pixel == k, weight, 0.0), wanted, rare)
            demand(abs(z) < LARGEST_Z, f"pixel {k} gets a wrong share of a splat at {x:.4f}")


def profiles_are_the_filter(spec: Filter) -> None:
    """Along an axis the profile is the filter over its integral."""
    model = FILTERS[spec.type_name()]
    if model.profile is None or model.reach is None:
        return
    table = compile_filter(spec)
    reach = float(model.reach(table))
    # Middles of cells, since a box ends at its reach.
    edges = np.linspace(-reach, reach, 100_001)
    fine = 0.5 * (edges[1:] + edges[:-1])
    along = np.asarray(model.value(spec, fine, 0.0), float) * np.ones(fine.size)
    found = np.broadcast_to(model.profile(table, fine.astype(np.float32)), fine.size)
    # A flat Gaussian is the difference of two numbers near 1, whose rounding is all that differs.
    wanted = along / (along.mean() * 2.0 * reach)
    demand_close(found, wanted, "the profile", atol=1e-4 * wanted.max())


# ---------------------------------------------------------------- machine code


@kernel
def sample_all(scene, u, out, n):
    """Offsets and weights for n pairs of random numbers."""
    for i in range(0, n, LANES):
        u2 = load_lanes(u, i), load_lanes(u, i + n)
        dx, dy, weight = sample_filter(scene, u2)
        store_lanes(out, i, dx)
        store_lanes(out, i + n, dy)
        store_lanes(out, i + 2 * n, lanes(0.0) + weight)


def compiled_samples_are_the_twins(spec: Filter) -> None:
    """Machine code draws the samples of the Python text."""
    program = Program(filter=spec.type_name(), registered=versions([spec]))
    # Not next to 0 and 1, where input that is rounded otherwise is none.
    u = np.random.default_rng(3).uniform(1e-3, 1.0 - 1e-3, (2, 4096)).astype(np.float32)
    demand_same_by_machine(sample_all, program, _Scene(compile_filter(spec)), u, 3)


LAWS = (
    weights_have_mean_one,
    pictures_are_not_shifted,
    samples_are_spread_as_the_filter,
    splats_get_what_the_filter_gives,
    profiles_are_the_filter,
)
COMPILED_LAWS = (compiled_samples_are_the_twins,)
