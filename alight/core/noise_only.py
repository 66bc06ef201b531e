"""Fields of descriptions that change the noise of a picture, never its mean.

A model says so where it declares the field, for instance how directions are drawn::

    sampling: Annotated[Literal["cosine", "uniform"], NoiseOnly()] = "cosine"

Whoever compares techniques may set such a field freely. Fields that do not say so decide what is
computed, those of a user's own models too.
"""

from __future__ import annotations

from dataclasses import dataclass

from pydantic import BaseModel


@dataclass(frozen=True)
class NoiseOnly:
    """That a field changes the noise only; metadata of a field type."""


def noise_only_fields(spec: BaseModel) -> tuple[str, ...]:
    """Names of the fields that a description's model declares so."""
    fields = type(spec).model_fields.items()
    return tuple(name for name, field in fields if NoiseOnly() in field.metadata)
