"""`trace`: one sample of one pixel, followed in plain Python, vertex by vertex.

The sample runs through the very kernels of the renderer, in their NumPy twin, so that a breakpoint
in any of them works; `alight.rendering.tracing.observation` looks on. A vertex is one call of the
integrator's `step`; what it added to the radiance of the path is its contribution, and the sum of
these is what the renderer adds to the film.
"""

from __future__ import annotations

import math
import os

import numpy as np

from alight.bsdfs.flags import DELTA, NULL, REFLECTION, TRANSMISSION
from alight.films.fixed_point import carry, to_float
from alight.options.entry import takes
from alight.options.laboratory import TraceOptions
from alight.options.loading import scene_of
from alight.rendering.tracing.observation import Event
from alight.rendering.tracing.observed_sample import SurfaceNames, observe_sample, path_of
from alight.rendering.tracing.traced_path import Emission, LightSample, Scattering, Trace, Vertex
from alight.scene import Scene


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
    found = observe_sample(scene, pixel, sample=options.sample, seed=options.seed)
    flat, events = found.flat, found.events
    carry(found.film.sums)
    value = to_float(found.film.sums)[0, 0].sum(axis=0)
    (finished,) = (event for event in events if event.name == "add_finished")
    steps = found.steps
    names = SurfaceNames(flat)
    return Trace(
        scene=str(scene.source.name or "scene"),
        integrator=flat.integrator.type_name(),
        sampler=flat.sampler.type_name(),
        filter=flat.film.filter.type_name(),
        size=flat.film.size,
        pixel=found.pixel,
        sample=options.sample,
        seed=options.seed,
        replicate=options.sample % flat.film.replicates,
        weight=path_of(steps[0]).beta[0],
        vertices=tuple(_vertex(event, names, found.compiled.origin) for event in steps),
        radiance=path_of(finished).L,
        value=tuple(value.tolist()),
        valid=not found.film.invalid,
        rays=found.rays,
    )


def _vertex(event: Event, names: SurfaceNames, origin: np.ndarray) -> Vertex:
    before, after = path_of(event), event.result
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
        origin=_in_world(before.o, origin),
        direction=before.d,
        beta=before.beta,
        pdf=before.pdf,
        delta=before.delta,
        t=t,
        position=None if position is None else _in_world(position, origin),
        normal=None if here is None else here.ns,
        shape=None if here is None else names.shapes[here.shape],
        bsdf=None if here is None else names.bsdfs[here.bsdf],
        primitive=None if here is None else here.prim,
        emission=_emission(event) if collision is None else None,
        light=_light(event),
        scattering=_scattering(event) if position is not None else None,
        contribution=tuple(gathered.tolist()),
    )


def _in_world(p: tuple[float, float, float], origin: np.ndarray) -> tuple[float, float, float]:
    """A point of rendering space, whose origin is there, in the world."""
    x, y, z = (float(c) + o for c, o in zip(p, origin.tolist(), strict=True))
    return x, y, z


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
            "evaluate_bsdf", "evaluate_phase", "is_occluded", "shadow_transmittance", "light_weight"
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
