"""What a pixel sees: the first vertex of one of its paths that scatters light smoothly."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from alight.bsdfs.dispatch import evaluate_bsdf
from alight.compiled.program import Program
from alight.compiled.scene import CompiledScene
from alight.core.errors import OptionError
from alight.core.vec import Vec3
from alight.guiding.lookup import direction_density, place_at
from alight.guiding.tables import Guide
from alight.integrators.walk import to_local
from alight.lab.guide.hemisphere import hemisphere
from alight.rendering.tracing.observation import lane_of, lanes_of
from alight.rendering.tracing.observed_sample import SurfaceNames, observe_sample, path_of
from alight.scene import Scene
from alight.shapes.hit import Surface, spawn_origin
from lanewise.jit import instantiate

#: Pixels across the disks in which a smooth lobe is looked for.
_COARSE = 32


@dataclass(frozen=True)
class ScatteringVertex:
    """A point of a surface that scatters light smoothly, and the direction that it is seen from.

    Attributes
    ----------
    surface : Surface
        Its one lane, in plain Python numbers.
    wo : tuple of 3 floats
        Unit direction to where it is seen from, in the shading frame.
    depth : int
        Edges from the camera; more than 1 behind mirrors and glass.
    shape, material : str
        Names in the scene.
    compiled : CompiledScene
        Without a tree, for the NumPy twin.
    """

    surface: Surface
    wo: tuple[float, float, float]
    depth: int
    shape: str
    material: str
    compiled: CompiledScene

    @property
    def position(self) -> tuple[float, float, float]:
        """In the world, metres."""
        x, y, z = (float(c) + o for c, o in zip(self.surface.p, self.compiled.origin, strict=True))
        return x, y, z

    @property
    def frame(self) -> np.ndarray:
        """(3, 3): tangent, bitangent and shading normal in the world, one a column."""
        return np.stack([self.surface.s, self.surface.t, self.surface.ns], axis=1).astype(float)

    def scattering(self, wi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """f cos (n, 3) and the BSDF's own density (n,) of unit directions (3, n) in the frame."""
        return _scattering(self.compiled, self.surface, self.wo, wi)

    def origin(self, w: np.ndarray) -> np.ndarray:
        """Where rays towards the side of a direction start, in the world."""
        there = spawn_origin(
            Vec3(*self.surface.p), self.surface.error, Vec3(*self.surface.ng), Vec3(*w)
        )
        return np.array([there.x, there.y, there.z], float)

    def leaf_of(self, guide: Guide) -> tuple[int, float]:
        """Number of the guide's leaf here, and the probability with which the guide chooses."""
        leaf = int(np.ravel(_twin(place_at)(guide, lanes_of(self.surface.p, 1)).leaf)[0])
        return leaf, float(guide.leaves.shaped[leaf, 0])

    def density_of(self, guide: Guide, w: np.ndarray) -> np.ndarray:
        """The guide's density here of unit directions (3, n) in the world."""
        n = w.shape[1]
        place = _twin(place_at)(guide, lanes_of(self.surface.p, n))
        directions = Vec3(*w.astype(np.float32))
        return np.asarray(
            _twin(direction_density)(guide, place, directions, np.full(n, True)), float
        )


def vertex_of(scene: Scene, pixel: tuple[int, int], *, seed: int) -> ScatteringVertex:
    """Follow the first sample of a pixel to the first surface that scatters light smoothly.

    Raises
    ------
    OptionError
        If there is none: the path leaves the scene, or ends before.
    """
    found = observe_sample(scene, pixel, sample=0, seed=seed)
    names = SurfaceNames(found.flat)
    directions = np.concatenate(
        [hemisphere(_COARSE, upper=upper).w for upper in (True, False)], axis=1
    )
    for event in found.steps:
        # The program of a scene with holes makes surfaces for shadow rays, too.
        made = event.calls("make_surface")
        if not made:
            continue
        surface, path = made[0].result, path_of(event)
        back = tuple(-c for c in path.d)
        wo = lane_of(to_local(lanes_of(surface, 1), lanes_of(back, 1)), 0)
        f_cos, density = _scattering(found.compiled, surface, wo, directions)
        if not (np.any(f_cos > 0.0) and np.any(density > 0.0)):
            continue
        shape, material = names.shapes[surface.shape], names.bsdfs[surface.bsdf]
        return ScatteringVertex(surface, wo, path.depth + 1, shape, material, found.compiled)
    raise OptionError(
        "its path meets no surface that scatters light smoothly; choose another pixel", "pixel"
    )


def _scattering(
    compiled: CompiledScene, surface: Surface, wo: Any, wi: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    n = wi.shape[1]
    f_cos, density = _twin(evaluate_bsdf, compiled.program)(
        compiled.tables, lanes_of(surface, n), lanes_of(wo, n), Vec3(*wi.astype(np.float32)),
        np.full(n, True),
    )  # fmt: skip
    colours = [np.broadcast_to(c, n).astype(float) for c in (f_cos.x, f_cos.y, f_cos.z)]
    return np.stack(colours, axis=1), np.broadcast_to(density, n).astype(float)


def _twin(root: Any, *program: Program) -> Any:
    return np.errstate(all="ignore")(instantiate(root, *program, compiled=False))
