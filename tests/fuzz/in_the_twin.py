"""Loads, compiles and renders mutated scenes in a process of its own.

A process can be stopped when it hangs, may crash without taking the tests along, and can be denied
memory. It renders in the NumPy twin: the same kernel text, but no two minutes of compilation for
each of thousands of programs.
"""

from __future__ import annotations

import time
import warnings
from dataclasses import replace
from multiprocessing.connection import Connection
from pathlib import Path
from typing import NamedTuple

import numpy as np

from alight.compiled.scene import compile_scene
from alight.core.errors import AlightError
from alight.films import fixed_point
from alight.formats import load, loads
from alight.integrators.walk import make_settings
from alight.rendering.tiles.tile import make_kernels, render_tile
from alight.rendering.tiles.tile_kernel import Tile
from alight.scene import FlatScene, flatten

SIDE = 8
#: Paths of the twin end here. A million edges between white walls are legal, and would be as right
#: as they are slow; eight pass through all that an integrator does.
MOST_EDGES = 8
#: The twin tests every primitive for every ray, at some 0.1 ms a packet. Scenes with more are
#: compiled whole and then thinned evenly: which of a thousand equal instances a ray meets is a
#: question to the acceleration structure, which has tests of its own.
MOST_PRIMITIVES = 100
MOST_BYTES = 2 << 30
#: Texts that are names of files.
MODELS = (".gltf", ".glb", ".obj", ".usda", ".mtlx")


class Outcome(NamedTuple):
    """What became of one scene.

    Attributes
    ----------
    kind : {"refused", "rendered", "failed"}
    text : str
        The message, or what went wrong.
    seconds : float
        Processor time.
    invalid : int
        Samples that were not finite, as the film counts them.
    """

    kind: str
    text: str
    seconds: float
    invalid: int = 0


def serve(connection: Connection) -> None:
    """Answer each mutation and its folder with an `Outcome` until None comes."""
    import resource

    resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, MOST_BYTES))
    # NumPy's warnings would appear between a user's lines: they are defects too.
    warnings.simplefilter("error")
    while (asked := connection.recv()) is not None:
        connection.send(outcome(*asked))


def outcome(case, folder: Path) -> Outcome:
    """Treat one `Mutation`; nothing but a picture or an `AlightError` with words will do."""
    (folder / case.mesh_name).write_bytes(case.mesh)
    start = time.process_time()
    text, invalid = "", 0
    try:
        is_name = case.text.endswith(MODELS)
        scene = load(folder / case.text) if is_name else loads(case.text, case.name, folder)
        invalid = picture(flatten(scene))
        kind = "rendered"
    except AlightError as error:
        text = str(error)
        kind = "refused" if text.strip() else "failed"
    except BaseException as error:
        kind, text = "failed", f"{type(error).__name__}: {error}"
    return Outcome(kind, text, time.process_time() - start, invalid)


def picture(flat: FlatScene) -> int:
    """Render 8x8 pixels at 1 spp; the number of invalid samples."""
    film = flat.film.model_copy(update={"size": (SIDE, SIDE), "crop": None})
    flat = replace(flat, film=film)
    scene = compile_scene(flat, structure="list")
    if scene.stats["listed"] > MOST_PRIMITIVES:
        scene = compile_scene(thinned(flat, scene.stats["listed"]), structure="list")
    settings = make_settings(scene.integrator, seed=0, replicates=film.replicates)
    settings = settings._replace(max_depth=min(settings.max_depth, MOST_EDGES))
    kernels = make_kernels(scene, compiled=False)
    tile, one = Tile(0, 0, SIDE, SIDE), np.array([[[0, 1]]], np.int64)
    partial, _ = render_tile(kernels, scene, settings, tile, one)
    assert (partial.counts.sum(axis=2) == 1).all(), "samples were lost"
    fixed_point.carry(partial.sums)
    assert np.isfinite(fixed_point.to_float(partial.sums)).all()
    return partial.invalid


def thinned(flat: FlatScene, listed: int) -> FlatScene:
    """Leave out shapes evenly, and triangles of those meshes that are left."""
    stride = -(-listed // MOST_PRIMITIVES)
    if len(flat.shapes) >= MOST_PRIMITIVES:
        return replace(flat, shapes=flat.shapes[::stride])
    geometries = [
        replace(geometry, faces=np.ascontiguousarray(geometry.faces[::stride]))
        for geometry in flat.geometries
    ]
    return replace(flat, geometries=geometries)
