"""What the renderer takes from the file of an integrator."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from alight.core.registry import Kernel, Record, Records, record_of

#: Modules of this package that can replace an integrator.
PASSES = ("contributions",)


@dataclass(frozen=True, eq=False, kw_only=True)
class IntegratorModel(Record):
    """An integrator, or a pass that replaces it.

    Attributes
    ----------
    step : (program) -> kernel
        ``step(scene, settings, path) -> path``: one more vertex of every path.
    stages : (program) -> (kernel, kernel)
        The two halves of a step, between which paths may wait: ``trace(scene, settings, path) ->
        (path, hit)`` and ``shade(scene, settings, path, hit) -> path``.
    empty_paths, start_paths : kernel
        Of integrators that keep more than a `PathState`; see `alight.integrators.walk`.
    begin : (program) -> kernel
        In the place of `step`, of integrators whose paths start at lights: ``begin(scene, settings,
        new, sampler) -> (path, splat)``.
    extend : (program) -> kernel
        Of the same: ``extend(scene, settings, path) -> (path, splat)``, one more vertex of every
        path. See `alight.integrators.light`.
    """

    step: Callable[..., Kernel] | None = None
    stages: Callable[[Any], tuple[Kernel, Kernel]] | None = None
    empty_paths: Kernel | None = None
    start_paths: Kernel | None = None
    begin: Callable[[Any], Kernel] | None = None
    extend: Callable[[Any], Kernel] | None = None


#: All integrators, by name.
INTEGRATORS = Records("integrators", IntegratorModel)


def model_of(program) -> IntegratorModel:
    """The program's integrator, or the pass in its place."""
    if program.integrator in PASSES:
        module = import_module(f"alight.integrators.{program.integrator}")
        return record_of(module, IntegratorModel, program.integrator)
    return INTEGRATORS[program.integrator]
