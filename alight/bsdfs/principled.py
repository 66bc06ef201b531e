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
* iridescence mixes in the reflectance of a thin film, see `alight.bsdfs.thin_film`.

With `compensation`, light that met several facets is given back by a table of the directional
albedo: the metal times 1 + F0 (1 - W) / W, glass times 1 / (R + T), see
`alight.bsdfs.albedo_rows`. White metals and white glass lose less than 1 % then, at every roughness
and anisotropy, and so do a film or nothing over a white base; a film over rough glass errs by up to
2 % from some directions. That scale and the layers look at wo alone: only plastic without them is
reciprocal. glTF's metallic-roughness is the default with its three parameters; Schlick's term is
exact here.

Anisotropic facets have alpha along the tangent raised to alpha + (1 - alpha) a^2. From behind all
but glass and thin sheets are black.

Source: Burley 2012 and 2015, Physically Based Shading at Disney; glTF 2.0, appendix B, and the
extensions KHR_materials_specular, _transmission, _volume, _clearcoat, _sheen, _anisotropy and
_iridescence; Turquin 2019, Practical multiple scattering compensation for microfacet models;
Kelemen and Szirmay-Kalos 2001 for the diffuse part; Walter et al. 2007 for refraction.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

from alight.bsdfs.absorption import (
    ABSORPTION_SLOTS,
    Absorbing,
    absorption_features,
    coefficients_at,
    pack_absorption,
)
from alight.bsdfs.albedo_rows import (
    LEAST_ALPHA,
    ROW,
    ROWS,
    Needs,
    albedo_rows,
    alpha_along,
    facet_rows,
)
from alight.bsdfs.albedo_table import load_rows
from alight.bsdfs.facets import ANISOTROPIC
from alight.bsdfs.principled_lobes import albedo as albedo
from alight.bsdfs.principled_lobes import evaluate as evaluate
from alight.bsdfs.principled_lobes import sample as sample
from alight.bsdfs.principled_view import (
    COAT,
    COAT_IOR,
    FILM,
    GLASS,
    NO_TURN,
    SHEEN,
    Coat,
    Film,
    Params,
    Sheen,
    Turn,
)
from alight.bsdfs.rows import MANY_ROWS, load_table, rows_at
from alight.bsdfs.sheen import ROW as SHEEN_ROW
from alight.bsdfs.sheen import ROWS as SHEEN_ROWS
from alight.bsdfs.sheen import sheen_rows
from alight.core.maths import sincos
from alight.core.microfacet import Facets
from alight.core.spec import (
    ColorTexture,
    IndexOfRefraction,
    Interval,
    NumberOrTexture,
    Texture,
    Truth,
    UnitTexture,
)
from alight.textures.fetch import color, constant_color, scalar, textured_scalar
from lanewise.jit import kernel, specialised
from lanewise.simd import lanes, lanes_vec3, maximum, minimum, where

#: Programs in which none is glass or a sheet have nothing that refracts.
REFRACTING = GLASS
#: What programs call it that metallic or roughness are textured, and that any of the others is:
#: each lookup of a texture is compiled inline.
TEXTURED, VARIED = "principled:textured", "principled:varied"
RARELY_TEXTURED = (
    "specular", "specular_color", "anisotropy", "anisotropy_rotation", "transmission", "clearcoat",
    "clearcoat_roughness", "sheen_color", "sheen_roughness", "iridescence", "iridescence_thickness",
)  # fmt: skip
#: Index of glass at least: the facet that refracts is found from it.
LEAST_IOR = 1.001

#: Larger angles of textures, in radians, are taken for this one: kernels do not know them.
MOST_TURNED = 1e5

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
        Colour of the metal, of what is diffuse, and of what glass lets through.
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
    thin : bool, default False
        Whether the surface is a thin sheet, not the boundary of a body.
    clearcoat, clearcoat_roughness : UnitTexture, defaults 0
        Strength and roughness of the coat, of index 1.5.
    sheen_color, sheen_roughness : ColorTexture and UnitTexture, defaults 0 and 0.3
        Colour and roughness of the sheen; roughness is at least 0.15.
    iridescence : UnitTexture, default 0
        Share of the film's reflectance.
    iridescence_ior : float in [1, 5], default 1.3
        Index of the film.
    iridescence_thickness : float or texture, nanometres, default 400
        Thickness of the film, in [0, 100000].
    attenuation_color, attenuation_distance
        As in `alight.bsdfs.absorption.Absorbing`; without effect if `thin`.
    compensation : bool, default True
        Whether light that met several facets is given back.
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
    thin: Truth = False
    clearcoat: UnitTexture = 0.0
    clearcoat_roughness: UnitTexture = 0.0
    sheen_color: ColorTexture = (0.0, 0.0, 0.0)
    sheen_roughness: UnitTexture = 0.3
    iridescence: UnitTexture = 0.0
    iridescence_ior: IndexOfRefraction = 1.3
    iridescence_thickness: Thickness = 400.0
    compensation: Truth = True

    @property
    def transmissive(self) -> bool:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Whether it has two sides already: glass and thin sheets."""
        return self.thin or not is_zero(self.transmission)


def is_zero(value: object) -> bool:
    """Whether a parameter is 0 everywhere; what is not known yet is not."""
    value = value.maximum() if isinstance(value, Texture) and not value.varies else value
    return value in (0.0, (0.0, 0.0, 0.0))


EXAMPLES = (
    Principled(base_color=(0.9, 0.5, 0.1)),
    Principled(base_color=1.0, metallic=1.0, roughness=0.7, anisotropy=0.6),
    Principled(base_color=1.0, transmission=1.0, roughness=0.6, ior=1.4, attenuation_distance=2.0),
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

SLOTS = {
    "base_color": 3, "metallic": 1, "roughness": 1, "specular": 1, "specular_color": 3,
    "anisotropy": 1, "anisotropy_rotation": 1, "transmission": 1, "clearcoat": 1,
    "clearcoat_roughness": 1, "sheen_color": 3, "sheen_roughness": 1, "iridescence": 1,
    "iridescence_ior": 1, "iridescence_thickness": 1, "eta": 1, "modes": 1, "rows": 1,
    "last_row": 1, "coat_rows": 1, "last_coat_row": 1, "sheen_rows": 1, "last_sheen_row": 1,
    **ABSORPTION_SLOTS,
}  # fmt: skip
_AT = dict(zip(SLOTS, (sum(list(SLOTS.values())[:i]) for i in range(len(SLOTS))), strict=True))
METALLIC, ROUGHNESS, SPECULAR = _AT["metallic"], _AT["roughness"], _AT["specular"]
SPECULAR_COLOR, ANISOTROPY = _AT["specular_color"], _AT["anisotropy"]
ROTATION, TRANSPARENT = _AT["anisotropy_rotation"], _AT["transmission"]
CLEARCOAT, COAT_ROUGHNESS = _AT["clearcoat"], _AT["clearcoat_roughness"]
SHEEN_COLOR, SHEEN_ROUGHNESS = _AT["sheen_color"], _AT["sheen_roughness"]
IRIDESCENCE, FILM_IOR, FILM_THICKNESS = (
    _AT["iridescence"], _AT["iridescence_ior"], _AT["iridescence_thickness"]
)  # fmt: skip
ETA, MODES = _AT["eta"], _AT["modes"]
TABLE, COAT_TABLE, SHEEN_TABLE = _AT["rows"], _AT["coat_rows"], _AT["sheen_rows"]
ABSORPTION = _AT["absorption"]


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
        # Kernels know no angles of many turns.
        turn = math.remainder(spec.anisotropy_rotation, 2.0 * math.pi)
        packer.numbers("anisotropy_rotation", turn)
    packer.numbers("iridescence_ior", spec.iridescence_ior)
    refracts = spec.transmissive and not spec.thin
    eta = max(spec.ior, LEAST_IOR) if refracts else spec.ior
    packer.numbers("eta", eta)
    packer.numbers("modes", spec.thin + 2.0 * spec.compensation)
    needs = Needs(eta, refracts, not is_zero(spec.iridescence))
    grid = facet_rows(_constant(packer, "roughness"), _constant(packer, "anisotropy"), needs)
    packer.curve("rows", grid.rows)
    packer.numbers("last_row", grid.axes)
    if not is_zero(spec.clearcoat):
        root = _constant(packer, "clearcoat_roughness")
        packer.curve("coat_rows", albedo_rows(root, Needs(COAT_IOR)))
        packer.numbers("last_coat_row", 0 if root is not None else ROWS - 1)
    if not is_zero(spec.sheen_color):
        root = _constant(packer, "sheen_roughness")
        packer.curve("sheen_rows", sheen_rows(root))
        packer.numbers("last_sheen_row", 0 if root is not None else SHEEN_ROWS - 1)
    pack_absorption(spec, packer)


def _constant(packer, name: str) -> float | None:
    """The number in a slot; None where it is textured."""
    at = packer.starts[name]
    return None if packer.textures[at] else min(max(float(packer.row[at]), 0.0), 1.0)


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
    return (*(name for name, used in names.items() if used), *absorbs)


def _is_textured(value: object) -> bool:
    return value.varies if isinstance(value, Texture) else not isinstance(value, float | tuple)


# ---------------------------------------------------------------- what a point of a surface holds


@specialised
def _usual(program):
    """``(scene, slot, surface) -> number`` of metallic and roughness."""
    return textured_scalar if TEXTURED in program.bsdfs else scalar


@specialised
def _rare(program):
    """``(scene, slot, surface) -> number`` of `RARELY_TEXTURED`."""
    return textured_scalar if VARIED in program.bsdfs else scalar


@specialised
def _rare_color(program):
    """``(scene, slot, surface) -> Vec3``, likewise."""
    return color if VARIED in program.bsdfs else constant_color


@kernel
def load(scene, base, surface):
    """The parameters at a point of a surface."""
    root = _unit(_usual(scene, base + ROUGHNESS, surface))
    alpha = maximum(root * root, LEAST_ALPHA)
    modes = scalar(scene, base + MODES, surface)
    facets, turn = _facets(scene, base, surface, alpha)
    return Params(
        color(scene, base, surface),
        _usual(scene, base + METALLIC, surface),
        facets,
        turn,
        load_rows(scene, base + TABLE),
        scalar(scene, base + ETA, surface),
        _rare(scene, base + SPECULAR, surface),
        _rare_color(scene, base + SPECULAR_COLOR, surface),
        _rare(scene, base + TRANSPARENT, surface),
        (modes == 1.0) | (modes == 3.0),
        modes >= 2.0,
        _coat(scene, base, surface),
        _sheen(scene, base, surface),
        _film(scene, base, surface),
    )


@kernel
def _unit(a):
    return minimum(maximum(a, 0.0), 1.0)


@specialised
def _facets(program):
    """``(scene, base, surface, alpha) -> (Facets, Turn)``."""
    if ANISOTROPIC not in program.bsdfs:

        @kernel
        def isotropic(scene, base, surface, alpha):
            return Facets(alpha, alpha, lanes(0.0)), NO_TURN

        return isotropic

    @kernel
    def anisotropic(scene, base, surface, alpha):
        a = _unit(_rare(scene, base + ANISOTROPY, surface))
        angle = _rare(scene, base + ROTATION, surface)
        s, c = sincos(minimum(maximum(angle, -MOST_TURNED), MOST_TURNED))
        return Facets(alpha_along(alpha, a), alpha, lanes(0.0)), Turn(s, c, a)

    return anisotropic


@specialised
def _coat(program):
    """``(scene, base, surface) -> Coat``, or nothing."""
    if COAT not in program.bsdfs:
        return _nothing

    @kernel
    def coat(scene, base, surface):
        root = _unit(_rare(scene, base + COAT_ROUGHNESS, surface))
        alpha = maximum(root * root, LEAST_ALPHA)
        strength = _rare(scene, base + CLEARCOAT, surface)
        rows = rows_at(load_table(scene, base + COAT_TABLE), root, ROW)
        return Coat(strength, Facets(alpha, alpha, lanes(0.0)), rows)

    return coat


@specialised
def _sheen(program):
    """``(scene, base, surface) -> Sheen``, or nothing."""
    if SHEEN not in program.bsdfs:
        return _nothing

    @kernel
    def sheen(scene, base, surface):
        roughness = _unit(_rare(scene, base + SHEEN_ROUGHNESS, surface))
        rows = rows_at(load_table(scene, base + SHEEN_TABLE), roughness, SHEEN_ROW)
        return Sheen(_rare_color(scene, base + SHEEN_COLOR, surface), roughness, rows)

    return sheen


@specialised
def _film(program):
    """``(scene, base, surface) -> Film``, or nothing."""
    if FILM not in program.bsdfs:
        return _nothing

    @kernel
    def film(scene, base, surface):
        return Film(
            _rare(scene, base + IRIDESCENCE, surface),
            scalar(scene, base + FILM_IOR, surface),
            _rare(scene, base + FILM_THICKNESS, surface),
        )

    return film


@kernel
def _nothing(scene, base, surface):
    return lanes(0.0)


@kernel
def inner_index(scene, base, surface):
    """Index inside over that outside; 1 for sheets."""
    modes = scalar(scene, base + MODES, surface)
    return where((modes == 1.0) | (modes == 3.0), 1.0, scalar(scene, base + ETA, surface))


@kernel
def absorption(scene, base, surface):
    """Absorption coefficients inside, per metre."""
    modes = scalar(scene, base + MODES, surface)
    found = coefficients_at(scene, base + ABSORPTION)
    return where((modes == 1.0) | (modes == 3.0), lanes_vec3(0.0), found)
