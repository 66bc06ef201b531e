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
way stays straight, clear glass mirrors nothing, and nothing is looked for by way of mirrors, or
beyond the first matte surface: the pilot tells whether such light matters, not how much of it there
is.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from alight.accel.batch import closest_hits
from alight.bsdfs.dielectrics.dispersion import disperses
from alight.bsdfs.dispatch import evaluate_bsdf, sample_bsdf
from alight.bsdfs.flags import DELTA, NULL, TRANSMISSION
from alight.bsdfs.nesting import find_transmissive
from alight.cameras.rays import generate_ray
from alight.compiled.casters import is_caster
from alight.compiled.scene import CompiledScene
from alight.core.spec import Bsdf
from alight.core.vec import Vec3
from alight.films import CELL_SIZE
from alight.integrators.direct_light import lit_side
from alight.integrators.walk import to_local
from alight.lights.choice import choose_light
from alight.lights.sampling import sample_light, shadow_ray
from alight.shapes.hit import INFO, Hit
from alight.shapes.surfaces import make_surface
from lanewise.jit import instantiate

#: Points that the camera sees, and directions to lights from each.
POINTS, DIRECTIONS = 256, 4

#: Surfaces of clear glass on a straight way.
_MOST_SURFACES = 16

#: Slot of a shape's material in `ShapeTables.info`.
_BSDF = 1

#: Densities of directions from which on glass passes for smooth, per steradian: lamps of half a
#: degree look as sharp through it as they are.
_SHARP = 1e4

#: Wavelength for which glass that disperses light is asked, nanometres.
_GREEN = np.float32(550.0)

#: A new ray starts so far behind the surface that it has passed, as a share of its way so far.
_BEYOND = np.float32(1e-4)


def is_looked_for(bsdfs: Sequence[Bsdf], scene: CompiledScene) -> bool:
    """Whether paths of a scene may have to find light behind glass by chance.

    Where nothing but chance finds light, this says nothing new (`Film.by_chance`). Paths from lamps
    and walks through glass do find it. Scenes in motion are not looked at.
    """
    integrator = scene.integrator
    samples = integrator.needs_light and not integrator.finds_light_by_chance
    aims = integrator.splats or integrator.aims_at_lamps
    lit = bool(scene.program.lights) and samples and not aims and not scene.program.motion
    return lit and any(find_transmissive(bsdf, {}) is not None for bsdf in bsdfs)


def light_behind_glass(bsdfs: Sequence[Bsdf], scene: CompiledScene) -> np.ndarray | None:
    """Look for it, the same way whatever the seed of the picture.

    Parameters
    ----------
    bsdfs : sequence of Bsdf
        Of the flat scene: its materials in their order.
    scene : CompiledScene

    Returns
    -------
    (n, 6) float64, or None where there is none
        A row is what a point of the picture sees in one direction: numbers of the point and of its
        8x8 pixels of the window, radiance that it adds to the picture (linear RGB), and the
        probability q of a sample to find it.
    """
    if not is_looked_for(bsdfs, scene):
        return None
    random = np.random.default_rng(0)
    clear = np.array([is_caster(b) and find_transmissive(b, {}) is not None for b in bsdfs])
    x, y, w, h = scene.crop or (0, 0, *scene.size)
    at = (x + w * random.random(POINTS), y + h * random.random(POINTS))
    film = [a.astype(np.float32) for a in at]
    middle = np.full(POINTS, 0.5, np.float32)
    o, d = _twin(generate_ray, scene)(scene.tables, *film, (middle, middle))
    o, d = _lanes(o, POINTS), _lanes(d, POINTS)
    end = np.full(POINTS, np.inf, np.float32)
    hit, o, *_ = _first_opaque(scene, clear, o, d, end, random)
    seen = np.flatnonzero(np.isfinite(hit.t))
    if not len(seen):
        return None
    rows = np.repeat(seen, DIRECTIONS)
    hit = Hit(*(part[rows] for part in hit))
    found, q = _arriving(scene, clear, hit, _some(o, rows), _some(d, rows), random)
    column, line = (
        (a[rows] - start).astype(int) // CELL_SIZE for a, start in zip(at, (x, y), strict=True)
    )
    cells = line * -(-w // CELL_SIZE) + column
    table = np.column_stack([rows, cells, found / DIRECTIONS, q])
    table = table[(found > 0.0).any(axis=1)]
    return table if len(table) else None


def _arriving(
    scene: CompiledScene, clear: np.ndarray, hit: Hit, o: Vec3, d: Vec3, random: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """For a direction to a light at each point: radiance (n, 3) that comes through glass, and q."""
    n, tables = len(hit.t), scene.tables
    there = np.full(n, True)
    surface = _twin(make_surface, scene)(tables, hit, o, d, there)
    wo = _twin(to_local, scene)(surface, Vec3(-d.x, -d.y, -d.z))
    side = _twin(lit_side, scene)(tables, surface, wo)
    u, *u2 = random.random((3, n)).astype(np.float32)
    choice = _twin(choose_light, scene)(tables, surface.p, side, u, tuple(u2), there)
    light = _twin(sample_light, scene)(tables, surface.p, side, u, tuple(u2), there)
    wi = _twin(to_local, scene)(surface, light.wi)
    f_cos, density = _twin(evaluate_bsdf, scene)(tables, surface, wo, wi, there)
    start, length = _twin(shadow_ray, scene)(surface, light)
    start, towards, length = _lanes(start, n), _lanes(light.wi, n), _wide(length, n)
    blocked, _, through, spread = _first_opaque(scene, clear, start, towards, length, random)
    pdf = _wide(light.pdf, n).astype(np.float64)
    lit = ~np.isfinite(blocked.t) & through & (pdf > 0.0) & ~_wide(light.delta, n)
    given, sent = _lanes(f_cos, n), _lanes(light.radiance, n)
    value = np.stack([given.x * sent.x, given.y * sent.y, given.z * sent.z], axis=1)
    safe = np.where(lit, pdf, 1.0)
    radiance = np.where(lit[:, None], value.astype(np.float64) / safe[:, None], 0.0)
    seen_as = _wide(choice.mis_pmf, n) / safe + spread
    q = np.minimum(_wide(density, n) * seen_as, 1.0)
    return np.nan_to_num(radiance), np.where(lit, np.nan_to_num(q), 0.0)


def _first_opaque(
    scene: CompiledScene,
    clear: np.ndarray,
    o: Vec3,
    d: Vec3,
    end: np.ndarray,
    random: np.random.Generator,
) -> tuple[Hit, Vec3, np.ndarray, np.ndarray]:
    """Straight on through clear glass, and where a sample of the material passes sharply.

    What is clear lets light on at any angle: the way that light really takes is another one.

    Returns
    -------
    hit : Hit
        The first surface that stops light; at infinity if there is none before `end`.
    o : Vec3
        Where the last part of the way starts.
    glass : (n,) bool
        Whether light was refracted on the way.
    spread : (n,) float
        Solid angle into which glass that is not quite smooth has scattered it.
    """
    n = len(end)
    glass, spread, going = np.zeros(n, bool), np.zeros(n), np.full(n, True)
    hit = closest_hits(scene.program, scene.tables, o, d, end)
    for _ in range(_MOST_SURFACES):
        met = going & np.isfinite(hit.t)
        surface = _twin(make_surface, scene)(scene.tables, hit, o, d, met)
        if disperses(scene.program):
            surface = surface._replace(wavelength=np.full(n, _GREEN))
        wo = _twin(to_local, scene)(surface, Vec3(-d.x, -d.y, -d.z))
        u, *u2 = random.random((3, n)).astype(np.float32)
        sample = _twin(sample_bsdf, scene)(scene.tables, surface, wo, u, tuple(u2), met)
        flags, pdf = _wide(sample.flags, n), _wide(sample.pdf, n).astype(np.float64)
        hole = (flags & NULL) != 0
        smooth = clear[scene.tables.shapes.info.array[hit.shape * INFO + _BSDF]]
        rough = ~smooth & ((flags & (DELTA | TRANSMISSION)) == TRANSMISSION) & (pdf > _SHARP)
        bent = ~hole & (smooth | rough)
        passed = met & (pdf > 0.0) & (hole | bent)
        if not passed.any():
            break
        # What has stopped a ray is not asked again.
        going = passed
        glass |= passed & bent
        rough = passed & rough
        spread += np.where(rough, 1.0 / np.where(rough, pdf, 1.0), 0.0)
        step = np.where(passed, hit.t * (1 + _BEYOND), 0.0).astype(np.float32)
        o = Vec3(o.x + step * d.x, o.y + step * d.y, o.z + step * d.z)
        end = end - step
        hit = closest_hits(scene.program, scene.tables, o, d, end)
    return hit, o, glass, spread


def _twin(kernel: Any, scene: CompiledScene) -> Any:
    return np.errstate(all="ignore")(instantiate(kernel, scene.program, compiled=False))


def _wide(value: Any, n: int) -> np.ndarray:
    return np.ascontiguousarray(np.broadcast_to(value, n))


def _lanes(v: Vec3, n: int) -> Vec3:
    return Vec3(*(_wide(c, n).astype(np.float32) for c in (v.x, v.y, v.z)))


def _some(v: Vec3, rows: np.ndarray) -> Vec3:
    return Vec3(v.x[rows], v.y[rows], v.z[rows])
