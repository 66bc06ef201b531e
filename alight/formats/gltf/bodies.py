"""Materials of glTF that scatter light inside -> `subsurface`, on closed shapes.

The mean free path follows from the volume's attenuation, radius = -distance / ln(color), and the
colour is the one that a deep body has.

Source: KHR_materials_volume_scatter (draft) and KHR_materials_diffuse_transmission.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from alight.formats.gltf.values import Item
from alight.formats.materials.surfaces import Surface, index_of, reflectance
from alight.meshes.volume import has_inside

Data = dict[str, Any]
TRANSLUCENT, SCATTERING = "KHR_materials_diffuse_transmission", "KHR_materials_volume_scatter"
#: Attenuation that is not there is so weak, as a colour.
CLEAREST = 1.0 - 1e-6
#: What a body cannot have.
_OTHERS = ("metallic", "transmission", "clearcoat", "sheen_color", "iridescence")


def have_insides(primitives: Sequence[tuple[Any, Surface, Item]]) -> list[bool]:
    """Which primitives of a mesh have an inside; reports those that lack one their material needs.

    Primitives may be open and close the mesh together. Light that enters one then finds nothing but
    bodies around it, if all of them are.

    Parameters
    ----------
    primitives : sequence of (Mesh, Surface, Item)
    """
    all_bodies = all(material.inside is not None for _, material, _ in primitives)
    shapes = [shape for shape, _, _ in primitives]
    together = len(shapes) > 1 and all_bodies and has_inside(*shapes)
    found = []
    for shape, material, item in primitives:
        is_body = material.inside is not None
        closed = is_body and (together or has_inside(shape))
        if is_body and not closed:
            text = "is open or inside out, so no light is scattered below its surface"
            item.report.approximate(f"{item.pointer}: {text}")
        found.append(closed)
    return found


def body_of(item: Item, core: Data, opacity: Any) -> Data | None:
    """A body, where a material is one and nothing else; None, with a remark, where it is not.

    Parameters
    ----------
    item : Item
        The material.
    core : dict
        As `principled`.
    opacity : number or texture
    """
    scattering, translucent = item.extension(SCATTERING), item.extension(TRANSLUCENT)
    if scattering is None and translucent is None:
        return None
    volume = item.extension("KHR_materials_volume")
    if (
        scattering is None
        or translucent is None
        or volume is None
        or not _is_alone(translucent, core, opacity)
    ):
        names = [name for name in (TRANSLUCENT, SCATTERING) if item.extension(name) is not None]
        text = "light that enters a surface is shown where all of it does, and is scattered inside"
        item.report.approximate(f"{item.pointer}: {' and '.join(names)}: left out; {text}")
        return None
    color = scattering.numbers("multiscatterColor", (0.0, 0.0, 0.0), 0.0, 1.0)
    if scattering.number("scatterAnisotropy", 0.0, -1.0, 1.0) != 0.0:
        text = f"{item.pointer}: scatterAnisotropy: light is scattered alike to all sides"
        item.report.approximate(text)
    distance = volume.number("attenuationDistance", 1e9, 1e-9)
    attenuation = volume.numbers("attenuationColor", (1.0, 1.0, 1.0), 0.0, 1.0)
    radius = [
        min(distance, 1e9) / -math.log(min(max(part, 1e-6), CLEAREST)) for part in attenuation
    ]
    roughness = core["roughness"]
    if not isinstance(roughness, float):
        roughness = 0.5
        item.report.approximate(f"{item.pointer}: the roughness of a body must not vary: 0.5 it is")
    ior, specular = core.get("ior", 1.5), core.get("specular", 1.0)
    if not isinstance(specular, float):
        text = "the reflection of a body has one strength: that of its index is taken"
        item.report.approximate(f"{item.pointer}: {text}")
    elif specular != 1.0:
        ior = index_of(specular * reflectance(ior))
    if list(core.get("specular_color", [1.0] * 3)) != [1.0] * 3:
        item.report.approximate(f"{item.pointer}: the colour of a body's reflection is left out")
    return {
        "type": "subsurface",
        "color": list(color),
        "radius": radius,
        "ior": ior,
        "roughness": roughness,
    }


def _is_alone(translucent: Item, core: Data, opacity: Any) -> bool:
    """Whether all light that is not reflected enters."""
    enters = translucent.number("diffuseTransmissionFactor", 0.0, 0.0, 1.0) == 1.0
    tint = translucent.numbers("diffuseTransmissionColorFactor", (1.0, 1.0, 1.0), 0.0, 1.0)
    textures = ("diffuseTransmissionTexture", "diffuseTransmissionColorTexture")
    plain = tuple(tint) == (1.0, 1.0, 1.0) and not any(map(translucent.has, textures))
    others = any(core.get(name, 0.0) not in (0.0, [0.0] * 3) for name in _OTHERS)
    return enters and plain and not others and opacity == 1.0
