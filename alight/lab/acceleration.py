"""What a tree is worth: time of a sample against the number of triangles.

A bumpy ball of more and more triangles on a floor of two, lit by ambient occlusion (a ray to the
surface, a ray from it). Every ray against every triangle; a tree divided at the median; a tree
divided by the surface area heuristic.

Source: MacDonald and Booth, Heuristics for ray tracing using space subdivision, The Visual
Computer 6 (1990); PBR4 section 7.3.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from alight.compiled.scene import CompiledScene, compile_scene
from alight.formats import loads
from alight.lab.arms import digest, seed_of
from alight.lab.replicates.measure import compiled_kernels, render_ladder
from alight.lab.replicates.session import Session, StudyProgress
from alight.lab.results import Curve, CurveResult, TableResult
from alight.lab.statistics.intervals import log_slope, positive_interval
from alight.metrics.estimate import Estimate
from alight.scene import Scene, flatten
from lanewise.machine import fingerprint

#: Name -> (label, structure, builder, most triangles of the ball).
METHODS: dict[str, tuple[str, str, str, int]] = {
    "list": ("every triangle", "list", "sah", 8192),
    "median": ("median split", "bvh", "median", 1 << 19),
    "sah": ("surface area heuristic", "bvh", "sah", 1 << 19),
}

#: Rings of the ball are doubled until it has this many triangles.
_QUICK_MOST = 32768

_SIZE, _SPP, _QUICK_SPP = 128, 4, 1


def bumpy_ball(triangles: int) -> dict[str, np.ndarray]:
    """Vertices and faces of a bumpy ball of about this many triangles."""
    rings = max(2, round((triangles / 4.0) ** 0.5))
    sectors = 2 * rings
    theta, phi = np.meshgrid(
        np.linspace(0.0, np.pi, rings + 1), np.linspace(0.0, 2.0 * np.pi, sectors + 1),
        indexing="ij",
    )  # fmt: skip
    radius = 1.0 + 0.08 * np.sin(9.0 * theta) * np.sin(11.0 * phi) * np.sin(theta)
    x = radius * np.sin(theta) * np.cos(phi)
    z = radius * np.sin(theta) * np.sin(phi)
    vertices = np.stack([x, radius * np.cos(theta), z], axis=-1).reshape(-1, 3)
    corner = (np.arange(rings)[:, None] * (sectors + 1) + np.arange(sectors)).ravel()
    right, below = corner + 1, corner + sectors + 1
    faces = np.concatenate(
        [np.stack([corner, right, below], axis=-1), np.stack([right, below + 1, below], axis=-1)]
    )
    return {"vertices": vertices.astype(np.float32), "faces": faces.astype(np.int32)}


#: A floor, and a triangle in the place of the ball.
SCENE = """
alight: 1
camera:
  type: pinhole
  fov: 32
  transform: {look_at: {origin: [0, 1.5, 5], target: [0, -0.1, 0]}}
integrator: ambient_occlusion
nodes:
  floor:
    shape: rectangle
    transform:
      - scale: 20
      - rotate: {axis: x, angle: -90}
      - translate: [0, -1.1, 0]
  ball:
    shape: {type: mesh, vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], faces: [[0, 1, 2]]}
"""


def scene_of(triangles: int) -> Scene:
    """The ball over its floor."""
    scene = loads(SCENE, "acceleration")
    ball = scene.nodes["ball"]
    assert ball.shape is not None
    shaped = ball.replaced(shape=ball.shape.replaced(**bumpy_ball(triangles)))
    film = scene.film.replaced(size=(_SIZE, _SIZE))
    return scene.replaced(film=film, nodes={**scene.nodes, "ball": shaped})


def counts_of(most: int) -> list[int]:
    """Triangle counts, a factor 4 apart."""
    return [n for n in (4**k * 2 for k in range(2, 12)) if n <= most]


def run_acceleration(session: Session) -> tuple[list[CurveResult], list[TableResult]]:
    """Time of a sample and of the build against triangles, and a table of both."""
    spp = _QUICK_SPP if session.quick else _SPP
    limit = _QUICK_MOST if session.quick else max(method[3] for method in METHODS.values())
    jobs = [
        (triangles, name)
        for triangles in counts_of(limit)
        for name, method in METHODS.items()
        if triangles <= method[3]
    ]
    measured: dict[tuple[int, str], dict[str, Any]] = {}
    order = np.random.default_rng(seed_of("order", session.study.seed))
    for number, triangles in enumerate(sorted({n for n, _ in jobs})):
        session.progress(StudyProgress(f"{triangles} triangles", number, len(counts_of(limit))))
        names = [name for n, name in jobs if n == triangles]
        for name, found in _measure(session, triangles, names, spp, order).items():
            measured[triangles, name] = found
    return _diagrams(jobs, measured), [_table(jobs, measured)]


def _measure(
    session: Session, triangles: int, names: list[str], spp: int, order: np.random.Generator
) -> dict[str, dict[str, Any]]:
    """Times of all methods at one number of triangles, replicates in random order."""
    keys = {
        name: digest("acceleration", triangles, name, spp, session.replicates, fingerprint())
        for name in names
    }
    found = {name: session.store.fact(key) for name, key in keys.items()}
    ready: dict[str, CompiledScene] = {}
    flat = flatten(scene_of(triangles)) if None in found.values() else None
    for name in names:
        if found[name] is None:
            assert flat is not None
            _, structure, builder, _ = METHODS[name]
            begin = time.perf_counter()
            for _ in range(2):
                # The first build may compile its kernels; the second one is measured.
                ready[name] = compile_scene(flat, structure=structure, builder=builder)
            loaded = time.perf_counter()
            stats = ready[name].stats
            found[name] = {
                "build": stats["seconds"], "bytes": stats.get("bytes"), "seconds": [],
                "cost": stats.get("sah_cost"),
            }  # fmt: skip
            session.seconds["load"] += loaded - begin
    kernels = {}
    for name, scene in ready.items():
        begin = time.perf_counter()
        kernels[name] = compiled_kernels(scene)
        session.seconds["compile"] += time.perf_counter() - begin
    for number in range(session.replicates):
        for i in order.permutation(len(names)).tolist():
            name = names[i]
            if name in ready:
                seed = seed_of("acceleration", session.study.seed, triangles, name, number)
                rung = next(
                    render_ladder(ready[name], kernels[name], 1, seed, [spp], session.threads)
                )
                found[name]["seconds"].append(rung.seconds / (spp * _SIZE * _SIZE))
                session.seconds["render"] += rung.seconds
    for name in ready:
        session.store.keep(keys[name], found[name])
    return found


def _diagrams(jobs: list, measured: dict) -> list[CurveResult]:
    speed, build = [], []
    for name, (label, *_) in METHODS.items():
        counts = [n for n, other in jobs if other == name]
        seconds = np.array([measured[n, name]["seconds"] for n in counts]) * 1e6
        intervals = [positive_interval(row) for row in seconds]
        x = [float(n) for n in counts]
        late = np.array(counts) >= 512
        repeated = np.repeat(np.array(x)[:, None], seconds.shape[1], axis=1)
        slope = log_slope(repeated[late], seconds[late])
        speed.append(
            Curve(
                name, label, x, [e.value for e in intervals], [e.low for e in intervals],
                [e.high for e in intervals], slope, 1.0 if name == "list" else None,
            )
        )  # fmt: skip
        if name != "list":
            times = [measured[n, name]["build"] for n in counts]
            build.append(Curve(name, label, x, times, list(times), list(times)))
    return [
        CurveResult(
            "time", "Time of a sample", "CPU time of one sample: two rays and their shading.",
            "triangles", "microseconds a sample", speed,
        ),
        CurveResult(
            "build", "Time of the build", "Seconds to build the tree, one thread.",
            "triangles", "seconds", build,
        ),
    ]  # fmt: skip


def _table(jobs: list, measured: dict) -> TableResult:
    rows = []
    for triangles, name in jobs:
        one = measured[triangles, name]
        sample = positive_interval(np.array(one["seconds"]) * 1e6)
        rows.append(
            [
                triangles, METHODS[name][0], list(Estimate(*sample)), one["build"],
                one["cost"] or "", one["bytes"] / 1e6 if one["bytes"] else "",
            ]
        )  # fmt: skip
    return TableResult(
        "acceleration", "Trees and lists",
        "Microseconds of a sample, seconds of the build, expected cost of a ray, memory.",
        ["triangles", "structure", "sample", "build", "cost", "megabytes"], rows,
    )  # fmt: skip
