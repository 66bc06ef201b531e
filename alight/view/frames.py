"""Pictures on their way to a browser, as `alight.view.protocol` describes them."""

from __future__ import annotations

import struct
from typing import Any

_HEAD = struct.Struct("<4I")


def frame(picture: int, number: int, rgba: Any) -> bytes:
    """Pack a frame.

    Parameters
    ----------
    picture : {0, 1}
    number : int
        Of the view.
    rgba : ndarray of uint8, shape (h, w, 4)
    """
    height, width = rgba.shape[:2]
    return _HEAD.pack(picture, width, height, number) + rgba.tobytes()
