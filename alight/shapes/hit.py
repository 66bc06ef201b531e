"""What a ray found, the surface there, and robust rays from it and to it.

Robustness follows the idea of PBR4 section 6.8: every computed point carries a bound of its
distance from the true surface, and new rays start outside that band. A bound is a small multiple
of the machine epsilon times the sum of the magnitudes that were added up; each shape derives its
own, for the whole round trip: the rounding of its stored row, of the point, of the moved origin,
and of the intersection arithmetic that must find a ray leaving from there on the right side.
"""

from __future__ import annotations

from collections import namedtuple

from alight.core.constants import gamma
from alight.core.registry import specs_of
from alight.core.spec import Texture
from lanewise.jit import kernel
from lanewise.simd import absolute, copysign, fma, lanes, lanes_u32, maximum, where

#: t: distance in units of |d| (infinity for a miss); u, v: barycentrics b1, b2 of a triangle, local
#: coordinates of the others; shape, prim: u32, 0 for a miss, so that they are always valid.
Hit = namedtuple("Hit", "t u v shape prim")

#: p: point on the surface; error: bound of its distance from the true surface along ng; ng: unit
#: geometric normal on the outer side; ns: unit shading normal; s, t: tangents, (s, t, ns) is
#: orthonormal and right-handed; u, v: texture coordinates; shape, prim, bsdf: u32; light: u32,
#: index of the area light + 1, 0 if there is none; color: vertex colour, 1 if there is none; chart:
#: see `alight.core.uv_sets`, () in most programs; wavelength: nanometres, () unless a material
#: disperses light; bend: `Bend`, () unless a map bends what lies below a coat of its own normals.
Surface = namedtuple(
    "Surface", "p error ng ns s t u v shape prim bsdf light color chart wavelength bend"
)

#: The frame that a map bends a surface to: its axes in the local one; fades: mask, light fades out
#: before the true surface turns away from it.
Bend = namedtuple("Bend", "s t n fades")

#: The part of `Surface` that a shape's own kernel finds.
Geometry = namedtuple("Geometry", "p error ng ns s t u v color")

#: A point chosen on a shape, seen from elsewhere. wi: unit direction to it; distance: m; cosine: of
#: the angle between -wi and the outer normal; error: as in `Surface`; pdf: per solid angle.
ShapeSample = namedtuple("ShapeSample", "wi distance cosine error pdf")

#: A point chosen on a shape by its area. p: before what moves has moved; u, v, prim: as in `Hit`;
#: pdf: per square metre.
AreaSample = namedtuple("AreaSample", "p u v prim pdf")

#: A point of a shape that a ray from elsewhere has hit: prim as in `Hit`, the rest as a sample's.
ShapeHit = namedtuple("ShapeHit", "prim wi distance cosine")

#: Arrays of the shapes, see `alight.compiled.shapes`.
ShapeTables = namedtuple("ShapeTables", "info data faces vertices normals uvs colors uv_shifts")

#: Words of `ShapeTables.info` a shape: kind, bsdf, light + 1, offset in data, flags, first face,
#: first vertex, number of faces.
INFO = 8
FLIP, SMOOTH, UVS, COLORS, INSTANCED = 1, 2, 4, 8, 16

#: By so many bits the flags are shifted up by the number of primitives of a shape of many.
PRIMITIVES = 8

#: What programs call it that a material has a normal or bump map.
BENT = "bent"

#: What programs call it that a coat has normals of its own.
OWN_COAT = "bent:coat"

_GAMMA_24 = gamma(24)


@kernel
def no_hit():
    """A `Hit` of zeros in every lane."""
    return Hit(lanes(0.0), lanes(0.0), lanes(0.0), lanes_u32(0), lanes_u32(0))


def varies(program) -> bool:
    """True if a texture of the program is not the same everywhere."""
    models = specs_of(Texture)
    return any(name not in models or models[name].varies for name in program.textures)


def needs_uv(program) -> bool:
    """True if anything in the program reads texture coordinates; the axes of a map do."""
    bends = BENT in program.bsdfs or OWN_COAT in program.bsdfs
    return bends or "uv" in program.aovs or varies(program)


def is_bent_below(program) -> bool:
    """Whether surfaces know the frame that a map bends them to, for coats that do not follow."""
    return BENT in program.bsdfs and OWN_COAT in program.bsdfs


@kernel(strict=True)
def side_of(w, n):
    """w . n in the order of operations of the flat shapes, so that both agree on its sign."""
    return fma(n.x, w.x, fma(n.y, w.y, n.z * w.z))


@kernel(strict=True)
def spawn_origin(p, error, ng, w):
    """Origin of a ray that leaves a surface point in direction `w`.

    Parameters
    ----------
    p : Vec3
        `Surface.p`, metres.
    error : float
        `Surface.error`, metres.
    ng : Vec3
        `Surface.ng`.
    w : Vec3
        Direction of the ray.

    Returns
    -------
    Vec3
        p moved along ng to the side of w, beyond the reach of all rounding.
    """
    return p + copysign(error, side_of(w, ng)) * ng


@kernel(strict=True)
def shadow_length(distance, cosine, error_light, error):
    """How far a shadow ray must be traced so that it ends just before the light.

    The ray starts within `error` of p (`spawn_origin`) and points along the rounded wi; it
    approaches the tangent plane of the light at the rate |cosine|. Measured along the light's
    normal, three things move the place where it meets the light: the light's own band
    `error_light`; the start of the ray, by `error`; and the rounding of wi, of the distance, and of
    an intersection computed from that far, together at most gamma(24) distance. Ending the ray
    their sum before the plane leaves the light unhit (a convex one too: it lies behind its tangent
    plane). A blocker is missed only within twice that sum of the light, where float32 cannot tell
    the two apart.

    Parameters
    ----------
    distance : float
        From the surface point to the light, metres; infinity allowed.
    cosine : float
        Of the angle at the light; 1 for lights without surface.
    error_light, error : float
        Error bounds on both sides, metres.
    """
    band = error_light + error + _GAMMA_24 * distance
    # Edge-on, where next to no light arrives, at least the first half is searched for blockers.
    length = maximum(distance - band / maximum(cosine, 1e-6), 0.5 * distance)
    return where(distance < 1e30, length, distance)


@kernel
def area_to_solid_angle(pdf_area, distance, cosine):
    """A density per area as a density per solid angle: dA |cos| = d^2 domega.

    Zero where the surface is seen edge-on: nothing arrives from there.
    """
    edge_on = absolute(cosine) <= 0.0
    return where(
        edge_on, 0.0, pdf_area * distance * distance / where(edge_on, 1.0, absolute(cosine))
    )
