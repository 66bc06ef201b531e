"""Compile kernels before they are needed: of all models, or of some scenes.

Kernels are kept function by function (decision 48), so once each model has been compiled in some
scene, no later scene waits for more than linking and the last optimisation of its own combination.
Processes share the work: the cache is safe for several of them.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from typing import Any, NamedTuple, TypeVar

from alight.compiled.scene import compile_scene
from alight.core.errors import AlightError
from alight.core.registry import FAMILIES_OF_SCENES, default_of, modules, type_name_of
from alight.core.spec import (
    Bsdf,
    Camera,
    Filter,
    Integrator,
    Light,
    Medium,
    PhaseFunction,
    Sampler,
    Shape,
    Spec,
    Texture,
)
from alight.formats import builtin_names
from alight.lab.replicates.measure import compiled_kernels
from alight.options.loading import scene_of
from alight.options.plugins import load_plugins
from alight.options.scene import SceneOptions
from alight.scene import FilmSettings, Node, Scene, flatten, translate

S = TypeVar("S", bound=Spec)


class WarmProgress(NamedTuple):
    """How far it is.

    Attributes
    ----------
    text : str
        What was compiled last.
    done, total : int
        Scenes.
    """

    text: str
    done: int
    total: int


class Warmed(NamedTuple):
    """What was compiled.

    Attributes
    ----------
    scenes : int
    seconds : float
        Of the wall clock.
    failures : dict of str to str
        By scene: why it could not be compiled.
    """

    scenes: int
    seconds: float
    failures: dict[str, str]


def warm(
    names: Sequence[str] = (),
    options: SceneOptions | None = None,
    *,
    processes: int = 1,
    progress: Callable[[WarmProgress], None] | None = None,
) -> Warmed:
    """Compile the kernels of scenes and keep them on disk.

    Parameters
    ----------
    names : sequence of str
        Scene files, or names of built-in scenes; all built-in scenes and all models by default.
    options : SceneOptions, optional
        How the named scenes are loaded; models of its scripts are among all models.
    processes : int, default 1
        That compile at the same time.
    progress : callable, optional
        Called after each scene.

    Raises
    ------
    AlightError
        If one of the named scenes cannot be loaded; nothing is compiled then.
    """
    begin, options = time.perf_counter(), options or SceneOptions()
    load_plugins(options.plugins)
    for name in names:
        scene_of(name, options.changed(plugins=()))
    jobs = list(names) or [*builtin_names(), *_models()]
    failures: dict[str, str] = {}
    # What all of them share is compiled once, before they begin together.
    results = _compiled(jobs[:1], options, 1)
    done = 0
    for part in (results, _compiled(jobs[1:], options, processes)):
        for job, problem in part:
            done += 1
            if problem:
                failures[job] = problem
            if progress is not None:
                progress(WarmProgress(job, done, len(jobs)))
    return Warmed(done, time.perf_counter() - begin, failures)


def _compiled(
    jobs: Sequence[str], options: SceneOptions, processes: int
) -> Iterator[tuple[str, str]]:
    """Each job when it is done, and what was wrong with it."""
    if processes == 1 or len(jobs) < 2:
        yield from ((job, compile_job(job, options)) for job in jobs)
        return
    with ProcessPoolExecutor(
        processes, get_context("spawn"), initializer=_load_scripts, initargs=(options,)
    ) as pool:
        futures = {pool.submit(compile_job, job, options): job for job in jobs}
        try:
            for future in as_completed(futures):
                yield futures[future], future.result()
        finally:
            pool.shutdown(cancel_futures=True)


def _load_scripts(options: SceneOptions) -> None:
    """Make models of scripts known in a new process."""
    load_plugins(options.plugins)


def compile_job(job: str, options: SceneOptions) -> str:
    """Compile one scene, whose scripts are loaded; says why if it cannot be done."""
    options = options.changed(plugins=())
    try:
        scene = scene_with(*job.split(": ")) if ": " in job else scene_of(job, options)
        compiled_kernels(compile_scene(flatten(scene)))
    except AlightError as error:
        return str(error)
    return ""


# ---------------------------------------------------------------- a scene of each model


def _models() -> Iterator[str]:
    for family in FAMILIES_OF_SCENES:
        for module in modules(family):
            yield f"{family}: {type_name_of(module)}"


def scene_with(family: str, name: str) -> Scene:
    """A small scene in which a model plays its part.

    Parameters
    ----------
    family, name : str
        As registries call them.
    """
    module = next(one for one in modules(family) if type_name_of(one) == name)
    return _scene(module.EXAMPLES[0])


def _scene(spec: Any) -> Scene:
    """A body under a sky; what is not of the model is what the families have by default."""
    sky = next(light for light in _examples(Light) if light.placement == "environment")
    body, camera, more = Node(shape=_examples(Shape)[0]), Node(camera=_examples(Camera)[0]), {}
    match spec:
        case Bsdf():
            body = _changed(body, bsdf=spec)
        case Texture():
            body = _changed(body, bsdf=_changed(default_of(Bsdf), reflectance=spec))
        case Shape():
            body = Node(shape=spec)
        case Light(placement="environment", has_place=False):
            sky = spec
        case Light(placement="shape"):
            body = _changed(body, light=spec)
        case Light():
            more["nodes"] = {"body": body, "lamp": Node(light=spec, transform=translate(0, 3, 0))}
        case Medium() | PhaseFunction():
            filling = (
                spec if isinstance(spec, Medium) else _changed(_examples(Medium)[0], phase=spec)
            )
            hole = next(bsdf for bsdf in _examples(Bsdf) if bsdf.unseen)
            body = _changed(body, bsdf=hole, interior=filling)
        case Camera():
            camera = Node(camera=spec)
        case Sampler():
            more["sampler"] = spec
        case Filter():
            more["film"] = FilmSettings(filter=spec)
        case Integrator():
            more["integrator"] = spec
    return Scene(**{"nodes": {"body": body}, "camera": camera, "environment": sky, **more})


def _examples(base: type[S]) -> list[S]:
    return [module.EXAMPLES[0] for module in modules(base.family)]


def _changed(spec: S, **values: Any) -> S:
    return spec.model_copy(update=values)
