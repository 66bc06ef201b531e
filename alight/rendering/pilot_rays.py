"""Rays of a pilot that looks for light before the first sample: many at once, in NumPy.

Only the search for what a ray meets is machine code, one small kernel; cameras, materials and
lights are evaluated by the NumPy twin.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from alight.accel.batch import closest_hits
from alight.bsdfs.dielectrics.dispersion import disperses
from alight.bsdfs.dispatch import sample_bsdf
from alight.bsdfs.flags import DELTA, NULL
from alight.bsdfs.switch import refracts, squared_index
from alight.cameras.rays import generate_ray
from alight.compiled.at_times import tables_at
from alight.compiled.scene import CompiledScene
from alight.core.vec import Vec3
from alight.films import CELL_SIZE
from alight.integrators.walk import to_local, to_world
from alight.rendering.pilot_media import Way, beyond, flown, medium_of_camera, transmittance
from alight.shapes.hit import Hit, Surface, spawn_origin
from alight.shapes.surfaces import make_surface
from lanewise.jit import instantiate

#: Points that the camera sees.
POINTS = 256

#: Surfaces of mirrors and clear glass on one way.
MOST_SURFACES = 16

#: Densities of directions from which on a material counts as smooth, per steradian: lamps of half a
#: degree look as sharp in it as they are.
SHARP = 1e4

#: Flights of each of the camera's rays through media: the first that collides tells where, all tell
#: how often.
_FLIGHTS = 8

#: Wavelength at which dispersive glass is evaluated, nanometres.
_GREEN = np.float32(550.0)


class Pilot:
    """A scene as rays of a pilot see it, each at its own time.

    Parameters
    ----------
    scene : CompiledScene
    random : numpy.random.Generator
    tables : optional
        Others than the scene's own.
    """

    def __init__(
        self, scene: CompiledScene, random: np.random.Generator, tables: Any = None
    ) -> None:
        self.scene, self.program, self.random = scene, scene.program, random
        self.tables = scene.tables if tables is None else tables

    def times(self, n: int) -> np.ndarray:
        """Of n rays, from 0 (the shutter opens) to 1; nothing is drawn where nothing moves."""
        if not self.program.motion:
            return np.zeros(n, np.float32)
        return self.random.random(n).astype(np.float32)

    def at(self, times: np.ndarray) -> Any:
        """The tables as rays of these times see them."""
        return tables_at(self.tables, times) if self.program.motion else self.tables

    def twin(self, kernel: Any) -> Any:
        """A kernel for arrays."""
        return np.errstate(all="ignore")(instantiate(kernel, self.program, compiled=False))

    def hits(self, o: Vec3, d: Vec3, times: np.ndarray, end: np.ndarray | None = None) -> Hit:
        """Closest hits; `end`: largest distances, metres."""
        end = np.full(len(times), np.inf, np.float32) if end is None else end
        return closest_hits(self.program, self.at(times), o, d, end)

    def surface(
        self, hit: Hit, o: Vec3, d: Vec3, times: np.ndarray, there: Any = None
    ) -> tuple[Surface, Vec3]:
        """Surfaces that rays meet, and the local directions from which these come."""
        there = np.full(len(times), True) if there is None else there
        surface = self.twin(make_surface)(self.at(times), hit, o, d, there)
        if disperses(self.program):
            surface = surface._replace(wavelength=np.full(len(times), _GREEN))
        return surface, self.twin(to_local)(surface, Vec3(-d.x, -d.y, -d.z))

    def turns(self, surface: Surface, wo: Vec3, times: np.ndarray, there: Any = None) -> Turns:
        """Where samples of the materials go."""
        n = len(times)
        there = np.full(n, True) if there is None else there
        u, *u2 = self.random.random((3, n)).astype(np.float32)
        s = self.twin(sample_bsdf)(self.at(times), surface, wo, u, tuple(u2), there)
        pdf = np.where(there, np.nan_to_num(wide(s.pdf, n).astype(np.float64)), 0.0)
        weight = np.nan_to_num(columns_of(lanes_of(s.weight, n)))
        d, flags = lanes_of(self.twin(to_world)(surface, s.wi), n), wide(s.flags, n)
        squares = np.ones(n)
        if refracts(self.program):
            square = self.twin(squared_index)
            beyond, before = (wide(square(self.at(times), surface, w), n) for w in (s.wi, wo))
            squares = np.where((flags & NULL) == 0, beyond / before.astype(np.float64), 1.0)
        return Turns(d=d, weight=weight, pdf=pdf, flags=flags, squares=squares)

    def leave(self, surface: Surface, d: Vec3) -> Vec3:
        """Where rays along d start at surfaces."""
        o = self.twin(spawn_origin)(surface.p, surface.error, surface.ng, d)
        return lanes_of(o, len(d.x))


class Turns(NamedTuple):
    """Samples of materials: d in the world, weight (n, 3), pdf per steradian, flags.

    `squares` is the square of the index of refraction where a sample goes, over that where it was.
    """

    d: Vec3
    weight: np.ndarray
    pdf: np.ndarray
    flags: np.ndarray
    squares: np.ndarray

    @property
    def reversed_weight(self) -> np.ndarray:
        """The weight of the same way in the other direction, shape (n, 3), where it is sharp.

        Radiance is concentrated in glass (Veach 1997, section 5.2).
        """
        return self.weight * (self.squares**2)[:, None]

    @property
    def spreading(self) -> np.ndarray:
        """By what refraction multiplies the étendue of light that goes this way."""
        return 1.0 / self.squares

    @property
    def holes(self) -> np.ndarray:
        """Straight on through a surface that is not there."""
        return (self.pdf > 0.0) & ((self.flags & NULL) != 0)

    @property
    def sharp(self) -> np.ndarray:
        """By a mirror or clear glass, or what is hardly rougher."""
        delta = (self.flags & DELTA) != 0
        return ~self.holes & (self.pdf > 0.0) & (delta | (self.pdf > SHARP))

    @property
    def passed(self) -> np.ndarray:
        """One or the other."""
        return self.holes | self.sharp

    @property
    def spread(self) -> np.ndarray:
        """Solid angle into which a sharp lobe scatters light, steradians."""
        rough = self.sharp & ((self.flags & DELTA) == 0)
        return np.where(rough, 1.0 / np.where(rough, self.pdf, 1.0), 0.0)


class Seen(NamedTuple):
    """What the camera sees, directly, in mirrors and through glass.

    Attributes
    ----------
    point, cell : (n,) int
        Number of the point of the film, and of its 8x8 pixels in the window.
    hit : Hit
    o, d : Vec3
        The ray that met it.
    weight : (n, 3) float64
        What is left of light from there when it reaches the camera.
    times : (n,) float32
    reached : (n,) float64
        Probability that media let a path come so far.
    turned : (n,) bool
        Whether a mirror, or glass, is on the way.
    """

    point: np.ndarray
    cell: np.ndarray
    hit: Hit
    o: Vec3
    d: Vec3
    weight: np.ndarray
    times: np.ndarray
    reached: np.ndarray
    turned: np.ndarray

    def some(self, rows: np.ndarray) -> Seen:
        """These rows, or those of a mask."""
        return Seen(*(picked(part, rows) for part in self))


class Collided(NamedTuple):
    """Where media scatter light into the rays of the camera.

    Attributes
    ----------
    point, cell, times, reached
        As of `Seen`.
    p : (n, 3) float64
    d : Vec3
        The ray that has collided.
    weight : (n, 3) float64
        What is left of light that is scattered there, times the probability to collide.
    medium : (n,) uint32
        Row of the medium.
    """

    point: np.ndarray
    cell: np.ndarray
    p: np.ndarray
    d: Vec3
    weight: np.ndarray
    times: np.ndarray
    reached: np.ndarray
    medium: np.ndarray

    def some(self, rows: np.ndarray) -> Collided:
        """These rows, or those of a mask."""
        return Collided(*(picked(part, rows) for part in self))


def seen_points(pilot: Pilot) -> tuple[Seen, Collided]:
    """Draw `POINTS` of the film, and follow what is seen there to a surface that scatters light.

    On the way one path of each collides in media, or passes.
    """
    scene, random = pilot.scene, pilot.random
    x, y, w, h = scene.crop or (0, 0, *scene.size)
    at = (x + w * random.random(POINTS), y + h * random.random(POINTS))
    column, line = (
        (a - start).astype(int) // CELL_SIZE for a, start in zip(at, (x, y), strict=True)
    )
    times, middle = pilot.times(POINTS), np.full(POINTS, 0.5, np.float32)
    film = [a.astype(np.float32) for a in at]
    o, d = pilot.twin(generate_ray)(pilot.at(times), *film, (middle, middle))
    o, d = lanes_of(o, POINTS), lanes_of(d, POINTS)
    points, cells = np.arange(POINTS), line * -(-w // CELL_SIZE) + column
    hit = pilot.hits(o, d, times)
    on = Seen(
        point=points,
        cell=cells,
        hit=hit,
        o=o,
        d=d,
        weight=np.ones((POINTS, 3)),
        times=times,
        reached=np.ones(POINTS),
        turned=np.zeros(POINTS, bool),
    )
    found, medium = [], medium_of_camera(pilot, POINTS)
    # Random numbers of their own: surfaces are the same as without media.
    aside = Pilot(scene, np.random.default_rng(1))
    collided = [_collided(aside, on, medium)]
    for _ in range(MOST_SURFACES):
        met = np.isfinite(on.hit.t)
        on, medium = on.some(met), medium[met]
        if not len(on.point):
            break
        left = transmittance(pilot, Way(on.o, on.d, on.hit.t, medium, on.times))
        on = on._replace(weight=on.weight * left, reached=on.reached * left.mean(axis=1))
        surface, wo = pilot.surface(on.hit, on.o, on.d, on.times)
        turns = pilot.turns(surface, wo, on.times)
        passed = turns.passed
        found.append(on.some(~passed))
        o = pilot.leave(surface, turns.d)
        medium = beyond(pilot, surface, turns.d, medium, on.times)[passed]
        on = on._replace(
            o=o, d=turns.d, weight=on.weight * turns.weight, turned=on.turned | turns.sharp
        ).some(passed)
        on = on._replace(hit=pilot.hits(on.o, on.d, on.times))
        collided.append(_collided(aside, on, medium))
    return joined(found) if found else on, joined(collided)


def _collided(pilot: Pilot, on: Seen, medium: np.ndarray) -> Collided:
    """Where the camera's rays collide before their next surface, and how often."""
    way = Way(on.o, on.d, on.hit.t, medium, on.times)
    often, place = np.zeros(len(medium)), np.zeros(len(medium))
    left = np.zeros((len(medium), 3))
    for _ in range(_FLIGHTS if medium.any() else 0):
        flight = flown(pilot, way)
        first = flight.scattered & (often == 0.0)
        place = np.where(first, flight.t, place)
        left = np.where(first[:, None], flight.weight * flight.albedo, left)
        often += flight.scattered / _FLIGHTS
    there = often > 0.0
    on, place, often = on.some(there), place[there, None], often[there]
    return Collided(
        point=on.point,
        cell=on.cell,
        p=columns_of(on.o) + place * columns_of(on.d),
        d=on.d,
        weight=on.weight * left[there] * often[:, None],
        times=on.times,
        reached=on.reached * often,
        medium=medium[there],
    )


# ---------------------------------------------------------------- arrays and vectors of them


def wide(value: Any, n: int) -> np.ndarray:
    """A number of each ray, which twins may give as one for all."""
    return np.ascontiguousarray(np.broadcast_to(value, n))


def lanes_of(v: Vec3, n: int) -> Vec3:
    """The same of a vector, float32."""
    return Vec3(*(wide(c, n).astype(np.float32) for c in (v.x, v.y, v.z)))


def columns_of(v: Vec3) -> np.ndarray:
    """A vector of arrays as (n, 3) float64."""
    return np.stack([v.x, v.y, v.z], axis=1).astype(np.float64)


def dots(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Scalar products of rows (n, 3) and rows, or one vector: ten times as fast as `np.sum`."""
    return a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]


def picked(part: Any, rows: np.ndarray) -> Any:
    """Rows of an array, of a vector of arrays, or of each of a namedtuple."""
    if isinstance(part, np.ndarray):
        return part[rows]
    if isinstance(part, Vec3):
        return Vec3(part.x[rows], part.y[rows], part.z[rows])
    return type(part)(*(picked(a, rows) for a in part))


def joined(parts: Sequence[Any]) -> Any:
    """Arrays, or namedtuples of arrays, one after the other."""
    if isinstance(parts[0], np.ndarray):
        return np.concatenate(parts)
    if isinstance(parts[0], Vec3):
        return Vec3(*(np.concatenate([getattr(v, axis) for v in parts]) for axis in "xyz"))
    return type(parts[0])(*(joined(a) for a in zip(*parts, strict=True)))
