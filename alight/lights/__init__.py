"""Sources of light, one model per file. A new model is one file and one line here."""

from alight.lights import area, constant, directional, environment, point, spot

MODELS = (
    point,
    directional,
    area,
    constant,
    spot,
    environment,
)
