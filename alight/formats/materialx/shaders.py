"""Surface shaders -> `Surface`, the description that all formats share.

Each shader has a file of its own, which says how its inputs become those of `principled`.
"""

from __future__ import annotations

import math
from typing import Any

from alight.core.errors import quote
from alight.formats.materials.surfaces import Surface
from alight.formats.materials.textures import MISSING, bitmap
from alight.formats.materialx import gltf_pbr, open_pbr, preview_surface, standard_surface
from alight.formats.materialx.evaluate import Evaluator
from alight.formats.materialx.nodes import Node
from alight.formats.materialx.protocols import Host
from alight.formats.materialx.shading import Shading
from alight.formats.reading.report import did_you_mean

#: Shader -> its reader.
SHADERS = {
    "UsdPreviewSurface": preview_surface.read,
    "gltf_pbr": gltf_pbr.read,
    "open_pbr_surface": open_pbr.read,
    "standard_surface": standard_surface.read,
}


def read_shader(node: Node, host: Host) -> Surface | None:
    """What a surface shader says.

    Parameters
    ----------
    node : Node
    host : Host
        Of its file.

    Returns
    -------
    Surface or None
        None for a shader that is not covered: a problem, or when lenient a stand-in is due.
    """
    if node.category == "surface_unlit":
        return _unlit(node, host)
    reader = SHADERS.get(node.category)
    if reader is None:
        return None
    shading = Shading(node, Evaluator(host))
    surface = reader(shading)
    shading.say_what_is_unknown()
    return surface


def not_covered(node: Node) -> str:
    """The remark on a shader that is not covered."""
    hint = did_you_mean(node.category, SHADERS)
    listed = ", ".join(sorted([*SHADERS, "surface_unlit"]))
    return f"shader {quote(node.category)} is not covered{hint}  (covered: {listed})"


def stand_in() -> Surface:
    """Stand-in for a shader that is not covered: squares of magenta and black."""
    return Surface({"type": "diffuse", "reflectance": bitmap(MISSING)})


def _unlit(node: Node, host: Host) -> Surface:
    """``surface_unlit``: shines with its colour."""
    shading = Shading(node, Evaluator(host))
    weight, color = shading.value("emission", 1.0), shading.value("emission_color", (1.0,) * 3)
    emission = shading.color("emission_color", shading.product(color, weight), math.inf)
    shading.say("surface_unlit: such surfaces shine with their colour, and light others")
    core: dict[str, Any] = {"type": "diffuse", "reflectance": 0.0}
    opacity = shading.number("opacity", shading.value("opacity", 1.0))
    return Surface(core, None, opacity, emission, True, shading.sets)
