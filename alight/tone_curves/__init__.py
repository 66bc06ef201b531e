"""Tone curves, from unbounded scene light to what a display can show; one model per file.

A new model is one file and one line here.
"""

from alight.tone_curves import aces, agx, clip, hable, reinhard

MODELS = (
    clip,
    reinhard,
    aces,
    hable,
    agx,
)

#: Of displays that name none.
DEFAULT = clip.Clip()
