"""``alight render``: a scene becomes a picture with an error bar."""

from __future__ import annotations

import functools
from dataclasses import replace
from pathlib import Path
from typing import Any

from alight.cli import arguments, promises
from alight.cli.reporting import note_unused, warn

DEFAULT_SCENE = "cornell-box"


def render(
    scene: arguments.SceneName = DEFAULT_SCENE,
    output: arguments.Output = None,
    spp: arguments.Spp = None,
    time_limit: arguments.TimeLimit = None,
    seed: arguments.Seed = 0,
    first_sample: arguments.FirstSample = 0,
    replicates: arguments.Replicates = None,
    threads: arguments.Threads = None,
    spp_per_pass: arguments.SppPerPass = None,
    error: promises.Error = None,
    confidence: promises.Confidence = "95%",
    metric: promises.Metric = "relrmse",
    share: promises.Share = "95%",
    max_time: promises.MaxTime = None,
    max_spp: promises.MaxSpp = None,
    adaptive: promises.Adaptive = False,
    criterion: promises.Criterion = "pilot",
    checkpoint: arguments.Checkpoint = None,
    every: arguments.Every = "60s",
    size: arguments.Size = None,
    crop: arguments.Crop = None,
    camera: arguments.CameraName = None,
    integrator: arguments.IntegratorName = None,
    sampler: arguments.SamplerName = None,
    filter_name: arguments.FilterName = None,
    max_depth: arguments.MaxDepth = None,
    rr_depth: arguments.RrDepth = None,
    assignments: arguments.Assignments = None,
    plugin: arguments.Plugins = None,
    define: arguments.Definitions = None,
    lenient: arguments.Lenient = False,
    root: arguments.Root = None,
    aov: arguments.Layers = None,
    exposure: arguments.Exposure = "0",
    white_balance: arguments.WhiteBalance = "none",
    tone_map: arguments.ToneMap = "none",
    bits: arguments.Bits = 8,
    denoise: arguments.Denoise = False,
    stats: arguments.Stats = None,
    quiet: arguments.Quiet = False,
) -> None:
    """Render a scene, by default the Cornell box."""
    from alight.cli.finishing import Results, run_and_finish
    from alight.cli.loading import load_scene
    from alight.cli.options import changes_of, parse_names, parse_seconds
    from alight.cli.resume import notes_of
    from alight.films.denoising import FEATURES
    from alight.outputs.display import Display
    from alight.rendering import render as render_scene

    # Everything that can be wrong is found before the first second is spent.
    display = Display(exposure, tone_map, bits, white_balance)
    outputs = output or [Path(f"{Path(scene).stem}.png")]
    results = Results(outputs, display, denoise, stats, checkpoint, quiet)
    results.check()
    options = {
        "size": size, "crop": crop, "camera": camera, "integrator": integrator, "sampler": sampler,
        "filter": filter_name, "max_depth": max_depth, "rr_depth": rr_depth,
        "replicates": replicates,
    }  # fmt: skip
    description = load_scene(
        scene,
        changes_of(options, assignments or []),
        plugin=plugin,
        define=define,
        lenient=lenient,
        root=root,
    )
    if not quiet:
        note_unused(scene, description)
    layers = parse_names(aov)
    if denoise:
        layers = tuple(dict.fromkeys([*layers, *FEATURES.values()]))
    warnings = [*description.warnings, *_useless_options(outputs, display, parse_names(aov))]
    for warning in warnings:
        warn(warning)
    sampling: dict[str, Any] = {
        "spp": spp, "time_limit": time_limit, "seed": seed, "threads": threads,
        "replicates": description.film.replicates, "spp_per_pass": spp_per_pass,
        "first_sample": first_sample, "aovs": layers,
    }  # fmt: skip
    steering = {
        "error": error, "confidence": confidence, "metric": metric, "share": share,
        "max_spp": max_spp, "adaptive": adaptive, "criterion": criterion,
    }  # fmt: skip
    default_spp = description.source.remarks.spp or 64
    sampling["schedule"] = promises.schedule_of(steering, spp, first_sample, default_spp)
    if max_time is not None:
        time_limit = sampling["time_limit"] = parse_seconds("--max-time", max_time)
    if checkpoint is not None:
        sampling["checkpoint"] = checkpoint
        sampling["every"] = parse_seconds("--every", every)
        sampling["notes"] = notes_of(outputs, plugin, display, denoise)
    results = replace(results, warnings=warnings)
    run_and_finish(functools.partial(render_scene, description, **sampling), results, time_limit)


def _useless_options(outputs: list[Path], display: Any, layers: tuple[str, ...]) -> list[str]:
    """Say which options have no effect on any of the files."""
    from alight.films.storage import is_film_file
    from alight.outputs.display import Display
    from alight.outputs.image import format_of

    pictures = [path for path in outputs if not is_film_file(path)]
    formats = [format_of(path) for path in pictures]
    keeps_layers = len(pictures) < len(outputs) or any(m.KEEPS_LAYERS for m in formats)
    found = []
    if display != Display() and not any(module.IS_DISPLAY for module in formats):
        found.append(
            "--exposure, --white-balance, --tone-map and --bits change display formats "
            "(PNG, JPEG) only"
        )
    if layers and not keeps_layers:
        found.append("--aov: only EXR keeps layers; add -o FILE.exr")
    return found
