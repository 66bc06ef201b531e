"""What compares machine code with the Python text looks at all of it, number by number.

A bench that forgets a channel forgets it on both sides, and every law that uses it still holds.
"""

from collections import namedtuple

import numpy as np

from alight.bsdfs.disney.burley import Burley
from alight.cameras.rays import generate_ray
from alight.cameras.thin_lens import ThinLens
from alight.compiled.cameras import compile_camera
from alight.compiled.program import Program
from alight.filters.importance import compile_filter, sample_filter
from alight.filters.tent import Tent
from alight.laws import cameras, emission, filters, textures
from alight.laws.bodies import body_of
from alight.laws.compiled import RESULTS, N, scatter
from alight.laws.lights import light_of_points, scene_of
from alight.laws.materials import Material, random_numbers
from alight.laws.shapes import RESULTS as SHAPE_RESULTS
from alight.laws.shapes import look_all
from alight.laws.statistics import unit_vectors
from alight.lights.emission.sampling import sample_emission
from alight.lights.sampling import sample_light
from alight.lights.spot import Spot
from alight.shapes.sphere import Sphere
from alight.textures.add import Add
from alight.textures.checkerboard import Checkerboard
from lanewise.jit import instantiate
from lanewise.vec3 import Vec3
from lanewise.view import View

Small = namedtuple("Small", "filter camera")


def rows_of(*values, n):
    """Numbers and vectors of n lanes as rows."""
    parts = [c for v in values for c in ((v.x, v.y, v.z) if isinstance(v, Vec3) else (v,))]
    return np.stack([np.broadcast_to(part, n).astype(float) for part in parts])


def same(found, expected):
    """Row by row, none of which is another one."""
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-7)
    alike = np.array([[np.allclose(a, b) for a in expected] for b in expected])
    np.testing.assert_array_equal(alike, np.eye(len(expected), dtype=bool))


def test_of_materials():
    spec = Burley(base_color=(0.6, 0.3, 0.2), roughness=0.4, metallic=0.3)
    out = scatter([spec], np.zeros(N, np.uint32), False)
    assert len(out) == RESULTS
    material, wo, other = Material(spec), unit_vectors(N, 3), unit_vectors(N, 4)
    wi, weight, pdf, flags = material.sample(wo, random_numbers(N, 1))
    f_cos, density = material.evaluate(wo, other)
    same(out[:11], rows_of(*wi, *weight, pdf, *f_cos, density, n=N))
    np.testing.assert_allclose(out[11:14], np.tile([[0.6], [0.3], [0.2]], N), rtol=1e-6)
    np.testing.assert_array_equal(out[14], flags)


def test_of_shapes():
    body, n = body_of(Sphere(), "turned"), 2048
    o, d = (np.ascontiguousarray(v[:, :n]) for v in body.lines(7))
    out = View(np.zeros((SHAPE_RESULTS, n), np.float32))
    body.run(look_all, body.scene, View(o), View(d), out, n)
    hit, g = body.hit(o, d, np.ones(n, bool))
    found = np.isfinite(hit.t)
    assert 0.2 < found.mean() < 1.0
    seen = rows_of(hit.t, g.p, g.ng, g.s.x, g.s.y, g.u, g.v, n=n)[:, found]
    same(out.shaped[:11, found], seen)
    np.testing.assert_array_equal(out.shaped[11], np.where(found, 0.0, -1.0))
    np.testing.assert_array_equal(out.shaped[0, ~found], -1.0)
    np.testing.assert_array_equal(out.shaped[1:11, ~found], 0.0)


def test_of_emission():
    spec, n = Spot(intensity=(3.0, 2.0, 1.0)), 2048
    scene = emission.compiled(next(iter(emission.scenes_with(spec))))
    u, out = (
        np.random.default_rng(3).random((5, n), np.float32),
        View(np.zeros((11, n), np.float32)),
    )
    with np.errstate(all="ignore"):
        instantiate(emission.rays_of_lights, scene.program, compiled=False)(
            scene.tables, View(u), out, n
        )
        e = instantiate(sample_emission, scene.program, compiled=False)(
            scene.tables, u[0], (u[1], u[2]), (u[3], u[4])
        )
    seen = rows_of(e.p, e.d, e.flux, e.pdf_position, e.pdf_direction, n=n)
    np.testing.assert_allclose(out.shaped, seen, rtol=1e-6, atol=1e-7)
    # A spot stands at one point, and its colours are alike but for their factors.
    same(out.shaped[3:9], seen[3:9])


def test_of_lights():
    scene, n = scene_of(Spot(intensity=(3.0, 2.0, 1.0))), 2048
    points = np.ascontiguousarray(5.0 * unit_vectors(n, 5), np.float32)
    u, out = np.random.default_rng(2).random((3, n), np.float32), View(np.zeros((8, n), np.float32))
    kernels = (
        instantiate(k, scene.program, compiled=False) for k in (light_of_points, sample_light)
    )
    with np.errstate(all="ignore"):
        bench, sample = kernels
        bench(scene.tables, View(points), View(u), out, n)
        p = Vec3(*points)
        s = sample(scene.tables, p, p, u[0], (u[1], u[2]), np.ones(n, bool))
    same(out.shaped[:7], rows_of(s.wi, s.distance, s.radiance, n=n))
    np.testing.assert_array_equal(out.shaped[7], np.broadcast_to(s.pdf, n))


def test_of_textures():
    spec, n = Add(a=Checkerboard(scale=4.0), b=(0.1, 0.5, 0.0)), 64
    scene, program = textures.compile_textures([spec])
    uv, out = (
        np.random.default_rng(6).random((2, n), np.float32),
        View(np.zeros((3, n), np.float32)),
    )
    instantiate(textures.look_up_all, program, compiled=False)(scene, View(uv), out, n)
    same(out.shaped, textures.values_at(spec, *uv))


def test_of_filters():
    scene, n = Small(filter=compile_filter(Tent()), camera=None), 64
    u, out = np.random.default_rng(6).random((2, n), np.float32), View(np.zeros((3, n), np.float32))
    program = Program(filter="tent")
    instantiate(filters.sample_all, program, compiled=False)(scene, View(u), out, n)
    dx, dy, weight = instantiate(sample_filter, program, compiled=False)(scene, tuple(u))
    np.testing.assert_array_equal(out.shaped, rows_of(dx, dy, weight, n=n))


def test_of_cameras():
    camera, n = compile_camera(ThinLens(aperture_radius=0.3), np.eye(4), (64, 48)), 64
    scene, program = Small(filter=None, camera=camera), Program(camera="thin_lens")
    u, out = np.random.default_rng(6).random((4, n), np.float32), View(np.zeros((6, n), np.float32))
    instantiate(cameras.generate_all, program, compiled=False)(scene, View(u), out, n)
    run = instantiate(generate_ray, program, compiled=False)
    same(out.shaped, rows_of(*run(scene, u[0], u[1], (u[2], u[3])), n=n))
