r"""Reflectance that was measured on a real sample.

.. math::
    f(\omega_o, \omega_i) \cos\theta_i = \frac{s(u)\, D(\omega_m)}{4\, \sigma(\omega_o)}, \qquad
    \omega_m = \frac{\omega_o + \omega_i}{|\omega_o + \omega_i|}

D is the density of the directions of facets and sigma the area of facets that is seen. The colour s
is stored over a unit square: u is the point that the density of the facets that the viewer sees
makes omega_m of, so most texels lie where most light goes. Samples choose u by the luminance that
was measured there, then omega_m by the density of visible facets.

What lies between the measured directions is interpolated; hence values obey reciprocity and the
conservation of energy only as well as the measurement does. Black from behind.

Source: Dupuy and Jakob 2018, An adaptive parameterization for efficient material acquisition and
rendering, ACM Transactions on Graphics 37(6); its database: https://rgl.epfl.ch/materials.
"""

from __future__ import annotations

from collections import namedtuple
from functools import lru_cache
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, Self

import numpy as np
from pydantic import model_validator

from alight.bsdfs.flags import REFLECTION
from alight.bsdfs.measured import examples
from alight.bsdfs.measured.measurement import MeasuredData, Measurement, read_measurement
from alight.bsdfs.measured.warp import (
    Viewed,
    Warp,
    density_at,
    interval_of,
    invert_warp,
    read_color,
    read_texels,
    sample_warp,
    warp_tables,
)
from alight.bsdfs.microfacets.facets import ANISOTROPIC
from alight.core.constants import INV_TWO_PI, PI
from alight.core.fields import invalid
from alight.core.maths import arcsin, arctan2, sincos
from alight.core.parameters import Slots, loader, slots_of
from alight.core.spec import Bsdf
from alight.core.vec import Vec3, dot, normalize, reflect, renormalize
from alight.textures.fetch import PlainColor
from lanewise.jit import kernel
from lanewise.simd import (
    absolute,
    copysign,
    floor,
    gather,
    lanes_u32,
    maximum,
    minimum,
    sqrt,
    to_uint,
    where,
)
from lanewise.view import View


class Measured(Bsdf):
    """Material from a database of measurements.

    Parameters
    ----------
    file : str, optional
        A tensor file of the RGL database (``.bsdf``), relative to the scene file, or
        ``builtin:brushed`` or ``builtin:satin``, which are computed.
    data : str, optional
        The file itself, in base64.
    """

    one_sided: ClassVar[bool] = True
    type: Literal["measured"] = "measured"
    file: str | None = None
    data: MeasuredData | None = None

    @model_validator(mode="after")
    def _has_one_source(self) -> Self:
        if (self.file is None) == (self.data is None):
            raise invalid("needs a file, or data" + (", got both" if self.file else ""))
        return self

    def read(self, files: Any) -> Self:
        """Take the measurement from its file."""
        if self.file is None:
            return self
        if self.file in examples.BUILTIN:
            return self.replaced(file=None, data=_computed(self.file))
        data, notes = files.read(read_measurement, self.file)
        for text in notes:
            files.note(text)
        return self.replaced(file=None, data=data)


@lru_cache
def _computed(name: str) -> Measurement:
    return examples.BUILTIN[name](examples.FINE)


EXAMPLES = (
    Measured(data=examples.satin()),
    Measured(data=examples.brushed()),
)


# ---------------------------------------------------------------- laws, checked for every example


def is_lossless(spec: Measured) -> bool:
    """What was measured is darker than white."""
    return False


def is_reciprocal(spec: Measured) -> bool | None:
    """As well as the measurement is: nothing is promised."""
    return None


# ---------------------------------------------------------------- tables

#: Tables of one measurement in `curves`: where they start. The first `HEAD` numbers say where each
#: of them begins, and how large it is.
Tables = namedtuple("Tables", "curves start")

HEAD = 24
#: Of the quadrature of the albedo.
_ELEVATION_STEPS, _AZIMUTH_STEPS = 64, 128
# Numbers of the head: how many elevations and azimuths; azimuths fit so many times into a turn;
# whether only the angle between azimuths counts; then of each table where it begins.
_ELEVATIONS, _AZIMUTHS, _TURNS, _ISOTROPIC, _THETA, _PHI = range(6)
# Of the tables of the square also height and width.
_NDF, _SIGMA, _VNDF, _LUMINANCE, _RGB = range(6, 21, 3)


@kernel
def _load_tables(scene, slot, surface):
    return Tables(scene.materials.curves, to_uint(gather(scene.materials.data, slot)))


class Params(NamedTuple):
    """A row of the table."""

    tables: Annotated[Any, Slots(_load_tables)]
    head_on: PlainColor


SLOTS = slots_of(Params)
load = loader(Params)


@lru_cache(maxsize=16)
def tables_of(data: Measurement) -> np.ndarray:
    """All tables of a measurement, (n,) float32."""
    arrays = data.arrays
    head = np.zeros(HEAD)
    head[:4] = len(arrays["theta_i"]), len(arrays["phi_i"]), data.turns, data.is_isotropic
    parts: list[np.ndarray] = [head]
    tables = {
        _THETA: arrays["theta_i"], _PHI: arrays["phi_i"],
        _NDF: arrays["ndf"], _SIGMA: arrays["sigma"],
        _VNDF: warp_tables(arrays["vndf"]), _LUMINANCE: warp_tables(arrays["luminance"]),
        _RGB: arrays["rgb"],
    }  # fmt: skip
    sizes = {_NDF: "ndf", _SIGMA: "sigma", _VNDF: "vndf", _LUMINANCE: "luminance", _RGB: "rgb"}
    end = HEAD
    for at, table in tables.items():
        head[at] = end
        if at in sizes:
            head[at + 1 : at + 3] = arrays[sizes[at]].shape[-2:]
        parts.append(np.ravel(table))
        end += table.size
    return np.concatenate(parts).astype(np.float32)


@lru_cache(maxsize=16)
def _albedo_of(data: Measurement) -> tuple[float, float, float]:
    """Reflected part of light that arrives at right angles, by quadrature over all directions.

    Not by samples: a regular grid of them meets none, or too many, of those that fail at its edges.
    """
    # Finer towards the axis, as the measurement is.
    s, turn = ((np.arange(n) + 0.5) / n for n in (_ELEVATION_STEPS, _AZIMUTH_STEPS))
    s, phi = (c.ravel() for c in np.meshgrid(s, 2.0 * np.pi * turn))
    sine, cosine = np.sin(0.5 * np.pi * s * s), np.cos(0.5 * np.pi * s * s)
    wi = (c.astype(np.float32) for c in (sine * np.cos(phi), sine * np.sin(phi), cosine))
    zero, one = np.zeros(s.size, np.float32), np.ones(s.size, np.float32)
    tables = Tables(View(tables_of(data)), zero.astype(np.uint32))
    f_cos, _ = evaluate(Params(tables, None), Vec3(zero, zero, one), Vec3(*wi))
    # domega = sin theta dtheta dphi, and dtheta = pi s ds.
    solid_angle = 2.0 * np.pi**2 * s * sine / s.size
    sums = [min(float(c @ solid_angle), 1.0) for c in (f_cos.x, f_cos.y, f_cos.z)]
    return sums[0], sums[1], sums[2]


def pack(spec: Measured, packer) -> None:
    """Fill the row of one material."""
    assert spec.data is not None
    packer.curve("tables", tables_of(spec.data))
    packer.numbers("head_on", *_albedo_of(spec.data))


def features(spec: Measured) -> tuple[str, ...]:
    """What must be compiled for this material beyond the model's usual path."""
    turns = spec.data is not None and len(spec.data.arrays["phi_i"]) > 1
    return (ANISOTROPIC,) if turns else ()


# ---------------------------------------------------------------- directions and the unit square


@kernel
def _head(tables, i):
    return gather(tables.curves, tables.start + i)


@kernel
def _elevation(w):
    """Angle from the axis; precise near it, where an arc cosine is not."""
    squared = w.x * w.x + w.y * w.y + (w.z - 1.0) * (w.z - 1.0)
    return 2.0 * arcsin(minimum(0.5 * sqrt(squared), 1.0))


@kernel
def _to_square(elevation, azimuth):
    """Coordinates of a direction, finer towards the axis."""
    y = azimuth * INV_TWO_PI + 0.5
    return sqrt(maximum(elevation, 0.0) * (2.0 / PI)), y - floor(y)


@kernel
def _mirrors(tables, wo):
    """Signs of x and y by which directions come to those that were measured."""
    turns = _head(tables, _TURNS)
    y = where(turns >= 2.0, -copysign(1.0, wo.y), 1.0)
    x = where(turns >= 4.0, -copysign(1.0, wo.x), y)
    return x, y


@kernel
def _viewed(tables, elevation, azimuth):
    """The measured directions around the viewer's."""
    elevations = to_uint(_head(tables, _ELEVATIONS))
    azimuths = to_uint(_head(tables, _AZIMUTHS))
    theta, phi = to_uint(_head(tables, _THETA)), to_uint(_head(tables, _PHI))
    i, of_elevation = interval_of(tables.curves, tables.start + theta, elevations, elevation)
    j, of_azimuth = interval_of(tables.curves, tables.start + phi, azimuths, azimuth)
    up = where(of_elevation > 0.0, lanes_u32(1), 0)
    around = where(of_azimuth > 0.0, elevations, 0)
    return Viewed(j * elevations + i, up, around, of_elevation, of_azimuth)


@kernel
def _warp(tables, table):
    """One of the densities."""
    height, width = _head(tables, table + 1), _head(tables, table + 2)
    rows = to_uint(height)
    size = 2 * rows * to_uint(width) + 2 * rows
    start = tables.start + to_uint(_head(tables, table))
    return Warp(tables.curves, start, size, height, width)


@kernel
def _colors(tables):
    height, width = _head(tables, _RGB + 1), _head(tables, _RGB + 2)
    start = tables.start + to_uint(_head(tables, _RGB))
    return Warp(tables.curves, start, 3 * to_uint(height) * to_uint(width), height, width)


@kernel
def _texels_at(tables, table, u):
    start = tables.start + to_uint(_head(tables, table))
    height, width = _head(tables, table + 1), _head(tables, table + 2)
    return read_texels(tables.curves, start, height, width, u)


# ---------------------------------------------------------------- scattering


@kernel
def evaluate(params, wo, wi):
    """(f cos theta_i, pdf per steradian)."""
    tables = params.tables
    above = (wo.z > 0.0) & (wi.z > 0.0)
    # Below the surface, the overhead direction replaces it; the result is not used.
    wo, wi = where(above, wo, Vec3(0.0, 0.0, 1.0)), where(above, wi, Vec3(0.0, 0.0, 1.0))
    x, y = _mirrors(tables, wo)
    wo, wi = Vec3(x * wo.x, y * wo.y, wo.z), Vec3(x * wi.x, y * wi.y, wi.z)
    wm = normalize(wo + wi)
    azimuth, elevation = arctan2(wo.y, wo.x), _elevation(wm)
    turned = where(_head(tables, _ISOTROPIC) > 0.0, azimuth, 0.0)
    u_m = _to_square(elevation, arctan2(wm.y, wm.x) - turned)
    slope = _elevation(wo)
    viewed = _viewed(tables, slope, azimuth)
    u, density = invert_warp(_warp(tables, _VNDF), viewed, u_m)
    facets = _texels_at(tables, _NDF, u_m)
    seen = _texels_at(tables, _SIGMA, _to_square(slope, azimuth))
    scale = where(above & (seen > 0.0), facets / (4.0 * where(seen > 0.0, seen, 1.0)), 0.0)
    # From the square to facets, 2 pi^2 u_x sin theta_m, and from these to directions, 4 wo . wm.
    sine = sqrt(wm.x * wm.x + wm.y * wm.y)
    area = maximum(8.0 * PI * PI * u_m[0] * sine * absolute(dot(wo, wm)), 1e-12)
    pdf = density * density_at(_warp(tables, _LUMINANCE), viewed, u) / area
    return read_color(_colors(tables), viewed, u) * scale, where(above, pdf, 0.0)


@kernel
def sample(params, wo, u, u2):
    """(wi, f cos theta_i / pdf, pdf per steradian, flags)."""
    tables = params.tables
    x, y = _mirrors(tables, wo)
    there = Vec3(x * wo.x, y * wo.y, absolute(wo.z))
    azimuth = arctan2(there.y, there.x)
    viewed = _viewed(tables, _elevation(there), azimuth)
    chosen, _ = sample_warp(_warp(tables, _LUMINANCE), viewed, u2)
    u_m, _ = sample_warp(_warp(tables, _VNDF), viewed, chosen)
    turned = where(_head(tables, _ISOTROPIC) > 0.0, azimuth, 0.0)
    sin_azimuth, cos_azimuth = sincos((2.0 * u_m[1] - 1.0) * PI + turned)
    sine, cosine = sincos(0.5 * PI * u_m[0] * u_m[0])
    wm = Vec3(x * cos_azimuth * sine, y * sin_azimuth * sine, cosine)
    wi = renormalize(reflect(wo, wm))
    # The point of the square is found again from wi: rounding would tell the densities apart.
    f_cos, pdf = evaluate(params, wo, wi)
    # Interpolated densities may choose facets that turn away from the viewer: they reflect nothing.
    failed = (pdf <= 0.0) | (dot(wo, wm) <= 0.0)
    weight = f_cos * where(failed, 0.0, 1.0 / where(failed, 1.0, pdf))
    return wi, weight, where(failed, 0.0, pdf), lanes_u32(REFLECTION)


@kernel
def albedo(params):
    """Reflected part of light that arrives at right angles."""
    return params.head_on
