"""Estimators of light transport, one model per file. A new model is one file and one line here."""

from alight.integrators import (
    ambient_occlusion,
    bidirectional,
    direct,
    light,
    path,
    random_walk,
    volpath,
)

MODELS = (
    path,
    volpath,
    direct,
    ambient_occlusion,
    random_walk,
    light,
    bidirectional,
)

#: Of scenes that name none and hold no media.
DEFAULT = path.Path()
