"""The parameters of `principled` at a point of a surface.

Lobes that no material of a program has are not compiled; their parameters are then a number that
nothing reads.
"""

from __future__ import annotations

import math
from collections import namedtuple
from typing import Annotated, Any, NamedTuple

from alight.bsdfs.dielectrics.dispersion import Index
from alight.bsdfs.disney.sheen import ROW as SHEEN_ROW
from alight.bsdfs.microfacets.albedo_rows import LEAST_ALPHA, ROW, alpha_along
from alight.bsdfs.microfacets.albedo_table import load_rows
from alight.bsdfs.microfacets.facets import ANISOTROPIC
from alight.bsdfs.normals.coat_normals import CoatNormalRow, own_coat_at
from alight.bsdfs.rows import rows_at, rows_in_slots
from alight.core.maths import sincos
from alight.core.microfacet import Facets
from alight.core.parameters import Slots, loader, slots_of
from alight.textures.fetch import (
    Scalar,
    TexturedColor,
    color,
    constant_color,
    scalar,
    textured_scalar,
)
from lanewise.jit import kernel, specialised
from lanewise.simd import lanes, maximum, minimum

#: What programs call lobes that not every material has.
GLASS, COAT = "principled:glass", "principled:coat"
SHEEN, FILM = "principled:sheen", "principled:film"
#: What programs call it that metallic or roughness are textured, and that any of the others is:
#: each lookup of a texture is compiled inline.
TEXTURED, VARIED = "principled:textured", "principled:varied"
#: Larger angles of textures, in radians, are taken for this one: kernels do not know them.
MOST_TURNED = 1e5


def within_a_turn(angle: float) -> float:
    """The angle of the same direction in [-pi, pi]: kernels know no angles of many turns."""
    return math.remainder(angle, 2.0 * math.pi)


#: Where the facets' long axis lies: sine and cosine of its angle from the tangent; and by how much
#: it is the longer one.
Turn = namedtuple("Turn", "sine cosine anisotropy")
NO_TURN = Turn(0.0, 1.0, 0.0)
#: Facets of the base, and their frame.
Brush = namedtuple("Brush", "facets turn")
#: Layers: how strong they are, and what they are made of.
Coat = namedtuple("Coat", "strength facets rows")
Sheen = namedtuple("Sheen", "color roughness rows")


# ---------------------------------------------------------------- fields of a row


@specialised
def _usual_at(program):
    return textured_scalar if TEXTURED in program.bsdfs else scalar


@specialised
def _rare_at(program):
    return textured_scalar if VARIED in program.bsdfs else scalar


@specialised
def _rare_color_at(program):
    return color if VARIED in program.bsdfs else constant_color


@kernel
def _flag_at(scene, slot, surface):
    return scalar(scene, slot, surface) > 0.0


#: metallic and roughness; all others that may be textured; masks.
Usual = Annotated[Any, Slots(_usual_at)]
Rare = Annotated[Any, Slots(_rare_at)]
RareColor = Annotated[Any, Slots(_rare_color_at, 3)]
Flag = Annotated[Any, Slots(_flag_at)]


@kernel
def _unit(a):
    return minimum(maximum(a, 0.0), 1.0)


@kernel
def _alpha(root):
    return maximum(root * root, LEAST_ALPHA)


@kernel
def _nothing(scene, slot, surface):
    return lanes(0.0)


class IsotropicRow(NamedTuple):
    """Roughness in the table."""

    roughness: Usual


class BrushRow(NamedTuple):
    """Roughness that differs by direction."""

    roughness: Usual
    anisotropy: Rare
    anisotropy_rotation: Rare


_load_isotropic, _load_brush = loader(IsotropicRow), loader(BrushRow)


@specialised
def _brush_at(program):
    """``(scene, slot, surface) -> Brush``."""
    if ANISOTROPIC not in program.bsdfs:

        @kernel
        def isotropic(scene, slot, surface):
            alpha = _alpha(_unit(_load_isotropic(scene, slot, surface).roughness))
            return Brush(Facets(alpha, alpha, lanes(0.0)), NO_TURN)

        return isotropic

    @kernel
    def anisotropic(scene, slot, surface):
        row = _load_brush(scene, slot, surface)
        alpha, a = _alpha(_unit(row.roughness)), _unit(row.anisotropy)
        s, c = sincos(minimum(maximum(row.anisotropy_rotation, -MOST_TURNED), MOST_TURNED))
        return Brush(Facets(alpha_along(alpha, a), alpha, lanes(0.0)), Turn(s, c, a))

    return anisotropic


class CoatRow(NamedTuple):
    """The clear coat in the table."""

    clearcoat: Rare
    clearcoat_roughness: Rare
    coat_rows: Annotated[Any, rows_in_slots("coat_rows")]


_load_coat = loader(CoatRow)


@specialised
def _coat_at(program):
    """``(scene, slot, surface) -> Coat``, or nothing."""
    if COAT not in program.bsdfs:
        return _nothing

    @kernel
    def coat(scene, slot, surface):
        row = _load_coat(scene, slot, surface)
        root = _unit(row.clearcoat_roughness)
        alpha = _alpha(root)
        facets = Facets(alpha, alpha, lanes(0.0))
        return Coat(row.clearcoat, facets, rows_at(row.coat_rows, root, ROW))

    return coat


class SheenRow(NamedTuple):
    """The sheen in the table."""

    sheen_color: RareColor
    sheen_roughness: Rare
    sheen_rows: Annotated[Any, rows_in_slots("sheen_rows")]


_load_sheen = loader(SheenRow)


@specialised
def _sheen_at(program):
    """``(scene, slot, surface) -> Sheen``, or nothing."""
    if SHEEN not in program.bsdfs:
        return _nothing

    @kernel
    def sheen(scene, slot, surface):
        row = _load_sheen(scene, slot, surface)
        roughness = _unit(row.sheen_roughness)
        return Sheen(row.sheen_color, roughness, rows_at(row.sheen_rows, roughness, SHEEN_ROW))

    return sheen


class Film(NamedTuple):
    """A thin film: share of its reflectance, index and thickness in nanometres."""

    iridescence: Rare
    iridescence_ior: Scalar
    iridescence_thickness: Rare


_load_film = loader(Film)


@specialised
def _film_at(program):
    """``(scene, slot, surface) -> Film``, or nothing."""
    return _load_film if FILM in program.bsdfs else _nothing


# ---------------------------------------------------------------- the row


class Params(NamedTuple):
    """A row of the table; coat, sheen and film are nothing in programs without them.

    own_coat : see `alight.bsdfs.normals.coat_normals`, nothing where no coat has normals of its
    own.
    """

    base_color: TexturedColor
    metallic: Usual
    brush: Annotated[Any, Slots(_brush_at, slots_of(BrushRow))]
    rows: Annotated[Any, Slots(load_rows, {"rows": 1, "last_row": 1})]
    eta: Index
    specular: Rare
    specular_color: RareColor
    transmission: Rare
    thin: Flag
    compensated: Flag
    coat: Annotated[Any, Slots(_coat_at, slots_of(CoatRow))]
    sheen: Annotated[Any, Slots(_sheen_at, slots_of(SheenRow))]
    film: Annotated[Any, Slots(_film_at, slots_of(Film))]
    own_coat: Annotated[Any, Slots(own_coat_at, slots_of(CoatNormalRow))]


#: The parameters whose textures make a program `VARIED`.
RARELY_TEXTURED = (
    "specular", "specular_color", "anisotropy", "anisotropy_rotation", "transmission", "clearcoat",
    "clearcoat_roughness", "sheen_color", "sheen_roughness", "iridescence", "iridescence_thickness",
)  # fmt: skip
