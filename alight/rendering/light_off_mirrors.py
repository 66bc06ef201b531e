r"""Light that mirrors and clear glass throw, which only chance finds: how much there is.

Light sampling does not reach a lamp in a reflector, a spot that a mirror throws on the floor, or a
second matte surface that is lit through a window. So a pilot follows light from the lamps before
the first sample. A light path carries the flux

.. math:: \Phi = L\, T\, G, \qquad G = \frac{|\cos\theta|}{N\, P_i\, p_A\, p_\omega} ,

where T is what surfaces have left of it and G the étendue that it stands for. Where paths that a
mirror or glass has turned arrive within :math:`\pi r^2` around a point that the camera sees (Jensen
1996), they add the radiance :math:`f \Phi / (\pi r^2)`. A path from the camera that is scattered
into the same light brings :math:`f |\cos\theta| L T / p_b`, so it does that with the probability

.. math:: q = \frac{p_b\, G}{|\cos\theta|\, \pi r^2} ,

the quotient of the two. Light of samples of about the same size (a factor of two) counts as one
event, however many light paths have brought it.

Half of the light paths aim at mirrors and clear glass, wherever these are while the shutter is
open; the two ways are combined by the balance heuristic. Light that comes straight on through
glass, from lamp to matte surface, is that of `alight.rendering.light_behind_glass`, and is left
out. Media, and what glass absorbs, are neglected.

Source: Jensen, Global illumination using photon maps, 1996; Veach 1997, section 9.2.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from alight.bsdfs.flags import REFLECTION
from alight.bsdfs.nesting import has_holes
from alight.compiled.casters import boxes_of_casters, is_caster
from alight.core.vec import Vec3
from alight.lights.emission.density import is_kind
from alight.lights.emission.from_environments import line_pdf
from alight.lights.emission.sampling import emission_towards, sample_emission
from alight.rendering.arriving_light import NEAREST, Arrived, all_of, gather
from alight.rendering.light_in_media import Beams, gather_in_media
from alight.rendering.nearby_lamps import with_nearby_lamps
from alight.rendering.pilot_media import medium_around
from alight.rendering.pilot_rays import (
    MOST_SURFACES,
    Pilot,
    columns_of,
    dots,
    lanes_of,
    picked,
    wide,
)
from alight.rendering.sight import Sight
from alight.shapes.hit import INFO

#: Light paths.
PATHS = 2**16

#: Balls around casters at which light paths aim, drawn at random if there are more.
_BALLS = 32

#: Slot of a shape's material in `ShapeTables.info`.
_BSDF = 1


class _Light(NamedTuple):
    """Light paths on their way.

    Attributes
    ----------
    o, d : Vec3
    radiance : (n, 3) float64
        L T.
    share : (n,) float64
        G, and more where a lobe that is not quite smooth has spread it, m^2 sr.
    angle : (n,) float64
        Solid angle of the lamp from the first surface is this over the square of the way, or this
        where the way is infinite, steradians.
    far, turned, aside : (n,) bool
        Whether it comes from infinity; a mirror or glass has turned it; since then something has,
        or a mirror did it.
    times : (n,) float32
    """

    o: Vec3
    d: Vec3
    radiance: np.ndarray
    share: np.ndarray
    angle: np.ndarray
    far: np.ndarray
    turned: np.ndarray
    aside: np.ndarray
    times: np.ndarray

    def some(self, rows: np.ndarray) -> _Light:
        return _Light(*(picked(part, rows) for part in self))


def light_off_mirrors(sight: Sight, random: np.random.Generator) -> np.ndarray:
    """Look for it where the camera sees something: rows of `light_behind_glass`."""
    nothing, flat, scene = np.zeros((0, 7)), sight.flat, sight.scene
    seen, collided = sight.seen, sight.collided
    if not any(is_caster(bsdf) for bsdf in flat.bsdfs) or not len(seen.point) + len(collided.point):
        return nothing
    if sight.lights is None:
        return nothing
    pilot = Pilot(scene, random, scene.tables._replace(lights=sight.lights))
    pilot = with_nearby_lamps(pilot, seen)
    light = _set_out(pilot, boxes_of_casters(flat))
    casts = np.array([is_caster(bsdf) or has_holes(bsdf, {}) for bsdf in flat.bsdfs])
    arrived, beams = _follow(pilot, light, casts)
    with np.errstate(all="ignore"):
        table = gather_in_media(pilot, collided, beams)
    if len(arrived.share) >= NEAREST and len(seen.point):
        table = np.concatenate([gather(pilot, seen, arrived), table])
    return table


# ---------------------------------------------------------------- from the lamps


def _set_out(pilot: Pilot, boxes: np.ndarray) -> _Light:
    """Begin light paths; every second one aims at a ball around a caster, if there is one."""
    n, random = PATHS, pilot.random
    times = pilot.times(n)
    tables, twin = pilot.at(times), pilot.twin
    u, ux, uy, vx, vy = random.random((5, n)).astype(np.float32)
    e = twin(sample_emission)(tables, u, (ux, uy), (vx, vy))
    index, choice = wide(e.light, n), wide(e.choice, n).astype(np.float64)
    around = wide(twin(is_kind)(tables, index)[2], n)
    p, d = columns_of(lanes_of(e.p, n)), columns_of(lanes_of(e.d, n))
    o, flux = columns_of(lanes_of(e.o, n)), columns_of(lanes_of(e.flux, n))
    normal = columns_of(lanes_of(e.n, n))
    pdf_d, pdf_p = (wide(a, n).astype(np.float64) for a in (e.pdf_direction, e.pdf_position))
    sized = ~wide(e.delta_position, n) & ~wide(e.delta_direction, n) & (pdf_d * pdf_p > 0.0)
    drawn = np.where(sized, pdf_d * pdf_p * choice, 1.0)
    cosine = np.where(around, 1.0, dots(normal, d))
    radiance = flux * (drawn / np.where(cosine > 0.0, cosine, np.inf))[:, None]
    balls = _balls(boxes, random)
    aims = (np.arange(n) % 2 == 1) & sized if len(balls) else np.zeros(n, bool)
    if aims.any():
        rows = np.flatnonzero(aims)
        q = _towards(balls, p[rows], d[rows], around[rows], random)
        far = around[rows]
        p[rows] = np.where(far[:, None], q, p[rows])
        d[rows] = np.where(far[:, None], d[rows], q)
        ends = Vec3(*(p[rows] + d[rows]).astype(np.float32).T)
        given = (u[rows], (ux[rows], uy[rows]), ends)
        sent, start = twin(emission_towards)(pilot.at(times[rows]), index[rows], *given)
        # Intensity is over the probabilities: L cos / (P p_A).
        cosine[rows] = np.where(far, 1.0, dots(normal[rows], d[rows]))
        per = np.where(cosine[rows] > 0.0, choice[rows] * pdf_p[rows] / cosine[rows], 0.0)
        from_shape = columns_of(lanes_of(sent, len(rows))) * per[:, None]
        radiance[rows] = np.where(far[:, None], radiance[rows], from_shape)
        o[rows] = np.where(far[:, None], p[rows], columns_of(lanes_of(start, len(rows))))
    density = _density(pilot, balls, p, d, around, pdf_p, pdf_d, cosine, times)
    good = sized & (density > 0.0) & (cosine > 0.0) & (radiance > 0.0).any(axis=1)
    share = cosine / np.where(good, density * choice * n, 1.0)
    angle = np.where(around, 1.0 / np.maximum(pdf_d, 1e-30), cosine / np.maximum(pdf_p, 1e-30))
    never = np.zeros(n, bool)
    o, d = (Vec3(*a.astype(np.float32).T.copy()) for a in (o, d))
    light = _Light(
        o=o,
        d=d,
        radiance=radiance,
        share=share,
        angle=angle,
        far=around,
        turned=never,
        aside=never,
        times=times,
    )
    return light.some(good)


def _balls(boxes: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Balls around boxes, (n, 4): middle and radius, metres."""
    rows = random.permutation(len(boxes))[:_BALLS]
    low, high = boxes[rows, :3], boxes[rows, 3:]
    return np.column_stack([(low + high) / 2, np.linalg.norm(high - low, axis=1) / 2])


def _towards(
    balls: np.ndarray, p: np.ndarray, d: np.ndarray, far: np.ndarray, random: np.random.Generator
) -> np.ndarray:
    """Directions from p into a ball's cone; of light from afar, places from which it meets one."""
    n = len(p)
    ball = balls[random.integers(len(balls), size=n)]
    way = ball[:, :3] - p
    distance = np.sqrt(dots(way, way))
    least = _cosine_of_cone(distance, ball[:, 3])
    u, v = random.random((2, n))
    axis = np.where(far[:, None], d, way / np.maximum(distance, 1e-30)[:, None])
    aside = np.where(np.abs(axis[:, :1]) > 0.7, [[0.0, 1.0, 0.0]], [[1.0, 0.0, 0.0]])
    s = np.cross(axis, aside)
    s /= np.sqrt(dots(s, s))[:, None]
    t = np.cross(axis, s)
    across = np.cos(2 * np.pi * v)[:, None] * s + np.sin(2 * np.pi * v)[:, None] * t
    z = 1.0 - u * (1.0 - least)
    cone = z[:, None] * axis + np.sqrt(np.maximum(1.0 - z * z, 0.0))[:, None] * across
    # Back along the ray as far as the point was before.
    back = dots(p - ball[:, :3], d)[:, None] * d
    line = ball[:, :3] + (ball[:, 3] * np.sqrt(u))[:, None] * across + back
    return np.where(far[:, None], line, cone)


def _cosine_of_cone(distance: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """Of the half angle under which balls are seen; -1 from inside."""
    square = 1.0 - (radius / np.maximum(distance, 1e-30)) ** 2
    return np.where(square > 0.0, np.sqrt(np.maximum(square, 0.0)), -1.0)


def _density(pilot, balls, p, d, around, pdf_p, pdf_d, cosine, times) -> np.ndarray:
    """Of place and direction, given the lamp, of both ways to draw them."""
    # A place that has moved has another density.
    rows = Vec3(*p.astype(np.float32).T), Vec3(*d.astype(np.float32).T)
    line = wide(pilot.twin(line_pdf)(pilot.at(times), *rows), len(p)) if around.any() else pdf_p
    plain_p, plain_d = np.where(around, line, pdf_p), np.where(around, pdf_d, cosine / np.pi)
    if not len(balls):
        return plain_p * plain_d
    aimed = np.zeros(len(p))
    for ball in balls:
        way = ball[:3] - p
        distance = np.sqrt(dots(way, way))
        along = dots(way, d)
        off = np.maximum(distance**2 - along**2, 0.0)
        least = _cosine_of_cone(distance, ball[3])
        in_cone = along >= least * distance
        cone = in_cone / np.maximum(2 * np.pi * (1.0 - least), 1e-30)
        line = (off <= ball[3] ** 2) / max(np.pi * ball[3] ** 2, 1e-30)
        aimed += np.where(around, line, cone) / len(balls)
    other = np.where(around, pdf_d, pdf_p) * aimed
    return 0.5 * plain_p * plain_d + 0.5 * other


# ---------------------------------------------------------------- to what they light


def _follow(pilot: Pilot, light: _Light, casts: np.ndarray) -> tuple[Arrived, list[Beams]]:
    """Where light arrives that a mirror or glass has turned, and its ways in media."""
    bsdf_of, found, beams = pilot.tables.shapes.info.array[_BSDF::INFO], [], []
    for _ in range(MOST_SURFACES):
        hit = pilot.hits(light.o, light.d, light.times)
        if pilot.program.media:
            beams.append(_beams(pilot, light.some(light.turned), hit.t[light.turned]))
        # Light that nothing has turned yet is found by light sampling where it meets what is matte.
        met = np.isfinite(hit.t) & (light.turned | casts[bsdf_of[hit.shape]])
        light, hit = light.some(met), picked(hit, met)
        n = len(light.share)
        if not n:
            break
        surface, wl = pilot.surface(hit, light.o, light.d, light.times)
        turns = pilot.turns(surface, wl, light.times)
        p, normal = (columns_of(lanes_of(v, n)) for v in (surface.p, surface.ns))
        here = Arrived(p, normal, -columns_of(light.d), light.radiance, light.share)
        found.append(picked(here, light.aside))
        sharp, passed = turns.sharp, turns.passed
        angle = light.angle / np.where(light.far, 1.0, hit.t.astype(np.float64) ** 2)
        wider = np.where(sharp & ~light.turned, 1.0 + turns.spread / np.maximum(angle, 1e-30), 1.0)
        reflected = sharp & ((turns.flags & REFLECTION) != 0)
        light = light._replace(
            o=pilot.leave(surface, turns.d),
            d=turns.d,
            radiance=light.radiance * turns.reversed_weight,
            share=light.share * wider * turns.spreading,
            turned=light.turned | sharp,
            aside=light.aside | reflected | (light.turned & ~passed),
        ).some((turns.pdf > 0.0) & (passed | light.turned))
    return all_of(found), beams


def _beams(pilot: Pilot, light: _Light, length: np.ndarray) -> Beams:
    medium = medium_around(pilot, light.o, light.d, light.times)
    found = Beams(
        o=light.o,
        d=light.d,
        length=length,
        radiance=light.radiance,
        share=light.share,
        medium=medium,
        times=light.times,
    )
    return picked(found, medium != 0)
