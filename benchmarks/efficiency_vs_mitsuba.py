"""Efficiency 1 / (relMSE * seconds) on the Cornell box, against Mitsuba 3 with multijitter.

    python benchmarks/efficiency_vs_mitsuba.py [--spp 64] [--reference-spp 1024]

relMSE = mean of (x - r)^2 / (r^2 + 0.01) over pixels and channels. The noise of the reference is
subtracted: with two independent references A (Mitsuba) and B (alight), the mean of (x - A)(x - B)
is the error of x alone, because the noises of x, A and B are uncorrelated. Both references are kept
in the temporary folder (--fresh remakes them).
"""

import argparse
import statistics
from pathlib import Path
from tempfile import TemporaryDirectory, gettempdir

import numpy as np
from harness import Worker, alternate, median_ratio, print_json, print_table

EPSILON = 0.01
REFERENCE_SEED = 1_000_003


def relmse(image: np.ndarray, a: np.ndarray, b: np.ndarray) -> float:
    """Error of `image` with the noise of the references `a` and `b` subtracted."""
    reference = (a + b) / 2
    x = image.astype(np.float64)
    return float(np.mean((x - a) * (x - b) / (reference**2 + EPSILON)))


def reference(worker: Worker, arguments: argparse.Namespace, batch: int = 64) -> np.ndarray:
    """Mean of many pictures of one renderer, stored for the next run."""
    name = f"alight-benchmark-{worker.name}-{arguments.size}-{arguments.reference_spp}.npy"
    path = Path(gettempdir()) / name
    if arguments.fresh or not path.exists():
        count = max(1, arguments.reference_spp // batch)
        total = np.zeros((arguments.size, arguments.size, 3))
        with TemporaryDirectory() as folder:
            picture = Path(folder) / "picture.npy"
            for i in range(count):
                worker.render(batch, REFERENCE_SEED + i, arguments.threads, picture)
                total += np.load(picture)
        np.save(path, total / count)
    return np.load(path)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="1 / (relMSE * seconds) against Mitsuba 3.")
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--reference-spp", type=int, default=1024, help="of each of the two")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--sampler", help="of alight; its default otherwise")
    parser.add_argument("--mitsuba-sampler", default="multijitter")
    parser.add_argument("--variant", default="llvm_ad_rgb", help="of Mitsuba")
    parser.add_argument("--fresh", action="store_true", help="remake the references")
    arguments = parser.parse_args()

    size = ["--size", str(arguments.size)]
    ours = size + (["--sampler", arguments.sampler] if arguments.sampler else [])
    theirs = [*size, "--sampler", arguments.mitsuba_sampler, "--variant", arguments.variant]
    errors: dict[str, list[float]] = {"alight": [], "mitsuba": []}
    seconds: dict[str, list[float]] = {"alight": [], "mitsuba": []}
    with (
        Worker("alight", "cornell", ours) as alight,
        Worker("mitsuba", "cornell", theirs) as mitsuba,
        TemporaryDirectory() as folder,
    ):
        a, b = reference(mitsuba, arguments), reference(alight, arguments)
        picture = Path(folder) / "picture.npy"

        def efficiency(worker: Worker, number: int) -> float:
            answer = worker.render(arguments.spp, number, arguments.threads, picture)
            error = relmse(np.load(picture), a, b)
            if number > 0:
                errors[worker.name].append(error)
                seconds[worker.name].append(answer["seconds"])
            return 1 / (error * answer["seconds"])

        figures = alternate(
            {
                "alight": lambda i: efficiency(alight, i),
                "mitsuba": lambda i: efficiency(mitsuba, i),
            },
            arguments.repeats,
        )
    rows = [
        {
            "renderer": name,
            "seconds": statistics.median(seconds[name]),
            "relMSE": statistics.mean(errors[name]),
            "1/(relMSE s)": statistics.median(figures[name]),
            "ratio": median_ratio(figures[name], figures["mitsuba"]),
        }
        for name in ("alight", "mitsuba")
    ]
    for row in rows:
        print_json(benchmark="efficiency", spp=arguments.spp, threads=arguments.threads, **row)
    print_table(rows)


if __name__ == "__main__":
    main()
