"""The main loop: jobs, tiles, threads, progress and checkpoints."""

from alight.rendering.checkpoints.resume import resume
from alight.rendering.job import Progress
from alight.rendering.merge import merge
from alight.rendering.render import render

__all__ = ["Progress", "merge", "render", "resume"]
