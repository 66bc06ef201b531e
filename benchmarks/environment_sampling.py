"""Variance of three ways to sample an environment map, at equal samples.

    python benchmarks/environment_sampling.py MAP.hdr ... [--sun] [--spp 64] [--seeds 32]

The map lights three balls, matte, glossy and coated, on a plane. `uniform` draws directions of the
whole sphere alike, `importance` in proportion to luminance, `compensated` after taking the mean off
(only under `mis`). --sun adds a made sky with a sun of half a degree that gives most of the light.

The variance of a pixel over independent seeds is averaged over all pixels; for relative variances
it is divided by mean^2 + (0.1 mean of the picture)^2 before, which gives dark pixels more weight.
Ratios are geometric means over eight groups of seeds, with their 95 % interval (Student's t).

No choice of directions by the map alone can do better than drawing them in proportion to its
luminance: on a horizontal matte plane that divides the variance of uniform directions by 4.2 for
a soft sunset, and by thousands where lamps or a sun give most of the light.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from harness import print_json, print_table
from numpy.typing import NDArray

import alight
from alight.formats import loads
from alight.lights.environment import Environment

#: Half-width of a 95 % interval for eight values, in standard errors of their mean: Student's t.
GROUPS, T = 8, 2.365

SCENE = """
alight: 1
camera: {fov: 35, transform: {look_at: {origin: [0, 2.2, 6], target: [0, 0.5, 0]}}}
film: {size: [96, 64]}
sampler: independent
integrator: {type: path, max_depth: 4}
environment: {type: environment, pixels: [[1]]}
nodes:
  plane: {shape: plane, transform: {rotate: {axis: x, angle: -90}}}
  matte:
    shape: {type: sphere, center: [-1.5, 0.7, 0], radius: 0.7}
    bsdf: {type: diffuse, reflectance: [0.7, 0.6, 0.5]}
  glossy:
    shape: {type: sphere, center: [0, 0.7, 0], radius: 0.7}
    bsdf: {type: rough_conductor, metal: gold, alpha: 0.15}
  coated:
    shape: {type: sphere, center: [1.5, 0.7, 0], radius: 0.7}
    bsdf: {type: rough_plastic, diffuse_reflectance: [0.1, 0.3, 0.5], alpha: 0.2}
"""

WAYS = {
    "uniform": {"sampling": "uniform"},
    "importance": {"sampling": "importance", "compensation": False},
    "compensated": {"sampling": "importance", "compensation": True},
}


def sunny_sky(height: int = 512) -> NDArray[np.float32]:
    """A clear sky over dark ground, with a sun of half a degree, 30 degrees high."""
    width = 2 * height
    y, x = np.mgrid[:height, :width]
    theta, phi = np.pi * y / (height - 1), 2.0 * np.pi * (x + 0.5) / width
    d = np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), -np.sin(theta) * np.cos(phi)], -1)
    high, around = np.radians(30.0), np.radians(60.0)
    sun = [np.cos(high) * np.sin(around), np.sin(high), np.cos(high) * np.cos(around)]
    between = np.degrees(np.arccos(np.clip(d @ sun, -1.0, 1.0)))
    blue = np.array([0.25, 0.45, 1.0]) * (0.4 + 0.6 * np.abs(d[..., 1:2]))
    glow = np.array([1.0, 0.9, 0.7]) * np.exp(-between / 8.0)[..., None]
    sky = np.where(d[..., 1:2] > 0.0, blue + 2.0 * glow, np.array([0.12, 0.1, 0.08]))
    # Irradiance 5 times the sky's, as on a clear day.
    sky[between < 0.27] = np.array([1.0, 0.92, 0.8]) * 1.2e5
    return sky.astype(np.float32)


def pictures(
    source: dict[str, Any], strategy: str, way: str, options: argparse.Namespace
) -> NDArray[np.float64]:
    """Luminances (seeds, h, w) of independent pictures."""
    scene = loads(SCENE)
    scene = scene.replaced(
        environment=Environment(**source, **WAYS[way]),
        integrator=scene.integrator.replaced(light_sampling=strategy),
    )
    # No two ways share their random numbers.
    first = 1000 * (1 + list(WAYS).index(way)) + (0 if strategy == "mis" else 500)
    images = []
    for seed in range(first, first + options.seeds):
        film = alight.render(scene, spp=options.spp, seed=seed, threads=options.threads)
        images.append(film.image.astype(np.float64) @ (0.212671, 0.715160, 0.072169))
    return np.stack(images)


def variances(
    images: NDArray[np.float64], scale: float | NDArray[np.float64]
) -> NDArray[np.float64]:
    """Mean over the picture of a pixel's variance over `scale`, by each group of seeds."""
    groups = np.array_split(images, GROUPS)
    return np.array([np.mean(group.var(0, ddof=1) / scale) for group in groups])


def ratio(a: NDArray[np.float64], b: NDArray[np.float64]) -> tuple[float, float, float]:
    """Geometric mean of a / b over groups, and the ends of its interval."""
    logs = np.log(a / b)
    half = T * logs.std(ddof=1) / np.sqrt(GROUPS)
    low, middle, high = np.exp(logs.mean() + half * np.array([-1.0, 0.0, 1.0]))
    return float(middle), float(low), float(high)


def z_of_means(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """Difference of the pictures' means, in standard errors over seeds."""
    x, y = a.mean((1, 2)), b.mean((1, 2))
    error = np.sqrt(x.var(ddof=1) / len(x) + y.var(ddof=1) / len(y))
    return float((x.mean() - y.mean()) / error)


def compare(name: str, source: dict[str, Any], options: argparse.Namespace) -> list[dict[str, Any]]:
    """All comparisons under one map."""
    pairs = [
        ("emitter", "uniform", "importance"),
        ("mis", "uniform", "importance"),
        ("mis", "uniform", "compensated"),
        ("mis", "importance", "compensated"),
    ]
    stacks: dict[tuple[str, str], NDArray[np.float64]] = {}
    rows = []
    for strategy, *ways in pairs:
        for way in ways:
            if (strategy, way) not in stacks:
                stacks[strategy, way] = pictures(source, strategy, way, options)
        a, b = (stacks[strategy, way] for way in ways)
        mean = 0.5 * (a.mean(0) + b.mean(0))
        middle, low, high = ratio(variances(a, 1.0), variances(b, 1.0))
        scale = mean**2 + (0.1 * mean.mean()) ** 2
        relative, _, _ = ratio(variances(a, scale), variances(b, scale))
        rows.append(
            {
                "map": name,
                "light_sampling": strategy,
                "variance of": f"{ways[0]} / {ways[1]}",
                "ratio": middle,
                "from": low,
                "to": high,
                "of relative variances": relative,
                "z of the means": z_of_means(a, b),
            }
        )
        print_json(benchmark="environment", spp=options.spp, seeds=options.seeds, **rows[-1])
    return rows


def main(words: Sequence[str] | None = None) -> None:
    """Measure every map asked for."""
    parser = argparse.ArgumentParser(description="Variance by the sampling of environment maps.")
    parser.add_argument("maps", nargs="*", type=Path, help="HDR or EXR files")
    parser.add_argument("--sun", action="store_true", help="a made sky with a bright sun too")
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--seeds", type=int, default=32, help="at least 16")
    parser.add_argument("--threads", type=int, default=2)
    options = parser.parse_args(words)
    sources: dict[str, dict[str, Any]] = {p.stem: {"file": str(p.resolve())} for p in options.maps}
    if options.sun:
        sources["made sky"] = {"pixels": sunny_sky()}
    rows = [row for name, source in sources.items() for row in compare(name, source, options)]
    print_table(rows)


if __name__ == "__main__":
    main()
