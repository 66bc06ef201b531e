"""A few shapes in a world without materials, traced by brute force: compiled, or as NumPy text."""

from collections import namedtuple
from functools import lru_cache
from types import SimpleNamespace

import numpy as np

from alight.compiled.lights import compile_lights
from alight.compiled.program import Program
from alight.compiled.shapes import compile_shapes
from alight.core.constants import INFINITY
from alight.core.vec import Vec3
from alight.scene.files import Files
from alight.scene.flatten import NO_GEOMETRY, PlacedLight, PlacedShape
from alight.scene.meshes import geometry
from alight.scene.transform import matrix, rotate, scale, translate
from alight.shapes.hit import INFO, Hit, side_of, spawn_origin
from alight.shapes.mesh import Mesh
from alight.shapes.model import SHAPES
from alight.shapes.surfaces import make_surface
from alight.shapes.triangle import intersect as intersect_triangle
from alight.shapes.triangle import rotated, shear_of
from lanewise.jit import instantiate, kernel
from lanewise.simd import (
    LANES,
    as_int,
    lanes,
    lanes_u32,
    load_lanes,
    minimum,
    store_lanes,
    to_float,
    where,
)
from lanewise.view import View

#: Shapes of one surface that has a formula.
FORMULAS = tuple(name for name in SHAPES if SHAPES[name].has_formula and not SHAPES[name].is_many)
TRACED = (*FORMULAS, "mesh")


def one_of_each(**chosen):
    """A shape of each kind in `TRACED`, by name: the chosen one, or the first example of its file.

    Tests that walk these hold for a new shape, too, or say what they need to know of it.
    """
    return {name: chosen.get(name) or SHAPES[name].EXAMPLES[0] for name in TRACED}


Scene = namedtuple("Scene", "shapes lights triangles triangle_ids")

#: One program for all worlds, so that the kernels below are compiled once.
PROGRAM = Program(
    bsdfs=("anisotropic",),
    shapes=TRACED,
    textures=("constant", "checkerboard"),
    lights=("point", "directional", "area", "constant"),
    light_shapes=tuple(name for name in TRACED if SHAPES[name].sample is not None),
)

#: Affine maps that keep, stretch, slant and mirror.
PLACEMENTS = {
    "identity": np.eye(4),
    "moved": translate(1, -2, 0.5).matrix @ rotate((1, 2, 3), 40).matrix @ scale(0.7).matrix,
    "stretched": rotate((1, 0, 2), 25).matrix @ scale(0.5, 2.0, 1.3).matrix,
    "sheared": matrix(
        [[1, 0.6, -0.2, 0.1], [0, 0.8, 0.5, 0.3], [0.2, 0, 1.1, -0.4], [0, 0, 0, 1]]
    ).matrix,
    "mirrored": translate(0.2, 0, 1).matrix @ scale(-1.2, 0.9, 0.8).matrix,
}


class World:
    """Placed shapes with their tables.

    Parameters
    ----------
    *placed : (Shape, (4, 4) matrix) or (Shape, matrix, Light)
    lights : list of PlacedLight
    environment : Light, optional
    environment_to_world : (4, 4) matrix, optional
    around : list of PlacedLight
        Further environments.
    selection : str
        How lights are chosen.
    compensated : bool
        Whether light sampling leaves light to BSDF sampling.
    """

    def __init__(
        self,
        *placed,
        lights=(),
        environment=None,
        environment_to_world=None,
        around=(),
        selection="power",
        compensated=False,
    ):
        files, geometries, shapes = Files(), [], []
        for shape, to_world, *light in placed:
            index = NO_GEOMETRY
            if isinstance(shape, Mesh):
                found = geometry(shape, files)
                if found not in geometries:
                    geometries.append(found)
                index = geometries.index(found)
            light = light[0] if light else None
            shapes.append(PlacedShape("shape", shape, np.asarray(to_world, float), 0, light, index))
        around = list(around)
        if environment is not None:
            turned = np.eye(4) if environment_to_world is None else environment_to_world
            around = [PlacedLight("environment", environment, turned), *around]
        flat = SimpleNamespace(
            shapes=shapes, geometries=geometries, lights=list(lights), environments=around
        )
        self.shapes = compile_shapes(flat)
        self.lights = compile_lights(flat, self.shapes, selection, compensated=compensated)
        corners = self.shapes.triangles.vertices[self.shapes.triangles.faces].reshape(-1)
        ids = np.stack([self.shapes.triangles.shape, self.shapes.triangles.prim], -1).reshape(-1)
        self.scene = Scene(self.shapes.tables, self.lights.tables, View(corners.copy()), View(ids))

    def trace(self, o, d, t_max=np.inf, only=-1):
        """The nearest hits of rays (3, n), in NumPy."""
        one = np.ones(len(d[0]), np.float32)
        # Dead lanes may divide by zero.
        with np.errstate(all="ignore"):
            return nearest(self.scene, vec(o) * one, vec(d) * one, one * np.float32(t_max), only)

    def surface(self, o, d, t_max=np.inf):
        """Hits and surfaces of rays (3, n), in NumPy."""
        hit = self.trace(o, d, t_max)
        found = np.isfinite(hit.t)
        return hit, self.surface_at(hit, o, d, found), found

    def surface_at(self, hit, o, d, found):
        """The surfaces of given hits."""
        make = instantiate(make_surface, PROGRAM, compiled=False)
        with np.errstate(all="ignore"):
            return make(self.scene, finite(hit), vec(o), vec(d), found)


def vec(rows):
    """(3, n) numbers as Vec3 of float32."""
    return Vec3(*(np.asarray(row, np.float32) for row in rows))


def rows(v):
    """Vec3 of lanes as (3, n) float64."""
    return np.array(np.broadcast_arrays(v.x, v.y, v.z), float)


def finite(hit):
    """The hit with t = 1 where nothing was hit: dead lanes may do any arithmetic."""
    return hit._replace(t=np.where(np.isfinite(hit.t), hit.t, np.float32(1.0)))


def unit(v):
    """Columns of (3, n) as unit vectors."""
    return v / np.linalg.norm(v, axis=0)


def directions(n, rng):
    """(3, n) uniform unit vectors."""
    return unit(rng.normal(size=(3, n)))


def of_kinds(names):
    """A kernel that runs the formula of a row's kind."""
    if not names:

        @kernel
        def nothing(kind, data, k, o, d, t_max):
            return lanes(0.0), lanes(0.0), lanes(0.0), t_max < 0.0

        return nothing
    number, intersect, rest = (
        SHAPES[names[0]].number,
        SHAPES[names[0]].intersect,
        of_kinds(names[1:]),
    )

    @kernel
    def choose(kind, data, k, o, d, t_max):
        t, u, v, hit = rest(kind, data, k, o, d, t_max)
        if kind == number:
            t, u, v, hit = intersect(data, k, o, d, t_max)
        return t, u, v, hit

    return choose


meet_one = of_kinds(FORMULAS)


@kernel(strict=True)
def nearest(scene, o, d, t_max, only):
    """The nearest hit of rays with all shapes, or with shape number `only`."""
    data, info = scene.shapes.data, scene.shapes.info
    t_best, u_best, v_best = lanes(t_max), lanes(0.0), lanes(0.0)
    shape, prim, found = lanes_u32(0), lanes_u32(0), lanes(0.0)
    for i in range(info.size // INFO):
        if (only < 0) | (only == i):
            kind, k = as_int(info[INFO * i]), as_int(info[INFO * i + 3])
            t, u, v, hit = meet_one(kind, data, k, o, d, t_best)
            t_best, shape = where(hit, t, t_best), where(hit, lanes_u32(i), shape)
            u_best, v_best = where(hit, u, u_best), where(hit, v, v_best)
            found = where(hit, 1.0, found)
    shear = shear_of(d)
    origin = rotated(o, shear)
    for i in range(scene.triangle_ids.size // 2):
        owner = as_int(scene.triangle_ids[2 * i])
        if (only < 0) | (only == owner):
            t, u, v, hit = intersect_triangle(scene.triangles, 9 * i, origin, shear, t_best)
            t_best, shape = where(hit, t, t_best), where(hit, lanes_u32(owner), shape)
            u_best, v_best = where(hit, u, u_best), where(hit, v, v_best)
            prim = where(hit, lanes_u32(as_int(scene.triangle_ids[2 * i + 1])), prim)
            found = where(hit, 1.0, found)
    missed = found < 0.5
    # A hit at infinity is wrong, and must not pass for a miss.
    t_best = where(missed, INFINITY, minimum(t_best, 3e38))
    return Hit(t_best, u_best, v_best, shape, prim)


@kernel
def load_vec3(view, i, n):
    """Vec3 lanes from the rows i of three columns of length n."""
    return Vec3(load_lanes(view, i), load_lanes(view, n + i), load_lanes(view, 2 * n + i))


@kernel
def store_vec3(view, i, n, v):
    """The inverse of `load_vec3`."""
    store_lanes(view, i, v.x)
    store_lanes(view, n + i, v.y)
    store_lanes(view, 2 * n + i, v.z)


#: Rows of the result of `bounce`, beside the three of each vector.
SCALARS = ("t", "error", "u", "v", "shape", "again", "again_shape", "side")
VECTORS = ("p", "ng", "ns", "s", "tangent")


@kernel
def bounce_kernel(scene, ray_o, ray_d, leaving, vectors, scalars, n):
    """Hit, surface, and where a ray that leaves from there comes to.

    `leaving` are directions in the frame (s, t, ng).
    """
    i = 0
    while i < n:
        o, d = load_vec3(ray_o, i, n), load_vec3(ray_d, i, n)
        hit = nearest(scene, o, d, lanes(INFINITY), -1)
        found = hit.t < INFINITY
        safe = Hit(where(found, hit.t, 1.0), hit.u, hit.v, hit.shape, hit.prim)
        g = make_surface(scene, safe, o, d, found)
        local = load_vec3(leaving, i, n)
        w = local.x * g.s + local.y * g.t + local.z * g.ng
        start = spawn_origin(g.p, g.error, g.ng, w)
        again = nearest(scene, start, w, lanes(INFINITY), -1)
        store_vec3(vectors, i, n, g.p)
        store_vec3(vectors, 3 * n + i, n, g.ng)
        store_vec3(vectors, 6 * n + i, n, g.ns)
        store_vec3(vectors, 9 * n + i, n, g.s)
        store_vec3(vectors, 12 * n + i, n, g.t)
        store_lanes(scalars, i, hit.t)
        store_lanes(scalars, n + i, g.error)
        store_lanes(scalars, 2 * n + i, g.u)
        store_lanes(scalars, 3 * n + i, g.v)
        store_lanes(scalars, 4 * n + i, to_float(hit.shape))
        store_lanes(scalars, 5 * n + i, again.t)
        store_lanes(scalars, 6 * n + i, to_float(again.shape))
        store_lanes(scalars, 7 * n + i, side_of(w, g.ng))
        i += LANES


@lru_cache(maxsize=2)
def bounce_function(compiled):
    """`bounce_kernel`, once a session."""
    return instantiate(bounce_kernel, PROGRAM, compiled=compiled)


def bounce(world, o, d, leaving, compiled=True):
    """`bounce_kernel` for rays (3, n) and local directions (3, n): arrays by name."""
    n = len(o[0]) // 16 * 16
    o, d, leaving = (
        np.ascontiguousarray(np.asarray(v)[:, :n], np.float32) for v in (o, d, leaving)
    )
    vectors, scalars = np.zeros((15, n), np.float32), np.zeros((len(SCALARS), n), np.float32)
    with np.errstate(all="ignore"):
        bounce_function(compiled)(
            world.scene, View(o), View(d), View(leaving), View(vectors), View(scalars), n
        )
    result = dict(zip(SCALARS, scalars, strict=True))
    result |= {name: vectors[3 * i : 3 * i + 3] for i, name in enumerate(VECTORS)}
    return SimpleNamespace(**result, found=np.isfinite(result["t"]))
