r"""Coats with normals of their own, on a base whose normals a map may bend.

A map gives the whole material that it wraps other normals, and hands directions to it in the bent
frame. A coat with normals of its own does not follow: lacquer lies smooth over rough wood. Such a
material is told directions in the surface's own frame, and the bent one beside them (`Bend`): its
base turns to the one, its coat to the normals that `clearcoat_normal` has, or to those of the
surface. Each fades and stays on its side of the true surface by itself, as
`alight.bsdfs.normals.shading_normals` has it for the whole; normals of the coat that turn away from
the viewer are lit.

Source: KHR_materials_clearcoat, where the coat is smooth unless it has a texture of normals;
OpenPBR surface 1.1, ``geometry_coat_normal``.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Any, NamedTuple

from alight.bsdfs.flags import DELTA
from alight.bsdfs.model import BsdfValue
from alight.bsdfs.normals.shading_normals import (
    OF_SET,
    TURNED,
    fading,
    frame_of_map,
    lit_normal,
    normal_of_texel,
    write_axes,
)
from alight.bsdfs.normals.tangent_space import UNTURNED, set_of, turn_of
from alight.core.frame import frame_from_tangent, to_local, to_world
from alight.core.parameters import loader, reader
from alight.core.vec import Vec3, dot, renormalize
from alight.shapes.hit import OWN_COAT, Bend, is_bent_below
from alight.shapes.surfaces import unbent
from alight.textures.fetch import PlainColor, Scalar, TexturedColor
from lanewise.jit import kernel, specialised
from lanewise.records import replace
from lanewise.simd import lanes, lanes_mask, where

#: The colour of normals along the surface's own.
FLAT = (0.5, 0.5, 1.0)

#: At a point. apart: mask, the coat has normals of its own; normal: its own, local; bend: of what
#: is below it; cosine: of the angle between the coat's normal and the viewer's direction.
OwnCoat = namedtuple("OwnCoat", "apart normal bend cosine")


class CoatNormalRow(NamedTuple):
    """Normals of a coat in the table, as a normal map has them."""

    coat_apart: Scalar
    clearcoat_normal: TexturedColor
    clearcoat_normal_scale: Scalar
    coat_modes: Scalar
    coat_turn: PlainColor


def pack_coat_normals(packer: Any, apart: bool, normal: Any, scale: float) -> None:
    """Fill the slots of a coat's normals; `normal` is its colour, texture or None."""
    packer.numbers("coat_apart", apart)
    packer.color("clearcoat_normal", normal if apart else FLAT)
    packer.numbers("clearcoat_normal_scale", scale)
    packer.numbers("coat_modes", OF_SET * set_of(normal))
    packer.numbers("coat_turn", *turn_of(normal))


def coat_features(normal: Any) -> tuple[str, ...]:
    """What must be compiled for a coat with normals of its own; see `map_features`."""
    turned = (TURNED,) if turn_of(normal) != UNTURNED else ()
    return (OWN_COAT, "anisotropic", *turned)


_load = loader(CoatNormalRow)
_modes_at, _turn_at = (reader(CoatNormalRow, name) for name in ("coat_modes", "coat_turn"))


@specialised
def axes_of_coat(program):
    """``(scene, base, surface) -> (dp/du, dp/dv, s, t)`` of the picture of a coat's normals."""
    return write_axes(program, _modes_at, _turn_at)


@specialised
def own_coat_at(program):
    """``(scene, slot, surface) -> OwnCoat``, or nothing."""
    if OWN_COAT not in program.bsdfs:
        return _nothing
    bends = is_bent_below(program)

    @kernel
    def own_coat(scene, slot, surface):
        row = _load(scene, slot, surface)
        apart, up = row.coat_apart > 0.0, Vec3(lanes(0.0), lanes(0.0), lanes(1.0))
        axes = axes_of_coat(scene, slot, surface)
        texel, scale = row.clearcoat_normal, row.clearcoat_normal_scale
        normal = normal_of_texel(surface, texel, scale, axes, lanes_mask(True))
        bend = unbent()
        if bends:
            bend = where(apart, surface.bend, bend)
        return OwnCoat(apart, where(apart, normal, up), bend, lanes(1.0))

    return own_coat


@kernel
def _nothing(scene, slot, surface):
    return lanes(0.0)


@kernel
def seen_from(own, wo):
    """The `OwnCoat` with the normal that the viewer sees, and its cosine; wo local, above."""
    normal = where(own.apart, lit_normal(own.normal, wo), own.normal)
    return replace(own, normal=normal, cosine=dot(normal, wo))


@kernel
def axes_of(own):
    """(s, t, n): the frame of the coat, in the local one."""
    x = Vec3(lanes(1.0), 0.0 * own.normal.x, 0.0 * own.normal.x)
    s, t = frame_from_tangent(own.normal, x)
    return s, t, own.normal


@kernel
def below_coat(own, w):
    """The local direction w in the frame of what is below the coat."""
    return to_local(own.bend.s, own.bend.t, own.bend.n, w)


@kernel
def from_below_coat(own, w):
    """The way back."""
    return to_world(own.bend.s, own.bend.t, own.bend.n, w)


@kernel
def left_below(own, wo, wi):
    """What the bent normals below the coat let through: 0 on the wrong side of the true surface."""
    bend = own.bend
    agrees = (dot(bend.n, wo) * wo.z > 0.0) & (dot(bend.n, wi) * wi.z > 0.0)
    return where(agrees, where(wo.z * wi.z > 0.0, fading(bend.n, bend.fades, wi), 1.0), 0.0)


@kernel
def left_of_coat(own, wi):
    """What the coat's own normals let through."""
    return fading(own.normal, own.apart, wi)


# ---------------------------------------------------------------- maps around such materials


def bent_evaluate(one_sided: Any, stride: int, normals_of: Any, is_apart: Any) -> Any:
    """`evaluate_row` with the bent normals of maps; arguments as in `alight.bsdfs.switch`."""

    @kernel
    def evaluate_row(scene, surface, row, wo, wi, active):
        s, t, n, fades = frame_of_map(scene, surface, normals_of(scene, row), stride, wo)
        apart = is_apart(scene, row)
        bent = replace(surface, bend=Bend(s, t, n, fades))
        inner_wo = where(apart, wo, to_local(s, t, n, wo))
        inner = where(apart, wi, to_local(s, t, n, wi))
        f_cos, pdf = one_sided(scene, bent, row, inner_wo, inner, active)
        agrees = (inner.z * wi.z > 0.0) & (inner_wo.z * wo.z > 0.0)
        left = where((wo.z * wi.z > 0.0) & ~apart, fading(n, fades, wi), 1.0)
        return BsdfValue(where(agrees, f_cos * left, 0.0), where(agrees, pdf, 0.0))

    return evaluate_row


def bent_sample(one_sided: Any, stride: int, normals_of: Any, is_apart: Any) -> Any:
    """`sample_row` with the bent normals of maps; arguments as in `alight.bsdfs.switch`."""

    @kernel
    def sample_row(scene, surface, row, wo, u, u2, active):
        s, t, n, fades = frame_of_map(scene, surface, normals_of(scene, row), stride, wo)
        apart = is_apart(scene, row)
        bent = replace(surface, bend=Bend(s, t, n, fades))
        inner_wo = where(apart, wo, to_local(s, t, n, wo))
        inner = one_sided(scene, bent, row, inner_wo, u, u2, active)
        wi = where(apart, inner.wi, renormalize(to_world(s, t, n, inner.wi)))
        agrees = (inner.wi.z * wi.z > 0.0) & (inner_wo.z * wo.z > 0.0)
        faded = (wo.z * wi.z > 0.0) & ((inner.flags & DELTA) == 0) & ~apart
        weight = inner.weight * where(faded, fading(n, fades, wi), 1.0)
        weight, pdf = where(agrees, weight, 0.0), where(agrees, inner.pdf, 0.0)
        return replace(inner, wi=wi, weight=weight, pdf=pdf)

    return sample_row
