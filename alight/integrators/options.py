"""Options that integrators share: how light is found, and how long paths are."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import model_validator

from alight.core.field_types import Depth
from alight.core.fields import Truth, invalid
from alight.core.noise_only import NoiseOnly
from alight.core.spec import Integrator


class LightSampling(Integrator):
    """Base class of integrators that look for light in two ways.

    Parameters
    ----------
    light_sampling : {"mis", "bsdf", "emitter"}, default "mis"
        How direct light is found: by BSDF sampling, by light sampling, or by both combined. All
        compute the same picture.
    light_choice : {"auto", "power", "uniform", "tree"}, default "auto"
        Probability of each light: by its power, the same for all, or by a tree that knows where
        lights are and where they face; "auto" takes the tree for many lights, else the power.
    hide_emitters : bool, default False
        Whether the camera sees through lights: surfaces that shine, and the environment. They
        light the scene as ever.
    """

    light_sampling: Annotated[Literal["mis", "bsdf", "emitter"], NoiseOnly()] = "mis"
    light_choice: Annotated[Literal["auto", "power", "uniform", "tree"], NoiseOnly()] = "auto"
    hide_emitters: Truth = False

    @property
    def choice_of_lights(self) -> str:
        """As `light_choice` says."""
        return self.light_choice

    @property
    def combines(self) -> bool:
        """Both ways, weighted."""
        return self.light_sampling == "mis"

    @property
    def finds_light_by_chance(self) -> bool:
        """By BSDF sampling alone."""
        return self.light_sampling == "bsdf"


class PathLengths(Integrator):
    """Base class of integrators whose paths may end at random.

    Parameters
    ----------
    russian_roulette : {"throughput", "none"}, default "throughput"
        Whether dim paths end at random, with weights that keep the mean.
    rr_depth : int >= 1, default 5
        Depth from which roulette is played.
    max_depth : int >= 1, optional
        Longest path, counted in edges: 1 shows lights only, 2 adds direct light. Unlimited by
        default, which needs roulette.
    """

    russian_roulette: Annotated[Literal["throughput", "none"], NoiseOnly()] = "throughput"
    rr_depth: Annotated[Depth, NoiseOnly()] = 5
    max_depth: Depth | None = None

    @property
    def longest_path(self) -> int | None:
        """As `max_depth` says."""
        return self.max_depth

    @model_validator(mode="after")
    def _paths_end(self) -> Self:
        if self.max_depth is None and self.russian_roulette == "none":
            raise invalid("paths would never end: give max_depth or russian_roulette: throughput")
        return self


class PathTracing(PathLengths, LightSampling):
    """Base class of path tracers.

    Parameters
    ----------
    guiding : {"off", "on", "auto", "camera"}, default "off"
        Whether paths also follow a guide, which learns before the picture where light comes from
        (`alight.guiding`); "auto": where training finds that it pays; "camera": a guide that
        learns from the camera's paths alone, and not from light paths too. Roulette then ends paths
        that the guide expects to add little, from the second vertex on.
    """

    guiding: Annotated[Literal["off", "on", "auto", "camera"], NoiseOnly()] = "off"

    @property
    def wants_guide(self) -> bool:
        """As `guiding` says."""
        return self.guiding != "off"

    @property
    def way_of_guiding(self) -> str:
        """As `guiding` says."""
        return self.guiding
