"""Why pictures are noisy, what they will cost, one path through them, guides, clusters."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest import mock

import numpy as np

import alight
from alight.cluster import addresses, files
from alight.cluster.dispatch import Patience
from alight.cluster.files import read_cluster_file
from alight.cluster.status import Losses, WorkerStatus, dashboard_of, losses_of
from alight.compiled.scene import compile_scene
from alight.lab.guide import disks
from alight.lab.guide.hemisphere import hemisphere
from alight.lab.guide.incidence import arriving_light
from alight.lab.why import words
from alight.lab.why.explanation import Explanation
from alight.lab.why.maps import draw_maps
from alight.lab.why.shares import TECHNIQUES, Part, Shares, relative_weights
from alight.lab.why.trials import Trial, alternatives
from alight.metrics.estimate import Estimate
from alight.rendering import plan as plans
from alight.rendering.schedules.rare_noise import RareNoise
from alight.rendering.schedules.stopping import Promise
from alight.scene import flatten
from tests.recorded.cases.renders import FILES, SCENE
from tests.recorded.making import by_twin, command, described, in_folder, outcome, rows


def _shares() -> Shares:
    techniques = list(TECHNIQUES.values())
    parts = tuple(
        Part(
            d,
            techniques[(d + k) % len(techniques)],
            ("lamp", "sky")[k],
            ("floor", "", "ball")[(d * k) % 3],
        )
        for d in (1, 2, 3, 7)
        for k in (0, 1)
    )
    draw = np.random.default_rng(4)
    numerators = draw.random((8, 8)) * [9, 0.2, 4, 1, 0.05, 2, 0.5, -0.3]
    maps = draw.random((8, 4, 5))
    return Shares(parts, numerators, 0.8, 64, draw.random((4, 5, 3)), maps.sum(axis=0), maps)


TRIALS = (
    Trial(
        "sampler.type=sobol",
        Estimate(2.5, 2.1, 3.0),
        Estimate(0.9, 0.8, 1.0),
        Estimate(2.25, 1.8, 2.8),
        0.001,
    ),
    Trial(
        "integrator.light_sampling=bsdf",
        Estimate(0.5, 0.4, 0.6),
        Estimate(1.1, 1.0, 1.2),
        Estimate(0.55, 0.4, 0.7),
        0.01,
    ),
    Trial(
        "integrator.rr_depth=9",
        Estimate(1.1, 0.9, 1.3),
        Estimate(1.0, 0.9, 1.1),
        Estimate(1.1, 0.8, 1.4),
        0.4,
    ),
)


def why() -> dict[str, Any]:
    """The parts of a made-up picture's noise, in words and numbers."""
    shares = _shares()
    still = Shares(
        shares.parts,
        shares.numerators * 0,
        0.0,
        8,
        shares.picture,
        shares.variance * 0,
        shares.maps * 0,
    )
    explanation = list(Explanation.__dataclass_fields__)
    found: dict[str, Any] = {"fields": explanation, "parts": [str(p) for p in shares.parts]}
    for name, one in {"noisy": shares, "still": still}.items():
        found[name] = [
            list(words.share_lines(one)),
            described(list(words.share_tables(one))),
            {str(p): described(s) for p, s in words.ranked(one).items()},
        ]
    found["trials"] = [
        list(words.trial_lines(t, left))
        for t in (TRIALS, TRIALS[1:], ())
        for left in ((), ("a=1", "b=2"))
    ]
    found["plain"] = described(words.plain(shares, TRIALS, ["a=1"]))
    found["by"] = {
        f: {str(k): described(v) for k, v in shares.by(*f.split()).items()}
        for f in ("depth", "light material", "technique")
    }
    found["maps"] = [
        described(shares.map_of(p)) for p in (shares.parts[1], Part(light="sky"), Part())
    ]
    with mock.patch("alight.lab.why.maps.sheet_of", list):
        found["sheet"] = described(draw_maps(shares, shares.parts[:3]))
    found["weights"] = described(relative_weights(np.random.default_rng(1).random((4, 5, 3))))
    with in_folder(FILES):
        for scene in ("scene.yaml", "environment-map"):
            found[f"alternatives of {scene}"] = list(alternatives(alight.load(scene)))
            found[f"for light, {scene}"] = list(
                alternatives(alight.load(scene), Part(2, TECHNIQUES[max(TECHNIQUES)], "lamp", None))
            )
    return found


def costs() -> dict[str, Any]:
    """Plans of made-up pilots."""
    found = {}
    pilots = {
        "steady": {"seen": [(16, 0.1, 0.09), (32, 0.08, 0.05), (64, 0.06, 0.022)], "need": 7.0},
        "steep": {"seen": [(16, 0.1, 0.09), (32, 0.1, 0.02), (64, 0.1, 0.003)], "need": 2.0},
        "kept": {"seen": [(16, 0.3, 0.001), (32, 0.1, 0.0006), (64, 0.1, 0.0002)], "need": 1.0},
        "nothing": {"seen": [(16, 0.0, 0.0), (32, 0.0, 0.0), (64, 0.0, 0.0)], "need": 1.0},
        "flat": {"seen": [(16, 0.1, 0.09), (32, 0.1, 0.08), (64, 0.1, 0.085)], "need": 40.0},
        "rare": {
            "seen": [(16, 0.1, 0.09), (32, 0.08, 0.05), (64, 0.06, 0.022)],
            "need": 7.0,
            "met": 0.03,
            "rare": {"noise": 0.2, "piloted": 0.15, "size": 3.0},
        },
    }
    for name, words_ in pilots.items():
        of_rare = words_.pop("rare", {})
        for promise in (Promise(0.05), Promise(0.3, 0.99, "pixel", 0.9)):
            for replicates in (4, 5):
                pilot = plans.PilotSchedule(
                    promise,
                    passes=[0.5, 0.6, 1.3],
                    looks=[0.01, 0.03, 0.02],
                    rare=RareNoise(**of_rare),
                    **words_,
                )
                plan = outcome(plans.plan_of, pilot, replicates)
                found[f"{name}, {promise.metric}, {replicates}"] = plan
    made = plans.Plan(
        Estimate(1234.4, 900, 2000.6),
        Estimate(12.345, 9, 20.2),
        Estimate(-1.1, -1.2, -1.0),
        0.0345,
        64,
        3,
    )
    found["says"] = [str(made), made._repr_html_()]
    return found


def paths() -> dict[str, Any]:
    """Paths through pixels."""
    found: dict[str, Any] = {}
    with in_folder(
        {
            **FILES,
            "glass.yaml": SCENE.replace(
                "type: rough_conductor, metal: gold, alpha: 0.3", "type: dielectric, int_ior: 1.4"
            ),
        }
    ):
        for scene, pixel, words_ in (
            ("scene.yaml", (4, 3), {}),
            ("scene.yaml", (5, 6), {"sample": 3, "seed": 5}),
            ("scene.yaml", (0, 0), {"max_depth": 2}),
            ("glass.yaml", (6, 4), {"integrator": "path"}),
            ("scene.yaml", (5, 5), {"integrator": "direct", "sampler": "sobol"}),
            ("scene.yaml", (40, 3), {}),
        ):
            found[f"{scene} {pixel} {words_}"] = outcome(
                lambda s=scene, p=pixel, w=words_: _trace(s, p, w)
            )
        found["command"] = command("trace", "scene.yaml", "--pixel", "4,3", "--sample", "1")
    return found


def _trace(scene: str, pixel: tuple[int, int], words_: dict[str, Any]) -> Any:
    found = alight.trace(scene, pixel, **words_)
    return [str(found), described(found.to_dict()), getattr(found, "_repr_html_", str)()]


def guides() -> dict[str, Any]:
    """Disks of directions, and what arrives at a point from each."""
    found: dict[str, Any] = {}
    for upper in (True, False):
        for side in (5, 8):
            found[f"{side}, {upper}"] = described(hemisphere(side, upper=upper, bottom=0.4), 12)
    draw = np.random.default_rng(2)
    disk = hemisphere(6)
    names = ("ideal", "of_bsdf", "of_guide", "of_mixture", "weight")
    sides = [
        SimpleNamespace(
            name=name,
            disk=disk,
            light=draw.random((disk.w.shape[1], 3)) * (3 + n),
            **{one: draw.random(disk.w.shape[1]) * (k + 1) for k, one in enumerate(names)},
        )
        for n, name in enumerate(("outside", "inside"))
    ]
    with mock.patch("alight.lab.guide.disks.sheet_of", list):
        found["disks"] = [described(disks.draw_disks(sides[:n])) for n in (1, 2)]  # type: ignore[arg-type]
    with in_folder(FILES), by_twin(), mock.patch("alight.lab.guide.incidence.FACE", 8):
        scene = compile_scene(flatten(alight.load("scene.yaml")), structure="list")
        w = np.array(
            [
                [0, 1, 0],
                [1, 0.2, 0.3],
                [-1, 0.1, 0.4],
                [0.1, -1, 0.2],
                [0.2, 0.3, 1],
                [0.3, 0.5, -1],
            ]
        )
        w = (w / np.linalg.norm(w, axis=1, keepdims=True)).T
        place = np.array([0.1, 0.9, 0.8])
        for seed in (0, 7):
            light = arriving_light(scene, place, w, spp=4, seed=seed, threads=1)
            found[f"light, {seed}"] = described(light)
    return found


CLUSTERS = {
    "slurm": "type: slurm\nworkers: 3\nwait: 60\nkeys: keys\noptions: {queue: fast, cores: 4}\n",
    "ssh": "type: ssh\nhosts: [a, b, c]\nworkers: 2\n",
    "address": "type: address\naddress: tls://host:8786\nkeys: k\n",
    "address and workers": "type: address\naddress: tls://host:8786\nworkers: 3\n",
    "no type": "workers: 3\n",
    "wrong type": "type: slrum\n",
    "no hosts": "type: ssh\n",
    "one host": "type: ssh\nhosts: [a]\n",
    "hosts of slurm": "type: slurm\nhosts: [a, b]\n",
    "wrong key": "type: lsf\nworker: 3\n",
    "zero": "type: pbs\nworkers: 0\n",
    "truth": "type: pbs\nworkers: true\n",
    "text": "type: pbs\nwait: long\n",
    "list": "[1]\n",
    "empty": "",
    "broken": "type: {\n",
    "infinite": "type: sge\nwait: .inf\n",
    "options": "type: sge\noptions: 3\n",
}

ADDRESSES: tuple[tuple[Any, ...], ...] = (
    ("local:2",),
    ("local:0",),
    ("local:x",),
    ("local:99999",),
    ("tcp://127.0.0.1:8786",),
    ("tcp://localhost:1",),
    ("tcp://[::1]:5",),
    ("tcp://8.8.8.8:80",),
    ("tcp://127.0.0.1:8786", "k"),
    ("tls://host:8786",),
    ("tls://host:8786", "k"),
    ("tls://host:99999", "k"),
    ("tls://host:0", "k"),
    ("host:80",),
    ("",),
    (3,),
    ("ssh.yaml",),
    ("none.yaml",),
    ("address.yaml",),
    ("tls://" + "a" * 70 + ":5", "k"),
)


def clusters() -> dict[str, Any]:
    """Addresses, files of clusters and lines of their status."""
    found: dict[str, Any] = {}
    with in_folder({f"{n}.yaml": t for n, t in CLUSTERS.items()}):
        found["files"] = {n: outcome(read_cluster_file, f"{n}.yaml") for n in (*CLUSTERS, "none")}
        found["with keys"] = outcome(read_cluster_file, "ssh.yaml", Path("other"))
        found["addresses"] = {repr(a): outcome(addresses.check_address, *a) for a in ADDRESSES}
        found["processes"] = rows(
            addresses.processes_of, ["local:3", "local:1024", "local:1025", "local:", "tls://a:1"]
        )
        found["is a file"] = [
            files.is_cluster_file(n) for n in ("a.yaml", "a.YML", "a.json", "tls://a:1")
        ]
        found["keys"] = [command("cluster", "keys", *w) for w in (("none/deep",), ("ssh.yaml",))]
    one = WorkerStatus(
        address="tls://a:1",
        threads=1,
        tasks=1,
        memory=3 * 2**20 + 5,
        kind="znver4",
        rate=2.5e6,
        trouble="",
    )
    many = WorkerStatus(
        address="tls://b:2",
        threads=8,
        tasks=0,
        memory=0,
        kind="",
        rate=0.0,
        trouble="another version",
    )
    found["status"] = [str(one), str(many)]
    events = [
        (0, {"action": "remove-worker", "processing-tasks": ["a", "b"]}),
        (1, {"action": "remove-worker", "expected": True, "processing-tasks": ["c"]}),
        (2, "x"),
        (3, {"action": "add"}),
        (4, {"action": "remove-worker"}),
    ]
    client = mock.Mock(dashboard_link="http://x")
    client.get_events.return_value = events
    client.scheduler_info.return_value = {"services": {"dashboard": 1}}
    found["losses"] = [described(losses_of(client)), described(Losses(1, 2)), dashboard_of(client)]
    client.scheduler_info.return_value = {}
    found["no dashboard"] = dashboard_of(client)
    found["patience"] = described(Patience())
    return found


CASES = {"why": why, "costs": costs, "paths": paths, "guides": guides, "clusters": clusters}
