"""`check_scene`: all laws for all parts of a scene, at one false alarm rate."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence

from alight.compiled.displacement import displaced
from alight.compiled.kept import Kept
from alight.compiled.scene import CompiledScene, compile_scene
from alight.core.spec import Bsdf
from alight.integrators.contributions import can_record
from alight.laws.scene.dump import write_failures
from alight.laws.scene.findings import Finding, Verdict
from alight.laws.scene.lights import check_lights
from alight.laws.scene.materials import check_materials
from alight.laws.scene.numbers import check_numbers, check_paths
from alight.laws.scene.pictures import check_accelerators, check_strategies, integrator_of, small
from alight.options.entry import takes
from alight.options.laboratory import PARTS, CheckOptions
from alight.options.loading import scene_of
from alight.scene import Scene, flatten
from alight.scene.flatten import FlatScene
from alight.scene.opening import at_opening

#: Probability that a scene without a bug fails.
LEVEL = 0.01


@takes(CheckOptions)
def check(scene: Scene | str | os.PathLike[str], options: CheckOptions) -> Verdict:
    """Test a scene: materials, lights, random numbers, and that all methods give one picture.

    Parameters
    ----------
    scene : Scene, path or name of a built-in scene
    {options}

    Returns
    -------
    Verdict
        True if nothing failed.

    Raises
    ------
    AlightError
        If the scene cannot be rendered, or an option is wrong.

    Examples
    --------
    >>> assert alight.check("cornell-box", only="materials")  # doctest: +SKIP
    """
    verdict = check_scene(
        scene_of(scene, options),
        level=options.level,
        seed=options.seed,
        only=options.only or PARTS,
        progress=options.progress or (lambda text: None),
    )
    if options.output is not None:
        write_failures(verdict, options.output)
    return verdict


def check_scene(
    scene: Scene,
    *,
    level: float = LEVEL,
    seed: int = 0,
    only: Sequence[str] = PARTS,
    progress: Callable[[str], None] = lambda text: None,
) -> Verdict:
    """Test everything that a scene uses against the laws of light transport.

    Parameters
    ----------
    scene : Scene
    level : float, default 0.01
        Probability that a scene without a bug fails any of the tests with a p-value.
    seed : int, default 0
        Other random numbers, another test.
    only : sequence of str
        Some of `PARTS`, all by default.
    progress : callable, optional
        Called with a description of what runs next.

    Returns
    -------
    Verdict
        True if nothing failed.

    Raises
    ------
    AlightError
        If the scene cannot be rendered, or a part has no such name.
    """
    CheckOptions.of({"only": only})
    progress("reading the scene")
    kept, flat = Kept(), flatten(small(scene, integrator_of(scene)))
    compiled = compile_scene(flat, structure="list", kept=kept)
    # The same meshes, whose displacement is kept.
    findings = _findings(scene, displaced(flat, kept), compiled, seed, only, progress)
    return Verdict(tuple(findings), level, compiled.warnings)


def _findings(
    scene: Scene,
    flat: FlatScene,
    compiled: CompiledScene,
    seed: int,
    only: Sequence[str],
    say: Callable[[str], None],
) -> Iterator[Finding]:
    if "materials" in only:
        say("materials")
        yield from check_materials(material_names(scene, flat), seed)
    if "lights" in only and scene.integrator.needs_light:
        say("lights")
        # The laws hold at any one time.
        still = at_opening(flat)
        moves = compiled.program.motion
        compiled_then = compile_scene(still, structure="list") if moves else compiled
        yield from check_lights(still, compiled_then, seed)
    if "numbers" in only:
        say("random numbers")
        yield from check_numbers(scene.sampler, seed)
    if "paths" in only and can_record(compiled.program.integrator):
        say("paths")
        yield from check_paths(compiled, seed)
    if "pictures" in only:
        yield from check_strategies(scene, seed, say)
    if "accelerators" in only:
        yield from check_accelerators(scene, seed, say)


def material_names(scene: Scene, flat: FlatScene) -> dict[str, Bsdf]:
    """The different materials in use, by their names in the scene or by model and shape."""
    users: dict[int, str] = {}
    for shape in flat.shapes:
        users.setdefault(shape.bsdf, shape.name)
    named: dict[int, str] = {}
    for _, _, node in scene.walk():
        if isinstance(node.bsdf, str):
            named.setdefault(hash(scene.bsdfs[node.bsdf]), node.bsdf)
    found: dict[str, Bsdf] = {}
    for index, bsdf in enumerate(flat.bsdfs):
        name = named.get(hash(bsdf)) or f"{bsdf.type_name()} of {users.get(index, index)}"
        found[name if name not in found else f"{name} ({index})"] = bsdf
    return found
