r"""Materials of other models as `principled`, the one surface that glTF can describe.

Metals have the reflectance of their index at normal incidence as base colour,
:math:`F_0 = ((\eta - 1)^2 + k^2) / ((\eta + 1)^2 + k^2)`; Schlick's formula takes the place of
Fresnel's. Roughness is the root of alpha. What is not the same is said.

Source: glTF 2.0, appendix B; Schlick 1994, An inexpensive BRDF model for physically-based
rendering.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from alight.bsdfs.adapters.blend import Blend
from alight.bsdfs.conductors.coated_conductor import CoatedConductor
from alight.bsdfs.conductors.conductor import Metallic, OfMetal
from alight.bsdfs.dielectrics.dispersion import indices
from alight.bsdfs.dielectrics.interface import Interface
from alight.bsdfs.disney.burley import Burley
from alight.bsdfs.disney.burley_thin import BurleyThin
from alight.bsdfs.disney.principled import Principled
from alight.bsdfs.interiors.subsurface import Subsurface
from alight.bsdfs.matte.diffuse import Diffuse
from alight.bsdfs.microfacets.facets import Rough
from alight.bsdfs.plastics.phong import Phong
from alight.bsdfs.plastics.plastic import Coated
from alight.core.spec import Bsdf, Texture
from alight.core.wavelengths import LINE_C, LINE_F
from alight.formats.gltf.burleys import burley_as_principled
from alight.formats.gltf.planes import Plane, plane_of
from alight.formats.materials.surfaces import (
    BRIGHTEST,
    LARGEST_IOR,
    abbe_number,
    index_of,
    reflectance,
)
from alight.textures.multiply import Multiply

WHITE = (1.0, 1.0, 1.0)


def as_principled(bsdf: Bsdf) -> tuple[Bsdf, list[str]]:
    """The nearest material that glTF can hold.

    Parameters
    ----------
    bsdf : Bsdf
        Without wrappers; names and files resolved.

    Returns
    -------
    Principled or Diffuse
    list of str
        What differs.
    """
    lost: list[str] = []
    kind = bsdf.type_name()
    if isinstance(bsdf, Blend):
        return _heavier(bsdf)
    if isinstance(bsdf, Principled | Diffuse):
        return bsdf, lost
    fields = dict(bsdf)
    if isinstance(bsdf, CoatedConductor):
        made = _lacquered(bsdf, lost)
    elif isinstance(bsdf, Metallic):
        made = _metal(bsdf, fields, lost)
    elif isinstance(bsdf, Interface):
        made = _glass(bsdf, fields, lost)
    elif isinstance(bsdf, Coated):
        made = _plastic(bsdf, fields, lost)
    elif isinstance(bsdf, Burley | BurleyThin):
        made = burley_as_principled(bsdf, lost)
    elif isinstance(bsdf, Subsurface):
        made = _body(bsdf, lost)
    elif isinstance(bsdf, Phong):
        made = _phong(fields, lost)
    elif kind == "mirror":
        lost.append("mirror: reflects all of the light at grazing angles")
        made = Principled(base_color=fields["reflectance"], metallic=1.0, roughness=0.0)
    elif kind == "null":
        made = Principled(base_color=WHITE, transmission=1.0, thin=True, ior=1.0, roughness=0.0)
    elif "reflectance" in fields:
        lost.append(f"{kind}: became a diffuse surface of its reflectance")
        made = Diffuse(reflectance=fields["reflectance"])
    else:
        lost.append(f"{kind}: became a grey surface")
        made = Diffuse(reflectance=0.5)
    return made, lost


def _heavier(bsdf: Blend) -> tuple[Bsdf, list[str]]:
    """The part of a mixture that there is more of."""
    weight = bsdf.weight.mean()[0] if isinstance(bsdf.weight, Texture) else float(bsdf.weight)
    part: Any = bsdf.bsdfs[int(weight > 0.5)]
    while "bsdf" in dict(part):
        part = part.bsdf
    made, lost = as_principled(part)
    return made, [f"blend: became its larger part, {part.type_name()}", *lost]


def _metal(bsdf: Metallic, fields: dict[str, Any], lost: list[str]) -> Principled:
    color = tinted(fields["specular_reflectance"], _at_normal_incidence(bsdf, lost))
    return Principled(base_color=color, metallic=1.0, **_facets(bsdf, lost))


def _lacquered(bsdf: CoatedConductor, lost: list[str]) -> Principled:
    """Metal below a clear coat; the file's coat has the index 1.5."""
    lost.append("coated_conductor: its coat became one of index 1.5, which light meets once")
    if bsdf.thickness > 0.0:
        lost.append("coated_conductor: the thickness of its coat")
    return Principled(
        base_color=_at_normal_incidence(bsdf, lost, bsdf.int_ior),
        metallic=1.0,
        roughness=math.sqrt(bsdf.alpha),
        clearcoat=1.0,
        clearcoat_roughness=math.sqrt(bsdf.coat_alpha),
    )


def _at_normal_incidence(
    bsdf: OfMetal, lost: list[str], outside: float = 1.0
) -> tuple[float, float, float]:
    """Reflectance of a metal seen from a medium of index `outside`."""
    eta, k = bsdf.index_of_refraction
    lost.append(f"{bsdf.type_name()}: Schlick's formula takes the place of its index of refraction")
    red, green, blue = (
        reflectance(n / outside, absorbed / outside) for n, absorbed in zip(eta, k, strict=True)
    )
    return red, green, blue


def _glass(bsdf: Interface, fields: dict[str, Any], lost: list[str]) -> Principled:
    kind, ratio = bsdf.type_name(), bsdf.int_ior / bsdf.ext_ior
    thin = kind == "thin_dielectric"
    if ratio < 1.0 and not thin:
        lost.append(f"{kind}: its denser side became the inner one")
    ratio = max(ratio, 1.0 / ratio)
    if thin:
        # A sheet of glTF reflects once, a pane at both of its sides: R + R (1 - R)^2 + ...
        once = ((ratio - 1.0) / (ratio + 1.0)) ** 2
        ratio = index_of(2.0 * once / (1.0 + once))
        lost.append(f"{kind}: one surface of index {ratio:.4g} reflects as much as its two")
    absorbing = {
        name: fields[name]
        for name in ("attenuation_color", "attenuation_distance")
        if name in fields
    }
    ior = _index(ratio, kind, lost)
    return Principled(
        base_color=fields["specular_transmittance"],
        transmission=1.0,
        thin=thin,
        ior=ior,
        dispersion=_abbe_number(bsdf, ior, lost),
        specular_color=_tint(fields["specular_reflectance"], kind, lost),
        **absorbing,
        **_facets(bsdf, lost),
    )


def _abbe_number(bsdf: Interface, ior: float, lost: list[str]) -> float:
    """That of the lines F and C, of whatever says how the index depends on the wavelength."""
    dispersion = getattr(bsdf, "dispersion", 0.0)
    if dispersion == 0.0:
        return 0.0
    lines = 1e-3 * np.array([LINE_F, LINE_C])
    blue, red = indices(dispersion, lines, bsdf.int_ior)
    if not isinstance(dispersion, float):
        lost.append(f"{bsdf.type_name()}: its dispersion became an Abbe number")
    spread = abs(blue - red) / bsdf.ext_ior
    return abbe_number((ior - 1.0) / spread, ior) if spread > 0.0 else 0.0


def _plastic(bsdf: Coated, fields: dict[str, Any], lost: list[str]) -> Principled:
    kind = bsdf.type_name()
    if bsdf.nonlinear:
        lost.append(f"{kind}: light is not coloured by each round inside of the coat")
    ratio = bsdf.int_ior / bsdf.ext_ior
    return Principled(
        base_color=fields["diffuse_reflectance"],
        ior=_index(max(ratio, 1.0), kind, lost),
        specular_color=_tint(fields["specular_reflectance"], kind, lost),
        **_facets(bsdf, lost),
    )


def _body(bsdf: Subsurface, lost: list[str]) -> Principled:
    """The coat over a matte base of the colour that a thick body has."""
    lost.append("subsurface: no light is scattered below the surface, its colour is diffuse")
    return Principled(
        base_color=bsdf.color,
        roughness=bsdf.roughness,
        ior=_index(bsdf.ior, "subsurface", lost),
    )


def _phong(fields: dict[str, Any], lost: list[str]) -> Principled:
    """A lobe of facets as wide as cos^n, over a base; its reflectance grows towards the rim."""
    exponent, specular = (_mean(fields[name]) for name in ("exponent", "specular"))
    lost.append("phong: became facets of GGX over a base")
    brightest = max(specular)
    if brightest <= 0.0:
        return Principled(base_color=fields["diffuse"], specular=0.0)
    return Principled(
        base_color=fields["diffuse"],
        roughness=(2.0 / (exponent[0] + 2.0)) ** 0.25,
        ior=index_of(min(brightest, BRIGHTEST)),
        specular_color=tuple(c / brightest for c in specular),
    )


def _facets(bsdf: Bsdf, lost: list[str]) -> dict[str, Any]:
    """Roughness, and how much it differs along the tangent."""
    kind = bsdf.type_name()
    if getattr(bsdf, "distribution", "ggx") != "ggx":
        lost.append(f"{kind}: facets became those of GGX")
    if hasattr(bsdf, "distribution"):
        lost.append(
            f"{kind}: readers may give back the light that met several facets, as ours does"
        )
    if not isinstance(bsdf, Rough):
        alpha = getattr(bsdf, "alpha", None)
        return {"roughness": 0.0 if alpha is None else rooted(alpha, lost)}
    along, across = bsdf.roughness
    if along == across:
        return {"roughness": rooted(along, lost)}
    along, across = (_mean(value)[0] for value in (along, across))
    low, high = sorted((along, across))
    turned = {} if along > across else {"anisotropy_rotation": math.pi / 2.0}
    strength = math.sqrt((high - low) / max(1.0 - low, 1e-9))
    return {"roughness": math.sqrt(low), "anisotropy": strength, **turned}


def rooted(alpha: Any, lost: list[str]) -> Any:
    """The root of a roughness alpha: a number, or a picture of it."""
    plane = plane_of(alpha)
    if plane is None:
        lost.append("roughness: its texture became the mean")
        return math.sqrt(_mean(alpha)[0])
    if isinstance(plane, Plane):
        return plane._replace(factor=math.sqrt(plane.factor)).texture(np.sqrt)
    return math.sqrt(plane)


def tinted(value: Any, factor: tuple[float, ...]) -> Any:
    """A colour or a texture times a colour."""
    if isinstance(value, Texture):
        return Multiply(a=factor, b=value)
    return tuple(a * b for a, b in zip(value, factor, strict=True))


def _tint(value: Any, kind: str, lost: list[str]) -> Any:
    if value != WHITE:
        lost.append(f"{kind}: the tint of what it reflects fades towards the rim")
    return value


def _index(ratio: float, kind: str, lost: list[str]) -> float:
    if ratio > LARGEST_IOR:
        lost.append(f"{kind}: its index {ratio:g} became {LARGEST_IOR:g}")
    return min(ratio, LARGEST_IOR)


def _mean(value: Any) -> tuple[float, ...]:
    if isinstance(value, Texture):
        return value.mean()
    return value if isinstance(value, tuple) else (float(value),) * 3
