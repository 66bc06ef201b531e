"""Participating media, one model per file; a new one is a line here too.

A model has `pack`, and two kernels: `fly` chooses where a path is scattered, `cross` says how much
light comes through on the way of a shadow ray; see `alight.media.tables`.
"""

from alight.media import grid, homogeneous

MODELS = (
    homogeneous,
    grid,
)
