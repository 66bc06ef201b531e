"""What a guide has learnt where a pixel's path first scatters."""

from alight.lab.guide.guided_vertex import GuidedVertex, guide
from alight.lab.guide.sides import Side

__all__ = ["GuidedVertex", "Side", "guide"]
