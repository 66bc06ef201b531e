"""Checks of materials that disperse light: who follows the wavelengths of paths."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from alight.bsdfs.model import BSDFS
from alight.bsdfs.nesting import Nested
from alight.core.errors import Issue, join_path
from alight.core.spec import Bsdf
from alight.core.wavelengths import DISPERSIVE
from alight.scene.description import Scene
from alight.scene.nodes import all_nodes


def dispersion_problems(scene: Scene) -> list[Issue]:
    """Say so if a material disperses light and the integrator would not see it."""
    integrator = scene.integrator
    if integrator.sees_dispersion or not integrator.needs_light:
        return []
    found = next(_dispersive(scene), None)
    if found is None:
        return []
    text = f"{integrator.type_name()} does not see that materials disperse light"
    text = f"{text}, and the scene has some ({found}): use path, or dispersion: 0 there"
    return [Issue("integrator", text)]


def _dispersive(scene: Scene) -> Iterator[str]:
    """The places of materials in use that disperse light, or hold some that do."""
    known = scene.bsdfs
    for path, node in all_nodes(scene):
        bsdf, place = node.bsdf, f"{path}.bsdf"
        if isinstance(bsdf, str):
            bsdf, place = known.get(bsdf), join_path("bsdfs", bsdf)
        if bsdf is not None and disperses_light(bsdf, known):
            yield place


def disperses_light(spec: Bsdf | str, known: Mapping[str, Bsdf]) -> bool:
    """Whether a material, or a part of it, disperses light; `known` holds those with names."""
    if isinstance(spec, str):
        return spec in known and disperses_light(known[spec], known)
    if isinstance(spec, Nested):
        return any(disperses_light(part.bsdf, known) for part in spec.parts)
    return DISPERSIVE in BSDFS[spec.type_name()].features(spec)
