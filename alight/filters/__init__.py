"""Pixel filters, one model per file. A new model is one file and one line here."""

from alight.filters import box, gaussian, mitchell, tent

MODELS = (
    box,
    tent,
    gaussian,
    mitchell,
)

#: Of films that name none.
DEFAULT = box.Box()
