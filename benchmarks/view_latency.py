"""What one waits for in the live view: moves of the camera, a full sample, the settled film.

    python benchmarks/view_latency.py matpreview.xml [--size 640x360] [--moves 100] [--spp 64]

A headless Chromium on this machine looks at `alight view`. Arrow keys are pressed one after
another, each once the picture of the one before is on the screen. Photon: from the event's own time
stamp to the start of the second refresh of the screen after the frame has come, by when the first
has shown it. First sample: from the last key to the message that says that every pixel has one.
Then `alight render` renders as many samples; its time is compared with that of the view from its
first sample to its last.

Needs the extras `view` and `dev`, and Chromium. Run it on a quiet machine.
"""

import argparse
import json
import statistics
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from harness import print_json, print_table

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.view.browsing import launched, opened, served, until

#: Notes the times of keys, of frames on the screen, and of what the server says.
LISTEN = """
window.heard = { keys: [], frames: [], states: [] };
const Plain = WebSocket;
window.WebSocket = class extends Plain {
  constructor(...words) {
    super(...words);
    this.addEventListener("message", ({ data }) => {
      const now = performance.now();
      if (typeof data === "string") {
        const { is, number, spp, phase } = JSON.parse(data);
        if (is === "state") heard.states.push([now, number, spp ?? 0, phase]);
        return;
      }
      const [picture, , , number] = new Uint32Array(data, 0, 4);
      if (picture !== 0) return;
      requestAnimationFrame(() => requestAnimationFrame(
        () => heard.frames.push([performance.now(), number])));
    });
  }
};
addEventListener("keydown", (event) => heard.keys.push(event.timeStamp), true);
"""


def moved(page, moves: int) -> list[float]:
    """Milliseconds from each key to its frame."""
    found = []
    for _ in range(moves):
        before = page.evaluate("heard.frames.length ? heard.frames.at(-1)[1] : -1")
        page.keyboard.press("ArrowLeft")
        until(page, f"heard.frames.at(-1)?.[1] > {before}")
        key = page.evaluate("heard.keys.at(-1)")
        found.append(page.evaluate(f"heard.frames.find((f) => f[1] > {before})[0]") - key)
    return found


def settled(page) -> tuple[float, float]:
    """Milliseconds from the last key to the first whole sample, and from there to the last one."""
    until(page, "heard.states.at(-1)?.[3] === 'done'", 600.0)
    states, key = page.evaluate("heard.states"), page.evaluate("heard.keys.at(-1)")
    last = [state for state in states if state[1] == states[-1][1] and state[0] > key]
    first = next(time for time, _, spp, phase in last if spp >= 1 and phase != "moving")
    begin = next(time for time, _, _, phase in last if phase == "rendering")
    end = next(time for time, _, _, phase in last if phase == "done")
    return first - key, end - begin


def rendered(words: list[str]) -> float:
    """Milliseconds of rendering of `alight render`, without those of loading and compiling."""
    with TemporaryDirectory() as folder:
        stats = Path(folder) / "stats.json"
        command = [sys.executable, "-m", "alight", "render", *words, "--quiet"]
        command += ["--stats", str(stats), "-o", str(Path(folder) / "picture.png")]
        subprocess.run(command, check=True)
        return 1000.0 * json.loads(stats.read_text())["seconds"]["render"]


def main() -> None:
    """Measure, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene")
    parser.add_argument("--size", default="640x360")
    parser.add_argument("--moves", type=int, default=100)
    parser.add_argument("--spp", type=int, default=64)
    options = parser.parse_args()
    words = [options.scene, "--size", options.size, "--spp", str(options.spp)]
    with served(*words) as address, launched() as browser:
        page, _ = opened(browser, address, script=LISTEN)
        # The first key compiles the kernel that finds the pivot.
        moved(page, 1)
        until(page, "heard.states.at(-1)?.[3] === 'done'", 600.0)
        photons = moved(page, options.moves)
        first, viewed = settled(page)
    alone = rendered(words)
    photons.sort()
    figures = (
        ("camera event to photon, median", statistics.median(photons), "ms"),
        ("camera event to photon, p95", photons[int(0.95 * (len(photons) - 1))], "ms"),
        ("last event to first full sample", first, "ms"),
        ("speed over alight render", alone / viewed, ""),
    )
    rows = [{"what": what, "value": value, "unit": unit} for what, value, unit in figures]
    for row in rows:
        print_json(**row)
    print_table(rows)


if __name__ == "__main__":
    main()
