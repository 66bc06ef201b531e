r"""Light that arrives through clear glass alone, which only chance finds: how much there is.

Smooth glass bends light to a direction of its own, so light sampling finds it blocked: a lamp in a
bulb, the sun behind a window pane. It is met by paths that happen to be scattered towards it. Until
one is, no sample tells of it, and neither does the indicator of unseen light.

So a pilot looks for it before the first sample. From points that the camera sees it draws
directions as light sampling does, and follows them straight on through glass. A light of radiance L
that is met behind glass, and would be drawn with density :math:`p_l` given that it is chosen, takes
up a solid angle of about :math:`1 / p_l`. A path is scattered into that with probability

.. math:: q = \min(1, p_b / p_l) ,

and brings :math:`f L |\cos\theta| / (p_l \, P(\text{chosen}))` on average. Among n samples none
meets it with probability :math:`(1 - q)^n \approx e^{-n q}`: so much of it is to be expected as
missing.

Holes and `null` are passed with the probability that they are open. So is glass that is not quite
smooth, where a sample of its material is: it spreads light, and q is the larger for that. But the
way stays straight, and clear glass mirrors nothing; how large and how bright it shows a lamp, three
refracted rays tell. What comes by way of mirrors, or from a second matte surface, is looked for by
paths from the lamps (`alight.rendering.light_off_mirrors`). The pilot tells whether such light
matters, not exactly how much of it there is.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from alight.bsdfs.dispatch import evaluate_bsdf
from alight.bsdfs.flags import TRANSMISSION
from alight.bsdfs.nesting import find_transmissive
from alight.bsdfs.switch import refracts, squared_index
from alight.compiled.casters import is_caster
from alight.compiled.scene import CompiledScene
from alight.core.spec import Bsdf
from alight.core.vec import Vec3
from alight.integrators.direct_light import lit_side
from alight.integrators.walk import to_local, to_world
from alight.lights.choice import choose_light
from alight.lights.sampling import sample_light, shadow_ray
from alight.rendering.light_off_mirrors import light_off_mirrors
from alight.rendering.pilot_rays import (
    MOST_SURFACES,
    Pilot,
    Seen,
    columns_of,
    dots,
    lanes_of,
    picked,
    wide,
)
from alight.rendering.sight import Sight
from alight.shapes.hit import INFO

#: Directions to lights from each point that the camera sees.
DIRECTIONS = 4

#: Rays that tell how glass shows a lamp are this part of its angle apart, and no more radians.
_STEP = 0.02

#: Largest magnification that they are believed, as a quotient of solid angles.
_MOST = 100.0

#: Slot of a shape's material in `ShapeTables.info`.
_BSDF = 1

#: A new ray starts so far behind the surface that it has passed, as a share of its way so far.
_BEYOND = np.float32(1e-4)


def is_looked_for(bsdfs: Sequence[Bsdf], scene: CompiledScene) -> bool:
    """Whether paths of a scene may have to find light behind glass or off mirrors by chance.

    Where nothing but chance finds light, this says nothing new (`Film.by_chance`). Paths from lamps
    and walks along mirrors and glass do find it.
    """
    integrator = scene.integrator
    samples = integrator.needs_light and not integrator.finds_light_by_chance
    aims = integrator.splats or integrator.aims_at_lamps
    lit = bool(scene.program.lights) and samples and not aims
    return lit and any(is_caster(b) or find_transmissive(b, {}) is not None for b in bsdfs)


def light_behind_glass(sight: Sight) -> np.ndarray | None:
    """Look for it, and for light off mirrors, the same way whatever the seed of the picture.

    Returns
    -------
    (n, 7) float64, or None where there is none
        A row is what a point of the picture sees in one direction: numbers of the point and of its
        8x8 pixels of the window, radiance that it adds to the picture (linear RGB), the
        probability q of a sample to find it, and the row's part r in the probability of all such
        light: the radiance over r is what a sample brings that has found it.
    """
    flat, scene = sight.flat, sight.scene
    if not is_looked_for(flat.bsdfs, scene):
        return None
    seen, random = sight.seen, sight.random()
    parts = [light_off_mirrors(sight, random)]
    glass = np.array([find_transmissive(bsdf, {}) is not None for bsdf in flat.bsdfs])
    if len(seen.point) and glass.any():
        clear = glass & np.array([is_caster(bsdf) for bsdf in flat.bsdfs])
        rows = seen.some(np.repeat(np.arange(len(seen.point)), DIRECTIONS))
        found, q, part = _arriving(Pilot(scene, random), clear, rows)
        radiance = found * rows.weight / DIRECTIONS
        q, part = q * rows.reached, part * rows.reached
        parts.append(np.column_stack([rows.point, rows.cell, radiance, q, part / DIRECTIONS]))
    table = np.concatenate(parts)
    table = table[(table[:, 2:5] > 0.0).any(axis=1)]
    return table if len(table) else None


def _arriving(
    pilot: Pilot, clear: np.ndarray, seen: Seen
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """For a direction to a light at each point.

    Returns
    -------
    radiance : (n, 3) float
        That comes through glass.
    q : (n,) float
        Probability of a sample to find this light.
    part : (n,) float
        q over the probability with which this light was chosen: its mean is that of all lights.
    """
    n, tables, twin = len(seen.point), pilot.at(seen.times), pilot.twin
    there = np.full(n, True)
    surface, wo = pilot.surface(seen.hit, seen.o, seen.d, seen.times)
    side = twin(lit_side)(tables, surface, wo)
    u, *u2 = pilot.random.random((3, n)).astype(np.float32)
    choice = twin(choose_light)(tables, surface.p, side, u, tuple(u2), there)
    light = twin(sample_light)(tables, surface.p, side, u, tuple(u2), there)
    wi = twin(to_local)(surface, light.wi)
    f_cos, density = twin(evaluate_bsdf)(tables, surface, wo, wi, there)
    start, length = twin(shadow_ray)(surface, light)
    start, towards, length = lanes_of(start, n), lanes_of(light.wi, n), wide(length, n)
    through, spread = _through(pilot, clear, start, towards, length, seen.times)
    wider, index = np.ones(n), np.ones(n)
    if through.any() and refracts(pilot.program):
        rows = np.flatnonzero(through)
        bundle = picked(start, rows), picked(towards, rows)
        size = 1.0 / np.sqrt(np.maximum(wide(light.pdf, n)[rows].astype(np.float64), 1e-30))
        # Rays that meet nothing, or are mirrored, are no numbers.
        with np.errstate(all="ignore"):
            wider[rows], index[rows] = _magnified(
                pilot, *bundle, length[rows], size, seen.times[rows]
            )
    pdf = wide(light.pdf, n).astype(np.float64)
    lit = through & (pdf > 0.0) & ~wide(light.delta, n)
    value = columns_of(lanes_of(f_cos, n)) * columns_of(lanes_of(light.radiance, n))
    safe = np.where(lit, pdf, 1.0)
    radiance = np.where(lit[:, None], value * (wider / index / safe)[:, None], 0.0)
    chosen = wide(choice.mis_pmf, n).astype(np.float64)
    seen_as = wider * chosen / safe + spread
    q = np.where(lit, np.nan_to_num(np.minimum(wide(density, n) * seen_as, 1.0)), 0.0)
    return np.nan_to_num(radiance), q, q / np.where(chosen > 0.0, chosen, 1.0)


def _through(
    pilot: Pilot, clear: np.ndarray, o: Vec3, d: Vec3, end: np.ndarray, times: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Straight on through clear glass, and where a sample of the material passes sharply.

    What is clear lets light on at any angle: the way that light really takes is another one.

    Returns
    -------
    glass : (n,) bool
        Whether light reaches the end, and was refracted on the way.
    spread : (n,) float
        Solid angle into which glass that is not quite smooth has scattered it.
    """
    n = len(end)
    glass, spread, going = np.zeros(n, bool), np.zeros(n), np.full(n, True)
    hit = pilot.hits(o, d, times, end)
    bsdf_of = pilot.tables.shapes.info.array[_BSDF::INFO]
    for _ in range(MOST_SURFACES):
        met = going & np.isfinite(hit.t)
        surface, wo = pilot.surface(hit, o, d, times, met)
        turns = pilot.turns(surface, wo, times, met)
        smooth = clear[bsdf_of[hit.shape]]
        on = turns.sharp & ((turns.flags & TRANSMISSION) != 0) & (turns.spread > 0.0)
        bent = ~turns.holes & (smooth | on)
        passed = met & (turns.pdf > 0.0) & (turns.holes | bent)
        if not passed.any():
            break
        # What has stopped a ray is not tested again.
        going = passed
        glass |= passed & bent
        spread += np.where(passed & ~smooth, turns.spread, 0.0)
        step = np.where(passed, hit.t * (1 + _BEYOND), 0.0).astype(np.float32)
        o = Vec3(o.x + step * d.x, o.y + step * d.y, o.z + step * d.z)
        end = end - step
        hit = pilot.hits(o, d, times, end)
    return glass & ~np.isfinite(hit.t), spread


def _magnified(
    pilot: Pilot,
    o: Vec3,
    d: Vec3,
    way: np.ndarray,
    size: np.ndarray,
    times: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """How glass shows lamps: three rays close together, refracted, tell what it does to angles.

    Parameters
    ----------
    o, d, way
        Straight on to the lamp.
    size : (n,) float64
        Angle of the lamp, radians.
    times : (n,) float32

    Returns
    -------
    wider : (n,) float64
        Solid angle of the image over that of the lamp seen straight; 1 where rays do not arrive.
    index : (n,) float64
        Square of the index of refraction at the lamp, over that at o: radiance falls by it.

    Notes
    -----
    The rays are those of Igehy, Tracing ray differentials, SIGGRAPH 1999, by differences.
    """
    n, far = len(way), ~np.isfinite(way)
    step = np.minimum(_STEP * size, _STEP)
    axis, length = columns_of(d), np.where(far, 1.0, way.astype(np.float64))
    lamp = columns_of(o) + length[:, None] * axis
    aside = np.where(np.abs(axis[:, :1]) > 0.7, [[0.0, 1.0, 0.0]], [[1.0, 0.0, 0.0]])
    s = np.cross(axis, aside)
    s *= (step / np.sqrt(dots(s, s)))[:, None]
    bundle = np.concatenate([axis, axis + s, axis + np.cross(axis, s)])
    bundle /= np.sqrt(dots(bundle, bundle))[:, None]
    starts = Vec3(*np.tile(columns_of(o), (3, 1)).astype(np.float32).T.copy())
    goal = np.where(far[:, None], np.inf, lamp)
    p, along, index = _refracted(pilot, starts, bundle, np.tile(goal, (3, 1)), np.tile(times, 3))
    p, along = p.reshape(3, n, 3), along.reshape(3, n, 3)
    # Where they cross the plane of the lamp; what comes from afar is a matter of directions.
    left = dots(lamp - p, along[0]) / dots(along, along[0])
    ends = np.where(far[:, None], along, p + left[..., None] * along)
    cross = np.cross(ends[1] - ends[0], ends[2] - ends[0])
    wider = np.nan_to_num((step * length) ** 2 / np.sqrt(dots(cross, cross)))
    same = np.ptp(index.reshape(3, n), axis=0) < 1e-3 * index[:n]
    # The ray in the middle may pass a lens straight on.
    bent = (along != bundle.reshape(3, n, 3)).any(axis=(0, 2)) | (index[:n] != 1.0)
    good = bent & same & (wider > 1.0 / _MOST) & (wider < _MOST) & (far | (left > 0.0).all(axis=0))
    return np.where(good, wider, 1.0), np.where(good, index[:n], 1.0)


def _refracted(
    pilot: Pilot, o: Vec3, d: np.ndarray, goal: np.ndarray, times: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rays through all surfaces before they are as far as their goal, (n, 3), infinite or a point.

    Returns
    -------
    p, d : (n, 3) float64
        Where rays start behind the last of these surfaces, and where they go.
    index : (n,) float64
        Square of the index of refraction there, over that at o.
    """
    n, index = len(times), np.ones(len(times))
    square, tables = pilot.twin(squared_index), pilot.at(times)
    for _ in range(MOST_SURFACES):
        ray = Vec3(*d.astype(np.float32).T.copy())
        hit = pilot.hits(o, ray, times)
        with np.errstate(invalid="ignore"):
            left = np.where(np.isinf(goal[:, 0]), np.inf, dots(goal - columns_of(o), d))
        met = np.isfinite(hit.t) & (hit.t < left)
        if not met.any():
            break
        surface, wo = pilot.surface(hit, o, ray, times, met)
        wo = lanes_of(wo, n)
        before, beyond = (
            wide(square(tables, surface, w), n).astype(np.float64)
            for w in (wo, Vec3(-wo.x, -wo.y, -wo.z))
        )
        ratio = np.sqrt(before / beyond)
        cosine = np.sqrt(np.maximum(1.0 - ratio**2 * (1.0 - wo.z.astype(np.float64) ** 2), 0.0))
        turned = np.stack([-wo.x * ratio, -wo.y * ratio, -np.sign(wo.z) * cosine])
        wi = pilot.twin(to_world)(surface, Vec3(*turned.astype(np.float32)))
        on = met & (ratio != 1.0)
        d = np.where(on[:, None], columns_of(lanes_of(wi, n)), d)
        index = np.where(met, index * beyond / before, index)
        ahead = pilot.leave(surface, Vec3(*d.astype(np.float32).T.copy()))
        places = np.where(met[:, None], columns_of(ahead), columns_of(o))
        o = Vec3(*places.astype(np.float32).T.copy())
    return columns_of(o), d, index
