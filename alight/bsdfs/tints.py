"""Tints of Fresnel reflection and transmission: 1 for real materials, which costs nothing."""

from __future__ import annotations

from typing import Annotated, Any

from alight.core.field_types import Triple
from alight.core.parameters import Slots
from alight.core.spec import Texture
from alight.textures.fetch import color
from lanewise.jit import kernel, specialised
from lanewise.simd import lanes_vec3

#: What programs call a material with a tint other than 1.
TINTED = "tinted"
WHITE = (1.0, 1.0, 1.0)


def tint_features(*tints: Triple | Texture | str) -> tuple[str, ...]:
    """What must be compiled for these tints."""
    return () if all(tint == WHITE for tint in tints) else (TINTED,)


@specialised
def tint(program):
    """``tint(scene, slot, surface) -> Vec3``, from the three slots of a colour."""
    return color if TINTED in program.bsdfs else _white


@kernel
def _white(scene, slot, surface):
    return lanes_vec3(1.0)


#: Field of a record of parameters.
Tint = Annotated[Any, Slots(tint, 3)]
