r"""Environment: light from infinity, given by a map of latitude and longitude.

The map is wrapped around the scene with +y of its node up. Its columns go around: at height
:math:`\theta` from +y and azimuth :math:`\varphi`

.. math::
    \omega = (\sin\theta \sin\varphi, \cos\theta, -\sin\theta \cos\varphi), \qquad
    x = \frac{w \varphi}{2 \pi} - \frac12, \qquad y = \frac{(h - 1)\, \theta}{\pi}

are the coordinates of a direction among the texels, whose radiance is interpolated bilinearly: the
left edge of the picture is towards -z, its middle towards +z, its first and last row are the poles.

Directions are drawn cell by cell, a cell being the patch between the centres of four texels: first
the cell, in proportion to its solid angle and the mean of its corners' weights; then a place in it,
in proportion to the weights interpolated between the corners. With
:math:`q = \sin^2(\theta / 2)`, which is uniform in solid angle, that density is smooth across cells
and has no sine to divide by. A weight is a texel's luminance ("importance"), or 1 ("uniform").

MIS compensation takes the mean off the weights, down to 0: what is darker than the mean is left to
BSDF sampling. Light sampling alone would miss it, so it is done only where both are combined.

Source: PBR4 section 12.5 and A.5; Karlik, Sik, Vevoda, Skrivan, Krivanek, MIS compensation:
optimizing sampling techniques in multiple importance sampling, ACM TOG 38(6), 2019; registration
of the texels as in Mitsuba 3's ``envmap``, found by experiment.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import model_validator

from alight.core.constants import INV_PI, INV_TWO_PI, PI
from alight.core.distributions import bilinear, pmf_cell, sample_bilinear, sample_cell
from alight.core.field_types import Color, Degrees, Triple
from alight.core.fields import Truth, invalid
from alight.core.maths import arctan2, sincos_2pi
from alight.core.noise_only import NoiseOnly
from alight.core.spec import Light
from alight.core.vec import Vec3, dot, row_vec3
from alight.lights.bright_disk import Disk, brightest_disk
from alight.lights.environment_map import (
    BAND,
    COLUMNS,
    FIRST_BAND,
    LEFT_OUT,
    ROWS,
    TEXEL,
    EnvironmentMap,
    environment_map,
)
from alight.lights.tables import INFO, from_infinity
from alight.textures.images import Image, Pixels, source_problem
from lanewise.jit import kernel, specialised
from lanewise.simd import (
    absolute,
    as_float,
    as_int,
    gather_row,
    maximum,
    minimum,
    minimum_u32,
    sqrt,
    to_float,
    to_uint,
    where,
)

#: A place on the map. column, row: of its cell; x: fraction of the cell's width, y: of the angle
#: from its upper to its lower edge, c: of the solid angle between them.
Place = namedtuple("Place", "column row x y c")


class Environment(Light):
    """A picture of all that is far away.

    Parameters
    ----------
    file : str, optional
        EXR, HDR, PNG or JPEG picture, relative to the scene file; not together with `pixels`.
    pixels : (h, w, 3) float32, W/(m^2 sr), optional
        The picture itself, linear sRGB, top row first.
    scale : Color, default 1
        Factor of the radiance.
    rotate : float, degrees, default 0
        Turn about the +y axis of its node.
    sampling : {"importance", "uniform"}, default "importance"
        Directions are drawn in proportion to luminance, or all alike.
    compensation : bool, default True
        Take the mean off the importance where BSDF sampling complements it (``light_sampling:
        mis``).
    """

    placement: ClassVar[Literal["node", "shape", "environment"]] = "environment"
    type: Literal["environment"] = "environment"
    file: str | None = None
    pixels: Pixels | None = None
    scale: Color = (1.0, 1.0, 1.0)
    rotate: Degrees = 0.0
    sampling: Annotated[Literal["importance", "uniform"], NoiseOnly()] = "importance"
    compensation: Annotated[Truth, NoiseOnly()] = True

    @model_validator(mode="after")
    def _has_one_source(self) -> Self:
        problem = source_problem(self)
        if problem:
            raise invalid(problem)
        return self

    @property
    def is_black(self) -> bool:
        """Whether it emits nothing, as far as is known without reading its file."""
        dark = self.pixels is not None and max(self.pixels.maximum()) == 0.0
        return dark or self.scale == (0.0, 0.0, 0.0)

    def largest_radiance(self) -> float | None:
        """Bound of the radiance that it emits."""
        if self.pixels is None:
            return None
        return max(p * s for p, s in zip(self.pixels.maximum(), self.scale, strict=True))


_SUNSET = ((0.2, 0.3, 0.4, 0.3), (0.5, (9.0, 6.0, 3.0), 0.5, 0.1), (0.1, 0.2, 0.1, 0.1))

EXAMPLES = (
    Environment(pixels=_SUNSET),
    Environment(pixels=_SUNSET, scale=(2.0, 1.0, 0.5), rotate=120.0, sampling="uniform"),
    Environment(pixels=((1.0,),), compensation=False),
    Environment(pixels=_SUNSET, scale=0.0),
)

#: A ray that leaves the scene finds it.
DELTA = False


def place(spec: Environment, to_world: np.ndarray) -> tuple[Triple, np.ndarray]:
    """Colour; its map has the rest."""
    return spec.scale, np.zeros(3)


def power(luminance: float, area: float, radius: float) -> float:
    """W that enter a scene of bounding radius `radius`: 4 pi directions through pi r^2."""
    return 4.0 * PI * PI * radius * radius * luminance


def map_of(spec: Environment, to_world: np.ndarray, compensated: bool) -> EnvironmentMap:
    """The tables of a light whose picture has been read.

    Parameters
    ----------
    spec : Environment
    to_world : (4, 4) float64
        Of its node; a rotation, perhaps mirrored or scaled.
    compensated : bool
        Whether BSDF sampling finds what the map leaves out.
    """
    compensated = compensated and spec.compensation
    return environment_map(*_oriented(spec, to_world), spec.sampling, compensated)


def disk_of(spec: Environment, to_world: np.ndarray) -> Disk | None:
    """The sun in a picture, if there is one; see `alight.lights.model.LightModel`."""
    return brightest_disk(*_oriented(spec, to_world))


def _oriented(spec: Environment, to_world: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(radiance of each texel, rotation from the world to the map)."""
    assert isinstance(spec.pixels, Image)
    axes = to_world[:3, :3] / np.linalg.norm(to_world[:3, :3], axis=0)
    turn = np.radians(spec.rotate)
    about_y = np.array(
        [[np.cos(turn), 0.0, np.sin(turn)], [0.0, 1.0, 0.0], [-np.sin(turn), 0.0, np.cos(turn)]]
    )
    radiance = np.broadcast_to(spec.pixels.linear(), (*spec.pixels.texels.shape[:2], 3))
    return radiance, (axes @ about_y).T


# In what follows `at` is where the map starts in the table.


@kernel
def to_map(scene, at, d):
    """A direction of the world in the space of the map."""
    m = scene.lights.map
    return Vec3(dot(row_vec3(m, at), d), dot(row_vec3(m, at + 3), d), dot(row_vec3(m, at + 6), d))


@kernel
def from_map(scene, at, d):
    """The inverse: the transpose."""
    m = scene.lights.map
    return row_vec3(m, at) * d.x + row_vec3(m, at + 3) * d.y + row_vec3(m, at + 6) * d.z


@kernel
def band_of(scene, at, row):
    """(q at the upper edge, difference of q to the lower edge, mask: seen from +y) of a row.

    q is sin^2(theta / 2) with theta from the nearer pole, so that it is precise there.
    """
    m = scene.lights.map
    edge, size = gather_row(m, at + FIRST_BAND + BAND * row, BAND)
    return edge, size, 2 * row + 1 <= as_int(m[at + ROWS])


@kernel
def locate(scene, at, d):
    """The `Place` of unit directions in the space of the map; valid whatever d is."""
    m = scene.lights.map
    columns, rows = as_int(m[at + COLUMNS]), as_int(m[at + ROWS])
    x = arctan2(d.x, -d.z) * INV_TWO_PI * as_float(columns) - 0.5
    x = where(x < 0.0, x + as_float(columns), x)
    column = minimum_u32(to_uint(x), columns - 1)
    squared = d.x * d.x + d.z * d.z
    y = arctan2(sqrt(squared), d.y) * INV_PI * as_float(rows)
    row = minimum_u32(to_uint(y), rows - 1)
    edge, size, upper = band_of(scene, at, row)
    # sin^2 theta = 4 q (1 - q), and 1 - q = (1 + |cos theta|) / 2 does not cancel.
    q = 0.5 * squared / (1.0 + where(upper, d.y, -d.y))
    return Place(
        column,
        row,
        minimum(maximum(x - to_float(column), 0.0), 1.0),
        minimum(maximum(y - to_float(row), 0.0), 1.0),
        minimum(maximum((q - edge) / size, 0.0), 1.0),
    )


@kernel
def corners_of(scene, at, column, row):
    """Indices of the four texels of a cell: upper left, upper right, lower left, lower right."""
    m = scene.lights.map
    columns, rows = as_int(m[at + COLUMNS]), as_int(m[at + ROWS])
    first = at + FIRST_BAND + BAND * rows + TEXEL * columns * row
    right = where(column + 1 < columns, column + 1, 0)
    a, b = first + TEXEL * column, first + TEXEL * right
    return a, b, a + TEXEL * columns, b + TEXEL * columns


@kernel
def texels_of(scene, at, column, row):
    """The four texels of a cell: red, green, blue and weight of each."""
    m = scene.lights.map
    a, b, c, d = corners_of(scene, at, column, row)
    return (
        gather_row(m, a, TEXEL), gather_row(m, b, TEXEL),
        gather_row(m, c, TEXEL), gather_row(m, d, TEXEL),
    )  # fmt: skip


@kernel
def channel(texels, k):
    """Number k of the four texels."""
    a, b, c, d = texels
    return a[k], b[k], c[k], d[k]


@kernel
def shown(texels, place):
    """Radiance of the map at a place, without `scale`."""
    x, y = place.x, place.y
    return Vec3(
        bilinear(channel(texels, 0), x, y),
        bilinear(channel(texels, 1), x, y),
        bilinear(channel(texels, 2), x, y),
    )


@kernel
def density(scene, at, weights, pmf, place, size):
    """Density per solid angle in a cell of probability `pmf`; size: of its band."""
    columns = as_float(as_int(scene.lights.map[at + COLUMNS]))
    mean = 0.25 * (weights[0] + weights[1] + weights[2] + weights[3])
    relative = bilinear(weights, place.x, place.c) / where(mean > 0.0, mean, 1.0)
    # The cell covers 2 pi / columns in azimuth and 2 |size| in cos(theta).
    return relative * pmf * columns * (0.5 * INV_TWO_PI) / absolute(size)


@specialised
def map_at(program):
    """``map_at(scene, back)``: where the map of an environment starts in `LightTables.map`."""
    if len(program.environments) < 2:

        @kernel
        def the_only_one(scene, back):
            return 0

        return the_only_one

    @kernel
    def as_noted(scene, back):
        info = scene.lights.info
        return as_int(info[info.size - INFO * back + 1])

    return as_noted


@kernel
def cells_at(scene, back):
    """Where the choice of cells starts in `LightTables.cdf`."""
    info = scene.lights.info
    return as_int(info[info.size - INFO * back + 3])


@kernel
def sample(scene, back, p, u, u2):
    """Choose a direction.

    Parameters
    ----------
    scene : namedtuple
        With the field `lights`.
    back : int
        The environment is the light of this number from the end; uniform.
    p : Vec3
        Where it is seen from; of no concern.
    u, u2
        Uniform in [0, 1): one number and a pair.

    Returns
    -------
    LightSample
        Without the probability of choosing this light; radiance over the light's colour (which the
        caller multiplies).
    """
    m, at = scene.lights.map, map_at(scene, back)
    columns, rows = as_int(m[at + COLUMNS]), as_int(m[at + ROWS])
    column, row, pmf, rest = sample_cell(
        scene.lights.cdf, cells_at(scene, back), rows, columns, u, u2
    )
    texels = texels_of(scene, at, column, row)
    weights = channel(texels, 3)
    x, c = sample_bilinear(weights, rest)
    edge, size, upper = band_of(scene, at, row)
    q = edge + c * size
    cosine, sine = 1.0 - 2.0 * q, 2.0 * sqrt(q * (1.0 - q))
    cosine = where(upper, cosine, -cosine)
    turn = (to_float(column) + x + 0.5) / as_float(columns)
    s, z = sincos_2pi(where(turn < 1.0, turn, turn - 1.0))
    y = arctan2(sine, cosine) * INV_PI * as_float(rows) - to_float(row)
    place = Place(column, row, x, minimum(maximum(y, 0.0), 1.0), c)
    return from_infinity(
        from_map(scene, at, Vec3(sine * s, cosine, -sine * z)),
        shown(texels, place),
        density(scene, at, weights, pmf, place, size),
    )


@kernel
def pdf(scene, back, p, d):
    """Density of `sample` per solid angle."""
    m, at = scene.lights.map, map_at(scene, back)
    columns, rows = as_int(m[at + COLUMNS]), as_int(m[at + ROWS])
    place = locate(scene, at, to_map(scene, at, d))
    start = cells_at(scene, back)
    pmf = pmf_cell(scene.lights.cdf, start, rows, columns, place.column, place.row)
    weights = channel(texels_of(scene, at, place.column, place.row), 3)
    _, size, _ = band_of(scene, at, place.row)
    return density(scene, at, weights, pmf, place, size)


@kernel
def left_out(scene, back):
    """Share of its light that `sample` leaves to BSDF sampling."""
    return scene.lights.map[map_at(scene, back) + LEFT_OUT]


@kernel
def radiance(scene, back, d):
    """Radiance that arrives from the unit direction d, without the light's colour."""
    at = map_at(scene, back)
    place = locate(scene, at, to_map(scene, at, d))
    return shown(texels_of(scene, at, place.column, place.row), place)
