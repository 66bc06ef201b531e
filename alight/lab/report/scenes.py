"""One scene of a report: its sentence, tables, diagrams, crops and maps, ready for the page."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from alight.core.constants import LUMINANCE
from alight.lab.report import pictures, tables
from alight.lab.report.charts import Line, diagram
from alight.lab.report.numbers import interval, number
from alight.lab.report.style import Look, looks
from alight.lab.results import BIASED, DISPUTED, ArmResult, SceneResult
from alight.metrics.epsilon import default_epsilon
from alight.metrics.estimate import Estimate

#: Frames around the crops in the reference, one a crop.
_FRAMES = ("#ffb000", "#00c2a8", "#ff5d8f", "#8f8bff")


def scene_context(scene: SceneResult, index: int) -> dict[str, Any]:
    """Everything that the page shows of a scene.

    Parameters
    ----------
    scene : SceneResult
    index : int
        Makes the ids of its figures unique on the page.
    """
    baseline = next((i for i, a in enumerate(scene.arms) if a.is_baseline), None)
    arm_looks = looks(len(scene.arms), baseline)
    arms = tables.ranked(scene, arm_looks)
    exposure = pictures.exposure_for(scene.reference_image)
    crops = crops_of(scene)
    return {
        "label": scene.label,
        "sentences": sentences(scene),
        "notes": scene.notes,
        "tables": {
            "efficiency": tables.efficiency_table(arms),
            "errors": tables.error_table(arms),
            "costs": tables.cost_table(arms),
            "truth": tables.truth_table(arms),
        },
        "diagrams": _diagrams(scene, arm_looks, f"s{index}"),
        "exposure": exposure,
        "reference": _reference(scene, crops, exposure),
        "crops": [_strip(scene, arms, crop, _FRAMES[i % len(_FRAMES)], exposure)
                  for i, crop in enumerate(crops)],
        "maps": _maps(arms, scene),
        "seeds": [(arm.label, " ".join(map(str, arm.seeds))) for arm, _ in arms],
        "options": [(arm.label, arm.options) for arm, _ in arms],
        "pairing": _pairing(scene),
        "reference_text": _reference_text(scene),
    }  # fmt: skip


def _pairing(scene: SceneResult) -> str:
    shared = "All arms share their seeds" if scene.paired else "No two arms share a seed"
    return f"{shared}; the order of rendering was drawn at random (seed {scene.order_seed})."


# -------------------------------------------------------------------------------- sentences


def sentences(scene: SceneResult) -> list[str]:
    """What was found, in words: the best arm, the significant ones, the biased ones."""
    base = next((a for a in scene.arms if a.is_baseline), None)
    named = base.label if base else scene.baseline
    gains = [(a, a.speedup) for a in scene.arms if a.speedup is not None]
    # An arm that computes something else cannot win.
    fair = [(a, s) for a, s in gains if tables.comparable(a)]
    fair = [(a, s) for a, s in fair if math.isfinite(s.ratio.value)]
    found = []
    if fair:
        arm, best = max(fair, key=lambda pair: pair[1].ratio.value)
        sure = best.significant
        if best.ratio.value > 1.0:
            found.append(
                f"{arm.label} has {interval(best.ratio, 3)} times the efficiency of {named}"
                + ("." if sure else ", but that may be chance.")
            )
        else:
            found.append(f"No arm is more efficient than {named}.")
        differing = sum(s.significant for _, s in fair)
        if len(fair) == 1:
            does = "differs" if differing else "does not differ"
            found.append(f"{arm.label} {does} significantly from {named} (5 %).")
        else:
            found.append(
                f"{differing} of {len(fair)} arms differ significantly from {named} (5 % over all "
                "arms, Holm)."
            )
    biased = [a.label for a in scene.arms if a.bias.verdict == BIASED]
    if biased:
        verb = "is" if len(biased) == 1 else "are"
        found.append(f"{_listed(biased)} {verb} biased: more time does not lead to the truth.")
    disputed = [a.label for a in scene.arms if a.bias.verdict == DISPUTED]
    if len(disputed) > 1:
        found.append(
            f"{_listed(disputed)} disagree, and no majority of the arms says which of them is "
            f"biased: errors are measured against {scene.reference.arm}."
        )
    elif disputed:
        found.append(f"{disputed[0]} disagrees with its own pictures of more samples.")
    return found


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _reference_text(scene: SceneResult) -> str:
    ref = scene.reference
    noise = f"{number(100.0 * ref.relative_noise, 2)} % relRMSE"
    known = "stated" if ref.declared else "measured, and subtracted from the errors"
    if ref.spp:
        start = f"{ref.source} with {ref.arm or 'an arm of its own'} at {ref.spp:,} spp"
        time = f", {number(ref.seconds)} s" if ref.seconds else ""
        return f"Reference: {start}{time}; its own noise is {noise} ({known}); key {ref.key}."
    return f"Reference: {ref.source}; its own noise is {noise} ({known}); key {ref.key}."


# --------------------------------------------------------------------------------- diagrams


def _rms(estimate: Estimate) -> Estimate:
    return Estimate(*(math.sqrt(v) if v > 0.0 else math.nan for v in estimate))


def _diagrams(scene: SceneResult, arm_looks: Sequence[Look], name: str) -> list[dict[str, str]]:
    kinds = (
        ("samples", "Samples a pixel", "At equal samples"),
        ("time", "CPU seconds", "At equal time"),
    )
    found = []
    for kind, x_label, title in kinds:
        lines = [_line(arm, look, kind) for arm, look in zip(scene.arms, arm_looks, strict=True)]
        svg = diagram(lines, x_label, "RMSE", f"{name}-{kind}", counts=kind == "samples")
        if svg:
            found.append({"svg": svg, "title": title})
    return found


def _line(arm: ArmResult, look: Look, kind: str) -> Line:
    """One arm's RMSE over samples or over time, with the slope that was fitted."""
    by_samples = kind == "samples"
    points = arm.samples if by_samples or not arm.times else arm.times
    slope = arm.slope_spp if by_samples else arm.slope_time
    errors = [_rms(p.mse) for p in points]
    x = [float(p.spp) if by_samples else p.seconds.value for p in points]
    expected = arm.expected_slope if by_samples else None
    y, low, high = ([e[i] for e in errors] for i in range(3))
    return Line(arm.label, look, x, y, low, high, slope, expected)


# -------------------------------------------------------------------------- crops and maps


def _relative_error(scene: SceneResult, arm: ArmResult) -> np.ndarray:
    """Expected squared relative error of one picture of an arm, per pixel."""
    reference = scene.reference_image.astype(np.float64)
    squared = arm.images.error.astype(np.float64) ** 2 + arm.images.variance
    scale = reference**2 + max(default_epsilon(reference), 1e-30)
    return (squared / scale).mean(axis=2)


def crops_of(scene: SceneResult) -> list[tuple[int, int, int, int]]:
    """The crops that the study names, or those where the arms' errors differ most."""
    if scene.crops:
        return [(x, y, w, h) for x, y, w, h in scene.crops]
    if not scene.arms:
        return []
    return pictures.choose_crops([_relative_error(scene, arm) for arm in scene.arms])


def _reference(
    scene: SceneResult, crops: Sequence[tuple[int, int, int, int]], exposure: float
) -> dict[str, Any]:
    h, w = scene.reference_image.shape[:2]
    frames = [
        {"x": x, "y": y, "w": cw, "h": ch, "color": _FRAMES[i % len(_FRAMES)]}
        for i, (x, y, cw, ch) in enumerate(crops)
    ]
    uri = pictures.picture_uri(scene.reference_image, exposure)
    return {"image": uri, "width": w, "height": h, "frames": frames, "line": max(w, h) / 160.0}


def _strip(
    scene: SceneResult,
    arms: tables.Ranked,
    crop: tuple[int, int, int, int],
    frame: str,
    exposure: float,
) -> dict[str, Any]:
    """One crop: the reference, then the arms from the most efficient down."""
    x, y, w, h = crop
    part = np.s_[y : y + h, x : x + w]
    shown = [{"label": "Reference", "note": "", "error": "", "color": "inherit",
              "image": pictures.picture_uri(scene.reference_image[part], exposure)}]  # fmt: skip
    for arm, look in arms:
        squared = _relative_error(scene, arm)[part]
        known = squared[np.isfinite(squared)]
        error = math.sqrt(known.mean()) if known.size else math.nan
        images = arm.images
        shown.append({
            "label": arm.label,
            "note": f"{images.example_spp:,} spp · {number(images.example_seconds, 2)}\u00a0s",
            "error": f"relRMSE {number(100.0 * error, 2)}\u00a0%",
            "color": look.color,
            "image": pictures.picture_uri(images.example[part], exposure),
        })  # fmt: skip
    return {
        "frame": frame,
        "pictures": shown,
        "columns": columns(len(shown)),
        "place": f"{w} × {h} pixels at ({x}, {y})",
    }


def columns(count: int) -> int:
    """Pictures in a row of a wide page: all, or rows of about the same length."""
    return count if count <= 8 else math.ceil(count / math.ceil(count / 7))


def _maps(arms: tables.Ranked, scene: SceneResult) -> list[dict[str, Any]]:
    """Error, noise and sample counts of all arms in false colour, each kind over one scale."""
    reference = scene.reference_image.astype(np.float64) @ LUMINANCE
    epsilon = max(default_epsilon(scene.reference_image), 1e-30)
    brightness = np.sqrt(reference**2 + epsilon)
    kinds: list[tuple[str, str, str, list[np.ndarray]]] = [
        (
            "signed", "Error",
            "Mean of all pictures minus the reference, as a share of its brightness.",
            [(arm.images.error @ LUMINANCE) / brightness for arm, _ in arms],
        ),
        (
            "log", "Variance",
            "Of one picture of about equal time, over the squared brightness.",
            [(arm.images.variance @ LUMINANCE) / brightness**2 for arm, _ in arms],
        ),
        ("linear", "Samples", "Of each pixel in one picture.", [a.images.count for a, _ in arms]),
    ]  # fmt: skip
    found = []
    for kind, title, text, planes in kinds:
        planes = [pictures.reduced(np.asarray(p, np.float64)) for p in planes]
        scale = pictures.Scale.of(planes, kind)
        found.append({
            "title": title,
            "text": text,
            "columns": columns(len(arms)),
            "bar": pictures.color_bar(scale, percent=kind == "signed"),
            "pictures": [
                {"label": arm.label, "color": look.color, "image": pictures.map_uri(plane, scale)}
                for (arm, look), plane in zip(arms, planes, strict=True)
            ],
        })  # fmt: skip
    return found
