"""What the renderer takes from the file of an integrator."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Any, NamedTuple

from alight.core.registry import Kernel, Record, Records, record_of

#: Modules of this package that can replace an integrator.
PASSES = ("contributions", "strategies")


class BothEnds(NamedTuple):
    """Kernels of paths from both ends; see `alight.rendering.tiles.both_ends_tile`.

    Attributes
    ----------
    begin_light : kernel (scene, settings, new, sampler) -> (walk, emission)
    extend_light : kernel (scene, settings, walk, emission, paths) -> (walk, vertex, splat)
    begin_camera : kernel (rays) -> walk
    extend_camera : kernel (scene, settings, walk, paths) -> (walk, vertex)
    join : kernel (scene, settings, path, vertex, vertex of a light path) -> path
    """

    begin_light: Kernel
    extend_light: Kernel
    begin_camera: Kernel
    extend_camera: Kernel
    join: Kernel


@dataclass(frozen=True, eq=False, kw_only=True)
class IntegratorModel(Record):
    """An integrator, or a pass that replaces it.

    Attributes
    ----------
    step : (program) -> kernel
        ``step(scene, settings, path) -> path``: one more vertex of every path.
    stages : (program) -> (kernel, kernel)
        The two halves of a step, between which paths may wait: ``trace(scene, settings, path) ->
        (path, hit)`` and ``shade(scene, settings, path, hit) -> (path, walk)``, where `walk` is
        what `alight.integrators.interiors.body_walk.begin_walks` gives.
    empty_paths, start_paths : kernel
        Of integrators that keep more than a `PathState`; see `alight.integrators.walk`.
    begin : (program) -> kernel
        In the place of `step`, of integrators whose paths start at lights: ``begin(scene, settings,
        new, sampler) -> (path, splat)``.
    extend : (program) -> kernel
        Of the same: ``extend(scene, settings, path) -> (path, splat)``, one more vertex of every
        path. See `alight.integrators.light`.
    both_ends : (program, tell=None) -> BothEnds
        Of integrators that join paths from both ends; `tell` is given what each technique adds, see
        `alight.integrators.strategies`.
    """

    step: Callable[..., Kernel] | None = None
    stages: Callable[[Any], tuple[Kernel, Kernel]] | None = None
    empty_paths: Kernel | None = None
    start_paths: Kernel | None = None
    begin: Callable[[Any], Kernel] | None = None
    extend: Callable[[Any], Kernel] | None = None
    both_ends: Callable[..., BothEnds] | None = None


#: All integrators, by name.
INTEGRATORS = Records("integrators", IntegratorModel)


def model_of(program) -> IntegratorModel:
    """The program's integrator, or the pass in its place."""
    if program.integrator in PASSES:
        module = import_module(f"alight.integrators.{program.integrator}")
        return record_of(module, IntegratorModel, program.integrator)
    return INTEGRATORS[program.integrator]
