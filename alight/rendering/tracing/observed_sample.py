"""One sample of one pixel, rendered by the NumPy twin while an observer looks on."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from alight.accel import intersect_closest, is_occluded
from alight.bsdfs.dispatch import evaluate_bsdf, sample_bsdf
from alight.compiled.scene import CompiledScene, compile_scene
from alight.compiled.shapes import compile_shapes
from alight.core.errors import OptionError, show_value
from alight.films import PartialFilm
from alight.integrators.shadow_rays import shadow_transmittance
from alight.integrators.walk import make_settings, step
from alight.lights.hits import emitted, light_pdf
from alight.lights.misses import environment_pdf, environment_radiance
from alight.lights.sampling import sample_light
from alight.media.sampling import evaluate_phase, fly, sample_phase
from alight.rendering.tiles.tile import make_kernels, render_tile
from alight.rendering.tiles.tile_kernel import Tile, add_finished
from alight.rendering.tracing.observation import Event, Observer
from alight.scene import FlatScene, Scene, flatten
from alight.shapes.surfaces import make_surface

#: Without a tree every ray tests every triangle: this many take about ten seconds a ray.
MOST_TRIANGLES = 30_000_000

WATCHED = {
    "add_finished": add_finished,
    "shadow_transmittance": shadow_transmittance,
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


class ObservedSample(NamedTuple):
    """A sample, and what was seen of it.

    Attributes
    ----------
    flat : FlatScene
    compiled : CompiledScene
        Without a tree, as the twin needs it.
    pixel : (int, int)
    film : PartialFilm
        Of the one pixel.
    rays : int
    events : list of Event
        Calls of the kernels of `WATCHED`.
    """

    flat: FlatScene
    compiled: CompiledScene
    pixel: tuple[int, int]
    film: PartialFilm
    rays: int
    events: list[Event]

    @property
    def steps(self) -> list[Event]:
        """The integrator's steps, one a vertex."""
        return [event for event in self.events if event.name == "step"]


def observe_sample(
    scene: Scene, pixel: tuple[int, int], *, sample: int, seed: int
) -> ObservedSample:
    """Render one sample of one pixel in plain Python, and note what its kernels do.

    Raises
    ------
    OptionError
        For a pixel outside the film, an integrator whose paths do not start at pixels, and more
        triangles than plain Python can test.
    """
    if scene.integrator.splats:
        alone = " alone" if scene.integrator.transports else ""
        raise OptionError(f"no path of {scene.integrator.type_name()} starts at a pixel{alone}")
    x, y = _checked_pixel(pixel, scene.film.size)
    flat = flatten(scene)
    _check_triangles(flat)
    compiled = compile_scene(flat, structure="list")
    observer = Observer(WATCHED, WEIGHTS)
    kernels = make_kernels(compiled, compiled=False, observe=observer)
    settings = make_settings(compiled.integrator, seed=seed, replicates=flat.film.replicates)
    tile, ranges = Tile(x, y, x + 1, y + 1), np.array([[[sample, 1]]], np.int64)
    film, rays = render_tile(kernels, compiled, settings, tile, ranges)
    return ObservedSample(flat, compiled, (x, y), film, rays, observer.events)


class SurfaceNames:
    """What the numbers of a surface are called in the scene."""

    def __init__(self, flat: FlatScene) -> None:
        self.shapes = [flat.shapes[row.source].name for row in compile_shapes(flat).rows]
        self.bsdfs = [bsdf.type_name() for bsdf in flat.bsdfs]


def path_of(event: Event) -> Any:
    """The paths that a kernel was given, whatever its argument is called."""
    return next(value for value in event.arguments.values() if hasattr(value, "beta"))


def _checked_pixel(pixel: tuple[int, int], size: tuple[int, int]) -> tuple[int, int]:
    width, height = size
    listed = isinstance(pixel, list | tuple) or (isinstance(pixel, np.ndarray) and pixel.ndim > 0)
    is_pair = listed and len(pixel) == 2
    whole = is_pair and all(isinstance(c, int | np.integer) for c in pixel)
    if not whole or not (0 <= pixel[0] < width and 0 <= pixel[1] < height):
        shown = ",".join(map(str, pixel)) if is_pair else show_value(pixel)
        allowed = f"x in [0, {width - 1}] and y in [0, {height - 1}]"
        raise OptionError(f"must be x,y with {allowed}, got {shown}", "pixel")
    return int(pixel[0]), int(pixel[1])


def _check_triangles(flat: FlatScene) -> None:
    count = sum(len(flat.geometries[s.geometry].faces) for s in flat.shapes if s.geometry >= 0)
    if count > MOST_TRIANGLES:
        raise OptionError(
            "in plain Python each ray is tested against every triangle: "
            f"at most {MOST_TRIANGLES}, got {count}"
        )
