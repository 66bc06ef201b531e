r"""Lamp with a measured profile: a point whose intensity varies with the direction.

.. math:: E(x) = I(\theta, \varphi) \cos\theta_x / |x - x_\text{light}|^2

:math:`\theta` is measured from +z of its node (straight ahead; down for a lamp that hangs),
:math:`\varphi` from +x towards +y. Intensities in between are interpolated bilinearly; a candela
counts as 1/683 W/sr, so that luminances over 683 are what comes out.

Source: IES LM-63-02; see `alight.lights.photometry`.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Strict, model_validator

from alight.core.constants import INV_TWO_PI, ONE_MINUS_EPSILON, PI
from alight.core.distributions import cumulative, pmf_discrete, sample_discrete
from alight.core.field_types import Color, Triple
from alight.core.fields import invalid
from alight.core.maths import arctan2, sincos
from alight.core.spec import Light
from alight.core.vec import Vec3, dot, gather_vec3, normalize
from alight.core.warps import direction_around_z
from alight.lights.at_point import way_to
from alight.lights.photometry import (
    HORIZONTAL_STEP,
    VERTICAL_STEP,
    Profile,
    grid,
    profile_problem,
    read_profile,
)
from alight.lights.tables import INFO, STRIDE, LightSample, from_point
from lanewise.jit import kernel
from lanewise.simd import (
    gather,
    lanes,
    lanes_mask,
    lanes_vec3,
    maximum,
    minimum,
    minimum_u32,
    sqrt,
    to_float,
    to_uint,
    where,
)

#: Lumens a watt: how candelas become W/sr.
LUMENS = 683.0

Numbers = tuple[Annotated[float, Strict(False)], ...]


def profile(spec: Ies) -> Profile:
    """The profile of a description whose file has been read."""
    return Profile(
        np.array(spec.vertical_angles, float),
        np.array(spec.horizontal_angles, float),
        np.array(spec.candela, float),
    )


class Ies(Light):
    """Lamp of a photometric file.

    Parameters
    ----------
    file : str, optional
        A file of LM-63 (``.ies``, type C), relative to the scene file; or the following three.
    vertical_angles : list of float, degrees, optional
        From +z of the node, ascending in [0, 180]; beyond them it is dark.
    horizontal_angles : list of float, degrees, optional
        0 alone (the same all around), or from 0 to 90, 180 or 360, or from 90 to 270; the rest by
        symmetry.
    candela : list of lists of float, optional
        A row a horizontal angle.
    scale : Color, default 1
        Factor of its intensity; not changed by a scale of the node.
    """

    type: Literal["ies"] = "ies"
    file: str | None = None
    vertical_angles: Numbers | None = None
    horizontal_angles: Numbers | None = None
    candela: tuple[Numbers, ...] | None = None
    scale: Color = (1.0, 1.0, 1.0)

    @model_validator(mode="after")
    def _has_one_source(self) -> Self:
        inside = (self.vertical_angles, self.horizontal_angles, self.candela)
        given = sum(value is not None for value in inside)
        if self.file is not None and given:
            raise invalid("takes either file or angles and candela, got both")
        if self.file is None and given < 3:
            raise invalid("needs a file, or vertical_angles, horizontal_angles and candela")
        if self.file is None:
            assert self.candela is not None
            if len({len(row) for row in self.candela}) != 1:
                raise invalid("candela must have rows of the same length")
            problem = profile_problem(profile(self))
            if problem:
                raise invalid(problem)
        return self

    @property
    def is_black(self) -> bool:
        """Whether it emits nothing, as far as is known without reading its file."""
        dark = self.candela is not None and max(map(max, self.candela)) == 0.0
        return dark or self.scale == (0.0, 0.0, 0.0)

    def read(self, files: Any) -> Self:
        """Take the profile from its file."""
        if self.file is None:
            return self
        found = files.read(read_profile, self.file)
        return self.replaced(
            file=None,
            vertical_angles=tuple(found.vertical.tolist()),
            horizontal_angles=tuple(found.horizontal.tolist()),
            candela=tuple(map(tuple, found.candela.tolist())),
        )


_DOWN = (0.0, 45.0, 90.0)

EXAMPLES = (
    Ies(vertical_angles=_DOWN, horizontal_angles=(0.0,), candela=((683.0, 400.0, 0.0),)),
    Ies(
        vertical_angles=(0.0, 60.0, 180.0),
        horizontal_angles=(0.0, 90.0),
        candela=((900.0, 500.0, 100.0), (900.0, 2000.0, 300.0)),
        scale=(2.0, 1.0, 0.5),
    ),
    Ies(
        vertical_angles=_DOWN,
        horizontal_angles=(90.0, 180.0, 270.0),
        candela=((100.0, 100.0, 0.0), (100.0, 300.0, 50.0), (100.0, 100.0, 0.0)),
    ),
    Ies(vertical_angles=_DOWN, horizontal_angles=(0.0,), candela=((0.0, 0.0, 0.0),)),
)

#: Rays cannot hit it, so every mode finds it by light sampling.
DELTA = True


def axes_of(to_world: np.ndarray) -> NDArray[np.float64]:
    """Unit vectors along x, y and z of a node, row by row; whatever its scale."""
    z = to_world[:3, 2] / np.linalg.norm(to_world[:3, 2])
    x = to_world[:3, 0] - (to_world[:3, 0] @ z) * z
    x = x / np.linalg.norm(x)
    y = np.cross(z, x)
    return np.stack([x, y if y @ to_world[:3, 1] >= 0.0 else -y, z])


def place(spec: Ies, to_world: np.ndarray) -> tuple[Triple, np.ndarray]:
    """Colour; position and axes."""
    return spec.scale, np.concatenate([to_world[:3, 3], axes_of(to_world).ravel()])


def table(spec: Ies) -> NDArray[np.float32]:
    """Number of columns but one, then the intensities in W/sr row by row."""
    values = grid(profile(spec)) / LUMENS
    return np.append(values.shape[1] - 1, values.ravel()).astype(np.float32)


def mean_color(spec: Ies) -> Triple:
    """Mean intensity over the sphere."""
    values = grid(profile(spec)) / LUMENS
    # The last column is the first one again.
    rows = values[:, : max(1, values.shape[1] - 1)].mean(axis=1)
    edges = np.cos(np.radians(np.arange(len(rows)) * VERTICAL_STEP))
    mean = float(np.sum(0.5 * (rows[1:] + rows[:-1]) * -np.diff(edges)) / 2.0)
    r, g, b = (mean * channel for channel in spec.scale)
    return r, g, b


def power(luminance: float, area: float, radius: float) -> float:
    """Emitted power in W: the mean intensity over the whole sphere."""
    return 4.0 * PI * luminance


def cone(spec: Ies) -> tuple[float, float]:
    """Half angle of the directions that it faces; dark beyond."""
    lit = np.flatnonzero(grid(profile(spec)).max(axis=1) > 0.0)
    # A dark lamp, or one whose light falls between the steps of the grid, has none.
    last = lit[-1] if lit.size else 0
    return min(PI, float(np.radians((last + 2) * VERTICAL_STEP))), 0.0


@kernel
def intensity(scene, index, w):
    """Intensity of the lights `index` in the direction w of their own space, W/sr."""
    cdf = scene.lights.cdf
    start = gather(scene.lights.info, index * INFO + 3)
    columns = gather(cdf, start)
    theta = arctan2(sqrt(w.x * w.x + w.y * w.y), w.z) * (180.0 / (PI * VERTICAL_STEP))
    phi = arctan2(w.y, w.x) * (180.0 / (PI * HORIZONTAL_STEP))
    phi = where(phi < 0.0, phi + 360.0 / HORIZONTAL_STEP, phi)
    # All around the same: one column.
    phi = minimum(phi, columns)
    row = minimum(to_float(to_uint(theta)), 180.0 / VERTICAL_STEP - 1.0)
    column = minimum(to_float(to_uint(phi)), maximum(columns - 1.0, 0.0))
    y, x = minimum(theta - row, 1.0), minimum(phi - column, 1.0)
    right = where(columns > 0.0, 1, 0)
    width = to_uint(columns) + 1
    a = start + 1 + to_uint(row) * width + to_uint(column)
    upper = gather(cdf, a) + x * (gather(cdf, a + right) - gather(cdf, a))
    b = a + width
    lower = gather(cdf, b) + x * (gather(cdf, b + right) - gather(cdf, b))
    return upper + y * (lower - upper)


@kernel
def sample(scene, index, p, u, u2):
    """The one direction to the light; see `alight.lights.area.sample`."""
    data, k = scene.lights.data, index * STRIDE
    wi, distance, falling = way_to(gather_vec3(data, k + 4) - p)
    x, y, z = gather_vec3(data, k + 7), gather_vec3(data, k + 10), gather_vec3(data, k + 13)
    away = Vec3(-dot(x, wi), -dot(y, wi), -dot(z, wi))
    one = lanes(1.0)
    return LightSample(
        wi=wi,
        distance=distance,
        radiance=lanes_vec3(1.0) * (intensity(scene, index, away) * falling),
        pdf=one,
        delta=lanes_mask(True),
        cosine=one,
        error=lanes(0.0),
    )


# ---------------------------------------------------------------- emission

#: Rows of cells between the angles of the grid, half of them ahead; halves of a row's angle.
ROWS = round(180.0 / VERTICAL_STEP)
_HALF_STEP = 0.5 * PI / ROWS


def emission_table(spec: Ies) -> NDArray[np.float32]:
    """Choice of a cell between the angles of the grid, row by row, by the light through it."""
    values = grid(profile(spec))
    around = values if values.shape[1] > 1 else np.repeat(values, 2, axis=1)
    means = 0.25 * (around[1:, 1:] + around[1:, :-1] + around[:-1, 1:] + around[:-1, :-1])
    edges = np.cos(np.linspace(0.0, np.pi, ROWS + 1))
    return cumulative((means * -np.diff(edges)[:, None]).ravel())


@kernel
def columns_of(scene, index):
    """How many cells a row has."""
    columns = gather(scene.lights.cdf, gather(scene.lights.info, index * INFO + 3))
    return where(columns > 0.0, to_uint(columns), 1)


@kernel
def heights_of(row):
    """1 - |cos| at the edge of a row of cells next to the pole, its change across, and mask: ahead.

    From the nearer pole, so that it is precise there.
    """
    ahead = row < ROWS // 2
    steps = to_float(where(ahead, row, ROWS - 1 - row))
    inner, _ = sincos(steps * _HALF_STEP)
    outer, _ = sincos((steps + 1.0) * _HALF_STEP)
    return 2.0 * inner * inner, 2.0 * (outer * outer - inner * inner), ahead


@kernel
def cell_density(scene, index, pmf, height):
    """Density per steradian in a cell of some probability."""
    return pmf * to_float(columns_of(scene, index)) * INV_TWO_PI / height


@kernel
def emit(scene, index, u2, v2):
    """A ray by the light of the cells; see `alight.lights.model.LightModel`."""
    data, k = scene.lights.data, index * STRIDE
    columns, start = columns_of(scene, index), gather(scene.lights.starts, index)
    cell, pmf, _ = sample_discrete(scene.lights.emission, start, columns * ROWS, u2[0])
    row = cell // columns
    column = cell - row * columns
    edge, height, ahead = heights_of(row)
    turn = minimum((to_float(column) + v2[1]) / to_float(columns), ONE_MINUS_EPSILON)
    w = direction_around_z(edge + v2[0] * height, turn)
    w = Vec3(w.x, w.y, where(ahead, w.z, -w.z))
    x, y, z = gather_vec3(data, k + 7), gather_vec3(data, k + 10), gather_vec3(data, k + 13)
    density = cell_density(scene, index, pmf, height)
    drawn = density > 0.0
    flux = where(drawn, intensity(scene, index, w) / where(drawn, density, 1.0), 0.0)
    d = normalize(w.x * x + w.y * y + w.z * z)
    return from_point(gather_vec3(data, k + 4), d, lanes_vec3(1.0) * flux, density)


@kernel
def emit_pdf(scene, index, d):
    """Density of `emit` per steradian."""
    data, k = scene.lights.data, index * STRIDE
    columns, start = columns_of(scene, index), gather(scene.lights.starts, index)
    x, y = dot(gather_vec3(data, k + 7), d), dot(gather_vec3(data, k + 10), d)
    theta = arctan2(sqrt(x * x + y * y), dot(gather_vec3(data, k + 13), d))
    row = minimum_u32(to_uint(theta * (ROWS / PI)), ROWS - 1)
    turn = arctan2(y, x) * INV_TWO_PI
    turn = where(turn < 0.0, turn + 1.0, turn)
    column = minimum_u32(to_uint(turn * to_float(columns)), columns - 1)
    _, height, _ = heights_of(row)
    pmf = pmf_discrete(scene.lights.emission, start, row * columns + column)
    return cell_density(scene, index, pmf, height)
