"""Msamples/s of alight and of Mitsuba 3, alternating in one run.

    python benchmarks/render_vs_mitsuba.py [--scenes cornell blob matpreview.xml ...] [--spp 64]

A scene is a name of ours or a file of Mitsuba's (see `files`). Both renderers: path integrator,
multiple importance sampling, depth 8, roulette from depth 5, box filter, independent sampler or
alight's default. --cpu divides by processor time per thread in place of time on the clock, for a
machine that does other work too, and leaves out what is done once a call. Needs ``make peers``
and a libLLVM for Mitsuba.
"""

import argparse
import statistics
from pathlib import Path

from harness import Worker, alternate, median_ratio, print_json, print_table
from scenes import NAMES


def measure(name: str, arguments: argparse.Namespace) -> dict[str, object]:
    """Compare on one scene."""
    size = ["--size", str(arguments.size), "--subdivisions", str(arguments.subdivisions)]
    ours = size + (["--sampler", arguments.sampler] if arguments.sampler else [])
    theirs = [*size, "--sampler", "independent", "--variant", arguments.variant]
    peaks: dict[str, float] = {}
    with Worker("alight", name, ours) as alight, Worker("mitsuba", name, theirs) as mitsuba:

        def rate(worker: Worker, number: int) -> float:
            answer = worker.render(arguments.spp, number, arguments.threads)
            peaks[worker.name] = answer["peak_rss_mb"]
            samples, seconds = answer["samples"], answer["seconds"]
            if arguments.cpu:
                # What a call costs that does not grow with the samples cancels in the difference.
                first = worker.render(1, number, arguments.threads)
                samples -= first["samples"]
                seconds = (answer["cpu_seconds"] - first["cpu_seconds"]) / arguments.threads
            return samples / seconds / 1e6

        figures = alternate(
            {"alight": lambda i: rate(alight, i), "mitsuba": lambda i: rate(mitsuba, i)},
            arguments.repeats,
        )
    return {
        "scene": name if name in NAMES else Path(name).stem,
        "alight Msamples/s": statistics.median(figures["alight"]),
        "Mitsuba Msamples/s": statistics.median(figures["mitsuba"]),
        "ratio": median_ratio(figures["alight"], figures["mitsuba"]),
        "alight peak MiB": peaks["alight"],
        "Mitsuba peak MiB": peaks["mitsuba"],
    }


def main() -> None:
    """Measure every scene asked for."""
    parser = argparse.ArgumentParser(description="alight against Mitsuba 3, Msamples/s.")
    parser.add_argument(
        "--scenes", nargs="+", default=list(NAMES), help=f"of {', '.join(NAMES)}, or Mitsuba files"
    )
    parser.add_argument("--size", type=int, default=512, help="rows of the picture")
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--sampler", help="alight's sampler, for instance independent")
    parser.add_argument("--variant", default="llvm_ad_rgb", help="of Mitsuba")
    parser.add_argument("--cpu", action="store_true", help="by processor time")
    parser.add_argument("--subdivisions", type=int, default=8, help="of the blob's icosphere")
    arguments = parser.parse_args()
    rows = []
    for name in arguments.scenes:
        rows.append(measure(name, arguments))
        print_json(benchmark="render", spp=arguments.spp, threads=arguments.threads, **rows[-1])
    print_table(rows)


if __name__ == "__main__":
    main()
