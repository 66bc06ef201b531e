"""What the pilots of a picture begin with, found once for all of them."""

from __future__ import annotations

import copy
from functools import cached_property

import numpy as np

from alight.compiled.area_maps import Textures
from alight.compiled.lights import emitting_lights
from alight.compiled.rendering_space import in_rendering_space
from alight.compiled.scene import CompiledScene
from alight.lights.tables import EmittingLights
from alight.rendering.pilot_rays import Collided, Pilot, Seen, seen_points
from alight.scene.flatten import FlatScene


class Sight:
    """The points that a picture sees, and its lamps.

    Parameters
    ----------
    flat : FlatScene
    scene : CompiledScene
        Made of it.

    Attributes
    ----------
    flat : FlatScene
        In rendering space.
    scene : CompiledScene
    """

    def __init__(self, flat: FlatScene, scene: CompiledScene) -> None:
        self.flat, self.scene = in_rendering_space(flat, scene.origin), scene
        self._random = np.random.default_rng(0)

    @cached_property
    def _looked(self) -> tuple[Seen, Collided]:
        return seen_points(Pilot(self.scene, self._random))

    @property
    def seen(self) -> Seen:
        """The same points whatever the seed of the picture."""
        return self._looked[0]

    @property
    def collided(self) -> Collided:
        """Where media scatter light into what it sees."""
        return self._looked[1]

    def random(self) -> np.random.Generator:
        """Random numbers behind those that drew `seen`, the same ones each time."""
        assert self.seen is not None
        return copy.deepcopy(self._random)

    @cached_property
    def lights(self) -> EmittingLights | None:
        """The lamps as paths start at them; None where there is one at which they cannot."""
        textures = Textures(self.scene.tables.materials, self.scene.program.textures)
        return emitting_lights(self.flat, textures)
