"""Extinction and scattering coefficients: what all media share."""

from __future__ import annotations

from typing import Annotated, Any, Self

import numpy as np
from pydantic import model_validator

from alight.core.field_types import Color, Positive, Reflectance
from alight.core.field_types import Triple as Triple
from alight.core.fields import Model, invalid
from alight.core.spec import Medium, PhaseFunction
from alight.phases import DEFAULT

#: What a medium is that says nothing: as in Mitsuba.
DEFAULT_EXTINCTION, DEFAULT_ALBEDO = 1.0, 0.75


class Coefficients(Medium):
    """Base class of media.

    Parameters
    ----------
    sigma_t : Color, 1/m, optional
        Extinction: absorption and scattering. 1 by default.
    albedo : Reflectance, optional
        Share of the extinction that is scattering. 0.75 by default.
    sigma_a, sigma_s : Color, 1/m, optional
        Absorption and scattering, instead of both; one alone leaves the other 0.
    scale : float > 0, default 1
        Factor of all coefficients.
    emission : Color, W m^-2 sr^-1, default 0
        What the medium shines with where it absorbs: deep inside of one that only absorbs, light is
        this bright. On a way dt it adds sigma_a times this, times dt.
    phase : PhaseFunction, default isotropic
        Where scattered light goes.
    """

    sigma_t: Color | None = None
    albedo: Reflectance | None = None
    sigma_a: Color | None = None
    sigma_s: Color | None = None
    scale: Positive = 1.0
    emission: Color = (0.0, 0.0, 0.0)
    phase: Annotated[PhaseFunction, Model("phase function", "phases")] = DEFAULT

    @property
    def largest_emission(self) -> float:
        """Of all channels and places."""
        return max(self.emission)

    def shining(self, emission: Triple) -> Self:
        """The same with this emission everywhere."""
        return self.replaced(emission=emission)

    def moved(self, shift: np.ndarray) -> Self | None:
        """The same in another place, (3,) metres further; None if a medium cannot tell its place.

        What is the same everywhere has none. A scene with a medium that returns None is rendered in
        the coordinates that it has, however far they are from the origin.
        """
        return None

    @model_validator(mode="after")
    def _given_one_way(self) -> Self:
        first = self.sigma_t is not None or self.albedo is not None
        second = self.sigma_a is not None or self.sigma_s is not None
        if first and second:
            raise invalid("takes sigma_t and albedo, or sigma_a and sigma_s, got some of both")
        return self


def shines(spec: Any) -> bool:
    """Whether a medium adds light; of a grid in a file, that is its `emission`."""
    return (
        spec.largest_emission > 0.0
        and min(scattering_albedo(spec)) < 1.0
        and max(extinction(spec)) > 0.0
    )


def extinction(spec: Any) -> Triple:
    """Extinction of each channel, 1/m."""
    total = [DEFAULT_EXTINCTION] * 3 if spec.sigma_t is None else spec.sigma_t
    if spec.sigma_a is not None or spec.sigma_s is not None:
        total = [a + s for a, s in zip(*_parts(spec), strict=True)]
    red, green, blue = (spec.scale * channel for channel in total)
    return red, green, blue


def scattering_albedo(spec: Any) -> Triple:
    """Share of scattering in the extinction of each channel; 0 where there is none."""
    if spec.sigma_a is None and spec.sigma_s is None:
        default = (DEFAULT_ALBEDO, DEFAULT_ALBEDO, DEFAULT_ALBEDO)
        return default if spec.albedo is None else spec.albedo
    pairs = zip(*_parts(spec), strict=True)
    red, green, blue = (s / (a + s) if s > 0.0 else 0.0 for a, s in pairs)
    return red, green, blue


def _parts(spec: Any) -> tuple[Triple, Triple]:
    black = (0.0, 0.0, 0.0)
    return spec.sigma_a or black, spec.sigma_s or black
