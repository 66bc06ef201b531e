"""Light and densities of all directions on either side of a surface."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from alight.compiled.scene import CompiledScene, compile_time_options
from alight.core.constants import LUMINANCE
from alight.guiding.tables import GUIDED
from alight.integrators.guided import mixed
from alight.lab.guide.hemisphere import Hemisphere, hemisphere
from alight.lab.guide.incidence import HALVES, arriving_light
from alight.lab.guide.vertex import ScatteringVertex
from alight.rendering.training.trainer import framed
from lanewise.view import View

#: Pixels across the disks.
SIDE = 180


@dataclass(frozen=True)
class Side:
    """Directions on one side of a surface; arrays have one row a direction.

    Attributes
    ----------
    name : str
    disk : Hemisphere
    light : (n, 3) ndarray
        Radiance that arrives.
    ideal, of_bsdf, of_guide, of_mixture : (n,) ndarray
        Densities per steradian. The ideal one is the luminance of f cos times that of the light,
        divided by the integral of it over both sides.
    square : (n,) ndarray
        Of the ideal density, without bias: the product of two independent estimates.
    """

    name: str
    disk: Hemisphere
    light: np.ndarray
    ideal: np.ndarray
    of_bsdf: np.ndarray
    of_guide: np.ndarray
    of_mixture: np.ndarray
    square: np.ndarray

    def relative_square(self, density: np.ndarray) -> float:
        """The part of this side in the second moment of a direction of that density."""
        return float(np.sum(_over(self.square, density))) * self.disk.solid_angle

    @property
    def weight(self) -> np.ndarray:
        """What a direction drawn from the mixture weighs, over the mean of all."""
        return _over(self.ideal, self.of_mixture)


def sides_of(
    vertex: ScatteringVertex,
    scene: CompiledScene,
    share: float,
    *,
    without_lamps: bool,
    spp: int,
    seed: int,
    threads: int,
) -> tuple[Side, ...]:
    """The side that a vertex is seen from, and the other one if light is transmitted.

    Parameters
    ----------
    vertex : ScatteringVertex
    scene : CompiledScene
        With a trained guide.
    share : float
        Probability with which the guide chooses.
    without_lamps : bool
        Leave out light that comes straight from lamps and the sky.
    spp : int
        Samples of the light from each direction.
    seed, threads : int
    """
    assert scene.guide is not None
    around = _as_a_vertex_sees_it(scene, without_lamps)
    bottom = float(np.arctan2(vertex.wo[1], vertex.wo[0]))
    found = []
    for name, upper in (("above", True), ("below", False)):
        disk = hemisphere(SIDE, upper=upper, bottom=bottom)
        f_cos, of_bsdf = vertex.scattering(disk.w)
        if not np.any(f_cos > 0.0):
            continue
        w = vertex.frame @ disk.w
        halves = arriving_light(
            around, vertex.origin(w.mean(axis=1)), w,
            spp=max(spp // HALVES, 1) * HALVES, seed=seed, threads=threads,
        )  # fmt: skip
        of_guide = vertex.density_of(scene.guide, w)
        # f cos times light by each half of its samples; divided by their integral below.
        wanted = (f_cos @ LUMINANCE) * (halves @ LUMINANCE)
        found.append(
            Side(
                name=name,
                disk=disk,
                light=halves.mean(axis=0),
                ideal=wanted.mean(axis=0),
                of_bsdf=of_bsdf,
                of_guide=of_guide,
                of_mixture=mixed(share, of_guide, of_bsdf),
                square=wanted.prod(axis=0),
            )
        )
    integral = max(sum(float(one.ideal.sum()) * one.disk.solid_angle for one in found), 1e-30)
    return tuple(
        replace(one, ideal=one.ideal / integral, square=one.square / integral**2) for one in found
    )


def _as_a_vertex_sees_it(scene: CompiledScene, without_lamps: bool) -> CompiledScene:
    """The guided scene for a camera at a vertex."""
    assert scene.guide is not None
    integrator = scene.integrator
    if without_lamps:
        integrator = integrator.replaced(hide_emitters=True)
    options = (*compile_time_options(integrator), (GUIDED, True))
    # Roulette knows the film's picture: all of this one is as bright as that was on average.
    picture = np.full((1, 1), scene.guide.picture.array.mean(), np.float32)
    blocks = View(framed(scene.guide.box.array, picture, scene.size).blocks)
    return replace(
        scene,
        program=scene.program._replace(options=options),
        integrator=integrator,
        guide=scene.guide._replace(picture=View(picture), blocks=blocks),
    )


def _over(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The quotient; 0 where both are 0."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(a != 0.0, a / b, 0.0)
