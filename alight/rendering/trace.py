"""`trace`: one sample of one pixel, followed in plain Python, vertex by vertex.

The sample runs through the very kernels of the renderer, in their NumPy twin, so that a breakpoint
in any of them works; `alight.rendering.observation` looks on. A vertex is one call of the
integrator's `step`; what it added to the radiance of the path is its contribution, and the sum of
these is what the renderer adds to the film.
"""

from __future__ import annotations

import math
import os
from typing import Any

import numpy as np

from alight.accel import intersect_closest, is_occluded
from alight.bsdfs.dispatch import evaluate_bsdf, sample_bsdf
from alight.bsdfs.flags import DELTA, NULL, REFLECTION, TRANSMISSION
from alight.compiled.scene import compile_scene
from alight.compiled.shapes import compile_shapes
from alight.core.errors import OptionError
from alight.films.fixed_point import carry, to_float
from alight.integrators.shadow_rays import come_through
from alight.integrators.walk import make_settings, step
from alight.lights.hits import emitted, light_pdf
from alight.lights.misses import environment_pdf, environment_radiance
from alight.lights.sampling import sample_light
from alight.media.sampling import evaluate_phase, fly, sample_phase
from alight.options.entry import takes
from alight.options.laboratory import TraceOptions
from alight.options.loading import scene_of
from alight.rendering.observation import Event, Observer
from alight.rendering.tile import make_kernels, render_tile
from alight.rendering.tile_kernel import Tile, add_finished
from alight.rendering.traced_path import Emission, LightSample, Scattering, Trace, Vertex
from alight.scene import FlatScene, Scene, flatten
from alight.shapes.surfaces import make_surface

#: Without a tree every ray tests every triangle: this many take about ten seconds a ray.
MOST_TRIANGLES = 30_000_000

WATCHED = {
    "add_finished": add_finished,
    "come_through": come_through,
    "emitted": emitted,
    "environment_pdf": environment_pdf,
    "environment_radiance": environment_radiance,
    "evaluate_bsdf": evaluate_bsdf,
    "evaluate_phase": evaluate_phase,
    "fly": fly,
    "intersect_closest": intersect_closest,
    "is_occluded": is_occluded,
    "light_pdf": light_pdf,
    "make_surface": make_surface,
    "sample_bsdf": sample_bsdf,
    "sample_light": sample_light,
    "sample_phase": sample_phase,
    "step": step,
}

#: Kernels that integrators write for themselves; any that has functions of these names is shown.
WEIGHTS = ("bsdf_weight", "light_weight")


@takes(TraceOptions)
def trace(
    scene: Scene | str | os.PathLike[str], pixel: tuple[int, int], options: TraceOptions
) -> Trace:
    """Follow one sample of one pixel in plain Python.

    Parameters
    ----------
    scene : Scene, path or name of a built-in scene
    pixel : (int, int)
        x and y on the full film, from the top left.
    {options}

    Returns
    -------
    Trace
        Its `value` is what `alight.render` adds to the film for this sample, within the rounding of
        float32 (compiled code fuses multiplications and additions).

    Raises
    ------
    AlightError
        For a scene, pixel or number that is wrong.
    """
    scene = scene_of(scene, options)
    if scene.integrator.splats:
        alone = " alone" if scene.integrator.transports else ""
        raise OptionError(f"no path of {scene.integrator.type_name()} starts at a pixel{alone}")
    x, y = _checked_pixel(pixel, scene.film.size)
    sample, seed = options.sample, options.seed
    flat = flatten(scene)
    _check_triangles(flat)
    compiled = compile_scene(flat, structure="list")
    observer = Observer(WATCHED, WEIGHTS)
    kernels = make_kernels(compiled, compiled=False, observe=observer)
    replicates = flat.film.replicates
    settings = make_settings(compiled.integrator, seed=seed, replicates=replicates)
    tile, ranges = Tile(x, y, x + 1, y + 1), np.array([[[sample, 1]]], np.int64)
    film, rays = render_tile(kernels, compiled, settings, tile, ranges)
    carry(film.sums)
    value = to_float(film.sums)[0, 0].sum(axis=0)
    (finished,) = (event for event in observer.events if event.name == "add_finished")
    steps = [event for event in observer.events if event.name == "step"]
    names = _Names(flat)
    return Trace(
        scene=str(scene.source.name or "scene"),
        integrator=flat.integrator.type_name(),
        sampler=flat.sampler.type_name(),
        filter=flat.film.filter.type_name(),
        size=flat.film.size,
        pixel=(x, y),
        sample=sample,
        seed=seed,
        replicate=sample % replicates,
        weight=_path_of(steps[0]).beta[0],
        vertices=tuple(_vertex(event, names) for event in steps),
        radiance=_path_of(finished).L,
        value=tuple(value.tolist()),
        valid=not film.invalid,
        rays=rays,
    )


class _Names:
    """What the numbers of a surface are called in the scene."""

    def __init__(self, flat: FlatScene) -> None:
        self.shapes = [flat.shapes[row.source].name for row in compile_shapes(flat).rows]
        self.bsdfs = [bsdf.type_name() for bsdf in flat.bsdfs]


def _path_of(event: Event) -> Any:
    """The paths that a kernel was given, whatever its argument is called."""
    return next(value for value in event.arguments.values() if hasattr(value, "beta"))


def _vertex(event: Event, names: _Names) -> Vertex:
    before, after = _path_of(event), event.result
    hit = _first(event, "intersect_closest")
    t = math.inf if hit is None else hit.result.t
    collision = _collision(event)
    t = t if collision is None else collision
    surface = _first(event, "make_surface") if math.isfinite(t) and collision is None else None
    here = None if surface is None else surface.result
    position = None if here is None else here.p
    if collision is not None:
        position = tuple(o + t * d for o, d in zip(before.o, before.d, strict=True))
    gathered = np.array(after.L, np.float64) - np.array(before.L, np.float64)
    return Vertex(
        depth=after.depth,
        origin=before.o,
        direction=before.d,
        beta=before.beta,
        pdf=before.pdf,
        delta=before.delta,
        t=t,
        position=position,
        normal=None if here is None else here.ns,
        shape=None if here is None else names.shapes[here.shape],
        bsdf=None if here is None else names.bsdfs[here.bsdf],
        primitive=None if here is None else here.prim,
        emission=_emission(event) if collision is None else None,
        light=_light(event),
        scattering=_scattering(event) if position is not None else None,
        contribution=tuple(gathered.tolist()),
    )


def _collision(event: Event) -> float | None:
    """How far the path came before a medium scattered it; None if it did not."""
    flight = _first(event, "fly")
    if flight is None or not flight.arguments["active"] or not flight.result.scattered:
        return None
    return flight.result.t


def _emission(event: Event) -> Emission | None:
    for name, density in (("emitted", "light_pdf"), ("environment_radiance", "environment_pdf")):
        found = _first(event, name)
        if found is not None:
            pdf, weight = _first(event, density), _first(event, "bsdf_weight")
            return Emission(
                found.result,
                None if pdf is None else pdf.result,
                None if weight is None else weight.result,
            )
    return None


def _light(event: Event) -> LightSample | None:
    found = _first(event, "sample_light")
    if found is None or not found.arguments["active"] or not found.result.pdf > 0.0:
        return None
    light = found.result
    later = event.inner[event.inner.index(found) + 1 :]
    # The BSDF's value for this direction comes before the next direction is chosen.
    names = [e.name for e in later]
    end = names.index("sample_bsdf") if "sample_bsdf" in names else len(names)
    by_name = {e.name: e for e in reversed(later[:end])}
    bsdf, phase, shadow, crossing, weight = (
        by_name.get(name)
        for name in (
            "evaluate_bsdf", "evaluate_phase", "is_occluded", "come_through", "light_weight"
        )
    )  # fmt: skip
    visible = None
    if shadow is not None and shadow.arguments["active"]:
        visible = not shadow.result
    elif crossing is not None and crossing.arguments["lit"]:
        visible = max(crossing.result[0].passed) > 0.0
    f_cos, density = (None, None) if bsdf is None else bsdf.result
    if phase is not None and phase.arguments["active"]:
        f_cos, density = (phase.result,) * 3, phase.result
    return LightSample(
        wi=light.wi,
        distance=light.distance,
        radiance=light.radiance,
        pdf=light.pdf,
        delta=light.delta,
        f_cos=f_cos,
        bsdf_pdf=density,
        visible=visible,
        weight=None if weight is None else weight.result,
    )


def _scattering(event: Event) -> Scattering | None:
    phase = _first(event, "sample_phase")
    if phase is not None and phase.arguments["active"]:
        return Scattering(phase.result[0], (1.0, 1.0, 1.0), phase.result[1], "phase")
    found = _first(event, "sample_bsdf")
    if found is None:
        return None
    wi, weight, pdf, flags = found.result
    return Scattering(wi, weight, pdf, lobe_name(flags))


def lobe_name(flags: int) -> str:
    """The flags of a sample in words, as "delta reflection"."""
    names = ((NULL, "null"), (DELTA, "delta"), (REFLECTION, "reflection"))
    words = [name for flag, name in (*names, (TRANSMISSION, "transmission")) if flags & flag]
    return " ".join(words)


def _first(event: Event, name: str) -> Event | None:
    return next(iter(event.calls(name)), None)


def _checked_pixel(pixel: tuple[int, int], size: tuple[int, int]) -> tuple[int, int]:
    width, height = size
    whole = len(pixel) == 2 and all(isinstance(c, int | np.integer) for c in pixel)
    if not whole or not (0 <= pixel[0] < width and 0 <= pixel[1] < height):
        shown = ",".join(map(str, pixel))
        allowed = f"x in [0, {width - 1}] and y in [0, {height - 1}]"
        raise OptionError(f"must be x,y with {allowed}, got {shown}", "pixel")
    return int(pixel[0]), int(pixel[1])


def _check_triangles(flat: FlatScene) -> None:
    count = sum(len(flat.geometries[s.geometry].faces) for s in flat.shapes if s.geometry >= 0)
    if count > MOST_TRIANGLES:
        raise OptionError(
            f"trace tests each ray against every triangle: at most {MOST_TRIANGLES}, got {count}"
        )
