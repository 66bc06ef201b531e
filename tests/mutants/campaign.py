"""Random slips against the suite: ``python -m tests.mutants.campaign --seed 1 --count 500``.

Each mutant is one slip (`operators`) in a copy of the project, on which the tests that concern the
file (`selection`) run until one fails (`trial`). Which mutants are tried depends on the seed alone:
a run that was stopped goes on where it stood, and a larger count only adds to a smaller one.
"""

from __future__ import annotations

import argparse
import json
import random
import re
import shutil
import tempfile
import time
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from hashlib import sha256
from itertools import islice
from pathlib import Path
from typing import Any

from tests.mutants.equivalent import EQUIVALENT
from tests.mutants.operators import Site, planted, sites_of
from tests.mutants.selection import ELSEWHERE, models_of, select_tests
from tests.mutants.trial import Result, Trial, copy_project, serve

ROOT = Path(__file__).parents[2]

#: Processor seconds in one test after which a program counts as hanging.
HANGS = 150.0

#: What a program says that did not get as far as a wrong number.
CRASHED = re.compile(r"(alight\S*|Type|Attribute|Name|Index|Unbound\w+|\w*Typing)Error|hangs")


def sample(sites: list[Site], seed: int) -> Iterator[Site]:
    """All sites in random order: a folder, a file in it, an operator, and one of its places.

    The chance of each goes with the square root of its size, so that what is large and frequent
    leads without drowning the rest. Within a group the order is that of a digest of the names: a
    change elsewhere in the package leaves it as it is.
    """
    chance = random.Random(seed)
    tree: _Tree = {}
    for site in sites:
        files = tree.setdefault(site.folder, {})
        files.setdefault(site.file, {}).setdefault(site.operator, []).append(site)
    for files in tree.values():
        for operators in files.values():
            for group in operators.values():
                group.sort(key=lambda site: sha256(f"{seed} {site.name}".encode()).digest())
    while tree:
        yield _take(chance, tree)


#: Folder, file, operator.
_Tree = dict[str, dict[str, dict[str, list[Site]]]]


def _take(chance: random.Random, group: Any) -> Site:
    """Draw a site from a tree or list, and remove it with what it leaves empty."""
    if isinstance(group, list):
        return group.pop()
    name = _drawn(chance, {name: _size(of) for name, of in group.items()})
    site = _take(chance, group[name])
    if not group[name]:
        del group[name]
    return site


def _size(group: Any) -> int:
    return len(group) if isinstance(group, list) else sum(map(_size, group.values()))


def _drawn(chance: random.Random, sizes: dict[str, int]) -> str:
    return chance.choices(list(sizes), [size**0.5 for size in sizes.values()])[0]


class Campaign:
    """Tries mutants, and learns which tests are cheap and which find what."""

    def __init__(self, trial: Trial, seconds: float):
        self.trial, self.seconds = trial, seconds
        self.costs: dict[str, float] = {}
        self.kills: dict[str, Counter[str]] = defaultdict(Counter)
        self.sound: dict[str, bool] = {}
        self.items_of: dict[str, list[str]] = defaultdict(list)
        for name in trial.items:
            self.items_of[name.partition("::")[0]].append(name)

    def learn(self, record: dict[str, Any]) -> None:
        """Take over what a mutant taught."""
        if record["verdict"] == "killed":
            self.kills[record["file"]][record["test"]] += 1

    def order(self, file: str) -> list[str]:
        """Tests that found other slips in the file, then the near ones, then the others."""
        kills = self.kills[file]
        found = [test for test in kills if test in self.trial.items]
        found.sort(key=lambda test: self.costs.get(test, 0.0) / kills[test])
        rest = [
            (self.strangeness(test, file) + self.rank(test, place) + (not near), place, test)
            for near, files in zip(
                (True, False), select_tests(self.trial.folder, file), strict=True
            )
            for place, name in enumerate(files)
            for test in self.items_of[name]
        ]
        chosen = dict.fromkeys([*found, *(test for *_, test in sorted(rest, key=lambda r: r[:2]))])
        return [test for test in chosen if self.sound.get(test, True)]

    def strangeness(self, test: str, file: str) -> int:
        """-1 for a test called like the file, 0 like a model in it, 2 like another one."""
        if Path(file).stem.partition("_")[0].rstrip("s") in test:
            return -1
        words = set(re.findall(r"[a-z]{3,}", test.partition("[")[2]))
        if models_of(self.trial.folder, file) & (words | set(test.partition("::")[2].split("_"))):
            return 0
        folder = self.trial.folder / "alight" / Path(file).parent
        others = {path.stem.partition("_")[0] for path in folder.glob("*.py")}
        return 2 if others & words else 1

    def rank(self, test: str, place: int) -> int:
        """0 for a test that takes moments, 3 for one that takes long; by its place if unknown."""
        seconds = self.costs.get(test, 0.2 + 0.1 * place)
        return sum(seconds > border for border in (0.5, 3.0, 12.0))

    def run(self, tests: list[str], seconds: float, plant: Any) -> Result:
        """As `Trial.run`, with the costs kept."""
        result = self.trial.run(tests, seconds, plant)
        # With kernels that were compiled before, a test is cheaper than it will be.
        for test, duration in result.durations.items():
            self.costs[test] = max(duration, self.costs.get(test, 0.0))
        return result

    def try_site(self, site: Site) -> dict[str, Any]:
        """Plant one slip and run the tests that concern it."""
        source = (self.trial.folder / "alight" / site.file).read_bytes()
        plant = (site.file, planted(source, site))
        started = time.perf_counter()
        tests = self.order(site.file)
        while True:
            result = self.run(tests, self.seconds, plant)
            if result.verdict != "failed" or self.is_sound(result.test):
                break
            print(f"fails without any slip: {result.test}", flush=True)
            tests = [test for test in tests if self.sound.get(test, True)]
        verdicts = {"passed": "survived", "failed": "killed", "died": "killed"}
        verdict, says = verdicts.get(result.verdict, "unfinished"), result.says
        if verdict == "unfinished" and self.hangs(result):
            verdict, says = "killed", "hangs"
        record = {
            "name": site.name, "file": site.file, "line": site.line, "operator": site.operator,
            "verdict": verdict, "test": result.test, "says": says, "cpu": round(result.seconds, 1),
            "seconds": round(time.perf_counter() - started, 1), "tests": len(result.durations),
        }  # fmt: skip
        self.learn(record)
        return record

    def hangs(self, result: Result) -> bool:
        """True if one test took far longer than any test does: in the suite it would time out."""
        spent = result.seconds - sum(result.durations.values())
        return result.test != "" and spent > HANGS

    def is_sound(self, test: str) -> bool:
        """True if a test passes without any slip."""
        if test not in self.sound:
            self.sound[test] = self.run([test], 300.0, None).verdict == "passed"
        return self.sound[test]


# ---------------------------------------------------------------- what is said


def summary(records: Iterable[dict[str, Any]]) -> str:
    """Counts per folder and operator."""
    lines = []
    records = list(records)
    for record in records:
        record["folder"] = record["file"].partition("/")[0]
    for key in ("folder", "operator"):
        groups: dict[str, Counter[str]] = defaultdict(Counter)
        for record in records:
            verdict = record["verdict"]
            if verdict != "killed" and record["name"] in EQUIVALENT:
                verdict = "equivalent"
            for name in (record[key], "all"):
                groups[name][verdict] += 1
                groups[name]["crashed"] += bool(CRASHED.match(record["says"]))
        lines.append(f"{key:<22} killed (crashed) equivalent survived unfinished   rate")
        for name, of in sorted(groups.items(), key=lambda item: (item[0] == "all", item[0])):
            counted = of["killed"] + of["survived"] + of["unfinished"]
            rate = of["killed"] / counted if counted else 1.0
            lines.append(
                f"{name:<22} {of['killed']:>6} {of['crashed']:>9} {of['equivalent']:>10} "
                f"{of['survived']:>8} {of['unfinished']:>10} {rate:>6.1%}"
            )
        lines.append("")
    return "\n".join(lines)


def read(path: Path) -> dict[str, dict[str, Any]]:
    """The last record of each mutant in a file of results."""
    if not path.is_file():
        return {}
    records = map(json.loads, path.read_text("utf-8").splitlines())
    return {record["name"]: record for record in records}


def main() -> None:
    """Try mutants and say what became of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=0, help="which mutants")
    parser.add_argument("--count", type=int, default=500, help="how many")
    parser.add_argument("--save", type=Path, default=Path("mutants.jsonl"), help="results")
    parser.add_argument("--limit", type=float, default=600.0, help="processor seconds for each")
    parser.add_argument("--root", type=Path, default=ROOT, help="the project to copy")
    parser.add_argument("--work", type=Path, help="folder of the copy and of its kernels")
    parser.add_argument("--again", default="", help="try anew: survived,unfinished")
    parser.add_argument("--only", default="", help="a regular expression for names")
    parser.add_argument("--report", action="store_true", help="only say what is known")
    asked = parser.parse_args()
    save = asked.save.resolve()
    known = read(save)
    chosen = []
    if not asked.report:
        for site in islice(sample(sites_of(asked.root / "alight"), asked.seed), asked.count):
            old = known.get(site.name)
            again = old is not None and old["verdict"] in asked.again.split(",")
            if (old is None or again) and re.search(asked.only, site.name):
                chosen.append(site)

    def try_all(trial: Trial) -> None:
        campaign = Campaign(trial, asked.limit)
        costs = save.with_suffix(".costs.json")
        if costs.is_file():
            campaign.costs.update(json.loads(costs.read_text()))
        for record in known.values():
            campaign.learn(record)
        for site in chosen:
            record = known[site.name] = {"seed": asked.seed, **campaign.try_site(site)}
            with save.open("a", encoding="utf-8") as file:
                file.write(json.dumps(record) + "\n")
            costs.write_text(json.dumps(campaign.costs))
            print(f"{record['verdict']:<10} {record['cpu']:>6.1f} s  {site.name[:150]}  "
                  f"{record['test']}", flush=True)  # fmt: skip

    if chosen:
        work = (asked.work or Path(tempfile.mkdtemp(prefix="mutants-"))).resolve()
        copy = copy_project(asked.root, work / "copy")
        serve(copy, work / "kernels", sorted(ELSEWHERE), try_all)
        if asked.work is None:
            shutil.rmtree(work)
    print(summary(known.values()))


if __name__ == "__main__":
    main()
