"""Scenes from files and into files: the native format, and those of other programs.

The usual names are exported here::

    from alight.formats import load, save
"""

from alight.formats.loading import load, loads
from alight.formats.native import dumps, save
from alight.formats.scene_text import builtin_names

__all__ = ["builtin_names", "dumps", "load", "loads", "save"]
