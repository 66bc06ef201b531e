"""What a user waits for and what it costs: first picture, second picture, memory, threads.

    python benchmarks/startup.py [--skip-blob] [--repeats 5]

Time from the command to a 512x512 picture at 16 spp with an empty kernel cache, then with a warm
one, with a combination of models that are known one by one, and with one that is new, each with
Python's byte code there, as pip leaves it; peak memory of the Cornell box and of the blob with a
warm cache; rate on 2 threads over that on 1. Compares alight with itself only, so it needs no
peers.
"""

import argparse
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from harness import Worker, alternate, median_ratio, print_json, print_table

MIB_PER_KIB = 1 / 1024
COPPER = "{type: rough_conductor, metal: copper}"
PAINT = "{type: rough_plastic, diffuse_reflectance: [0.5, 0.1, 0.1]}"
CLAY = "{type: oren_nayar}"
RENDER = "from alight.cli.main import app; app()"


def run(command: Sequence[str], environment: Mapping[str, str]) -> tuple[float, float]:
    """Seconds and peak resident memory in MiB of a command."""
    start = time.perf_counter()
    process = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - start
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise RuntimeError(f"{' '.join(command)} ended with code {process.returncode}")
    return seconds, usage.ru_maxrss * MIB_PER_KIB


def first_pictures(repeats: int) -> list[dict[str, object]]:
    """Time of the first picture, and the median of the later ones."""
    with TemporaryDirectory() as folder:
        environment = {**os.environ, "ALIGHT_CACHE": str(Path(folder) / "cache")}
        # An installed package has byte code: all of it is written here first, whatever is set.
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        environment["PYTHONPYCACHEPREFIX"] = str(Path(folder) / "bytecode")
        picture = str(Path(folder) / "picture.png")
        command = [sys.executable, "-c", RENDER, "render", "cornell-box"]
        command += ["--size", "512x512", "--spp", "16", "--output", picture]
        run(command, {**environment, "ALIGHT_CACHE": str(Path(folder) / "other")})
        fresh, _ = run(command, environment)
        warm = [run(command, environment) for _ in range(repeats)]
        for model in (COPPER, PAINT):
            run([*command, "--set", f"bsdfs.white={model}"], environment)
        both = ["--set", f"bsdfs.white={COPPER}", "--set", f"bsdfs.red={PAINT}"]
        combined, _ = run([*command, *both], environment)
        new, _ = run([*command, "--set", f"bsdfs.white={CLAY}"], environment)
    return [
        {"what": "first picture, fresh cache", "value": fresh, "unit": "s"},
        {
            "what": "the same again",
            "value": statistics.median(seconds for seconds, _ in warm),
            "unit": "s",
        },
        {"what": "known models, a new combination", "value": combined, "unit": "s"},
        {"what": "one new model", "value": new, "unit": "s"},
        {"what": "peak memory, cornell", "value": max(peak for _, peak in warm), "unit": "MiB"},
    ]


def blob_memory() -> dict[str, object]:
    """Peak memory of the blob, once the kernels are in the cache."""
    for _ in range(2):
        with Worker("alight", "blob") as worker:
            peak = worker.render(4, 0)["peak_rss_mb"]
    return {"what": "peak memory, blob", "value": peak, "unit": "MiB"}


def thread_scaling(spp: int, repeats: int) -> dict[str, object]:
    """Rate on two threads over that on one."""
    with Worker("alight", "cornell") as worker:
        figures = alternate(
            {
                "one": lambda i: worker.render(spp, i, threads=1)["seconds"],
                "two": lambda i: worker.render(spp, i, threads=2)["seconds"],
            },
            repeats,
        )
    ratio = median_ratio(figures["one"], figures["two"])
    return {"what": "2 threads over 1, cornell", "value": ratio, "unit": "1"}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="First picture, memory and threads of alight.")
    parser.add_argument("--skip-blob", action="store_true")
    parser.add_argument("--spp", type=int, default=64, help="of the test of threads")
    parser.add_argument("--repeats", type=int, default=5)
    arguments = parser.parse_args()
    rows = first_pictures(arguments.repeats)
    if not arguments.skip_blob:
        rows.append(blob_memory())
    rows.append(thread_scaling(arguments.spp, arguments.repeats))
    for row in rows:
        print_json(benchmark="startup", **row)
    print_table(rows)


if __name__ == "__main__":
    main()
