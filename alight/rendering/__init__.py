"""The main loop: jobs, tiles, threads, progress and checkpoints."""

from alight.rendering.job import Progress
from alight.rendering.main_loop import render
from alight.rendering.merge import merge
from alight.rendering.resume import resume

__all__ = ["Progress", "merge", "render", "resume"]
