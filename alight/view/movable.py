"""A scene compiled once and seen from anywhere: only the table of the camera is made anew."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from alight.compiled.cameras import compile_camera
from alight.compiled.recompile import Compiled, compiled_of
from alight.compiled.rendering_space import shifted
from alight.compiled.scene import CompiledScene
from alight.films.fixed_point import carry, to_float
from alight.integrators.aov import LAYERS, layer_bits
from alight.integrators.walk import make_settings
from alight.options.render import RenderOptions
from alight.rendering.job import Job
from alight.rendering.layers import layers_of
from alight.rendering.main_loop import Clock, job_of
from alight.rendering.resources import usable_processors
from alight.rendering.schedules.schedule import Uniform
from alight.rendering.schedules.selection import planned_spp, schedule_of, time_limit_of
from alight.rendering.tiles.tile import make_kernels
from alight.rendering.tiles.tile_kernel import Tile
from alight.rendering.training.guide_training import is_to_be_guided, untrained
from alight.scene import FlatScene, Scene
from alight.scene.flatten import PlacedCamera
from alight.view.layers import COARSER
from alight.view.pose import Pose
from lanewise.view import View


class Movable:
    """A scene that is compiled once, and rendered from any pose.

    Parameters
    ----------
    scene : Scene
        With the changes of the options.
    options : RenderOptions

    Attributes
    ----------
    size : (int, int)
        Of the full film, in pixels.
    window : (int, int, int, int)
        x, y, width and height of what is rendered of it.
    """

    def __init__(self, scene: Scene, options: RenderOptions) -> None:
        self.scene, self.options = scene, options
        self.threads = options.threads or usable_processors()
        self._own = compiled_of(scene, layers_of(options.aovs), self.threads)
        self.flat, self.compiled = self._own.flat, self._own.compiled
        self.size = self.flat.film.size
        self.window = self.flat.film.crop or (0, 0, *self.size)
        self._at_rest: Compiled | None = None
        self._look: Callable | None = None

    def prepare(self) -> None:
        """Compile the kernels of the picture, unless there is machine code for them already."""
        if is_to_be_guided(self.compiled):
            self.coarse_job(Pose.of(self.flat.camera), 1).start(None)
        else:
            self.job(None, 1).start(None)

    def scene_from(self, pose: Pose | None) -> Scene:
        """Describe the scene with its camera in a pose; None leaves it as it is."""
        if pose is None:
            return self.scene
        return self.scene.replaced(camera=pose.node).from_source(self.scene.source)

    def job(self, pose: Pose | None, spp: int | None) -> Job:
        """Make the job of the picture itself, as ``alight render`` does.

        Parameters
        ----------
        pose : Pose or None
            None leaves the scene's own camera, which may move.
        spp : int or None
            Samples per pixel in place of what the options say.
        """
        flat, compiled = self._seen_from(pose)
        own = self.scene.source.remarks.spp
        schedule = schedule_of(self.options, own)
        job = job_of(
            flat, compiled, schedule if spp is None else schedule.extended(spp), Clock(),
            seed=self.options.seed, threads=self.threads, replicates=self.options.replicates,
            planned=(spp, False) if spp else planned_spp(self.options, own),
        )  # fmt: skip
        job.time_limit = time_limit_of(self.options)
        return job

    def coarse_job(self, pose: Pose, spp: int) -> Job:
        """Make the job of a small picture of the same view, for a camera that moves."""
        flat, compiled = self._seen_from(pose)
        width, height = (-(-side // COARSER) for side in self.size)
        x, y, w, h = (edge // COARSER for edge in self.window)
        x, y = min(x, width - 1), min(y, height - 1)
        near = shifted(PlacedCamera(pose.camera, pose.to_world), compiled.origin)
        camera = compile_camera(near.camera, near.to_world, (width, height), compiled.origin)
        # Layers that the kernel of the picture gathers: without them it would be another one.
        split = tuple(name for name in compiled.program.aovs if name not in LAYERS)
        if is_to_be_guided(compiled):
            compiled = untrained(compiled)
        small = replace(
            compiled,
            tables=compiled.tables._replace(camera=camera),
            program=compiled.program._replace(aovs=layers_of(split)),
            size=(width, height),
            crop=(x, y, min(max(w, 1), width - x), min(max(h, 1), height - y)),
            small_view=None,
        )
        return job_of(
            flat, small, Uniform(0, spp), Clock(),
            seed=self.options.seed, threads=self.threads, replicates=1,
        )  # fmt: skip

    def hit(self, pose: Pose, x: int, y: int) -> np.ndarray | None:
        """Find the point that a pixel of the full film shows, by one ray; None if it is none.

        The first time on a machine the kernel of a scene is compiled for it, which takes seconds.
        """
        _, compiled = self._seen_from(pose.sharp)
        names = ("position", "depth")
        if self._look is None:
            program = compiled.program._replace(aovs=names)
            self._look = make_kernels(replace(compiled, program=program, ground=None)).layers
        assert self._look is not None
        settings = make_settings(compiled.integrator, seed=0, replicates=1, guide=compiled.guide)
        sums = View(np.zeros((len(names), 1, 1, 3, 2), np.int64))
        ranges = View(np.array([[[0, 1]]], np.int64))
        tile = Tile(x, y, x + 1, y + 1)
        self._look(compiled.tables, settings, tile, ranges, layer_bits(names), sums)
        carry(sums.shaped)
        position, depth = to_float(sums.shaped[:, 0, 0])
        return position if depth[0] > 0.0 else None

    def _seen_from(self, pose: Pose | None) -> tuple[FlatScene, CompiledScene]:
        """The scene from a pose: as it would be flattened and compiled with this camera."""
        if pose is None:
            return self.flat, self.compiled
        placed, made = PlacedCamera(pose.camera, pose.to_world), self._own
        if made.flat.camera.motion is not None:
            # The tables of a camera that moves are of no use to one that does not.
            if self._at_rest is None:
                flat = replace(made.flat, camera=placed)
                self._at_rest = Compiled.of(self.scene, flat, made.layers, self.threads, made.kept)
            made = self._at_rest
        seen = made.seen_from(placed)
        return seen.flat, seen.compiled
