"""relMSE before and after denoising, and what the denoiser costs.

    python benchmarks/denoising.py [--spp 16] [--reference-spp 16384] [--size 192]

Four built-in scenes against references of many more samples. The denoised picture is also compared
at 64 times the samples, where a trained filter may do harm: its bias does not go away.
"""

import argparse
import time

from harness import print_table

import alight
from alight.films.denoising import FEATURES
from alight.metrics import relmse

SCENES = ("cornell-box", "mirror-and-glass", "veach-plates", "depth-of-field")


def measure(name, scene, spp, reference):
    """One row of the table."""
    film = alight.render(scene, spp=spp, aovs=list(FEATURES.values()))
    begin = time.perf_counter()
    picture, bias = alight.denoise(film)
    seconds = time.perf_counter() - begin
    before, after = relmse(film.image, reference), relmse(picture.image, reference)
    return {
        "scene": name,
        "spp": spp,
        "relMSE before": f"{before:.3g}",
        "after": f"{after:.3g}",
        "ratio": f"{before / after:.3g}",
        "mean changed": f"{bias.effect:+.2%}",
        "seconds": f"{seconds:.2f}",
    }


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--reference-spp", type=int, default=16384)
    parser.add_argument("--size", type=int, default=192)
    arguments = parser.parse_args()
    size = arguments.size
    rows = []
    for name in SCENES:
        scene = alight.load(name, [f"film.size=[{size}, {size}]"])
        reference = alight.render(scene, spp=arguments.reference_spp, seed=1).image
        both = arguments.spp, 64 * arguments.spp
        rows += [measure(name, scene, spp, reference) for spp in both]
    print_table(rows)


if __name__ == "__main__":
    main()
