"""The layers beside a picture: what each holds, and the order in which they are kept."""

from __future__ import annotations

from collections.abc import Sequence

from alight.films.mattes import ALL_MATTES, MATTES
from alight.integrators.aov import LAYERS
from alight.integrators.shadow_catcher import CHANNELS
from alight.lights.ground import SHADOW

#: Further layers and their channels; mattes have none, they are kept as a table.
AOVS = {
    "direct": ("R", "G", "B"), "indirect": ("R", "G", "B"), **LAYERS, SHADOW: CHANNELS,
    **dict.fromkeys(MATTES, ()),
}  # fmt: skip


def layers_of(names: Sequence[str]) -> tuple[str, ...]:
    """Layers in our order, each once; direct and indirect light come together."""
    wanted = set(names)
    if wanted & {"direct", "indirect"}:
        wanted |= {"direct", "indirect"}
    if ALL_MATTES in wanted:
        wanted |= set(MATTES)
    return tuple(name for name in AOVS if name in wanted)
