"""Kernels of mathematics, samplers, tone curves, spectra and distributions on fixed numbers."""

from functools import partial

import numpy as np

from alight.core import distributions, equal_area, fresnel, maths, mis, rng, spectra, warps
from alight.core.frame import frame_from_normal, frame_from_tangent, to_local, to_world
from alight.core.srgb import decode_srgb, encode_srgb
from alight.core.wavelengths import wavelength_at, weights_at
from alight.formats import loads
from alight.integrators.largest_sample import largest_of_paths
from alight.integrators.path import Path
from alight.laws.samplers import twin
from alight.samplers.sampling import sampler_state
from alight.tone_curves.model import TONE_CURVES
from lanewise.vec3 import Vec3
from lanewise.view import View
from tests.recorded.zoo import STAGE, scene

N = 24
SAMPLERS = (
    "independent", "{type: stratified, strata: 3}", "{type: multijittered, strata: 5}", "halton",
    "sobol",
)  # fmt: skip


def uniform(rows: int, seed: int, low: float = 0.0, high: float = 1.0) -> np.ndarray:
    """Numbers (rows, N)."""
    return np.random.default_rng(seed).uniform(low, high, (rows, N)).astype(np.float32)


def directions(seed: int) -> Vec3:
    """Unit vectors."""
    v = np.random.default_rng(seed).normal(size=(3, N))
    return Vec3(*(v / np.linalg.norm(v, axis=0)).astype(np.float32))


def flat(value: object) -> object:
    """Vectors, masks and numbers as lists."""
    if isinstance(value, Vec3):
        value = (value.x, value.y, value.z)
    if isinstance(value, tuple):
        return [flat(part) for part in value]
    array = np.broadcast_to(value, N)
    return array.astype(np.int64) if array.dtype.kind in "ui" else array


def elementary() -> dict[str, object]:
    """Elementary functions."""
    x, signed = uniform(1, 1, 0.01, 9.0)[0], uniform(2, 2, -1.0, 1.0)
    names = {"sincos": x, "sincos_2pi": x / 9, "exp": 7 * signed[0], "expm1": signed[0], "log": x,
             "log1p": signed[0], "arccos": signed[0], "arcsin": signed[1]}  # fmt: skip
    answer = {name: flat(getattr(maths, name)(argument)) for name, argument in names.items()}
    return answer | {
        "pow": flat(maths.pow(x, 3 * signed[0])),
        "arctan2": flat(maths.arctan2(*signed)),
    }


def warped() -> dict[str, object]:
    """Warps, and their densities."""
    u2, cone = tuple(uniform(2, 3)), uniform(1, 4)[0]
    names = [name for name in vars(warps) if name.startswith("square_to_")]
    alone = [name for name in names if name not in
             ("square_to_uniform_cone", "square_to_spherical_rectangle")]  # fmt: skip
    answer = {name: flat(getattr(warps, name)(u2)) for name in alone}
    corner, x, y = Vec3(-0.4, 0.2, 1.1), Vec3(1.3, 0.1, 0.2), Vec3(-0.2, 0.9, 0.1)
    p = Vec3(*uniform(3, 5, -1.0, 1.0))
    window = warps.spherical_rectangle(corner, x, y, p)
    d = directions(6)
    return answer | {
        "square_to_uniform_cone": flat(warps.square_to_uniform_cone(u2, cone)),
        "uniform_cone_pdf": flat(warps.uniform_cone_pdf(cone)),
        "square_to_spherical_rectangle": flat(warps.square_to_spherical_rectangle(window, u2)),
        "spherical_rectangle_pdf": flat(warps.spherical_rectangle_pdf(window, d)),
        "disk_pdf": flat(warps.disk_pdf(u2[0], u2[1])),
        "hemispheres": flat((warps.cosine_hemisphere_pdf(d), warps.uniform_hemisphere_pdf(d),
                             warps.uniform_sphere_pdf())),
        "square_to_sphere": flat(equal_area.square_to_sphere(*u2)),
        "sphere_to_square": flat(equal_area.sphere_to_square(d)),
        "around_edges": flat(equal_area.around_edges(*uniform(2, 7, -0.4, 1.4))),
    }  # fmt: skip


def surfaces() -> dict[str, object]:
    """Fresnel's equations, frames, weights of techniques, wavelengths."""
    n, w, cosine = directions(8), directions(9), uniform(1, 10, -1.0, 1.0)[0]
    eta, k, u = uniform(1, 11, 0.6, 1.7)[0], Vec3(*uniform(3, 12, 0.0, 4.0)), uniform(2, 13)
    frame, other = frame_from_normal(n), frame_from_tangent(n, w)
    cos_t = fresnel.cos_transmitted(abs(cosine), eta)
    return {
        "dielectric": flat(fresnel.fresnel_dielectric(cosine, eta)),
        "conductor": flat(fresnel.fresnel_conductor(abs(cosine), k + Vec3(0.1, 0.2, 0.3), k)),
        "schlick": flat(fresnel.fresnel_schlick(abs(cosine), Vec3(0.04, 0.5, 0.9))),
        "refract": flat((cos_t, fresnel.refract(w, eta, cos_t))),
        "frames": flat((*frame, *other)),
        "turned": flat((to_local(*frame, n, w), to_world(*frame, n, w))),
        "heuristics": flat((mis.balance_heuristic(*u), mis.power_heuristic(*u))),
        "wavelengths": flat((wavelength_at(u[0]), weights_at(u[0]))),
        "srgb": [encode_srgb(u), decode_srgb(u)],
    }  # fmt: skip


def spectral() -> dict[str, object]:
    """Spectra as colours."""
    nm = np.linspace(380.0, 760.0, 9)
    values = np.array([0.1, 0.4, 0.9, 0.3, 0.2, 0.7, 0.8, 0.5, 0.6])
    return {
        "reflects": spectra.to_linear_srgb(nm, values, shines=False),
        "shines": spectra.to_linear_srgb(nm, values, shines=True),
        "error": [spectra.reduction_error(nm, values, shines=shines) for shines in (False, True)],
        "weights": spectra.reflectance_weights(nm),
        "blackbody": [column[::40] for column in spectra.blackbody(3400.0)],
    }


def chosen() -> dict[str, object]:
    """Discrete, guided, two-dimensional and linear distributions."""
    weights = np.random.default_rng(14).random((5, 7)) ** 3
    row, cells = distributions.cumulative(weights[0]), distributions.cumulative_2d(weights)
    u2, zero = tuple(uniform(2, 15)), np.zeros(N, np.uint32)
    corners = tuple(uniform(4, 16))
    line, area = View(row), View(cells)
    index = (np.arange(N) % 7).astype(np.uint32)
    return {
        "row": row, "cells": cells,
        "guide": distributions.guide(np.append(0.0, np.cumsum(weights[0])), 4),
        "sizes": [distributions.guide_size(n) for n in (3, 17, 100, 1000)],
        "discrete": flat(distributions.sample_discrete(line, zero, 7, u2[0])),
        "pmf": flat(distributions.pmf_discrete(line, zero, index)),
        "cell": flat(distributions.sample_cell(area, 0, 5, 7, u2[0], u2[1])),
        "pmf of a cell": flat(distributions.pmf_cell(area, 0, 5, 7, index, index % 5)),
        "linear": flat(distributions.sample_linear(corners[0], corners[1], u2[0])),
        "bilinear": flat(distributions.sample_bilinear(corners, u2)),
        "between": flat(distributions.bilinear(corners, *u2)),
    }  # fmt: skip


def bounds_of_samples() -> dict[str, object]:
    """Largest samples that paths can have, by their options."""
    options = [
        {"max_depth": depth, "rr_depth": first, "russian_roulette": roulette}
        for depth in (1, 3, 7)
        for first in (1, 3)
        for roulette in ("none", "throughput")
    ]
    weights = 0.0, 0.8, 1.1
    return {
        "limited": [largest_of_paths(Path(**one), 0.7, 3.0, 0.8, 1.3) for one in options],
        "unlimited": [largest_of_paths(Path(), 0.7, 3.0, weight, 1.3) for weight in weights],
    }


def random_words() -> dict[str, object]:
    """Hashes of counters."""
    words = np.random.default_rng(17).integers(0, 2**32, (4, N), np.uint32)
    return {
        "pcg4d": flat(tuple(rng.pcg4d(*words))),
        "mix": flat(rng.mix(words[0])),
        "keys": flat((rng.pixel_keys(*words[:2], 3, 5), rng.sample_keys(*words[:3]))),
        "hashes": flat((rng.hash_1(*words[:3]), rng.hash_2(*words[:3]))),
        "floats": flat(rng.unit_float(words[3])),
    }


def numbers(text: str) -> dict[str, object]:
    """Numbers of a sampler: early and late ones, of several pixels and dimensions."""
    spec = loads(scene(STAGE, sampler=text), "zoo.yaml").sampler
    ints = np.random.default_rng(18).integers(0, 2**32, (4, N), np.uint32)
    ints[2, :16] = np.arange(16) * 5 % 37
    ints[:2] &= np.uint32(1023)
    ints[3] &= np.uint32(63)
    state = sampler_state(ints[0], ints[1], ints[2], 3, 77)
    return {
        "pairs": flat(tuple(twin(spec)(state, ints[3]))),
        "single": flat(twin(spec, False)(state, ints[3])),
    }


def shown(name: str) -> dict[str, object]:
    """A tone curve and its inverse."""
    curve = TONE_CURVES[name]
    rgb = (uniform(3, 19).T.astype(float) * 1.9) ** 3
    answer = {"shown": curve.apply(curve.EXAMPLES[0], rgb)}
    if curve.invert is not None:
        answer["back"] = curve.invert(curve.EXAMPLES[0], uniform(3, 20).T.astype(float))
    return answer


CASES = {
    "elementary": elementary, "warps": warped, "surfaces": surfaces, "spectra": spectral,
    "distributions": chosen, "random-words": random_words, "bounds-of-samples": bounds_of_samples,
    **{f"sampler-{text.strip('{').split(',')[0].split()[-1]}": partial(numbers, text)
       for text in SAMPLERS},
    **{f"tone-curve-{name}": partial(shown, name)
       for name in ("aces", "agx", "clip", "hable", "reinhard") if name in TONE_CURVES},
}  # fmt: skip
