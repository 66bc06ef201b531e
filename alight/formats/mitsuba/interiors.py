"""``<medium>``, ``<phase>`` and ``<volume>`` -> media of the native format.

Mitsuba's albedos and extinctions are ours. A grid volume fills the unit cube of its ``to_world``,
with values at the centres of cells, as ours does.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from alight.core.errors import SceneError, join_path, unknown_name
from alight.formats.mitsuba.colors import Role
from alight.formats.mitsuba.context import Context, Data
from alight.formats.mitsuba.draft import Draft
from alight.formats.mitsuba.properties import COLORS
from alight.formats.mitsuba.transforms import matrix_of, steps_of
from alight.formats.reading.reach import OutOfReachError
from alight.formats.reading.xml import Element
from alight.media.volumes import Volume
from alight.scene.volumes import box_of, read_volume

SIDES = ("interior", "exterior")
#: Integrators that see media; the others pass through them as through empty space.
SEEING = ("volpath", "volpathmis")


def of_shape(draft: Draft) -> bool:
    """Put the media on both sides of a shape into its node; whether it has any."""
    nested = draft.properties.take("medium")
    bounds_media = bool(nested) or any(draft.properties.has(side) for side in SIDES)
    for side in SIDES:
        found = [element for element in nested if element.name == side]
        reference = draft.properties.find(side)
        found += [] if reference is None else [reference]
        for surplus in found[1:]:
            draft.context.report.error(surplus, f"a shape has one {side} at most")
        for element in found[:1]:
            draft.put(side, medium(draft.context, element, join_path(draft.path, side)), side)
    for element in nested:
        if element.name not in SIDES:
            text = unknown_name("side of a shape", element.name, SIDES, listed_as="sides")
            draft.context.report.error(element, text)
    return bounds_media


def of_camera(draft: Draft) -> None:
    """Give the camera the medium that its sensor is in."""
    found = draft.properties.take("medium", "ref")
    for surplus in found[1:]:
        draft.context.report.error(surplus, "a sensor stands in one medium at most")
    for element in found[:1]:
        draft.put("medium", medium(draft.context, element, join_path(draft.path, "medium")))


def medium(context: Context, element: Element, path: str) -> str | Data | None:
    """Convert a medium, or a reference to one; None where it plays no part."""
    target = context.target(element, "medium")
    if target is None:
        return None
    if not context.sees_media:
        context.report.note(element, "plays no part: the integrator does not see media")
        return None
    if target.type not in COVERED:
        context.report.unknown(target, "medium", target.type, COVERED, "empty space is taken")
        return None
    context.uses_media = True

    def build(path: str) -> Data:
        draft = Draft(context, target, path, COVERED[target.type][0])
        draft.properties.ignore("lights are sampled in all media", "sample_emitters")
        draft.properties.ignore(
            "distances are sampled otherwise", "medium_sampling_mode", "sigma_n"
        )
        draft.number("scale")
        COVERED[target.type][1](draft)
        _phase(draft)
        draft.properties.finish()
        return draft.data

    return context.named("media", target, build) if "id" in target else build(path)


def _homogeneous(draft: Draft) -> None:
    volumes = {element.name: element for element in draft.properties.take("volume")}
    keys: tuple[tuple[str, Role], ...] = (
        ("sigma_t", "index"),
        ("albedo", "reflectance"),
        ("sigma_a", "index"),
        ("sigma_s", "index"),
    )
    for key, role in keys:
        if key in volumes:
            draft.put(key, _constant(draft, volumes.pop(key), role))
        else:
            draft.color(key, role=role)
    for element in volumes.values():
        draft.context.report.not_covered(element, "has no use in a homogeneous medium", "ignored")


def _heterogeneous(draft: Draft) -> None:
    p, report = draft.properties, draft.context.report
    p.ignore("the largest density of the whole grid is taken", "majorant_resolution_factor")
    volumes = {element.name: element for element in p.take("volume")}
    density = volumes.pop("sigma_t", None)
    if density is None or density.type != "gridvolume":
        report.error(draft.element, 'needs <volume name="sigma_t" type="gridvolume">')
        draft.put("values", Volume(np.zeros((1, 1, 1, 1), np.float32)))
        return
    grid, matrix = _grid(draft.context, density)
    draft.put("values", grid if grid.values.shape[3] == 1 else _mean_channel(draft, density, grid))
    draft.put("matrix", matrix)
    albedo = volumes.pop("albedo", None)
    if albedo is None:
        draft.color("albedo", role="reflectance")
    elif albedo.type == "constvolume":
        draft.put("albedo", _constant(draft, albedo, "reflectance"))
    else:
        values, of_albedo = _grid(draft.context, albedo)
        draft.put("albedo_values", values)
        if of_albedo != matrix:
            report.not_covered(albedo, "must fill the same box as the densities", "it is moved")
    for element in volumes.values():
        report.not_covered(element, "has no use in a heterogeneous medium", "ignored")


def _mean_channel(draft: Draft, element: Element, grid: Volume) -> Volume:
    text = "is not as dense for all colours: the mean of its channels is taken"
    draft.context.report.warn(element, text)
    return Volume(grid.values.mean(axis=3, keepdims=True))


def _constant(draft: Draft, element: Element, role: Role) -> list[float] | None:
    """The colour of a ``constvolume``."""
    inner = Draft(draft.context, element, draft.path)
    if element.type != "constvolume":
        draft.context.report.unknown(
            element, "volume", element.type, ("constvolume",), "the default is taken"
        )
        return None
    found = inner.properties.find("value")
    inner.properties.finish()
    if found is None or found.tag not in (*COLORS, "float", "integer"):
        draft.context.report.error(element, 'needs a colour of the name "value"')
        return None
    return draft.context.colors.read(found, role)


def _grid(context: Context, element: Element) -> tuple[Volume, list[float]]:
    """Values of a ``gridvolume``, and the rows of its matrix from the unit cube to the world."""
    p, report = Draft(context, element, "").properties, context.report
    if element.type != "gridvolume":
        report.unknown(
            element, "volume", element.type, ("gridvolume", "constvolume"), "an empty one is taken"
        )
    p.text("filter_type", "trilinear", ("trilinear",))
    p.text("wrap_mode", "clamp", ("clamp",))
    in_box = p.flag("use_grid_bbox", False)
    p.flag("raw", True)
    name = p.text("filename")
    matrix = matrix_of(steps_of(p))
    rows = matrix[:3].ravel().tolist()
    p.finish()
    try:
        path = context.reach.find(name)
        values = context.reach.files.read(read_volume, name, path)
        if in_box:
            rows = (matrix @ box_of(path, name))[:3].ravel().tolist()
        return values, rows
    except OutOfReachError as error:
        report.error(element, str(error))
    except SceneError as error:
        report.errors_of(element, error)
    return Volume(np.zeros((1, 1, 1, 1), np.float32)), rows


def _phase(draft: Draft) -> None:
    found = draft.properties.take("phase")
    for surplus in found[1:]:
        draft.context.report.error(surplus, "a medium has one phase function at most")
    for element in found[:1]:
        phase = Draft(draft.context, element, join_path(draft.path, "phase"))
        if element.type == "blendphase":
            g = _mean_cosine(draft.context, element)
            draft.context.report.warn(element, f"becomes one lobe with the same mean, g = {g:g}")
            draft.put("phase", {"type": "henyey_greenstein", "g": g})
        elif element.type in PHASES:
            phase.put("type", PHASES[element.type])
            if element.type == "hg":
                phase.number("g", 0.8)
            phase.properties.finish()
            draft.put("phase", phase.data)
        else:
            _unknown_phase(draft.context, element, "an isotropic one is taken")


def _unknown_phase(context: Context, element: Element, replacement: str) -> None:
    context.report.unknown(element, "phase function", element.type, PHASES, replacement)


def _mean_cosine(context: Context, element: Element) -> float:
    """Mean cosine of a phase function, perhaps made of others."""
    draft = Draft(context, element, "")
    p = draft.properties
    if element.type == "hg":
        g = p.number("g", 0.8)
    elif element.type == "blendphase":
        parts = p.take("phase")
        weight = p.number("weight", 0.5)
        if len(parts) != 2:
            context.report.error(element, f"must hold two phase functions, got {len(parts)}")
            return 0.0
        found = [_mean_cosine(context, part) for part in parts]
        g = found[0] + weight * (found[1] - found[0])
    else:
        if element.type not in PHASES:
            _unknown_phase(context, element, "isotropic is taken")
        g = 0.0
    p.finish()
    return min(max(g, -0.99), 0.99)


#: Our names of Mitsuba's phase functions.
PHASES = {"isotropic": "isotropic", "hg": "henyey_greenstein", "rayleigh": "rayleigh"}

#: Our names of Mitsuba's media, and what reads their volumes.
COVERED: dict[str, tuple[str, Callable[[Draft], None]]] = {
    "homogeneous": ("homogeneous", _homogeneous),
    "heterogeneous": ("grid", _heterogeneous),
}
