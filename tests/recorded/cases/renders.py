"""Renders from end to end, by the NumPy reading of kernels: films, files, checkpoints, frames."""

from __future__ import annotations

import json
import threading
from pathlib import Path
from typing import Any

import numpy as np

import alight
from tests.recorded.making import by_twin, command, described, in_folder, outcome

SCENE = """alight: 1
camera:
  type: thin_lens
  fov: 47
  aperture_radius: 0.1
  focus_distance: 4.1
  transform: {look_at: {origin: [0.4, 1.3, 4.2], target: [0.1, 0.4, 0.2]}}
film: {size: [11, 9], replicates: 4, filter: {type: tent, radius: 0.8}}
integrator: {type: path, max_depth: 3}
sampler: {type: independent}
bsdfs:
  floor: {type: diffuse, reflectance: [0.7, 0.5, 0.2]}
  ball: {type: rough_conductor, metal: gold, alpha: 0.3}
nodes:
  floor: {shape: rectangle, bsdf: floor, transform: [{rotate: {axis: x, angle: -90}}, {scale: 3}]}
  group:
    transform: [{translate: [0.3, 0.6, 0.1]}]
    children:
      ball: {shape: {type: sphere, radius: 0.6}, bsdf: ball}
  lamp:
    shape: disk
    light: {type: area, radiance: [9, 8, 6]}
    transform: [{rotate: {axis: x, angle: 90}}, {translate: [-0.5, 2.7, 0.4]}]
environment: {type: constant, radiance: [0.1, 0.15, 0.3]}
"""

FILES = {"scene.yaml": SCENE}


def _stats(stats: Any) -> Any:
    """Without what the machine decides."""
    left_out = {"seconds", "msamples_per_s", "peak_rss_mb", "accelerator", "total_seconds", "wall"}
    return {k: described(v) for k, v in stats.items() if k not in left_out}


WORDS: dict[str, dict[str, Any]] = {
    "plain": {"spp": 5},
    "crop and layers": {
        "spp": 4,
        "crop": (2, 1, 7, 6),
        "aovs": ("albedo", "depth", "direct", "id"),
    },
    "seed, first and replicates": {
        "spp": 6,
        "seed": 8,
        "first_sample": 3,
        "replicates": 3,
        "integrator": "direct",
    },
    "error": {"error": 0.9, "max_spp": 16},
    "adaptive": {"adaptive": True, "spp": 9, "size": (17, 9)},
    "transparent": {"background": "transparent", "spp": 3},
    "shadow": {"background": "shadow", "spp": 3},
    "mattes": {"spp": 2, "aovs": "cryptomatte"},
    "part": {"spp": 9, "part": "2/4"},
    "light paths": {"spp": 2, "integrator": "light", "filter": "box", "size": (6, 5)},
}


def films() -> dict[str, Any]:
    """What `alight.render` gives."""
    found: dict[str, Any] = {}
    with in_folder(FILES), by_twin():
        for name, words in WORDS.items():
            told: list[Any] = []

            def heard(progress: Any, told: list[Any] = told) -> None:
                told.append([progress.phase, progress.total_samples, progress.note])

            film = outcome(lambda words=words, heard=heard: _film(words, heard))
            if isinstance(film, dict):
                film["progress"] = told[:2] + told[-1:]
            found[name] = film
    return found


def _film(words: dict[str, Any], heard: Any) -> dict[str, Any]:
    film = alight.render("scene.yaml", threads=1, progress=heard, **words)
    return {
        "image": described(film.image, 12),
        "error": described(film.standard_error, 12),
        "layers": {n: described(film.aov(n), 12) for n in film.aov_channels},
        "stats": _stats(film.stats),
        "alpha": described(film.alpha, 12),
        "largest": film.largest_sample,
        "options": described(film.options),
        "cells": sorted({repr(c) for c in film.cells.ravel()}),
        "seed": film.seed,
        "crop": film.crop,
    }


RENDER = ("render", "scene.yaml", "--threads", "1")
CHECKPOINT = (
    *RENDER, "--spp", "4", "--checkpoint", "a.checkpoint", "-o", "b.exr", "--size", "9x8",
)  # fmt: skip
#: Commands by what they are for; later ones take files of earlier ones.
LINES = {
    "render": (
        *RENDER,
        "--spp",
        "4",
        "-o",
        "a.png",
        "-o",
        "a.exr",
        "--stats",
        "a.json",
        "--aov",
        "albedo",
    ),
    "checkpoint": CHECKPOINT,
    "again": CHECKPOINT,
    "resume": ("resume", "a.checkpoint", "--spp", "7", "-o", "c.exr", "--threads", "1"),
    "resume to less": ("resume", "a.checkpoint", "--spp", "2", "-o", "d.exr"),
    "part 1": (*RENDER, "--spp", "6", "--part", "1/2", "-o", "p1.alight"),
    "part 2": (*RENDER, "--spp", "6", "--part", "2/2", "-o", "p2.alight", "-q"),
    "merge": ("merge", "p1.alight", "p2.alight", "-o", "p.exr", "-o", "p.png"),
    "merge twice": ("merge", "p1.alight", "p1.alight", "-o", "q.exr"),
    "merge to a text": ("merge", "p1.alight", "-o", "q.txt"),
    "tonemap": ("tonemap", "a.exr", "--exposure", "1", "--tone-map", "aces", "-o", "t.png"),
    "tonemap a film": ("tonemap", "p1.alight", "--white-balance", "3200K"),
    "tonemap a png": ("tonemap", "a.png"),
    "tonemap to exr": ("tonemap", "a.exr", "-o", "t.exr"),
    "info of a film": ("info", "p1.alight"),
    "info of a picture": ("info", "a.exr"),
    "info of a png": ("info", "a.png"),
    "info of a checkpoint": ("info", "a.checkpoint"),
    "compare": ("compare", "a.exr", "p.exr", "--no-flip"),
    "compare, json": (
        "compare",
        "a.exr",
        "p.exr",
        "--no-flip",
        "--json",
        "--fail-above",
        "rmse=1e-6",
    ),
    "compare with": (
        "compare",
        "a.exr",
        "a.png",
        "--reference",
        "p.exr",
        "--no-flip",
        "-o",
        "d.npy",
    ),
    "compare a layer": ("compare", "a.exr", "a.exr", "--layer", "albedo", "--no-flip"),
    "compare sizes": ("compare", "a.exr", "c.exr"),
    "compare limit": ("compare", "a.exr", "p.exr", "--fail-above", "rms=1"),
    "quiet": (*RENDER, "--spp", "1", "-o", "e.png", "--quiet"),
    "useless": (*RENDER, "--spp", "1", "--bits", "16", "-o", "f.exr"),
    "no folder": (*RENDER, "-o", "none/a.png"),
    "no suffix": (*RENDER, "-o", "a"),
    "part alone": (*RENDER, "--part", "1/2", "-o", "a.png"),
    "error": (*RENDER, "--error", "70%", "--max-spp", "16", "-o", "g.png"),
    "error not met": (*RENDER, "--error", "1%", "--max-spp", "8", "-o", "g.png"),
    "frames": (
        *RENDER,
        "--frames",
        "3:5",
        "--spp",
        "1",
        "-o",
        "f_##.png",
        "-o",
        "f.gif",
        "--size",
        "6x5",
    ),
    "frames again": (
        *RENDER,
        "--frames",
        "2:4",
        "--spp",
        "1",
        "-o",
        "f_##.png",
        "--size",
        "6x5",
    ),
    "turntable": (
        *RENDER,
        "--turntable",
        "--frames",
        "0:3",
        "--spp",
        "1",
        "-o",
        "t_##.exr",
        "--size",
        "6x5",
        "-q",
    ),
    "frames of a film": (*RENDER, "--frames", "0:2", "-o", "a.alight"),
    "frames without number": (*RENDER, "--frames", "0:2", "-o", "a.png"),
    "fps alone": (*RENDER, "--fps", "12", "-o", "a.png"),
    "gif alone": (*RENDER, "-o", "a.gif"),
    "frames and stats": (*RENDER, "--frames", "0:2", "--stats", "s.json", "-o", "a_#.png"),
}


def commands() -> dict[str, Any]:
    """Commands that render, resume, merge and look at what was rendered."""
    found: dict[str, Any] = {}
    with in_folder(FILES) as folder, by_twin():
        for name, words in LINES.items():
            found[name] = command(*words)
        found["files"] = sorted(p.name for p in folder.iterdir())
        found["stats"] = _stats(json.loads(Path("a.json").read_text("utf-8")))
        found["frames as pictures"] = {
            p.name: described(alight.outputs.image.read_image(p), 9)
            for p in sorted(folder.glob("[ft]_*"))
        }
        found["pictures"] = {
            n: described(alight.outputs.image.read_image(n), 9)
            for n in ("a.exr", "c.exr", "p.exr", "t.png", "p1.png")
        }
    return found


def stopped() -> dict[str, Any]:
    """Renders that are cancelled, and what then goes on."""
    found: dict[str, Any] = {}
    with in_folder(FILES), by_twin():
        cancel = threading.Event()

        def after_first(progress: Any) -> None:
            if progress.done_samples:
                cancel.set()

        film = alight.render(
            "scene.yaml",
            spp=9,
            spp_per_pass=2,
            threads=1,
            checkpoint="a.checkpoint",
            cancel=cancel,
            progress=after_first,
            every=0,
            notes={"who": "me"},
        )
        found["stopped"] = [film.stats["verdict"], film.spp > 0]
        whole = alight.resume("a.checkpoint", threads=1)
        same = alight.render("scene.yaml", spp=9, threads=1)
        found["goes on"] = [bool(np.array_equal(whole.sums, same.sums)), whole.stats["verdict"]]
        found["to an error"] = described(
            alight.resume("a.checkpoint", error=0.8, max_spp=24, threads=1).stats["verdict"]
        )
        found["to a number"] = alight.resume("a.checkpoint", spp=12, threads=1).spp
        for name, words in {
            "less": {"spp": 4},
            "both": {"spp": 12, "error": 0.1},
            "wrong": {"seed": 3},
        }.items():
            found[name] = outcome(
                lambda words=words: alight.resume("a.checkpoint", threads=1, **words).spp
            )
        Path("b.checkpoint").write_bytes(Path("a.checkpoint").read_bytes()[:300])
        found["broken"] = outcome(alight.resume, "b.checkpoint")
        found["none"] = outcome(alight.resume, "none.checkpoint")
        found["a scene"] = outcome(alight.resume, "scene.yaml")
        from alight.films.archive import read_archive

        content = read_archive("a.checkpoint").content
        found["content"] = described(_without_times(content))
        found["lost"] = command(
            "render", "scene.yaml", "--checkpoint", "a.checkpoint", "--spp", "3"
        )
    return found


def _without_times(value: Any) -> Any:
    """Of a checkpoint: no seconds, no digests of this machine's code."""
    left_out = ("seconds", "fingerprint", "time", "tables", "version", "machine")
    if isinstance(value, dict):
        return {k: _without_times(v) for k, v in value.items() if k not in left_out}
    if isinstance(value, list):
        return [_without_times(v) for v in value]
    return value


CASES = {"films": films, "commands": commands, "stopped": stopped}
