"""Laws of cameras: rays start where they should, and projection undoes what they do.

Each law is a function of an example and raises `BrokenLawError`. All look at it under `PLACEMENTS`,
on a wide film and on a high one.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Iterator
from typing import Any

import numpy as np

from alight.cameras.connection import Connection
from alight.cameras.model import CAMERAS
from alight.cameras.rays import (
    connect_camera,
    connect_far_camera,
    generate_ray,
    project,
    unproject,
)
from alight.compiled.cameras import compile_camera
from alight.compiled.program import Program
from alight.core.registry import versions
from alight.core.spec import Camera
from alight.core.vec import Vec3
from alight.laws.materials import stacked
from alight.laws.report import demand, demand_close
from alight.laws.statistics import length_error
from alight.laws.twins import demand_same_by_machine
from alight.scene.transform import Matrix, rotate, scale, translate
from lanewise.jit import instantiate, kernel
from lanewise.simd import LANES, load_lanes, store_lanes

N = 10_000

#: What cameras see of a scene.
_Scene = namedtuple("_Scene", "camera")

#: Width and height of the film, and the matrix camera to world: at rest; moved and turned; larger
#: and mirrored.
PLACEMENTS: dict[str, tuple[tuple[int, int], Matrix]] = {
    "as it is": ((64, 48), np.eye(4)),
    "turned": ((48, 64), (translate(1, -2, 0.5) @ rotate((1, 2, 3), 40)).matrix),
    "mirrored": ((64, 64), (rotate((1, 0, 2), 25) @ scale(-2.0, 2.0, 2.0)).matrix),
}

#: Rounding errors of float32 in a ray's direction or origin, relative to what they are made of:
#: a dozen operations with 2^-24 each.
ROUNDING = 12 * 2.0**-24


class Shots:
    """Rays of a camera through random points of its film.

    Attributes
    ----------
    film : (2, N) float32, pixels
    o, d : (3, N) float64
    size, to_world
        Of `PLACEMENTS`.
    """

    def __init__(
        self,
        spec: Camera,
        name: str,
        lens: np.ndarray | None = None,
        step: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        self.size, self.to_world = PLACEMENTS[name]
        rng = np.random.default_rng(2)
        self.film = (rng.random((2, N)) * np.reshape(self.size, (2, 1))).astype(np.float32)
        lens = np.full((2, N), 0.5, np.float32) if lens is None else lens
        program = Program(camera=spec.type_name(), registered=versions([spec]))
        run = instantiate(generate_ray, program, compiled=False)
        scene = _Scene(compile_camera(spec, self.to_world, self.size))
        film = self.film + np.reshape(np.float32(step), (2, 1))
        rays = run(scene, *film, tuple(lens))
        self.o, self.d = (
            np.stack([np.broadcast_to(c, N) for c in (v.x, v.y, v.z)]).astype(float) for v in rays
        )

    @property
    def rays(self) -> tuple[np.ndarray, np.ndarray]:
        """Origins and directions."""
        return self.o, self.d


def _lens(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).random((2, N), np.float32)


def _depths(shots: Shots) -> Iterator[np.ndarray]:
    """Points of the rays, near and far."""
    for distance in (0.3, 1.0, 30.0):
        yield shots.o + distance * np.linalg.norm(shots.to_world[:3, 2]) * shots.d


def rays_have_unit_directions(spec: Camera) -> None:
    """Rays of a camera have finite origins and unit directions."""
    for name in PLACEMENTS:
        shots = Shots(spec, name, _lens(3))
        demand(np.isfinite(shots.o), f"{name}: an origin is not finite")
        error = length_error(shots.d)
        demand(error < 1e-6, f"{name}: a length is {error:.2g} off")


def projection_undoes_the_rays(spec: Camera) -> None:
    """What lies on a ray through the centre of the lens appears where the ray went through."""
    for name in PLACEMENTS:
        shots = Shots(spec, name)
        for points in _depths(shots):
            found = project(spec, shots.to_world, shots.size, points.T)
            back = unproject(spec, shots.to_world, shots.size, found)
            reach = np.linalg.norm(points, axis=0) + np.linalg.norm(shots.to_world[:3, 3])
            off = np.linalg.norm(back - points.T, axis=1)
            demand_close(off / reach, 0.0, f"{name}: there and back", atol=ROUNDING)
            # What a rounding error of the point is worth in pixels, by the same projection.
            moved = points.T + (ROUNDING * reach)[:, None] * _across(shots.d).T
            beside = project(spec, shots.to_world, shots.size, moved)
            pixel = np.linalg.norm((beside - found)[:, :2], axis=1)
            margin = 2.0 * pixel + ROUNDING * max(shots.size)
            off = np.linalg.norm(found[:, :2] - shots.film.T, axis=1)
            demand_close(off, 0.0, f"{name}: pixels from the film point", atol=margin)


def _across(d: np.ndarray) -> np.ndarray:
    """Unit vectors at right angles to others (3, n)."""
    helper = np.where(np.abs(d[0]) < 0.6, 1.0, 0.0), np.where(np.abs(d[0]) < 0.6, 0.0, 1.0)
    across = np.cross(d, np.stack([*helper, np.zeros(d.shape[1])]), axis=0)
    return across / np.linalg.norm(across, axis=0)


def rays_of_a_film_point_meet(spec: Camera) -> None:
    """Rays from all over the lens meet the one through its centre, in front of it: in focus."""
    for name in PLACEMENTS:
        central, other = Shots(spec, name), Shots(spec, name, _lens(4))
        between = other.o - central.o
        size = np.linalg.norm(between, axis=0)
        across = np.linalg.norm(np.cross(central.d, other.d, axis=0), axis=0)
        if not size.max() > 0.0:
            continue
        apart = size > 1e-3 * size.max()
        demand(across[apart] > 0.0, f"{name}: rays from the lens never meet")
        n = np.cross(central.d, other.d, axis=0)[:, apart] / across[apart]
        # The distance of two lines; their angle says what a rounding error does to it.
        off = np.abs(np.sum(n * between[:, apart], axis=0))
        reach = np.linalg.norm(central.o[:, apart], axis=0) + size[apart]
        margin = 8.0 * ROUNDING * (reach + size[apart] / across[apart])
        demand_close(off, 0.0, f"{name}: metres between rays of one film point", atol=margin)
        ahead = np.sum(np.cross(between, other.d, axis=0)[:, apart] * n, axis=0)
        demand(ahead > 0.0, f"{name}: rays meet behind the camera")


def the_lens_is_sampled_evenly(spec: Camera) -> None:
    """Equal areas of u_lens give equal areas of the lens."""
    step, rng = 2.0**-6, np.random.default_rng(5)
    corner = (rng.random((2, N)) * (1.0 - step)).astype(np.float32)
    for name in PLACEMENTS:
        moved = [np.zeros((2, 1)), np.array([[step], [0.0]]), np.array([[0.0], [step]])]
        o, a, b = (Shots(spec, name, (corner + m).astype(np.float32)).o for m in moved)
        area = np.linalg.norm(np.cross(a - o, b - o, axis=0), axis=0)
        if not area.max() > 0.0:
            continue
        # Steps across a fold of the map, and near its centre, are not flat parallelograms.
        wrong = np.abs(area / np.median(area) - 1.0)
        demand(
            np.quantile(wrong, 0.8) < 2.0 * step,
            f"{name}: areas of the lens differ by {np.quantile(wrong, 0.8):.3g}",
        )


def _connected(
    spec: Camera, shots: Shots, ends: np.ndarray, lens: np.ndarray, connect: Any = connect_camera
) -> Connection:
    """How points are seen, or directions by `connect_far_camera`; (3, N)."""
    program = Program(camera=spec.type_name(), registered=versions([spec]))
    run = instantiate(connect, program, compiled=False)
    scene = _Scene(compile_camera(spec, shots.to_world, shots.size))
    return run(scene, Vec3(*ends.astype(np.float32)), tuple(lens))


def connections_undo_the_rays(spec: Camera) -> None:
    """What lies on a ray is seen along it, from the same point of the lens, in the same pixel."""
    if CAMERAS[spec.type_name()].connect is None:
        return
    for name in PLACEMENTS:
        lens = _lens(6)
        shots = Shots(spec, name, lens)
        for points in _depths(shots):
            found = _connected(spec, shots, points, lens)
            demand(found.visible, f"{name}: a point before the camera is not visible")
            w, o = stacked(found.w, N), stacked(found.o, N)
            reach = np.linalg.norm(points, axis=0) + np.linalg.norm(shots.o, axis=0)
            away = np.linalg.norm(points - shots.o, axis=0)
            margin = 4.0 * ROUNDING * reach / away + 1e-6
            demand_close(np.linalg.norm(w + shots.d, axis=0), 0.0, f"{name}: w", atol=margin)
            off = np.linalg.norm(o - shots.o, axis=0)
            demand_close(off / reach, 0.0, f"{name}: origins", atol=4.0 * ROUNDING)
            demand_close(found.distance / reach, away / reach, f"{name}: m", atol=4.0 * ROUNDING)
            pixels = margin * max(shots.size) / np.tan(_narrowest(spec, shots))
            at = np.stack([found.x, found.y])
            demand_close(np.abs(at - shots.film), 0.0, f"{name}: pixels", atol=pixels + 1e-3)


def _narrowest(spec: Camera, shots: Shots) -> float:
    """Angle that the film covers at least, radians; of parallel rays that of its metres."""
    return float(np.arctan(min(CAMERAS[spec.type_name()].half_extents(spec, *shots.size))))


def importance_is_pixels_over_area(spec: Camera) -> None:
    """`importance` is how many pixels show a square metre across the ray."""
    if CAMERAS[spec.type_name()].connect is None:
        return
    for name in PLACEMENTS:
        lens, shots = _lens(7), Shots(spec, name, _lens(7))
        points = shots.o + 3.0 * np.linalg.norm(shots.to_world[:3, 2]) * shots.d
        found = _connected(spec, shots, points, lens)
        ends = []
        for step in ((0.5, 0.0), (-0.5, 0.0), (0.0, 0.5), (0.0, -0.5)):
            o, d = Shots(spec, name, lens, step).rays
            # Where the ray beside it crosses the plane across the first.
            t = np.sum((points - o) * shots.d, axis=0) / np.sum(d * shots.d, axis=0)
            ends.append(o + t * d)
        area = np.linalg.norm(np.cross(ends[0] - ends[1], ends[2] - ends[3], axis=0), axis=0)
        demand_close(found.importance * area, 1.0, f"{name}: pixels per pixel", atol=0.03)


def what_is_far_is_seen_as_what_is_near(spec: Camera) -> None:
    """Along a ray: the same origin and pixel, and the same importance per steradian."""
    if CAMERAS[spec.type_name()].connect_far is None:
        return
    for name in PLACEMENTS:
        lens = _lens(8)
        shots = Shots(spec, name, lens)
        far = _connected(spec, shots, shots.d, lens, connect_far_camera)
        demand(far.visible, f"{name}: a direction before the camera is not visible")
        demand(far.distance > 1e20, f"{name}: it is not far")
        demand_close(stacked(far.w, N), -shots.d, f"{name}: w", atol=1e-6)
        # Of the near point only its direction from the lens is rounded otherwise.
        points = shots.o + np.linalg.norm(shots.to_world[:3, 2]) * shots.d
        near = _connected(spec, shots, points, lens)
        reach = np.linalg.norm(points, axis=0) + np.linalg.norm(shots.o, axis=0)
        margin = 4.0 * ROUNDING * reach / near.distance + 1e-6
        off = np.linalg.norm(stacked(far.o, N) - shots.o, axis=0)
        demand_close(off / reach, 0.0, f"{name}: origins", atol=4.0 * ROUNDING)
        pixels = margin * max(shots.size) / np.tan(_narrowest(spec, shots))
        at = np.stack([far.x, far.y])
        demand_close(np.abs(at - shots.film), 0.0, f"{name}: pixels", atol=pixels + 1e-3)
        ratio = far.importance / (near.importance * near.distance**2)
        demand_close(ratio, 1.0, f"{name}: importance", atol=float(margin.max()) * 30.0)


# ---------------------------------------------------------------- machine code


@kernel
def generate_all(scene, u, out, n):
    """Rays through n points of the film and of the lens."""
    for i in range(0, n, LANES):
        u_lens = load_lanes(u, i + 2 * n), load_lanes(u, i + 3 * n)
        o, d = generate_ray(scene, load_lanes(u, i), load_lanes(u, i + n), u_lens)
        store_lanes(out, i, o.x)
        store_lanes(out, i + n, o.y)
        store_lanes(out, i + 2 * n, o.z)
        store_lanes(out, i + 3 * n, d.x)
        store_lanes(out, i + 4 * n, d.y)
        store_lanes(out, i + 5 * n, d.z)


def compiled_rays_are_the_twins(spec: Camera) -> None:
    """Machine code generates the rays of the Python text."""
    size, to_world = PLACEMENTS["turned"]
    scene = _Scene(compile_camera(spec, to_world, size))
    program = Program(camera=spec.type_name(), registered=versions([spec]))
    u = np.random.default_rng(8).uniform(1e-3, 1.0 - 1e-3, (4, 4096))
    u[:2] *= np.reshape(size, (2, 1))
    demand_same_by_machine(generate_all, program, scene, u.astype(np.float32), 6)


LAWS = (
    rays_have_unit_directions,
    projection_undoes_the_rays,
    rays_of_a_film_point_meet,
    the_lens_is_sampled_evenly,
    connections_undo_the_rays,
    importance_is_pixels_over_area,
    what_is_far_is_seen_as_what_is_near,
)
COMPILED_LAWS = (compiled_rays_are_the_twins,)
