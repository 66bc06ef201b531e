r"""Surfaces whose normals are bent by a picture, while their shape stays as it is.

The nested material sees directions in the frame of another normal n. Two things then go wrong:
the viewer, or what he sees mirrored, may lie behind the bent surface, which gives black rims; and
light is cut off in a hard line where the true surface turns away from it.

Rims that are ``lit``: n is moved towards the surface's normal z until the mirrored direction of the
viewer w is above the surface. For n + k z that is a quadratic equation,
:math:`w_z k^2 + 2 (n \cdot w)\, k + 2 (n \cdot w)\, n_z - (1 + \epsilon)\, w_z = 0`. Of what is
matte (`alight.core.spec.Bsdf.matte`) nobody misses what it mirrors: n is moved only until the
viewer is above the bent surface, :math:`n \cdot w + k w_z = \epsilon w_z`, so that it is as bright
as its normals are turned to the light. Rims that are ``folded``: where n turns away from the
viewer, its slope is taken the other way round. Those that are ``black``: nothing is done.

With ``fading``, light is faded out before the line by Smith's masking function of GGX,
:math:`G = 2 / (1 + \sqrt{1 + \alpha^2 \tan^2\theta_i})` with
:math:`\alpha^2 = \tan^2(n, z) / 8`, at most 1; mirrors and what passes are left alone. Where a
direction is on one side of the true surface and on the other one of the bent surface, nothing is
scattered. All of this only takes light away, so a white surface never makes any; none of it is
reciprocal.

Source: Estevez, Lecocq and Stein 2019, A Microfacet-Based Shadowing Function to Solve the Bump
Terminator Problem (Ray Tracing Gems, chapter 12); Schuessler, Heitz, Hanika and Dachsbacher 2017,
Microfacet-based Normal Mapping for Robust Monte Carlo Path Tracing, for the folding, as in Mitsuba
3.9; the quadratic is our own.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from alight.bsdfs.flags import DELTA
from alight.bsdfs.model import BsdfValue
from alight.bsdfs.nesting import is_matte
from alight.core.frame import frame_from_tangent, to_local, to_world
from alight.core.parameters import loader, reader
from alight.core.uv_sets import UV_SETS
from alight.core.vec import Vec3, cross, dot, normalize, renormalize
from alight.shapes.charts import moved_chart
from alight.shapes.derivatives import uv_derivatives
from alight.shapes.hit import BENT as BENT
from alight.textures.fetch import (
    PlainColor,
    Scalar,
    TexturedColor,
    TexturedScalar,
)
from lanewise.jit import kernel, specialised
from lanewise.records import replace
from lanewise.simd import any_lane, floor, lanes, maximum, minimum, sqrt, to_uint, where

#: What programs call it that a material has one of both maps.
NORMALS, HEIGHTS = "bent:normals", "bent:heights"
#: That the picture of a normal map is looked up turned or mirrored.
TURNED = "bent:turned"
#: That a map with lit rims is on something matte.
ON_MATTE = "bent:matte"
#: Bits of the `modes` of both maps.
IS_HEIGHT, FOLLOWS_UV, FADES, IS_LIT, IS_FOLDED = 1.0, 2.0, 4.0, 8.0, 16.0
#: Times the set of texture coordinates that orients a normal map; only in programs with sets.
OF_SET = 32.0
#: Both at once: rims of what is matte are lit.
IS_LIT_MATTE = IS_LIT + IS_FOLDED
#: The mirrored viewer stays this part of his height above the surface, over |n + k z|^2; above the
#: bent surface of what is matte, over |n + k z|, the viewer himself.
MARGIN = 0.1


_RIMS = {"black": 0.0, "lit": IS_LIT, "folded": IS_FOLDED}


class NormalMapRow(NamedTuple):
    """A normal map in the table; `turn` as `axes_of_map` reads it."""

    scale: Scalar
    modes: Scalar
    texture: TexturedColor
    turn: PlainColor


class BumpMapRow(NamedTuple):
    """A bump map in the table."""

    scale: Scalar
    modes: Scalar
    texture: TexturedScalar


_normal_map, _bump_map = loader(NormalMapRow), loader(BumpMapRow)
_turn_at = reader(NormalMapRow, "turn")
_modes_at, _height_at = reader(BumpMapRow, "modes"), reader(BumpMapRow, "texture")

#: Distance of two heights whose difference is a slope, in texture coordinates.
STEP = 2.0**-13


# ---------------------------------------------------------------- the bent normal


@specialised
def bent_normal(program):
    """``(scene, base, surface, height, follows) -> n`` in the local frame, n.z > 0."""
    if HEIGHTS not in program.bsdfs:
        return _from_normals
    if NORMALS not in program.bsdfs:
        return _from_heights

    @kernel
    def either(scene, base, surface, height, follows):
        a = _from_normals(scene, base, surface, height, follows)
        b = _from_heights(scene, base, surface, height, follows)
        return where(height, b, a)

    return either


@kernel
def _from_normals(scene, base, surface, height, follows):
    scale, _, texel, _ = _normal_map(scene, base, surface)
    return normal_of_texel(surface, texel, scale, axes_of_map(scene, base, surface), follows)


@kernel
def normal_of_texel(surface, texel, scale, axes, follows):
    """The normal of a colour, in the local frame; axes as of `axes_of_map`."""
    along, across, s, t = axes
    # The second axis of the picture, on charts that are mirrored too.
    turned = dot(cross(surface.ns, s), across) * dot(s, along) < 0.0
    x, y = scale * (2.0 * texel.x - 1.0), scale * (2.0 * texel.y - 1.0)
    n = normalize(Vec3(x, where(turned & follows, -y, y), maximum(2.0 * texel.z - 1.0, 1e-3)))
    return in_own_axes(surface, s, t, n)


@specialised
def axes_of_map(program):
    """``(scene, base, surface) -> (dp/du, dp/dv, s, t)``: of what a map's picture is looked up by.

    These are the coordinates of its set after its `to_uv`, whose inverse takes the unit vector of
    u to (x, y) times a length. A row's `turn` is (x, y) and the sign of the determinant; with the
    sign, dp/dv is that of a conformal map, which lies on the same side of dp/du.
    """
    return write_axes(program, _modes_at, _turn_at)


def write_axes(program, modes_at, turn_at):
    """The same with readers of a row's `modes`, of which the set counts, and of its `turn`."""
    axes = _axes_of_set(program, modes_at)
    if TURNED not in program.bsdfs:
        return axes

    @kernel
    def of_turned_picture(scene, base, surface):
        along, across, _, _ = axes(scene, base, surface)
        turn = turn_at(scene, base, surface)
        right = turn.x * along + turn.y * across
        above = turn.z * (turn.x * across - turn.y * along)
        s, t = frame_from_tangent(surface.ns, right)
        return right, above, s, t

    return of_turned_picture


def _axes_of_set(program, modes_at):
    """The same of the set alone."""
    if UV_SETS not in program.textures:
        return _own_axes

    @kernel
    def of_its_set(scene, base, surface):
        number = floor(modes_at(scene, base, surface) * (1.0 / OF_SET))
        along, across, s, t = _own_axes(scene, base, surface)
        further = number > 0.0
        if any_lane(further):
            other = _charted(surface, to_uint(where(further, number, 0.0)))
            along1, across1 = uv_derivatives(scene, other)
            s1, t1 = frame_from_tangent(surface.ns, along1)
            along, across = where(further, along1, along), where(further, across1, across)
            s, t = where(further, s1, s), where(further, t1, t)
        return along, across, s, t

    return of_its_set


@kernel
def _own_axes(scene, base, surface):
    along, across = uv_derivatives(scene, surface)
    return along, across, surface.s, surface.t


@kernel
def _charted(surface, number):
    """The surface with derivatives by another set."""
    return replace(surface, chart=replace(surface.chart, set=number))


@specialised
def in_own_axes(program):
    """``(surface, s, t, n)``: n of the frame (s, t, ns) in the surface's own frame."""
    if UV_SETS not in program.textures and TURNED not in program.bsdfs:
        return _as_it_is

    @kernel
    def turned(surface, s, t, n):
        w = n.x * s + n.y * t
        return Vec3(dot(w, surface.s), dot(w, surface.t), n.z)

    return turned


@kernel
def _as_it_is(surface, s, t, n):
    return n


@kernel
def _moved(scene, surface, du, dv, shift):
    """The surface with its texture coordinates moved, and its point with them."""
    chart = moved_chart(scene, surface, du, dv)
    return replace(surface, p=surface.p + shift, u=surface.u + du, v=surface.v + dv, chart=chart)


@kernel
def _from_heights(scene, base, surface, height, follows):
    scale, _, here = _bump_map(scene, base, surface)
    along, across = uv_derivatives(scene, surface)
    right = _height_at(scene, base, _moved(scene, surface, STEP, 0.0, STEP * along))
    above = _height_at(scene, base, _moved(scene, surface, 0.0, STEP, STEP * across))
    a = _risen(surface, along, scale * (right - here) * (1.0 / STEP))
    b = _risen(surface, across, scale * (above - here) * (1.0 / STEP))
    n = cross(a, b)
    n = where(n.z < 0.0, -n, n)
    squared = dot(n, n)
    usable = (squared > 0.0) & (n.z * n.z > 1e-12 * squared)
    return normalize(where(usable, n, Vec3(0.0, 0.0, 1.0)))


@kernel
def _risen(surface, w, rise):
    """A derivative of the point in the local frame, with another height."""
    return Vec3(dot(w, surface.s), dot(w, surface.t), rise)


# ---------------------------------------------------------------- frames


@kernel
def lit_normal(n, wo):
    """n moved towards z until the mirror image of the viewer is above the surface."""
    w = where(wo.z < 0.0, -wo, wo)
    along = dot(n, w)
    c = 2.0 * along * n.z - (1.0 + MARGIN) * w.z
    height = maximum(w.z, 1e-6)
    root = sqrt(maximum(along * along - height * c, 0.0))
    # The larger root of the quadratic, so that nothing cancels.
    k = where(along > 0.0, -c / maximum(root + along, 1e-9), (root - along) / height)
    moved = normalize(Vec3(n.x, n.y, n.z + maximum(k, 0.0)))
    return where((c < 0.0) | (along <= 0.0), moved, n)


@specialised
def not_hidden(program):
    """``(n, wo, lit, folded) -> n``: what becomes of normals that turn away from the viewer."""
    return _not_hidden_by_kind if ON_MATTE in program.bsdfs else _not_hidden


@kernel
def _not_hidden(n, wo, is_lit, folded):
    folded = folded & (dot(n, wo) * wo.z <= 0.0)
    return where(folded, Vec3(-n.x, -n.y, n.z), where(is_lit, lit_normal(n, wo), n))


@kernel
def _not_hidden_by_kind(n, wo, is_lit, folded):
    matte = is_lit & folded
    return where(matte, _seen(n, wo), _not_hidden(n, wo, is_lit & ~matte, folded & ~matte))


@kernel
def _seen(n, wo):
    """n moved towards z until the viewer is above the surface that it bends."""
    w = where(wo.z < 0.0, -wo, wo)
    k = MARGIN - dot(n, w) / maximum(w.z, 1e-6)
    return where(k > 0.0, normalize(Vec3(n.x, n.y, n.z + maximum(k, 0.0))), n)


@kernel
def fading(n, fades, wi):
    """G of Estevez et al., or 1."""
    cos2 = maximum(n.z * n.z, 1e-6)
    # Rounding may leave n.z above 1; the root below would then be of a negative number.
    alpha2 = minimum(0.125 * maximum(1.0 - cos2, 0.0) / cos2, 1.0)
    height2 = maximum(wi.z * wi.z, 1e-12)
    g = 2.0 / (1.0 + sqrt(1.0 + alpha2 * maximum(1.0 - height2, 0.0) / height2))
    return where(fades, g, 1.0)


@specialised
def without_set(program):
    """``without_set(code)``: a sum of bits less those that name a set of coordinates."""
    if UV_SETS not in program.textures:
        return _same

    @kernel
    def rest(code):
        return code - OF_SET * floor(code * (1.0 / OF_SET))

    return rest


@kernel
def _same(code):
    return code


@kernel
def _modes(code):
    """(height, follows, fades, lit, folded) of a sum of bits."""
    code = without_set(code)
    folded = code >= IS_FOLDED
    code = where(folded, code - IS_FOLDED, code)
    lit = code >= IS_LIT
    code = where(lit, code - IS_LIT, code)
    fades = code >= FADES
    code = where(fades, code - FADES, code)
    follows = code >= FOLLOWS_UV
    code = where(follows, code - FOLLOWS_UV, code)
    return code >= IS_HEIGHT, follows, fades, lit, folded


@kernel
def frame_of_map(scene, surface, normals, stride, wo):
    """(s, t, n, fades) of the bent frame, in the local one; z itself without a map."""
    has = normals != 0
    base = where(has, normals - 1, 0) * stride
    code = where(has, _modes_at(scene, base, surface), 0.0)
    height, follows, fades, lit, folded = _modes(code)
    n = bent_normal(scene, base, surface, height, follows)
    n = not_hidden(n, wo, lit, folded)
    n = where(has, n, Vec3(0.0, 0.0, 1.0))
    s, t = frame_from_tangent(n, Vec3(lanes(1.0), 0.0 * n.x, 0.0 * n.x))
    return s, t, n, fades


def packed_modes(spec: Any) -> float:
    """The bits that both maps have."""
    rims = IS_LIT_MATTE if is_lit_matte(spec) else _RIMS[spec.rims]
    return FADES * spec.fading + rims


def is_lit_matte(spec: Any) -> bool:
    """Whether a map with lit rims is on something matte; the name of its material is resolved."""
    return spec.rims == "lit" and is_matte(spec.bsdf)


def map_features(spec: Any) -> tuple[str, ...]:
    """What must be compiled for either map; their frames are those of the shapes' tangents."""
    return (BENT, "anisotropic", *([ON_MATTE] if is_lit_matte(spec) else []))


def bent_evaluate(one_sided, stride, normals_of):
    """`evaluate_row` with the bent normals of maps; arguments as in `alight.bsdfs.switch`."""

    @kernel
    def evaluate_row(scene, surface, row, wo, wi, active):
        s, t, n, fades = frame_of_map(scene, surface, normals_of(scene, row), stride, wo)
        inner = to_local(s, t, n, wi)
        f_cos, pdf = one_sided(scene, surface, row, to_local(s, t, n, wo), inner, active)
        agrees = (inner.z * wi.z > 0.0) & (dot(n, wo) * wo.z > 0.0)
        left = where(wo.z * wi.z > 0.0, fading(n, fades, wi), 1.0)
        return BsdfValue(where(agrees, f_cos * left, 0.0), where(agrees, pdf, 0.0))

    return evaluate_row


def bent_sample(one_sided, stride, normals_of):
    """`sample_row` with the bent normals of maps; arguments as in `alight.bsdfs.switch`."""

    @kernel
    def sample_row(scene, surface, row, wo, u, u2, active):
        s, t, n, fades = frame_of_map(scene, surface, normals_of(scene, row), stride, wo)
        inner = one_sided(scene, surface, row, to_local(s, t, n, wo), u, u2, active)
        wi = renormalize(to_world(s, t, n, inner.wi))
        agrees = (inner.wi.z * wi.z > 0.0) & (dot(n, wo) * wo.z > 0.0)
        faded = (wo.z * wi.z > 0.0) & ((inner.flags & DELTA) == 0)
        weight = inner.weight * where(faded, fading(n, fades, wi), 1.0)
        weight, pdf = where(agrees, weight, 0.0), where(agrees, inner.pdf, 0.0)
        return replace(inner, wi=wi, weight=weight, pdf=pdf)

    return sample_row
