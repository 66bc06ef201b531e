"""Materials by machine code and by the Python text, on the same random input."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from alight.bsdfs.dispatch import albedo_bsdf, evaluate_bsdf, sample_bsdf
from alight.core.spec import Bsdf
from alight.laws.materials import Material, random_numbers
from alight.laws.plane import plane_point
from alight.laws.report import demand, demand_close
from alight.laws.statistics import unit_vectors
from lanewise.jit import instantiate, kernel
from lanewise.simd import LANES, lanes_vec3, load_lanes, store_lanes, to_float
from lanewise.vec3 import Vec3
from lanewise.view import View

N = 2048
RESULTS = 15


@kernel
def load_vec3(view, i):
    """Three rows of N numbers, from place i on."""
    return Vec3(load_lanes(view, i), load_lanes(view, i + N), load_lanes(view, i + 2 * N))


@kernel
def store_vec3(view, row, i, v):
    """Into three rows of N numbers."""
    store_lanes(view, row * N + i, v.x)
    store_lanes(view, (row + 1) * N + i, v.y)
    store_lanes(view, (row + 2) * N + i, v.z)


@kernel
def scatter_all(scene, bsdf, wo, other, u, uv, out):
    """Sample and evaluate the materials `bsdf` at N points of the plane z = 0."""
    for i in range(0, N, LANES):
        color = Vec3(0.25, 0.5, 0.75) * load_lanes(uv, i)
        surface = plane_point(
            lanes_vec3(0.0), load_lanes(uv, i), load_lanes(uv, i + N), load_lanes(bsdf, i), color
        )
        w, v = load_vec3(wo, i), load_vec3(other, i)
        u2 = load_lanes(u, i + N), load_lanes(u, i + 2 * N)
        active = load_lanes(u, i) >= 0.0
        wi, weight, pdf, flags = sample_bsdf(scene, surface, w, load_lanes(u, i), u2, active)
        f_cos, density = evaluate_bsdf(scene, surface, w, v, active)
        store_vec3(out, 0, i, wi)
        store_vec3(out, 3, i, weight)
        store_lanes(out, 6 * N + i, pdf)
        store_vec3(out, 7, i, f_cos)
        store_lanes(out, 10 * N + i, density)
        store_vec3(out, 11, i, albedo_bsdf(scene, surface, w, active))
        store_lanes(out, 14 * N + i, to_float(flags))


def scatter(specs: Sequence[Bsdf], bsdf: np.ndarray, compiled: bool) -> np.ndarray:
    """Results (RESULTS, N) of `scatter_all` on the same random input."""
    material = Material(*specs)
    u, uv = random_numbers(N, 1), 6.0 * random_numbers(N, 2)[:2]
    out = View(np.zeros((RESULTS, N), np.float32))
    wo, other = (View(np.ascontiguousarray(unit_vectors(N, seed))) for seed in (3, 4))
    run = instantiate(scatter_all, material.program, compiled=compiled, lanes=N)
    with np.errstate(all="ignore"):
        run(material.scene, View(bsdf), wo, other, View(u), View(uv), out)
    return out.shaped


def rounding_of_cosine(cosine: np.ndarray) -> np.ndarray:
    """How far rounding may move a cosine that is the root of a difference, as in refraction.

    The difference is as small as the cosine's square near the horizon, and rounded as one.
    """
    return 2e-7 / np.maximum(np.abs(cosine), 1e-3)


def compiled_bsdf_is_the_twins(specs: Sequence[Bsdf]) -> None:
    """Machine code scatters as the Python text."""
    ids = np.random.default_rng(5).integers(0, len(specs), N).astype(np.uint32)
    compiled, twin = scatter(specs, ids, True), scatter(specs, ids, False)
    demand(np.isfinite(compiled), "a number of the compiled kernel is not finite")
    same = compiled[14] == twin[14]
    demand(same.mean() >= 0.999, "the compiled kernel chooses other lobes")
    # Of directions. Bent normals turn directions there and back, and lobes stretch the rounding.
    atol = 2e-5 if any(Material(spec).is_bent() for spec in specs) else 3e-6
    demand_close(compiled[:2, same], twin[:2, same], "directions", atol=atol)
    atol += rounding_of_cosine(twin[2, same])
    demand_close(compiled[2, same], twin[2, same], "cosines of directions", atol=atol)
    # The sharpest lobes take rounding errors of a direction to a high power.
    close = np.isclose(compiled[3:14, same], twin[3:14, same], rtol=1e-3, atol=1e-5)
    demand(close.mean() >= 0.999, "values, densities or weights differ")
