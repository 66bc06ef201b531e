r"""Projector: a picture thrown through a pinhole.

.. math:: E(x) = P(u, v)\, d / z^3 \cdot \cos\theta_x, \qquad I(\omega) = P(u, v) / \cos^3\theta

z is the distance along +z of its node, d that to the point: on a screen at right angles to the axis
the picture has the same brightness up to its corners, :math:`P / z^2`. The picture is upright
where +y is up; seen along +z its left edge is towards +x. With a cutoff it is a spot light with a
texture: the picture fades between the angles of beam and cutoff.

Source: PBR4 section 12.2.3; brightness and orientation as in Mitsuba 3's ``projector``.
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator

from alight.core.constants import PI
from alight.core.distributions import cumulative, pmf_discrete, sample_discrete
from alight.core.field_types import Color, Positive, Triple
from alight.core.fields import Interval, invalid
from alight.core.maths import arctan2
from alight.core.spec import Light
from alight.core.vec import Vec3, dot, gather_vec3, length_squared, luminance, normalize
from alight.lights.at_point import way_to
from alight.lights.ies import axes_of
from alight.lights.tables import INFO, STRIDE, LightSample, from_point
from alight.textures.images import Image, Pixels, source_problem
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

#: Of its table: width and height of the picture; cutoff and 1 / (cutoff - beam), radians; 1 if
#: it is even on a screen, else 0; then the picture, row by row.
WIDTH, HEIGHT, CUTOFF, FADE, SCREEN, FIRST = range(6)

# A hard edge: so narrow in radians that no float32 angle falls into it; and none at all.
_NARROWEST, _NO_CUTOFF = 1e-9, 4.0

Fov = Annotated[float, Interval(0.1, 179.0)]
Angle = Annotated[float, Interval(0.0, 90.0)]


class Projector(Light):
    r"""Projector of a picture.

    Parameters
    ----------
    file : str, optional
        EXR, HDR, PNG or JPEG picture, relative to the scene file; not together with `pixels`.
    pixels : (h, w, 3) float32, W/sr, optional
        The picture itself, linear sRGB, top row first: intensity along the axis.
    scale : Color, default 1
        Factor of the picture; not changed by a scale of the node.
    fov : float in [0.1, 179], degrees, default 45
        Angle across the width of the picture.
    aspect : float > 0, optional
        Width over height of what is thrown; that of the picture by default.
    evenness : {"screen", "intensity"}, default "screen"
        A white picture is even on a screen at right angles to the axis, or in its intensity, as a
        spot light is (without the :math:`\cos^3\theta` above).
    cutoff_angle : float in [0, 90], degrees, optional
        Angle from the axis beyond which it is dark; no limit but the picture's edges by default.
    beam_width : float in [0, cutoff_angle], degrees, optional
        Angle up to which the picture has its full brightness; the cutoff by default.
    """

    type: Literal["projector"] = "projector"
    file: str | None = None
    pixels: Pixels | None = None
    scale: Color = (1.0, 1.0, 1.0)
    fov: Fov = 45.0
    aspect: Positive | None = None
    evenness: Literal["screen", "intensity"] = "screen"
    cutoff_angle: Angle | None = None
    beam_width: Angle | None = None

    @model_validator(mode="after")
    def _is_whole(self) -> Self:
        problem = source_problem(self)
        if problem:
            raise invalid(problem)
        if self.beam_width is not None and self.beam_width > (self.cutoff_angle or 0.0):
            most = "a cutoff_angle" if self.cutoff_angle is None else f"{self.cutoff_angle:g}"
            raise invalid(f"beam_width must be at most {most}, got {self.beam_width:g}")
        return self

    @property
    def is_black(self) -> bool:
        """Whether it emits nothing, as far as is known without reading its file."""
        dark = self.pixels is not None and max(self.pixels.maximum()) == 0.0
        return dark or self.scale == (0.0, 0.0, 0.0)


_FLAG = (((1.0, 0.2, 0.1), 0.5, 3.0), (0.3, (0.1, 1.0, 0.2), 0.0))

EXAMPLES = (
    Projector(pixels=_FLAG),
    Projector(pixels=_FLAG, fov=110.0, scale=(2.0, 1.0, 0.5), evenness="intensity", aspect=1.0),
    Projector(pixels=((1.0,),), fov=60.0, cutoff_angle=25.0, beam_width=10.0),
    Projector(pixels=_FLAG, scale=0.0),
)

#: Rays cannot hit it, so every mode finds it by light sampling.
DELTA = True


def tangents(spec: Projector) -> tuple[float, float]:
    """Half width and half height of the picture at distance 1."""
    height, width = _texels(spec).shape[:2]
    half = float(np.tan(np.radians(0.5 * spec.fov)))
    return half, half / (spec.aspect or width / height)


def _texels(spec: Projector) -> NDArray[np.float32]:
    assert isinstance(spec.pixels, Image)
    return np.broadcast_to(spec.pixels.linear(), (*spec.pixels.texels.shape[:2], 3))


def place(spec: Projector, to_world: np.ndarray) -> tuple[Triple, np.ndarray]:
    """Colour; position, and axes, x and y stretched so that the picture is [-1, 1]."""
    axes = axes_of(to_world)
    stretched = axes / np.array([[*tangents(spec), 1.0]]).T
    return spec.scale, np.concatenate([to_world[:3, 3], stretched.ravel()])


def table(spec: Projector) -> NDArray[np.float32]:
    """The picture and what goes with it, see `WIDTH`."""
    texels = _texels(spec)
    height, width = texels.shape[:2]
    cutoff, fade = _NO_CUTOFF, 1.0
    if spec.cutoff_angle is not None:
        beam = spec.cutoff_angle if spec.beam_width is None else spec.beam_width
        cutoff = np.radians(spec.cutoff_angle)
        fade = 1.0 / max(cutoff - np.radians(beam), _NARROWEST)
    screen = spec.evenness == "screen"
    return np.append([width, height, cutoff, fade, screen], texels.ravel()).astype(np.float32)


def mean_color(spec: Projector) -> Triple:
    """Mean intensity over the sphere, by the middle of each texel."""
    texels, (half_x, half_y) = _texels(spec), tangents(spec)
    height, width = texels.shape[:2]
    # Finer than the picture where that is coarse: a cutoff is round, a falloff smooth.
    rows, columns = max(height, 256), max(width, 256)
    x = half_x * (1.0 - 2.0 * (np.arange(columns) + 0.5) / columns)
    y = half_y * (1.0 - 2.0 * (np.arange(rows) + 0.5) / rows)
    cosine = 1.0 / np.sqrt(1.0 + x * x + (y * y)[:, None])
    # On the plane at distance 1 a solid angle is cos^3 times an area.
    weight = cosine**3 if spec.evenness == "intensity" else np.ones_like(cosine)
    if spec.cutoff_angle is not None:
        header = table(spec)
        weight *= np.clip((header[CUTOFF] - np.arccos(cosine)) * header[FADE], 0.0, 1.0)
    # As the kernel interpolates.
    v = np.clip((np.arange(rows) + 0.5) * height / rows - 0.5, 0.0, height - 1.0)
    u = np.clip((np.arange(columns) + 0.5) * width / columns - 0.5, 0.0, width - 1.0)
    seen = _between(_between(texels.astype(float), v).swapaxes(0, 1), u).swapaxes(0, 1)
    solid_angle = 4.0 * half_x * half_y / (rows * columns)
    mean = (seen * weight[..., None]).sum(axis=(0, 1)) * solid_angle / (4.0 * PI)
    r, g, b = (float(a) * c for a, c in zip(mean, spec.scale, strict=True))
    return r, g, b


def _between(rows: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Rows of an array interpolated between whole numbers."""
    low = np.minimum(places.astype(int), max(len(rows) - 2, 0))
    high = np.minimum(low + 1, len(rows) - 1)
    part = (places - low)[:, None, None]
    return rows[low] * (1.0 - part) + rows[high] * part


def power(luminance: float, area: float, radius: float) -> float:
    """Emitted power in W: the mean intensity over the whole sphere."""
    return 4.0 * PI * luminance


def cone(spec: Projector) -> tuple[float, float]:
    """Half angle of the directions that it faces; dark beyond."""
    corner = float(np.arctan(np.hypot(*tangents(spec))))
    return min(corner, np.radians(spec.cutoff_angle or 90.0)), 0.0


@kernel
def texel(cdf, start, width, column, row):
    """Three numbers of the picture."""
    return gather_vec3(cdf, start + FIRST + 3 * (row * width + column))


@kernel
def shown(cdf, start, u, v):
    """The picture at (u, v) in [0, 1], v from the top; interpolated between centres of texels."""
    width, height = to_uint(gather(cdf, start + WIDTH)), to_uint(gather(cdf, start + HEIGHT))
    x = maximum(u * to_float(width) - 0.5, 0.0)
    y = maximum(v * to_float(height) - 0.5, 0.0)
    column, row = minimum_u32(to_uint(x), width - 1), minimum_u32(to_uint(y), height - 1)
    right, below = minimum_u32(column + 1, width - 1), minimum_u32(row + 1, height - 1)
    x, y = minimum(x - to_float(column), 1.0), minimum(y - to_float(row), 1.0)
    a, b = texel(cdf, start, width, column, row), texel(cdf, start, width, right, row)
    c, d = texel(cdf, start, width, column, below), texel(cdf, start, width, right, below)
    upper, lower = a + x * (b - a), c + x * (d - c)
    return upper + y * (lower - upper)


@kernel
def brightness_of(scene, index, z, x, y):
    """How a picture shows: mask: within its edges; its falloff; what its intensity is divided by.

    z is the direction's cosine with the axis; (x, y) its place in the picture, each in [-1, 1].
    """
    cdf, start = scene.lights.cdf, gather(scene.lights.info, index * INFO + 3)
    there = (x >= -1.0) & (x <= 1.0) & (y >= -1.0) & (y <= 1.0) & (z > 1e-6)
    theta = arctan2(sqrt(maximum(1.0 - z * z, 0.0)), z)
    cutoff, fade = gather(cdf, start + CUTOFF), gather(cdf, start + FADE)
    falloff = minimum(maximum((cutoff - theta) * fade, 0.0), 1.0)
    spread = where(gather(cdf, start + SCREEN) > 0.0, z * z * z, 1.0)
    return there, falloff, spread


@kernel
def sample(scene, index, p, u, u2):
    """The one direction to the light; see `alight.lights.area.sample`."""
    data, cdf, k = scene.lights.data, scene.lights.cdf, index * STRIDE
    start = gather(scene.lights.info, index * INFO + 3)
    wi, distance, falling = way_to(gather_vec3(data, k + 4) - p)
    z = maximum(-dot(gather_vec3(data, k + 13), wi), 1e-9)
    x, y = -dot(gather_vec3(data, k + 7), wi) / z, -dot(gather_vec3(data, k + 10), wi) / z
    there, falloff, spread = brightness_of(scene, index, z, x, y)
    u, v = where(there, 0.5 - 0.5 * x, 0.5), where(there, 0.5 - 0.5 * y, 0.5)
    bright = where(there, falloff * falling / spread, 0.0)
    one = lanes(1.0)
    return LightSample(
        wi=wi,
        distance=distance,
        radiance=where(there, shown(cdf, start, u, v) * bright, lanes_vec3(0.0)),
        pdf=one,
        delta=lanes_mask(True),
        cosine=one,
        error=lanes(0.0),
    )


# ---------------------------------------------------------------- emission


def emission_table(spec: Projector) -> NDArray[np.float32]:
    """Choice of a texel by the light through it, of its neighbours too: they show in it."""
    texels, (half_x, half_y) = _texels(spec).astype(float), tangents(spec)
    height, width = texels.shape[:2]
    bright = np.pad(luminance(Vec3(*np.moveaxis(texels, 2, 0))), 1, mode="edge")
    mean = sum(bright[i : i + height, j : j + width] for i in range(3) for j in range(3)) / 9.0
    if spec.evenness == "intensity":
        x = half_x * (1.0 - 2.0 * (np.arange(width) + 0.5) / width)
        y = half_y * (1.0 - 2.0 * (np.arange(height) + 0.5) / height)
        mean = mean * (1.0 + x * x + (y * y)[:, None]) ** -1.5
    return cumulative(np.ravel(mean))


@kernel
def size_of(scene, index):
    """Texels across and down the picture."""
    cdf, start = scene.lights.cdf, gather(scene.lights.info, index * INFO + 3)
    return to_uint(gather(cdf, start + WIDTH)), to_uint(gather(cdf, start + HEIGHT))


@kernel
def texel_density(scene, index, pmf, z):
    """Density per steradian in a texel of some probability, z: cosine of the direction."""
    data, k = scene.lights.data, index * STRIDE
    width, height = size_of(scene, index)
    # The picture covers 4 tan tan at distance 1, where areas are solid angles over cos^3.
    stretch = length_squared(gather_vec3(data, k + 7)) * length_squared(gather_vec3(data, k + 10))
    return pmf * to_float(width * height) * (0.25 * sqrt(stretch)) / (z * z * z)


@kernel
def emit(scene, index, u2, v2):
    """A ray by the light of the texels; see `alight.lights.model.LightModel`."""
    data, k = scene.lights.data, index * STRIDE
    width, height = size_of(scene, index)
    start = gather(scene.lights.starts, index)
    cell, pmf, _ = sample_discrete(scene.lights.emission, start, width * height, u2[0])
    row = cell // width
    u = (to_float(cell - row * width) + v2[0]) / to_float(width)
    v = (to_float(row) + v2[1]) / to_float(height)
    x, y = 1.0 - 2.0 * u, 1.0 - 2.0 * v
    across, up = gather_vec3(data, k + 7), gather_vec3(data, k + 10)
    axis = gather_vec3(data, k + 13)
    d = axis + (x / length_squared(across)) * across + (y / length_squared(up)) * up
    d = normalize(lanes_vec3(0.0) + d)
    z = dot(axis, d)
    _, falloff, spread = brightness_of(scene, index, z, x, y)
    density = texel_density(scene, index, pmf, z)
    drawn = density > 0.0
    bright = where(drawn, falloff / (spread * where(drawn, density, 1.0)), 0.0)
    first = gather(scene.lights.info, index * INFO + 3)
    flux = shown(scene.lights.cdf, first, u, v) * bright
    return from_point(gather_vec3(data, k + 4), d, flux, density)


@kernel
def emit_pdf(scene, index, d):
    """Density of `emit` per steradian."""
    data, k = scene.lights.data, index * STRIDE
    width, height = size_of(scene, index)
    z = maximum(dot(gather_vec3(data, k + 13), d), 1e-9)
    x, y = dot(gather_vec3(data, k + 7), d) / z, dot(gather_vec3(data, k + 10), d) / z
    there = (x >= -1.0) & (x <= 1.0) & (y >= -1.0) & (y <= 1.0) & (z > 1e-6)
    u, v = where(there, 0.5 - 0.5 * x, 0.5), where(there, 0.5 - 0.5 * y, 0.5)
    column = minimum_u32(to_uint(u * to_float(width)), width - 1)
    row = minimum_u32(to_uint(v * to_float(height)), height - 1)
    start = gather(scene.lights.starts, index)
    pmf = pmf_discrete(scene.lights.emission, start, row * width + column)
    return where(there, texel_density(scene, index, pmf, z), 0.0)
