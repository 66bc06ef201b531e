"""How a layer is shown."""

from __future__ import annotations

from dataclasses import dataclass, field

from alight.outputs.display import Display
from alight.view.contrast import DIVIDER
from alight.view.layers import PICTURE


@dataclass(frozen=True)
class Look:
    """How a layer is shown.

    Attributes
    ----------
    layer : str
        What is wished for; the picture where the layers lack it.
    display : Display
    denoised : bool
        The picture is, when it rests.
    way : str
        How it is compared, see `alight.view.contrast`.
    """

    layer: str = PICTURE
    display: Display = field(default_factory=Display)
    denoised: bool = False
    way: str = DIVIDER
