"""Estimators of light transport, one model per file. A new model is one file and one line here."""

from alight.integrators import ambient_occlusion, direct, path, random_walk

MODELS = (
    path,
    direct,
    ambient_occlusion,
    random_walk,
)
