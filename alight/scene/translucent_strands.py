"""Checks of strands that let light through: who sees it."""

from __future__ import annotations

from collections.abc import Iterable

from alight.bsdfs.nesting import find_transmissive
from alight.core.errors import Issue
from alight.core.spec import Bsdf, Integrator, Shape
from alight.shapes.model import SHAPES


def strand_problems(
    integrator: Integrator, placed: Iterable[tuple[str, Shape, Bsdf]]
) -> list[Issue]:
    """Say so if light passes strands and the integrator would meet it elsewhere.

    Rays meet a strand from outside only (`alight.shapes.curves`). Light that passes one is
    scattered where the ray arrives: on the camera's side for its paths, on the lamp's for paths of
    light, which are not two ways to the same point then.

    Parameters
    ----------
    integrator : Integrator
    placed : iterable of (str, Shape, Bsdf)
        What is in the scene: its place there, and its material.
    """
    if not integrator.splats:
        return []
    for name, shape, bsdf in placed:
        if SHAPES[shape.type_name()].is_many:
            found = find_transmissive(bsdf, {})
            if found is not None:
                text = (
                    f"{integrator.type_name()} does not see light that passes strands, and the "
                    f"scene has some ({name}: {found.type_name()}): use path"
                )
                return [Issue("integrator", text)]
    return []
