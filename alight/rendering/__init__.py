"""The main loop: jobs, tiles, threads and progress."""

from alight.rendering.main_loop import Progress, render

__all__ = ["Progress", "render"]
