"""What is below the surface of a material: which body light enters that crosses it."""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Iterator
from typing import Any

from alight.bsdfs.interiors.absorption import ABSORBING, Absorbing
from alight.bsdfs.model import BSDFS
from alight.bsdfs.nesting import Nested
from alight.core.maths import exp
from alight.core.spec import Bsdf
from alight.core.vec import Vec3, gather_vec3
from alight.shapes.hit import INFO, PRIMITIVES
from alight.shapes.model import SHAPES
from lanewise.jit import kernel, specialised
from lanewise.simd import gather, where

#: Absorption of what is no body.
NO_BODY = (-1.0, -1.0, -1.0)
#: Share of a part whose weight varies over the surface.
VARYING_SHARE = 0.5

#: What programs call a scene in which bodies that scatter light may have no end.
ENDLESS = "endless"

#: of_material: three numbers a material, absorption of the body below it, per metre, or `NO_BODY`;
#: box: six numbers, corners of the box around all bodies that absorb, metres.
BodyTables = namedtuple("BodyTables", "of_material box")

Coefficients = tuple[float, float, float]


def body_below(spec: Bsdf) -> Coefficients | None:
    """Absorption of the body below a material, per metre; None where there is no body.

    Names of nested materials must be resolved.
    """
    found = [(share, body) for share, body in _bodies_of(spec, 1.0) if share > 0.0]
    whole = sum(share for share, _ in found)
    if not found:
        return None
    r, g, b = (sum(share * body[i] for share, body in found) / whole for i in range(3))
    return r, g, b


def _bodies_of(spec: Any, share: float) -> Iterator[tuple[float, Coefficients]]:
    """Share and absorption of each part of a material that has a body."""
    if isinstance(spec, Nested):
        weight = getattr(spec, spec.weight_field) if spec.weight_field else 1.0
        weight = weight if isinstance(weight, float) else VARYING_SHARE
        factors = {"all": 1.0, "weight": weight, "rest": 1.0 - weight}
        masked = any(part.is_hole for part in spec.parts)
        for part in spec.parts:
            if not part.is_hole:
                yield from _bodies_of(part.bsdf, share * (1.0 if masked else factors[part.share]))
    elif isinstance(spec, Absorbing):
        if spec.bounds_body:
            yield share, spec.coefficients
    elif BSDFS[spec.type_name()].inside is not None:
        yield share, (0.0, 0.0, 0.0)


# ---------------------------------------------------------------- kernels


def absorbs(program) -> bool:
    """Whether there are bodies that absorb light."""
    return ABSORBING in program.bsdfs


@specialised
def absorption_below(program):
    """``(scene, surface) -> Vec3``: absorption of the body below, per metre, or `NO_BODY`."""

    @kernel
    def of_material(scene, surface):
        return gather_vec3(scene.materials.bodies.of_material, 3 * surface.bsdf)

    if not any(SHAPES[name].is_many for name in program.shapes):
        return of_material

    @kernel
    def of_closed_shape(scene, surface):
        # Of shapes of many primitives only the near side is met: nobody would leave them again.
        flags = gather(scene.shapes.info, surface.shape * INFO + 4)
        return where((flags >> PRIMITIVES) == 0, of_material(scene, surface), NO_BODY[0])

    return of_closed_shape


@kernel
def left_after(sigma, t):
    """What remains of light after t metres at the absorption sigma per metre."""
    return Vec3(exp(-sigma.x * t), exp(-sigma.y * t), exp(-sigma.z * t))
