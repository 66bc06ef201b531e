"""Rare light of a picture: light that paths find by chance alone."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from alight.core.spec import Integrator
from alight.rendering.light_behind_glass import light_behind_glass
from alight.rendering.light_off_surfaces import light_off_surfaces
from alight.rendering.pilot_rays import POINTS
from alight.rendering.sight import Sight


class RareLight:
    """Tables of rare light, each made when it is first asked for.

    Parameters
    ----------
    sight : Sight, optional
        What the picture sees; without it there is no such light.
    """

    def __init__(self, sight: Sight | None = None) -> None:
        self._sight = sight

    @cached_property
    def behind_glass(self) -> np.ndarray | None:
        """Light behind clear glass and off mirrors: rows of `light_behind_glass`, or None."""
        return light_behind_glass(self._sight) if self._sight else None

    @cached_property
    def everywhere(self) -> np.ndarray | None:
        """That, and light off small bright surfaces: `Film.rare_light`, or None."""
        if not self._sight:
            return None
        parts = [self.behind_glass, light_off_surfaces(self._sight)]
        found = [part for part in parts if part is not None]
        return np.concatenate(found) if found else None

    def left_by(self, integrator: Integrator) -> np.ndarray | None:
        """Rows of `everywhere` that another integrator finds by chance, too.

        Paths from both ends are joined at what the camera sees, unless it sees it in a mirror or
        through glass. Walks find what arrives by way of mirrors and glass.
        """
        table = self.everywhere
        if table is None or self._sight is None:
            return None
        if integrator.splats:
            turned = np.zeros(POINTS, bool)
            turned[self._sight.seen.point[self._sight.seen.turned]] = True
            return table[turned[table[:, 0].astype(int)]]
        behind = self.behind_glass
        return table[len(behind) :] if integrator.aims_at_lamps and behind is not None else table
