r"""Medium on a grid: its density is interpolated between the centres of cells.

.. math:: \sigma_t(x) = \sigma_t\, \rho(x), \qquad \rho(x) \le \bar\rho

Distances are chosen by delta tracking: as if the density were :math:`\bar\rho` everywhere, where
each collision is real with probability :math:`\rho / \bar\rho`, and else nothing happens. Shadow
rays multiply :math:`1 - \rho / \bar\rho` at the same kind of places (ratio tracking). The channel
that chooses the distances is one of three; what the others would have done is carried along.

Outside of its box the density is 0.

Source: Woodcock et al., Techniques used in the GEM code, ANL-7050 (1965); Novak, Selle and Jarosz,
Residual ratio tracking, SIGGRAPH Asia 2014; Miller, Georgiev and Jarosz, A null-scattering path
integral formulation of light transport, SIGGRAPH 2019; PBR4 section 11.2.1 and 14.2.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import model_validator

from alight.core.field_types import Triple, Vector3
from alight.core.fields import Interval, Numbers, invalid
from alight.core.maths import log
from alight.core.vec import gather_vec3
from alight.media.coefficients import Coefficients, extinction
from alight.media.tables import (
    ALBEDO,
    ALBEDOS,
    DENSITIES,
    EMISSIONS,
    EXTINCTION,
    FARTHEST,
    LARGEST,
    MATRIX,
    STRIDE,
    Crossing,
    Flight,
    decay,
    pick,
    share,
    step_numbers,
)
from alight.media.volumes import Values
from alight.media.voxels import color_at, density, into_cube
from alight.phases import FORWARD
from lanewise.jit import kernel
from lanewise.simd import (
    any_lane,
    gather,
    lanes,
    lanes_mask,
    lanes_u32,
    lanes_vec3,
    maximum,
    minimum,
    where,
)

#: Mean free paths across a grid at most: a ray takes a step at each, through empty cells too.
MOST_STEPS = 1e4

#: Shadow rays dimmer than this are ended at random, three of four.
DIM, KEPT = 0.05, 0.25


class Grid(Coefficients):
    """Density on a grid.

    Parameters
    ----------
    file : str, optional
        Densities: NPY of shape (nz, ny, nx), VOL of Mitsuba, or ``builtin:cloud``.
    values : (nz, ny, nx) array, optional
        The densities themselves, factors of the coefficients.
    albedo_values : (nz, ny, nx) or (nz, ny, nx, 3) array, optional
        In the place of `albedo`, interpolated too; each in [0, 1].
    emission_values : (nz, ny, nx) or (nz, ny, nx, 3) array, optional
        In the place of `emission`, interpolated too.
    low, high : Vector3, m, defaults (0, 0, 0) and (1, 1, 1)
        Corners of the box in the world.
    matrix : (12,) float, optional
        Three rows of four, instead of both: from the unit cube to the world.
    """

    has_place: ClassVar[bool] = True
    type: Literal["grid"] = "grid"
    file: str | None = None
    values: Values | None = None
    albedo_values: Values | None = None
    emission_values: Values | None = None

    @property
    def largest_emission(self) -> float:
        """Of all channels and places."""
        values = self.emission_values
        return max(self.emission) if values is None else float(values.values.max())

    def shining(self, emission: Triple) -> Self:
        """The same with this emission everywhere."""
        return self.replaced(emission=emission, emission_values=None)

    def moved(self, shift: np.ndarray) -> Self:
        """The same in another place."""
        matrix = to_world(self)[:3]
        matrix[:, 3] += shift
        return self.replaced(matrix=tuple(matrix.ravel().tolist()))

    low: Vector3 = (0.0, 0.0, 0.0)
    high: Vector3 = (1.0, 1.0, 1.0)
    matrix: Annotated[tuple[float, ...], Numbers(12, Interval())] | None = None

    @model_validator(mode="after")
    def _is_a_box_of_densities(self) -> Self:
        if (self.file is None) == (self.values is None):
            raise invalid("needs a file, or values" + (", got both" if self.file else ""))
        if any(a >= b for a, b in zip(self.low, self.high, strict=True)):
            raise invalid(f"low must lie below high, got {list(self.low)} and {list(self.high)}")
        if abs(np.linalg.det(to_world(self)[:3, :3])) < 1e-30:
            raise invalid("matrix is singular: it flattens space")
        if self.values is not None and self.values.values.shape[3] != 1:
            raise invalid("values: must have one number a cell, got 3")
        if self.albedo_values is not None and self.albedo_values.values.max() > 1.0:
            text = f"must be in [0, 1], got {self.albedo_values.values.max():g}"
            raise invalid(f"albedo_values: {text}")
        return self

    def problem(self) -> str | None:
        """Say that tracking would take too long: it makes a step at every mean free path."""
        assert self.values is not None
        diagonal = float(np.linalg.norm(to_world(self)[:3, :3].sum(axis=1)))
        thickest = float(self.values.values.max()) * max(extinction(self)) * diagonal
        if thickest <= MOST_STEPS:
            return None
        return (
            "the largest extinction times the diagonal of the box must be at most "
            f"{MOST_STEPS:g}, the steps that a ray may take, got {thickest:.3g}: make sigma_t or "
            "scale smaller"
        )


def to_world(spec: Grid) -> np.ndarray:
    """The (4, 4) matrix from the unit cube to the world."""
    result = np.eye(4)
    if spec.matrix is not None:
        result[:3] = np.reshape(spec.matrix, (3, 4))
    else:
        result[:3, :3] = np.diag(np.subtract(spec.high, spec.low))
        result[:3, 3] = spec.low
    return result


_STEP = np.arange(24.0).reshape(2, 3, 4) / 23.0

EXAMPLES = (
    Grid(values=_STEP),
    Grid(values=_STEP, sigma_t=(4.0, 2.0, 1.0), albedo=0.9, phase=FORWARD.replaced(g=0.6)),
    Grid(values=_STEP, albedo_values=_STEP[..., None] * [1.0, 0.5, 0.0], low=(-1.0, 0.0, 0.0)),
    Grid(values=_STEP, albedo=0.2, emission_values=_STEP[..., None] * [3.0, 1.0, 0.0]),
)


def pack(spec: Grid, packer) -> None:
    """The densities, what else varies, and the matrix from the world to the unit cube."""
    assert spec.values is not None
    packer.grid(DENSITIES, spec.values.values)
    packer.data[LARGEST] = spec.values.values.max()
    packer.data[MATRIX : MATRIX + 12] = np.linalg.inv(to_world(spec))[:3].ravel()
    for word, volume in ((ALBEDOS, spec.albedo_values), (EMISSIONS, spec.emission_values)):
        if volume is not None:
            packer.grid(word, np.broadcast_to(volume.values, (*volume.values.shape[:3], 3)))
            packer.info[word] += 1


def density_at(spec: Grid, points: np.ndarray) -> np.ndarray:
    """Density at points (n, 3) of the world: 0 outside of the box."""
    assert spec.values is not None
    inverse = np.linalg.inv(to_world(spec))
    p = points @ inverse[:3, :3].T + inverse[:3, 3]
    values = np.asarray(spec.values.values, float)[..., 0]
    count = np.array(values.shape[::-1])
    at = np.clip(p * count - 0.5, 0.0, count - 1.0)
    first = at.astype(int)
    found = np.zeros(len(p))
    for corner in np.ndindex(2, 2, 2):
        i, j, k = np.minimum(first + corner, count - 1).T
        weight = np.where(corner, at - first, 1.0 - (at - first)).prod(axis=1)
        found += weight * values[k, j, i]
    return np.where(((p >= 0.0) & (p <= 1.0)).all(axis=1), found, 0.0)


# ---------------------------------------------------------------- tracking


@kernel
def _slab(o, d, near, far):
    """Distances within 0 <= o + t d <= 1, cut out of [near, far]."""
    inverse = 1.0 / where(d == 0.0, 1e-30, d)
    a, b = -o * inverse, (1.0 - o) * inverse
    return maximum(near, minimum(a, b)), minimum(far, maximum(a, b))


@kernel
def _inside(o, d, t_max):
    """The part of a ray in the unit cube; empty if the first number is not the smaller one."""
    near, far = _slab(o.x, d.x, lanes(0.0), minimum(t_max, FARTHEST))
    near, far = _slab(o.y, d.y, near, far)
    return _slab(o.z, d.z, near, far)


#: What stays the same on the way of a ray: the ray in the unit cube, its end, extinctions of the
#: channels where the density is 1, rate of collisions in the one that chose, and reciprocals.
_Way = namedtuple("_Way", "o d end thickness largest rate ratio per_rate per_largest")


@kernel
def _enter(scene, segment, active):
    """The `_Way` of rays, where it begins, and the mask of those that get there."""
    medium = segment.medium
    thickness = gather_vec3(scene.media.data, medium * STRIDE + EXTINCTION)
    largest = gather(scene.media.data, medium * STRIDE + LARGEST)
    chosen = pick(thickness, segment.channel)
    rate, ratio = chosen * largest, share(thickness, chosen)
    per_rate, per_largest = 1.0 / maximum(rate, 1e-30), 1.0 / maximum(largest, 1e-30)
    og, dg = into_cube(scene, medium, segment.o, 1.0), into_cube(scene, medium, segment.d, 0.0)
    t, end = _inside(og, dg, segment.length)
    way = _Way(
        o=og,
        d=dg,
        end=end,
        thickness=thickness,
        largest=largest,
        rate=rate,
        ratio=ratio,
        per_rate=per_rate,
        per_largest=per_largest,
    )
    return way, t, active & (t < end)


@kernel
def _collide(scene, medium, way, t, v, going):
    """To the next collision, or to the end: (mask of collisions, t, part that is real, change).

    `change`: densities of this in the three channels, over that in the one that chose.
    """
    there = t - log(1.0 - v) * way.per_rate
    inside = going & (there < way.end) & (way.rate > 0.0)
    reached = where(inside, there, way.end)
    real = density(scene, medium, way.o + reached * way.d) * way.per_largest
    change = decay(way.thickness * way.largest, way.rate, reached - t)
    return inside, reached, real, where(inside, change * way.ratio, change)


@kernel
def fly(scene, segment, u, active):
    """A `Flight` to the surface at the end of a `Segment`."""
    way, t, going = _enter(scene, segment, active)
    scattered, step = lanes_mask(False), lanes_u32(0)
    factor, light = lanes_vec3(1.0), lanes_vec3(1.0)
    while any_lane(going):
        v, w = step_numbers(segment.stream, step)
        inside, reached, real, change = _collide(scene, segment.medium, way, t, v, going)
        collides = inside & (w < real)
        null = inside & ~collides
        factor = where(going, factor * change, factor)
        # A collision that does nothing had the probability 1 - real; light sampling has no choice.
        light = where(going, light * change * where(null, 1.0 / (1.0 - real), 1.0), light)
        scattered = scattered | collides
        t = where(going, reached, t)
        going = null
        step = step + 1
    albedo = color_at(scene, segment.medium, ALBEDO, ALBEDOS, way.o + t * way.d)
    return Flight(scattered, where(scattered, t, segment.length), factor, light, albedo)


@kernel
def cross(scene, segment, active):
    """A `Crossing` along the `Segment` of a shadow ray."""
    way, t, going = _enter(scene, segment, active)
    light, passed, weight, step = lanes_vec3(1.0), lanes(1.0), lanes(1.0), lanes_u32(0)
    while any_lane(going):
        v, w = step_numbers(segment.stream, step)
        inside, reached, real, change = _collide(scene, segment.medium, way, t, v, going)
        light = where(going, light * change, light)
        passed = where(inside, passed * maximum(1.0 - real, 0.0), passed)
        dim = inside & (passed * weight < DIM)
        kept = w < KEPT
        weight = where(dim & kept, weight * (1.0 / KEPT), weight)
        passed = where(dim & ~kept, 0.0, passed)
        t = where(going, reached, t)
        going = inside & (passed > 0.0)
        step = step + 1
    return Crossing(light * passed, light, weight)
