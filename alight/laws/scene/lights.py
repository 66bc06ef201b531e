r"""Laws of the lights of a scene: directions to them follow the density that MIS weights need.

No integral over the sphere is summed up. Directions are drawn in two ways, by the light and evenly
over a cone around it, with densities p and q that are known for all of them. For any region C

.. math:: E_p\Big[ \frac{1_C\, q}{p + q} \Big] = \int_C \frac{p\,q}{p + q}\, d\omega
    = E_q\Big[ \frac{1_C\, p}{p + q} \Big],

two means of bounded numbers, whatever the light: a sharp edge or a small sun costs no accuracy.
(The weights are those of the balance heuristic; Veach and Guibas, SIGGRAPH 1995.)
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from alight.accel import intersect_closest
from alight.compiled.scene import CompiledScene, compile_scene
from alight.core.frame import frame_from_normal
from alight.core.vec import Vec3
from alight.laws.materials import stacked
from alight.laws.scene.findings import Finding
from alight.laws.statistics import chi_square, chi_square_tail, length_error, unit_vectors
from alight.lights.choice import choose_light
from alight.lights.hits import light_pdf
from alight.lights.misses import environment_pdf
from alight.lights.model import LIGHTS
from alight.lights.sampling import sample_light
from alight.lights.tree.traversal import choose_by_tree
from alight.scene.flatten import NO_GEOMETRY, FlatScene, PlacedShape
from alight.shapes.surfaces import make_surface
from lanewise.jit import instantiate, kernel
from lanewise.simd import where

#: Directions drawn in each way, for each point.
N = 20_000
#: Points from which a light is looked at, and how many are tried to find such that it shines on.
POINTS, TRIES = 2, 12
#: Cells along both coordinates of the cone; those with fewer directions are put together.
SIDE, FEWEST = 6, 100
#: Lights with more triangles are not looked at in plain Python, nor are more lights than this.
MOST_TRIANGLES, MOST_LIGHTS = 400, 8


@kernel
def density_towards(scene, p, d):
    """Density of light sampling at p for the directions d that rays find."""
    hit = intersect_closest(scene, p, d, d.x * 0.0 + 3.0e38, d.x == d.x)
    found = hit.t < 3.0e38
    surface = make_surface(scene, hit, p, d, found)
    area = light_pdf(scene, surface.light, p, d, hit.t, surface)
    return where(found, area, environment_pdf(scene, p, d))


class Cone(NamedTuple):
    """All directions within an angle of an axis: unit vectors (3,), and 1 - cos of the angle."""

    axis: np.ndarray
    s: np.ndarray
    t: np.ndarray
    one_minus_cos: float

    @property
    def density(self) -> float:
        """Per steradian."""
        return 1.0 / (2.0 * math.pi * self.one_minus_cos)

    def directions(self, u: np.ndarray) -> np.ndarray:
        """Even directions (3, n) from u (2, n) in [0, 1)."""
        z = 1.0 - u[0] * self.one_minus_cos
        r, phi = np.sqrt(np.maximum(0.0, 1.0 - z * z)), 2.0 * math.pi * u[1]
        axes = np.stack([self.s, self.t, self.axis], axis=1)
        return axes @ np.stack([r * np.cos(phi), r * np.sin(phi), z])

    def cells(self, d: np.ndarray) -> np.ndarray:
        """Cell of each direction (3, n): rings of equal solid angle, cut in sectors."""
        # By the chord, of the unit vector: 1 - cos of float32 loses all digits for small lights.
        d = d / np.linalg.norm(d, axis=0)
        ring = np.sum((d - self.axis[:, None]) ** 2, axis=0) / (2.0 * self.one_minus_cos) * SIDE
        sector = np.arctan2(self.t @ d, self.s @ d) / (2.0 * math.pi) % 1.0 * SIDE
        ring, sector = (np.clip(c.astype(int), 0, SIDE - 1) for c in (ring, sector))
        return ring * SIDE + sector


def check_lights(flat: FlatScene, compiled: CompiledScene, seed: int) -> Iterator[Finding]:
    """Judge the choice of the lights, and each light by itself.

    Parameters
    ----------
    flat : FlatScene
    compiled : CompiledScene
        Of it.
    seed : int
        Of the random numbers.
    """
    rng = np.random.default_rng((seed, 2))
    if not compiled.program.lights:
        return
    if not compiled.program.single_light:
        yield _choice(compiled, _box(flat), rng)
    shining = [shape for shape in flat.shapes if shape.light is not None and not _is_dark(shape)]
    parts = [(shape.name, _alone(flat, shapes=[shape])) for shape in shining]
    parts += [(light.name, _alone(flat, lights=[light])) for light in flat.lights]
    parts += [(light.name, _alone(flat, environments=[light])) for light in flat.environments]
    for name, one in parts[:MOST_LIGHTS]:
        yield from _of_one(f"light {name}", one, _box(flat), rng)
    if len(parts) > MOST_LIGHTS:
        detail = f"{len(parts) - MOST_LIGHTS} more were not looked at"
        yield Finding("lights", "all laws", detail=detail)


def _is_dark(shape: PlacedShape) -> bool:
    return shape.light is None or shape.light.is_black


def _alone(flat: FlatScene, **kept: Any) -> FlatScene:
    """The scene with one light and nothing else."""
    nothing: dict[str, Any] = {"shapes": [], "lights": [], "environments": []}
    return dataclasses.replace(flat, **(nothing | kept))


def _box(flat: FlatScene) -> tuple[np.ndarray, np.ndarray]:
    """Corners of a box around the places of all shapes, lights and the camera."""
    centres = [shape.to_world[:3, 3] for shape in flat.shapes]
    for shape in flat.shapes:
        if shape.geometry != NO_GEOMETRY:
            vertices = flat.geometries[shape.geometry].vertices
            ends = np.stack([vertices.min(axis=0), vertices.max(axis=0)])
            centres += list(ends @ shape.to_world[:3, :3].T + shape.to_world[:3, 3])
    centres += [light.to_world[:3, 3] for light in flat.lights]
    places = np.array([*centres, flat.camera.to_world[:3, 3]])
    return places.min(axis=0), places.max(axis=0)


def _choice(
    compiled: CompiledScene, box: tuple[np.ndarray, np.ndarray], rng: np.random.Generator
) -> Finding:
    """Whether each light is chosen as often as its probability says."""
    n = 100_000
    u = rng.random((3, n), np.float32)
    law = "lights are chosen as often as their probability says"
    lights = compiled.tables.lights.info.size // 4
    if compiled.program.light_tree:
        place, normal = rng.uniform(*box), unit_vectors(1, int(rng.integers(1 << 30)))[:, 0]
        p, up = (Vec3(*(np.full(n, c, np.float32) for c in v)) for v in (place, normal))
        run = instantiate(choose_by_tree, compiled.program, compiled=False)
        with np.errstate(all="ignore"):
            found = run(compiled.tables, p, up, u[0], (u[1], u[2]), np.ones(n, bool))
        # A mesh light's triangles are chosen one by one.
        keys = found.index.astype(np.int64) << 24 | np.floor(found.rest).astype(np.int64)
        keys = np.where(found.pmf > 0.0, keys, -1)
        names, first, counts = np.unique(keys, return_index=True, return_counts=True)
        said, none = found.pmf[first].astype(float), counts[names < 0].sum()
        counts, said = np.append(counts[names >= 0], none), said[names >= 0]
        return Finding("lights", law, p=chi_square(counts, said), detail=f"{lights} lights")
    choose = instantiate(choose_light, compiled.program, compiled=False)
    choice = choose(compiled.tables, None, None, u[0], None, None)
    said = np.zeros(lights)
    said[choice.index] = choice.pmf
    counts = np.append(np.bincount(choice.index, minlength=lights), 0)
    if not ((choice.rest >= 0.0) & (choice.rest < 1.0)).all():
        return Finding("lights", law, holds=False, detail="what is left of u is outside [0, 1)")
    return Finding("lights", law, p=chi_square(counts, said), detail=f"{lights} lights")


def _of_one(
    part: str, flat: FlatScene, box: tuple[np.ndarray, np.ndarray], rng: np.random.Generator
) -> Iterator[Finding]:
    law = "directions follow their density"
    triangles = sum(len(flat.geometries[s.geometry].faces) for s in flat.shapes if s.geometry >= 0)
    if triangles > MOST_TRIANGLES:
        yield Finding(part, law, detail=f"{triangles} triangles: too many for plain Python")
        return
    scene = compile_scene(flat, structure="list")
    seen, lengths = 0, 0.0
    for _ in range(TRIES):
        p = rng.uniform(*box).astype(np.float32)
        light, wi, pdf = _sampled(scene, p, rng)
        lengths = max(lengths, float(length_error(wi[:, pdf > 0.0])) if (pdf > 0.0).any() else 0.0)
        if np.any(light.delta) or np.count_nonzero(pdf > 0.0) < N // 20:
            continue
        seen += 1
        yield from _two_ways(part, scene, p, wi, pdf, rng)
        if seen == POINTS:
            break
    if lengths > 1e-6:
        detail = f"a length is {lengths:.2g} off"
        yield Finding(part, "directions have unit length", holds=False, detail=detail)
    else:
        yield Finding(part, "directions have unit length", holds=True)
    if seen == 0 and not _is_delta(scene):
        yield Finding(part, law, detail="it shines on none of the places that were tried")


def _is_delta(scene: CompiledScene) -> bool:
    return all(LIGHTS[name].DELTA for name in scene.program.lights if name in LIGHTS)


def _sampled(
    scene: CompiledScene, p: np.ndarray, rng: np.random.Generator
) -> tuple[Any, np.ndarray, np.ndarray]:
    """N light samples at one point: the samples, wi (3, N) and pdf (N,)."""
    point = Vec3(*(np.full(N, c, np.float32) for c in p))
    u = rng.random((3, N), np.float32)
    sample = instantiate(sample_light, scene.program, compiled=False)
    with np.errstate(all="ignore"):
        # Without a normal the probabilities of a light tree are those that MIS knows.
        light = sample(scene.tables, point, point * 0.0, u[0], (u[1], u[2]), np.ones(N, bool))
    return light, stacked(light.wi, N).astype(float), np.broadcast_to(light.pdf, N).astype(float)


def _two_ways(
    part: str,
    scene: CompiledScene,
    p: np.ndarray,
    wi: np.ndarray,
    pdf: np.ndarray,
    rng: np.random.Generator,
) -> Iterator[Finding]:
    place = ", ".join(f"{c:.3g}" for c in p)
    valid = pdf > 0.0
    cone = _cone_around(wi[:, valid])
    even = cone.directions(rng.random((2, N))).astype(np.float32).astype(float)
    there, here = (_density(scene, p, d) for d in (even, wi))
    q = cone.density
    by_light = np.where(valid, q / (np.where(valid, pdf, 1.0) + q), 0.0)
    by_cone = there / (there + q)
    chi2, cells = _difference(cone.cells(wi), by_light, cone.cells(even), by_cone)
    yield Finding(
        part,
        "directions follow their density (chi-square)",
        p=chi_square_tail(chi2, cells),
        detail=f"seen from ({place})",
    )
    # Rays along sampled directions may miss the light by the rounding of its edge.
    close = np.abs(here - pdf)[valid] <= 2e-3 * pdf[valid]
    law = "rays find the density that light sampling says"
    wrong = 1.0 - close.mean()
    detail = f"{100 * wrong:.2g} % of the directions differ, seen from ({place})"
    yield Finding(part, law, holds=bool(wrong < 0.01), detail=detail)


def _density(scene: CompiledScene, p: np.ndarray, d: np.ndarray) -> np.ndarray:
    n = d.shape[1]
    point = Vec3(*(np.full(n, c, np.float32) for c in p))
    run = instantiate(density_towards, scene.program, compiled=False)
    with np.errstate(all="ignore"):
        found = run(scene.tables, point, Vec3(*np.ascontiguousarray(d, np.float32)))
    return np.broadcast_to(found, n).astype(float)


def _cone_around(wi: np.ndarray) -> Cone:
    """A cone that holds all directions and some more around them."""
    axis = wi.mean(axis=1)
    length = float(np.linalg.norm(axis))
    axis = axis / length if length > 1e-3 else np.array([0.0, 0.0, 1.0])
    wi = wi / np.linalg.norm(wi, axis=0)
    widest = float(np.max(np.sum((wi - axis[:, None]) ** 2, axis=0))) / 2.0
    s, t = (np.array([v.x, v.y, v.z], float) for v in frame_from_normal(Vec3(*axis)))
    return Cone(axis, s, t, min(2.0, 1.2 * widest + 1e-9))


def _difference(
    cells_a: np.ndarray, a: np.ndarray, cells_b: np.ndarray, b: np.ndarray
) -> tuple[float, int]:
    """Sum of squares of the standardised differences of two means in each cell; how many cells."""
    cells = SIDE * SIDE
    counts = np.minimum(
        np.bincount(cells_a[a > 0.0], minlength=cells),
        np.bincount(cells_b[b > 0.0], minlength=cells),
    )
    group = np.where(counts >= FEWEST, np.arange(cells), cells)
    total, used = 0.0, 0
    for k in np.unique(group):
        x, y = np.where(group[cells_a] == k, a, 0.0), np.where(group[cells_b] == k, b, 0.0)
        variance = x.var(ddof=1) / len(x) + y.var(ddof=1) / len(y)
        if variance > 0.0 and (k < cells or min(np.sum(x > 0), np.sum(y > 0)) >= FEWEST):
            total += float((x.mean() - y.mean()) ** 2 / variance)
            used += 1
    return total, max(used, 1)
