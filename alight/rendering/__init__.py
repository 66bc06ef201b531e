"""The main loop: jobs, tiles, threads, progress and checkpoints."""

from alight.rendering.job import Progress
from alight.rendering.merge import merge
from alight.rendering.render import render
from alight.rendering.resume import resume

__all__ = ["Progress", "merge", "render", "resume"]
