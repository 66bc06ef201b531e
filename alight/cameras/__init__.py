"""Cameras, one model per file. A new model is one file and one line here."""

from alight.cameras import orthographic, pinhole, thin_lens

MODELS = (
    pinhole,
    thin_lens,
    orthographic,
)

#: Of scenes whose camera has no type.
DEFAULT = pinhole.Pinhole()
