"""What the renderer takes from the file of a texture, and how textures read their rows."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any

from alight.core.parameters import Slots
from alight.core.registry import Kernel, Record, Records
from alight.core.vec import gather_vec3
from lanewise.jit import kernel
from lanewise.simd import gather


def no_features(spec: Any) -> tuple[str, ...]:
    """Nothing."""
    return ()


@kernel
def no_parameters(scene, base, surface):
    """An empty record."""
    return ()


@dataclass(frozen=True, eq=False, kw_only=True)
class TextureModel(Record):
    """A texture: a colour for each point, an operation on the colours of others, or a constant.

    Attributes
    ----------
    SLOTS : mapping of str to int
        Names and widths of the numbers of a texture, in the order of its row.
    pack : (spec, packer)
        Fills the row.
    evaluate : kernel ``(scene, base, surface) -> Vec3``
        Colour at a point of a surface, from the row that begins at `base`.
    load : kernel ``(scene, base, surface) -> params``
        Of operations: their own parameters.
    operate : kernel ``(params, a, ...) -> Vec3``
        The colour from those of its parts.
    features : (spec) -> tuple of str
        What programs must compile for a texture.
    """

    SLOTS: Mapping[str, int] = field(default_factory=dict)
    pack: Callable[[Any, Any], None] | None = None
    evaluate: Kernel | None = None
    load: Kernel = no_parameters
    operate: Kernel | None = None
    features: Callable[[Any], tuple[str, ...]] = no_features


#: All textures, by name.
TEXTURES = Records("textures", TextureModel)


def patterns(program) -> list[TextureModel]:
    """The models of a program that find a colour themselves."""
    return [model for model in _used(program) if model.evaluate is not None]


def operators(program) -> list[TextureModel]:
    """The models of a program that compute one from those of others."""
    return [model for model in _used(program) if model.operate is not None]


def constants(program) -> list[TextureModel]:
    """The models of a program that are the same everywhere: their row is a colour."""
    return [model for model in _used(program) if not model.spec.varies]


def _used(program) -> list[TextureModel]:
    return [model for name, model in TEXTURES.items() if name in program.textures]


# ---------------------------------------------------------------- fields of a texture's parameters


@kernel
def _number_at(scene, slot, surface):
    return gather(scene.materials.texture_data, slot)


@kernel
def _flag_at(scene, slot, surface):
    return gather(scene.materials.texture_data, slot) > 0.0


@kernel
def _triple_at(scene, slot, surface):
    return gather_vec3(scene.materials.texture_data, slot)


#: See `alight.core.parameters`: a number, a mask, three numbers.
Number = Annotated[Any, Slots(_number_at)]
Flag = Annotated[Any, Slots(_flag_at)]
Triplet = Annotated[Any, Slots(_triple_at, 3)]
