"""``subsurface`` and ``kdsubsurface`` of pbrt -> `subsurface`, or where it cannot be, a coat.

The colour is what the medium gives back to its own boundary, with the light that this throws back
inside; the radius is the mean free path, with forward scattering taken out of it (similarity). In
pbrt, too, light leaves the coat alike to all sides but for Fresnel's factor.
"""

from __future__ import annotations

from typing import Any

from alight.core.errors import join_path, unknown_name
from alight.formats.materials.substances import SUBSTANCES, diffuse_reflectance
from alight.formats.materials.surfaces import LARGEST_IOR, two_sided
from alight.formats.pbrt.context import Context, Data
from alight.formats.pbrt.making import Making
from alight.formats.pbrt.materials import coat, index
from alight.formats.pbrt.roughness import alphas, one_alpha
from alight.formats.pbrt.textures import Value
from alight.scene.description import VACUUM
from alight.shapes.strands import StrandShape

#: What is black to pbrt has no mean free path.
LEAST_EXTINCTION, LEAST_RADIUS = 1e-6, 1e-9
USUAL_ROUGHNESS = 0.5


def _subsurface(m: Making) -> Data:
    color: Value | None = m.color("reflectance", None) or m.color("Kd", None)
    eta = index(m, "eta", 1.33)
    alpha = one_alpha(m, *alphas(m, 0.0))
    scale = m.plain_number("scale", 1.0)
    free = m.color("mfp", [1.0] * 3, "index")
    free = free if isinstance(free, list) else _usual(m, "mfp", [1.0] * 3)
    scattered, absorbed = _coefficients(m)
    m.p.ignore("real surfaces have none", "Kr", "Kt")
    m.warn("becomes one in which light walks through the body, not by a profile of diffusion")
    if color is None:
        pairs = list(zip(absorbed, scattered, strict=True))
        color = [diffuse_reflectance(a, s, eta) for a, s in pairs]
        # The usual coefficients are those of millimetres, and count as they are in pbrt too.
        radius = [1.0 / max(scale * (a + s), LEAST_EXTINCTION) for a, s in pairs]
    else:
        radius = [scale * channel for channel in free]
    roughness: float = USUAL_ROUGHNESS
    if isinstance(alpha, float):
        roughness = min(max(alpha, 0.0), 1.0) ** 0.5
    else:
        m.warn(f"has a texture of roughness: {USUAL_ROUGHNESS} is taken")
    m.context.coats[m.path] = two_sided({**coat(m, alpha, color, eta, None), "nonlinear": True})
    return {
        "type": "subsurface",
        "color": color,
        "radius": [max(channel, LEAST_RADIUS) for channel in radius],
        "ior": min(max(eta, 1.0), LARGEST_IOR),
        "roughness": roughness,
    }


def _coefficients(m: Making) -> tuple[list[float], list[float]]:
    """Scattering and absorption, in 1 over the unit of length."""
    name = m.p.text("name")
    if name and name not in SUBSTANCES:
        known = unknown_name("medium", name, SUBSTANCES, listed_as="known")
        m.p.report.warn(m.p.named["name"], f"{known.partition('  (')[0]}: whole milk is taken")
    usual = SUBSTANCES.get(name, SUBSTANCES["Wholemilk"])
    scattered = m.color("sigma_s", list(usual[0]), "index")
    absorbed = m.color("sigma_a", list(usual[1]), "index")
    if not isinstance(scattered, list):
        scattered = _usual(m, "sigma_s", list(usual[0]))
    if not isinstance(absorbed, list):
        absorbed = _usual(m, "sigma_a", list(usual[1]))
    forward = min(max(m.plain_number("g", 0.0), -0.99), 0.99)
    return [(1.0 - forward) * channel for channel in scattered], absorbed


def _usual(m: Making, name: str, usual: list[float]) -> list[float]:
    m.warn(f"has a texture of {name}: {usual[0]:g}, {usual[1]:g}, {usual[2]:g} is taken")
    return usual


BELOW = {"subsurface": _subsurface, "kdsubsurface": _subsurface}


# ---------------------------------------------------------------- where no body can be


def put_coats(context: Context, nodes: dict[str, Any]) -> None:
    """Put a coat in the place of bodies in masks and mixtures, on curves, and around media."""
    table = context.tables["bsdfs"]
    for data in table.values():
        for name in data.get("bsdfs", ()):
            _coated(context, name)
    waiting = [*nodes.values(), *context.tables["prototypes"].values()]
    while waiting:
        node = waiting.pop()
        waiting += node.get("children", {}).values()
        bsdf, shape = node.get("bsdf"), node.get("shape")
        inner = node.get("interior", VACUUM) != VACUUM
        if isinstance(bsdf, dict):
            _coated(context, bsdf.get("bsdf"))
        elif inner or isinstance(shape, StrandShape):
            _coated(context, bsdf)


def _coated(context: Context, name: object) -> None:
    stand_in = context.coats.pop(join_path("bsdfs", str(name)), None)
    if stand_in is None:
        return
    table = context.tables["bsdfs"]
    data = table[str(name)]
    if "bsdf" in data:
        data["bsdf"] = stand_in
    else:
        table[str(name)] = stand_in
    text = "is part of a mixture, of what has holes, of curves, or holds a medium"
    context.report.warnings.append(f"{name} {text}: no light wanders below it, a coat is taken")
