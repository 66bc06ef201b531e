r"""Principled: metal, plastic, glass, lacquer and cloth by one set of parameters.

.. math::
    f = c\, f_c + (1 - c\, E_c(\omega_o)) \left[ s\, f_s + (1 - s\, E_s(\omega_o))
        \left( m\, f_m + (1 - m) ((1 - t)\, f_p + t\, f_g) \right) \right]

A clear coat of strength c lies over sheen of the colour s over a mixture of a metal (share m), and
of plastic and glass (share t of the rest). Each layer leaves to the next what its directional
albedo E does not take. All but sheen are facets of GGX, with alpha = roughness^2:

* the metal reflects by Schlick's Fresnel term from `base_color`;
* plastic reflects by Fresnel's equations, and below is diffuse with what was not reflected,
  :math:`\rho (1 - E(\omega_o)) (1 - E(\omega_i)) / (\pi (1 - \bar E))`, so white stays white;
* glass reflects and refracts by the same equations, tinted by `base_color` at each crossing; with
  `thin` it is a sheet that light passes without being bent, and both sides of it look the same;
* iridescence mixes in the reflectance of a thin film, see `alight.bsdfs.disney.thin_film`.

With `compensation`, energy lost to multiple scattering between facets is restored from a table of
the directional albedo: the metal times 1 + F0 (1 - W) / W, glass times 1 / (R + T), see
`alight.bsdfs.microfacets.albedo_rows`. White metals and white glass lose less than 1 % then, at
every roughness and anisotropy, and so do a film or nothing over a white base; a film over rough
glass errs by up to 2 % from some directions. That scale and the layers look at wo alone: only
plastic without them is reciprocal. glTF's metallic-roughness is the default with its three
parameters; Schlick's term is exact here.

Anisotropic facets have alpha along the tangent raised to alpha + (1 - alpha) a^2. From behind all
but glass and thin sheets are black.

Source: Burley 2012 and 2015, Physically Based Shading at Disney; glTF 2.0, appendix B, and the
extensions KHR_materials_specular, _transmission, _volume, _clearcoat, _sheen, _anisotropy and
_iridescence; Turquin 2019, Practical multiple scattering compensation for microfacet models;
Kelemen and Szirmay-Kalos 2001 for the diffuse part; Walter et al. 2007 for refraction.
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import model_validator

from alight.bsdfs.dielectrics.dispersion import (
    AbbeNumber,
    dispersion_features,
    extremes_of,
    out_of_range,
    pack_spread,
)
from alight.bsdfs.disney.coat import evaluate as evaluate
from alight.bsdfs.disney.coat import sample as sample
from alight.bsdfs.disney.lobes import albedo as albedo
from alight.bsdfs.disney.parameters import (
    COAT,
    FILM,
    GLASS,
    RARELY_TEXTURED,
    SHEEN,
    TEXTURED,
    VARIED,
    Params,
    within_a_turn,
)
from alight.bsdfs.disney.sheen import ROWS as SHEEN_ROWS
from alight.bsdfs.disney.sheen import sheen_rows
from alight.bsdfs.disney.view import COAT_IOR
from alight.bsdfs.interiors.absorption import Absorbing, absorption_features
from alight.bsdfs.microfacets.albedo_rows import (
    ROWS,
    Needs,
    albedo_rows,
    facet_rows,
)
from alight.bsdfs.microfacets.facets import ANISOTROPIC
from alight.bsdfs.normals.coat_normals import coat_features, pack_coat_normals
from alight.bsdfs.rows import MANY_ROWS
from alight.core.field_types import ColorTexture, IndexOfRefraction, Number, UnitTexture
from alight.core.fields import Interval, NumberOrTexture, Truth
from alight.core.parameters import loader, reader, slots_of
from alight.core.spec import Texture
from lanewise.jit import kernel
from lanewise.simd import where

#: Programs in which none is glass or a sheet have nothing that refracts.
REFRACTING = GLASS
#: Index of glass at least: the facet that refracts is found from it.
LEAST_IOR = 1.001

_Any = Interval()
Angle = Annotated[float | Texture | str, NumberOrTexture(_Any, other=(str, Texture))]
Thickness = Annotated[
    float | Texture | str, NumberOrTexture(Interval(0.0, 1e5), other=(str, Texture))
]


class Principled(Absorbing):
    """One material for most things.

    Parameters
    ----------
    base_color : ColorTexture, default 0.8
        Colour of the metal, of what is diffuse, and of what glass transmits.
    metallic : UnitTexture, default 0
        Share of metal.
    roughness : UnitTexture, default 0.5
        Root of alpha; alpha is at least 0.001.
    ior : float in [1, 5], default 1.5
        Index of refraction of plastic and glass; glass has at least 1.001.
    specular, specular_color : UnitTexture and ColorTexture, defaults 1
        Strength and tint of what plastic and glass reflect; the tint fades towards the rim.
    anisotropy, anisotropy_rotation : UnitTexture and texture, defaults 0
        How much rougher the tangent's direction is, and the angle that it is turned by, radians.
    transmission : UnitTexture, default 0
        Share of glass in what is not metal.
    dispersion : float, default 0
        Abbe's number of glass, which refracts each wavelength by an index of its own
        (`alight.bsdfs.dielectrics.dispersion`); 0 for one index. Without effect if `thin`.
    thin : bool, default False
        Whether the surface is a thin sheet, not the boundary of a body.
    clearcoat, clearcoat_roughness : UnitTexture, defaults 0
        Strength and roughness of the coat, of index 1.5.
    clearcoat_normal : ColorTexture, optional
        Normals of the coat, as of a `normal_map`; (0.5, 0.5, 1) are those of the surface. Without
        it the coat follows the map that bends what is below it.
    clearcoat_normal_scale : float, default 1
        Factor of their slopes; below 0 hills become hollows.
    sheen_color, sheen_roughness : ColorTexture and UnitTexture, defaults 0 and 0.3
        Colour and roughness of the sheen; roughness is at least 0.15.
    iridescence : UnitTexture, default 0
        Share of the film's reflectance.
    iridescence_ior : float in [1, 5], default 1.3
        Index of the film.
    iridescence_thickness : float or texture, nanometres, default 400
        Thickness of the film, in [0, 100000].
    attenuation_color, attenuation_distance
        As in `alight.bsdfs.interiors.absorption.Absorbing`; without effect if `thin`.
    compensation : bool, default True
        Whether energy lost to multiple scattering between facets is restored.
    """

    type: Literal["principled"] = "principled"
    base_color: ColorTexture = (0.8, 0.8, 0.8)
    metallic: UnitTexture = 0.0
    roughness: UnitTexture = 0.5
    ior: IndexOfRefraction = 1.5
    specular: UnitTexture = 1.0
    specular_color: ColorTexture = (1.0, 1.0, 1.0)
    anisotropy: UnitTexture = 0.0
    anisotropy_rotation: Angle = 0.0
    transmission: UnitTexture = 0.0
    dispersion: Annotated[float, AbbeNumber()] = 0.0
    thin: Truth = False
    clearcoat: UnitTexture = 0.0
    clearcoat_roughness: UnitTexture = 0.0
    clearcoat_normal: ColorTexture | None = None
    clearcoat_normal_scale: Number = 1.0
    sheen_color: ColorTexture = (0.0, 0.0, 0.0)
    sheen_roughness: UnitTexture = 0.3
    iridescence: UnitTexture = 0.0
    iridescence_ior: IndexOfRefraction = 1.3
    iridescence_thickness: Thickness = 400.0
    compensation: Truth = True

    @model_validator(mode="after")
    def _has_indices(self) -> Self:
        low, high = extremes_of(self.abbe_number, max(self.ior, LEAST_IOR))
        if not LEAST_IOR <= low <= high <= 5.0:
            raise out_of_range(low, high, LEAST_IOR)
        return self

    @property
    def abbe_number(self) -> float:
        """`dispersion` where it counts, else 0."""
        return self.dispersion if self.transmissive and not self.thin else 0.0

    @property
    def transmissive(self) -> bool:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Whether it has two sides already: glass and thin sheets."""
        return self.thin or not is_zero(self.transmission)

    @property
    def bounds_body(self) -> bool:
        """Whether it is glass."""
        return self.transmissive and not self.thin

    @property
    def has_own_coat(self) -> bool:
        """Whether its coat has normals of its own."""
        return self.clearcoat_normal is not None and not is_zero(self.clearcoat)

    @property
    def matte(self) -> bool:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Whether it is plastic that reflects less than 1/9 straight on, and is not black."""
        lacks = (self.metallic, self.transmission, self.iridescence)
        is_plastic = all(is_zero(share) for share in lacks) and not self.thin
        return is_plastic and self.ior <= 2.0 and not is_zero(self.base_color)


def is_zero(value: object) -> bool:
    """Whether a parameter is 0 everywhere; what is not known yet is not."""
    value = value.maximum() if isinstance(value, Texture) and not value.varies else value
    return value in (0.0, (0.0, 0.0, 0.0))


EXAMPLES = (
    Principled(base_color=(0.9, 0.5, 0.1)),
    Principled(base_color=1.0, metallic=1.0, roughness=0.7, anisotropy=0.6),
    Principled(base_color=1.0, transmission=1.0, roughness=0.6, ior=1.4, dispersion=20.0),
    Principled(
        base_color=(0.8, 0.1, 0.1), clearcoat=0.9, clearcoat_roughness=0.4, sheen_color=0.5,
        metallic=0.3, iridescence=0.6, specular_color=(1.0, 0.6, 0.2), specular=0.8,
    ),
    Principled(base_color=(0.9, 1.0, 0.9), transmission=0.7, thin=True, roughness=0.5,
               sheen_color=(0.1, 0.2, 0.3), clearcoat=0.3, clearcoat_roughness=0.5),
    Principled(base_color=1.0, roughness=1.0, compensation=False, metallic=0.5, transmission=0.5),
)  # fmt: skip


# ---------------------------------------------------------------- laws, checked for every example


def is_lossless(spec: Principled) -> bool:
    """Nearly, where it is white: see above."""
    return False


def is_reciprocal(spec: Principled) -> bool | None:
    """Plastic and what is not compensated; layers and compensation look at wo alone."""
    scaled = spec.compensation and not (is_zero(spec.metallic) and is_zero(spec.transmission))
    layered = not (is_zero(spec.clearcoat) and is_zero(spec.sheen_color))
    return None if scaled or layered or not is_zero(spec.iridescence) else True


def relative_ior(spec: Principled) -> float:
    """Index inside over that outside."""
    return 1.0 if spec.thin else max(spec.ior, LEAST_IOR)


# ---------------------------------------------------------------- tables

SLOTS = slots_of(Params)
load = loader(Params)
_eta, _thin = (reader(Params, name) for name in ("eta", "thin"))


def pack(spec: Principled, packer) -> None:
    """Fill the row of one material."""
    for name in ("base_color", "specular_color", "sheen_color"):
        packer.color(name, getattr(spec, name))
    for name in (
        "metallic", "roughness", "specular", "anisotropy", "anisotropy_rotation", "transmission",
        "clearcoat", "clearcoat_roughness", "sheen_roughness", "iridescence",
        "iridescence_thickness",
    ):  # fmt: skip
        packer.scalar(name, getattr(spec, name))
    if isinstance(spec.anisotropy_rotation, float):
        packer.numbers("anisotropy_rotation", within_a_turn(spec.anisotropy_rotation))
    packer.numbers("iridescence_ior", spec.iridescence_ior)
    refracts = spec.transmissive and not spec.thin
    eta = max(spec.ior, LEAST_IOR) if refracts else spec.ior
    packer.numbers("eta", eta)
    pack_spread(packer, spec.abbe_number, eta)
    packer.numbers("thin", spec.thin)
    packer.numbers("compensated", spec.compensation)
    needs = Needs(eta, refracts, not is_zero(spec.iridescence))
    grid = facet_rows(_constant(packer, "roughness"), _constant(packer, "anisotropy"), needs)
    packer.curve("rows", grid.rows)
    packer.numbers("last_row", grid.axes)
    if not is_zero(spec.clearcoat):
        root = _constant(packer, "clearcoat_roughness")
        packer.curve("coat_rows", albedo_rows(root, Needs(COAT_IOR)))
        packer.numbers("last_coat_rows", 0 if root is not None else ROWS - 1)
    pack_coat_normals(packer, spec.has_own_coat, spec.clearcoat_normal, spec.clearcoat_normal_scale)
    if not is_zero(spec.sheen_color):
        root = _constant(packer, "sheen_roughness")
        packer.curve("sheen_rows", sheen_rows(root))
        packer.numbers("last_sheen_rows", 0 if root is not None else SHEEN_ROWS - 1)


def _constant(packer, name: str) -> float | None:
    """The number in a slot, in [0, 1]; None where it is textured."""
    value = packer.number(name)
    return None if value is None else min(max(value, 0.0), 1.0)


def features(spec: Principled) -> tuple[str, ...]:
    """What must be compiled for this material beyond the model's usual path."""
    rows = (spec.roughness, spec.anisotropy, spec.clearcoat_roughness, spec.sheen_roughness)
    names = {
        GLASS: spec.transmissive,
        COAT: not is_zero(spec.clearcoat),
        SHEEN: not is_zero(spec.sheen_color),
        FILM: not is_zero(spec.iridescence),
        ANISOTROPIC: not is_zero(spec.anisotropy),
        MANY_ROWS: any(map(_is_textured, rows)),
        TEXTURED: _is_textured(spec.metallic) or _is_textured(spec.roughness),
        VARIED: any(_is_textured(getattr(spec, name)) for name in RARELY_TEXTURED),
    }
    absorbs = () if spec.thin else absorption_features(spec)
    used = (name for name, is_used in names.items() if is_used)
    own = coat_features(spec.clearcoat_normal) if spec.has_own_coat else ()
    return (*used, *own, *dispersion_features(spec.abbe_number), *absorbs)


def _is_textured(value: object) -> bool:
    return value.varies if isinstance(value, Texture) else not isinstance(value, float | tuple)


@kernel
def inner_index(scene, base, surface):
    """Index inside over that outside; 1 for sheets."""
    return where(_thin(scene, base, surface), 1.0, _eta(scene, base, surface))
