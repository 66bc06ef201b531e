"""What must hold of every scene: functions of (scene, seed, spp) that list what is wrong."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from alight.bsdfs.dielectrics.null import Null
from alight.bsdfs.nesting import leaves
from alight.compiled.scene import CompiledScene, compile_scene
from alight.core.registry import specs
from alight.films import fixed_point
from alight.formats import dumps, loads
from alight.integrators.walk import make_settings
from alight.laws.scene import check_scene
from alight.rendering.tiles.tile import make_kernels, render_tile
from alight.rendering.tiles.tile_kernel import Tile
from alight.scene import FlatScene, Scene, flatten
from alight.scene.validation import find_problems

#: The twin tests every primitive for every ray: scenes with more are thinned evenly.
MOST_PRIMITIVES = 200
#: Paths of the twin end here at the latest.
MOST_EDGES = 12
REPLICATES = 4
#: Probability that a scene without a bug fails its laws.
LEVEL = 1e-4


def robustness(scene: Scene, seed: int, spp: int) -> list[str]:
    """Valid, the same after a round trip, and rendered without an invalid sample."""
    found = [f"{issue.path}: {issue.message}" for issue in find_problems(scene)]
    if found:
        return found
    if loads(dumps(scene)) != scene:
        found.append("is another scene after it was written and read")
    found += [f"warning: {text}" for text in scene.warnings]
    _, invalid = picture(small(flatten(scene)), spp, seed)
    if invalid:
        found.append(f"{invalid} invalid samples")
    return found


def laws(scene: Scene, seed: int, spp: int) -> list[str]:
    """Materials, lights, random numbers and paths are as the laws say."""
    return _verdict(scene, seed, ("materials", "lights", "numbers", "paths"))


def modes(scene: Scene, seed: int, spp: int) -> list[str]:
    """All ways to find the light give one picture, and so do a list and a tree of the shapes."""
    return _verdict(scene, seed, ("pictures", "accelerators"))


def integrators(scene: Scene, seed: int, spp: int) -> list[str]:
    """`volpath` gives the picture of `path` where both see all there is: from the same numbers."""
    own = scene.integrator
    if not hasattr(own, "russian_roulette") or next(scene.used_media(), None):
        return []
    parts = (leaf.bsdf for bsdf in flatten(scene).bsdfs for leaf in leaves(bsdf))
    if any(isinstance(part, Null) for part in parts):
        # Only one of them counts holes and invisible surfaces as vertices.
        return []
    fields = {name: value for name, value in own if name not in ("type", "heuristic")}
    # `volpath` knows the balance heuristic only.
    sides = [{"type": "path", "heuristic": "balance"} | fields, {"type": "volpath"} | fields]
    sums = [
        picture(small(flatten(_with_integrator(scene, side))), spp, seed)[0].sum(axis=2)
        for side in sides
    ]
    return _same(*sums, "path and volpath")


def machine(scene: Scene, seed: int, spp: int) -> list[str]:
    """Machine code gives the picture of the twin."""
    compiled = small(flatten(scene))
    sums = [picture(compiled, spp, seed, compiled=way)[0].sum(axis=2) for way in (True, False)]
    return _same(*sums, "machine code and the twin")


PARTS: dict[str, Callable[[Scene, int, int], list[str]]] = {
    "robustness": robustness,
    "laws": laws,
    "integrators": integrators,
    "machine": machine,
    "modes": modes,
}


def small(flat: FlatScene) -> CompiledScene:
    """A compiled scene with so few primitives that the twin can test them all."""
    scene = compile_scene(flat, structure="list")
    if scene.stats["listed"] <= MOST_PRIMITIVES:
        return scene
    stride = -(-scene.stats["listed"] // MOST_PRIMITIVES)
    if len(flat.shapes) >= MOST_PRIMITIVES:
        return compile_scene(replace(flat, shapes=flat.shapes[::stride]), structure="list")
    geometries = [
        replace(geometry, faces=np.ascontiguousarray(geometry.faces[::stride]))
        for geometry in flat.geometries
    ]
    return compile_scene(replace(flat, geometries=geometries), structure="list")


def picture(
    scene: CompiledScene, spp: int, seed: int, *, compiled: bool = False
) -> tuple[np.ndarray, int]:
    """Sums (h, w, replicates, 3) of a whole film, and the number of invalid samples."""
    width, height = scene.size
    settings = make_settings(scene.integrator, seed=seed, replicates=REPLICATES)
    settings = settings._replace(max_depth=min(settings.max_depth, MOST_EDGES))
    cells = (-(-height // 8), -(-width // 8), 1)
    ranges = np.tile(np.array([0, spp], np.int64), cells)
    kernels = make_kernels(scene, compiled=compiled)
    film, _ = render_tile(kernels, scene, settings, Tile(0, 0, width, height), ranges)
    fixed_point.carry(film.sums)
    return fixed_point.to_float(film.sums), int(film.invalid)


def _with_integrator(scene: Scene, fields: dict) -> Scene:
    name = fields.pop("type")
    return scene.replaced(integrator=specs("integrators")[name](**fields))


def _same(found: np.ndarray, expected: np.ndarray, what: str) -> list[str]:
    """A path whose choice hangs on a rounding error goes another way: few do."""
    close = np.isclose(found, expected, rtol=2e-3, atol=1e-3 * max(expected.mean(), 1e-6))
    share = 1.0 - float(close.all(axis=-1).mean())
    return [f"{what}: {share:.1%} of the pixels differ"] if share > 0.1 else []


def _verdict(scene: Scene, seed: int, parts: tuple[str, ...]) -> list[str]:
    verdict = check_scene(scene, level=LEVEL, seed=seed, only=parts)
    return [
        f"{finding.part}: {finding.law}: p {finding.p} {finding.detail}"
        for finding in verdict.failures
    ]
