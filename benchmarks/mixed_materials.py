"""Nine materials in one scene against nine scenes of one material each.

    python benchmarks/mixed_materials.py [--size 192] [--spp 64] [--repeats 5]

Nine balls over nine tiles, below an even sky and a lamp: each ball and its tile of one material, or
all of the same. Lanes of a packet that come upon different materials wait for each other, which is
what the ratio shows: time of the mixed scene over the mean time of the nine others.

Processor time on one thread, scenes taking turns; medians. What a call costs that does not grow
with the samples (loading, tree, kernels from the cache) is measured by calls of 1 sample, and taken
off. Compares alight with itself only, so it needs no peers.
"""

import argparse
import statistics
import time

from harness import alternate, print_json, print_table

import alight
from alight import Scene
from alight.formats import loads

MATERIALS = {
    "diffuse": "{type: diffuse, reflectance: [0.6, 0.4, 0.2]}",
    "oren_nayar": "{type: oren_nayar, reflectance: 0.6, sigma: 30}",
    "phong": "{type: phong, diffuse: 0.3, specular: 0.5, exponent: 40}",
    "conductor": "{type: conductor, metal: silver}",
    "rough_conductor": "{type: rough_conductor, metal: gold, alpha: 0.2}",
    "dielectric": "{type: dielectric}",
    "rough_dielectric": "{type: rough_dielectric, alpha: 0.2}",
    "plastic": "{type: plastic, diffuse_reflectance: [0.1, 0.3, 0.6]}",
    "rough_plastic": "{type: rough_plastic, diffuse_reflectance: [0.6, 0.1, 0.1], alpha: 0.2}",
}

HEAD = """
alight: 1
camera: {fov: 40, transform: {look_at: {origin: [0, 6, 7], target: [0, 0.2, 0]}}}
film: {size: [SIZE, SIZE]}
sampler: independent
integrator: {type: path, max_depth: 8}
environment: {type: constant, radiance: 0.7}
nodes:
  lamp:
    transform: [{rotate: {axis: x, angle: 90}}, {translate: [0, 5, 0]}]
    shape: rectangle
    light: {type: area, radiance: 10}
"""

PLACE = """
  ball{i}:
    shape: {{type: sphere, center: [{x}, 0.8, {z}], radius: 0.8}}
    bsdf: {bsdf}
  tile{i}:
    transform: [{{rotate: {{axis: x, angle: -90}}}}, {{translate: [{x}, 0, {z}]}}]
    shape: rectangle
    bsdf: {bsdf}
"""


def scene_of(names: list[str], size: int) -> Scene:
    """Nine balls and tiles of nine materials, row by row."""
    text = HEAD.replace("SIZE", str(size))
    for i, name in enumerate(names):
        place = {"i": i, "x": 2.0 * (i % 3) - 2.0, "z": 2.0 * (i // 3) - 2.0}
        text += PLACE.format(bsdf=MATERIALS[name], **place)
    return loads(text)


def seconds(scene: Scene, spp: int, seed: int) -> float:
    """Processor time of a render on one thread, without what is done once."""
    times = []
    for samples in (1, spp + 1):
        start = time.process_time()
        alight.render(scene, spp=samples, spp_per_pass=samples, seed=seed, threads=1)
        times.append(time.process_time() - start)
    return times[1] - times[0]


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Nine materials mixed, and each by itself.")
    parser.add_argument("--size", type=int, default=192, help="pixels along each side")
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--repeats", type=int, default=5)
    arguments = parser.parse_args()
    everyone = list(MATERIALS)
    scenes = {"mixed": scene_of(everyone, arguments.size)}
    scenes |= {name: scene_of([name] * 9, arguments.size) for name in everyone}
    figures = alternate(
        {
            name: lambda i, scene=scene: seconds(scene, arguments.spp, i)
            for name, scene in scenes.items()
        },
        arguments.repeats,
    )
    count = arguments.size**2 * arguments.spp
    rows = [
        {"scene": name, "ns per sample": 1e9 * statistics.median(values) / count}
        for name, values in figures.items()
    ]
    singles = zip(*(figures[name] for name in everyone), strict=True)
    ratios = [
        mixed / statistics.mean(others)
        for mixed, others in zip(figures["mixed"], singles, strict=True)
    ]
    print_table(rows)
    print_json(
        benchmark="mixed materials",
        ratio=statistics.median(ratios),
        smallest=min(ratios),
        largest=max(ratios),
    )


if __name__ == "__main__":
    main()
