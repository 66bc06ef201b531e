"""How much faster a cluster of this machine's processes is, and what it costs: interleaved runs.

    python benchmarks/cluster_speed.py --seconds 10 --rounds 3

Each run is a process of its own: one worker, two workers, two threads of one process, in turn. What
is told are medians: two workers over one and over threads, by the time of rendering and by the time
of the whole process with its start; bytes from workers to client per pixel; the client's share of a
core. Then what a worker with an empty cache takes from Dask's first answer to the first samples,
and the speed of portable code over that of native code, in processor time. Times mean something
only on a machine that does nothing else.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time

SCENE, SIZE = "cornell-box", 256

WAYS = {"one": "local:1", "two": "local:2", "threads": None}


def render(way: str, spp: int, target: str) -> dict:
    """One render, in this process; what it took."""
    import alight

    begin, own = time.perf_counter(), time.process_time()
    where = WAYS.get(way)
    words = {} if where is None else {"cluster": where}
    threads = 2 if way == "threads" else 1
    film = alight.render(SCENE, size=SIZE, spp=spp, threads=threads, target=target, **words)
    told = film.stats.get("cluster", {})
    return {
        "seconds": film.stats["seconds"]["render"], "bytes": told.get("bytes", 0),
        "all": time.perf_counter() - begin, "cpu": time.process_time() - own,
    }  # fmt: skip


def measured(way: str, spp: int, target: str = "native", **environment: str) -> dict:
    """The same in a new process; its start counts."""
    words = [sys.executable, __file__, "--one", way, str(spp), target]
    begin = time.perf_counter()
    done = subprocess.run(
        words, env={**os.environ, **environment}, capture_output=True, text=True, check=True
    )
    told = json.loads(done.stdout.splitlines()[-1])
    return told | {"process": time.perf_counter() - begin}


def cold_start() -> float:
    """Seconds that a render adds to Dask's own start, on workers whose cache is empty."""
    import alight
    from alight.cluster.addresses import connected

    with tempfile.TemporaryDirectory() as cache, connected("local:1") as client:
        client.submit(sum, [1, 2]).result()
        client.run(os.environ.__setitem__, "ALIGHT_CACHE", cache)
        begin = time.perf_counter()
        alight.render(SCENE, size=64, spp=1, threads=1, cluster=client)
        return time.perf_counter() - begin


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=10.0, help="of a render by two threads")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--one", nargs=3)
    given = parser.parse_args()
    if given.one:
        way, spp, target = given.one
        print(json.dumps(render(way, int(spp), target)))
        return
    measured("threads", 1)
    measured("threads", 1, "portable")
    trial = measured("threads", 2000)
    spp = max(1, int(2000 * given.seconds / trial["seconds"]))
    runs: dict[str, list[dict]] = {way: [] for way in (*WAYS, "native", "portable")}
    for _ in range(given.rounds):
        for way in WAYS:
            runs[way].append(measured(way, spp))
        for target in ("native", "portable"):
            runs[target].append(measured("alone", spp // 8, target))

    def median(way: str, what: str) -> float:
        return statistics.median(run[what] for run in runs[way])

    rows = {
        "spp": spp,
        "two workers over one, rendering": median("one", "seconds") / median("two", "seconds"),
        "two workers over one, whole process": median("one", "process") / median("two", "process"),
        "over threads, rendering": median("threads", "seconds") / median("two", "seconds"),
        "over threads, with the cluster's start": median("threads", "all") / median("two", "all"),
        "over threads, whole process": median("threads", "process") / median("two", "process"),
        "bytes from workers per pixel": median("two", "bytes") / SIZE**2,
        "bytes from workers per pixel and sample": median("two", "bytes") / SIZE**2 / spp,
        "client's share of a core": median("two", "cpu") / median("two", "all"),
        "seconds that a render adds to a cold worker's start": cold_start(),
        "speed of portable code over native": median("native", "cpu") / median("portable", "cpu"),
    }  # fmt: skip
    for name, value in rows.items():
        print(f"{name:55} {value:.4g}")


if __name__ == "__main__":
    main()
