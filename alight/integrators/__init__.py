"""Estimators of light transport, one model per file. A new model is one file and one line here."""

from alight.integrators import ambient_occlusion, direct, light, path, random_walk, volpath

MODELS = (
    path,
    volpath,
    direct,
    ambient_occlusion,
    random_walk,
    light,
)

#: Of scenes that name none and hold no media.
DEFAULT = path.Path()
