"""Sources of light, one model per file. A new model is one file and one line here."""

from alight.lights import (
    area,
    constant,
    directional,
    environment,
    ies,
    point,
    portal,
    projector,
    sky,
    spot,
    sun,
    sunsky,
)

MODELS = (
    point,
    directional,
    area,
    constant,
    spot,
    environment,
    sky,
    sun,
    sunsky,
    ies,
    projector,
    portal,
)
