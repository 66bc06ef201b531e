"""Contact sheets: many scenes as small pictures on one page, none left out."""

from alight.lab.sheet.scenes import find_scenes
from alight.lab.sheet.tiles import Tile, render_tile
from alight.lab.sheet.views import SUFFIXES, write_sheet

__all__ = ["SUFFIXES", "Tile", "find_scenes", "render_tile", "write_sheet"]
