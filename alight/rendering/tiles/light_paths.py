"""Pictures of light paths: what they need, what cannot be had of them, how they are cut up."""

from __future__ import annotations

from collections.abc import Iterator

from alight.bsdfs.dispatch import LAYERED_NAME
from alight.bsdfs.switch import has_null, refracts
from alight.cameras.model import CAMERAS
from alight.compiled.program import Program
from alight.compiled.scene import CompiledScene
from alight.core.errors import OptionError
from alight.films import CELL_SIZE
from alight.filters.model import FILTERS
from alight.lights.model import LIGHTS
from alight.rendering.schedules.schedule import Schedule, Uniform
from alight.rendering.tiles.tile_kernel import Tile
from alight.shapes.hit import BENT
from alight.shapes.model import SHAPES

#: Pixels of one replicate share its light paths: only replicates say how far off they are.
LEAST_REPLICATES = 16

#: Parts of a pass for each thread: each has sums for the whole window.
PARTS = 2


def check_light_paths(scene: CompiledScene, schedule: Schedule) -> None:
    """Refuse what pictures of light paths cannot have.

    Raises
    ------
    OptionError
        With everything that is in the way.
    """
    problems = [*_problems(scene.program, scene.integrator.transports)]
    if not isinstance(schedule, Uniform):
        problems.append("it takes the same samples everywhere: give spp or a time limit")
    if problems:
        name = scene.integrator.type_name()
        raise OptionError(f"{name} cannot render this: {'; '.join(problems)}", "integrator")


def _problems(program: Program, from_both_ends: bool) -> Iterator[str]:
    """In words; paths from the camera too find light from infinity in more places."""
    if CAMERAS[program.camera].connect is None:
        yield f"light paths do not reach a camera of type {program.camera} (no kernel connect)"
    if "camera" in program.motion:
        yield "the camera moves"
    filter_model = FILTERS[program.filter]
    if filter_model.profile is None or filter_model.reach is None:
        yield f"a filter of type {program.filter} has no profile (kernels profile and reach)"
    far = any(_is_far(name) for name in program.lights if name in LIGHTS)
    unbounded = any(not SHAPES[name].spec.finite for name in program.shapes)
    if far and unbounded and (has_null(program) or not from_both_ends):
        yield "light from infinity reaches only a part of shapes without bounds"
    sees_far = from_both_ends or CAMERAS[program.camera].connect_far is not None
    if far and _sees_surroundings(program) and not sees_far:
        yield f"a camera of type {program.camera} sees the surroundings in one direction only"
    if refracts(program) and (LAYERED_NAME in program.bsdfs or BENT in program.bsdfs):
        yield "there is glass, and some material is made of others or has a normal or bump map"
    if program.aovs:
        yield f"it has no layers, and {', '.join(program.aovs)} is asked for"


def _is_far(name: str) -> bool:
    """Whether a light is at infinity: neither on a shape, nor in a place that a tree knows."""
    return not LIGHTS[name].is_on_shape and LIGHTS[name].cone is None


def _sees_surroundings(program: Program) -> bool:
    return any(LIGHTS[name].is_around for name in program.lights if name in LIGHTS)


def parts_of(window: tuple[int, int, int, int], threads: int) -> list[Tile]:
    """Parts of a window, by rows of cells: whose light paths are traced together."""
    x, y, width, height = window
    rows = -(-(y + height) // CELL_SIZE) - y // CELL_SIZE
    step = CELL_SIZE * -(-rows // (PARTS * threads))
    return [
        Tile(x, max(y, top), x + width, min(y + height, top + step))
        for top in range(y // CELL_SIZE * CELL_SIZE, y + height, step)
    ]
