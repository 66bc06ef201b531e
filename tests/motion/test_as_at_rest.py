"""What moves is, at each instant, what rests where it then is: surfaces, lights and densities.

A shutter that is open for no time makes a scene of resting things, seen by other kernels.
"""

import numpy as np
import pytest

from alight.accel import intersect_closest
from alight.core.vec import Vec3
from alight.lights.hits import light_pdf
from alight.lights.sampling import sample_light
from alight.shapes.derivatives import uv_derivatives
from alight.shapes.hit import Hit
from alight.shapes.surfaces import make_surface
from tests.motion.moving import compiled
from tests.motion.test_kernels import rays, seen, twin_of

N = 4096
TIMES = (0.0, 0.37, 0.9)
HEAD = """
alight: 1
film: {size: [8, 8]}
camera: {type: pinhole, shutter: [%s, %s]}
integrator: {type: path, light_choice: %s}
"""
#: Every shape, stretched and slanted in itself, and then again by motions that change it; one is
#: turned inside out, one has normals of its own and coordinates.
CHANGING = """
  ball:
    transform: {keyframes: [{time: 0, translate: [-2, 0, 0]},
                            {time: 1, scale: [1, 2, 0.7], translate: [0, 1, 1]}]}
    children: {egg: {shape: sphere, bsdf: brushed,
                     transform: [{scale: [0.4, 0.9, 0.6]}, {rotate: {axis: [1, 1, 0], angle: 40}}]}}
  plate:
    transform: {keyframes: [{time: 0, rotate: {axis: [1, 2, 3], angle: 10}},
                            {time: 1, scale: [2, 0.5, 1], rotate: {axis: x, angle: 140}}]}
    children: {disk: {shape: {type: disk, flip_normals: true}, bsdf: brushed,
                      transform: [{scale: [1, 0.4, 1]}, {rotate: {axis: z, angle: 50}},
                                  {translate: [0, 2, 0]}]}}
  box:
    transform: {keyframes: [{time: 0, scale: [1, -1, 1.4]},
                            {time: 1, scale: [2, -0.7, 1], rotate: {axis: y, angle: 80}}]}
    children: {cube: {shape: cube, bsdf: brushed,
                      transform: [{scale: 0.5}, {rotate: {axis: [1, 0, 2], angle: 30}},
                                  {translate: [2, 2, 0]}]}}
  tube:
    transform: {keyframes: [{time: 0, scale: [1, 0.5, 1]}, {time: 1, scale: [0.6, 1, 1.5]}]}
    shape: {type: cylinder, radius: 0.5, p0: [0, -3, -1], p1: [1, -3, 1]}
    bsdf: brushed
  leaf:
    transform: {keyframes: [{time: 0, scale: [2, 2, 0.5]},
                            {time: 1, scale: [1, 3, 2], rotate: {axis: [1, 0, 1], angle: 70}}]}
    shape: {type: mesh, vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
            faces: [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
            normals: [[-1, -1, -1], [1, 0.2, 0], [0, 1, 0.1], [0.3, 0, 1]],
            uvs: [[0, 0], [1, 0.1], [0.2, 1], [1, 1]]}
    bsdf: brushed
  mirrored:
    transform: {keyframes: [{time: 0, scale: [-1, 2, 1], translate: [2, -2, 2]},
                            {time: 1, scale: [-2, 1, 1], translate: [2, -1, 2]}]}
    shape: {type: mesh, vertices: [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]],
            faces: [[0, 1, 2], [0, 2, 3]], flip_normals: true,
            normals: [[-0.5, 0, 1], [0.5, 0.1, 1], [0, 0.4, 1], [0.1, -0.4, 1]]}
    bsdf: brushed
  still: {shape: rectangle, bsdf: brushed, transform: [{scale: 5}, {translate: [0, 0, -4]}]}
environment: {type: constant}
"""
BRUSHED = """
bsdfs: {brushed: {type: rough_conductor, alpha_u: 0.1, alpha_v: 0.4,
                  specular_reflectance: {type: checkerboard}}}
nodes:
"""
#: Lamps that keep their form while they move, as they must; but it may be any form.
LAMPS = """nodes:
  wheel:
    transform: {keyframes: [{time: 0, rotate: {axis: [1, 2, 3], angle: 10}},
                            {time: 0.5, translate: [0, 1, 0], rotate: {axis: y, angle: 150}},
                            {time: 1, translate: [0, 2, 0], rotate: {axis: x, angle: 40}}]}
    children:
      egg: {shape: sphere, light: area, transform: [{scale: [0.4, 1.2, 0.8]},
                                                    {rotate: {axis: [1, 1, 0], angle: 40}},
                                                    {translate: [-2, 0, 0]}]}
      ball: {shape: {type: sphere, radius: 0.5, center: [0, 3, 1]}, light: area}
      plate: {shape: disk, light: area, transform: [{scale: [1, 2, 1]}, {translate: [0, 0, 2]}]}
      leaf: {shape: rectangle, light: area, transform: {translate: [0, 2, -1]}}
      slant: {shape: rectangle, light: area, transform: {matrix: [[1, 0.6, 0, 2],
              [0, 0.7, 0, -2], [0.2, 0, 1, 0], [0, 0, 0, 1]]}}
      tube: {shape: {type: cylinder, radius: 0.5, p0: [0, -3, -1], p1: [1, -3, 1]}, light: area,
             transform: {scale: [1, 1, 2]}}
      mesh: {transform: {translate: [2, 2, 0]}, light: area,
             shape: {type: mesh, vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
                     faces: [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]}}
      spot: {light: {type: spot, cutoff_angle: 70}, transform: {translate: [0, 0, 1]}}
      bulb: {light: {type: point, intensity: 3}, transform: {translate: [1, 0, 1]}}
"""
AREA_LIGHTS = 7


def scenes(text, choice="power"):
    """The scene that moves, and for each time that which rests."""
    yield None, compiled(HEAD % (0, 1, choice) + text)
    for time in TIMES:
        still = compiled(HEAD % (time, time, choice) + text)
        assert still.program.motion == ()
        yield time, still


def columns(v):
    """Vec3 of lanes, (3, N)."""
    return np.array([np.broadcast_to(c, N) for c in (v.x, v.y, v.z)], float)


def surfaces_of(scene, at, o, d):
    """Hits and the surfaces there."""
    far, every = np.full(N, np.inf, np.float32), np.ones(N, bool)
    hit = twin_of(intersect_closest, scene)(at, Vec3(*o), Vec3(*d), far, every)
    met = np.isfinite(hit.t)
    finite = Hit(np.where(met, hit.t, 0.0).astype(np.float32), hit.u, hit.v, hit.shape, hit.prim)
    return finite, met, twin_of(make_surface, scene)(at, finite, Vec3(*o), Vec3(*d), met)


def derivatives_of(scene, at, surface):
    """dp/du and dp/dv, each (3, N)."""
    return [columns(v) for v in twin_of(uv_derivatives, scene)(at, surface)]


def test_surfaces_are_those_of_what_rests_there():
    o, d, _ = rays(N, seed=2)
    (_, moving), *still = scenes(BRUSHED + CHANGING)
    assert "shapes" in moving.program.motion and "rigid" not in moving.program.motion
    shapes = set()
    for time, scene in still:
        expected_hit, met, expected = surfaces_of(scene, scene.tables, o, d)
        hit, too, found = surfaces_of(moving, seen(moving, np.full(N, time)), o, d)
        same = met & too & (hit.shape == expected_hit.shape) & (hit.prim == expected_hit.prim)
        assert same.sum() > 0.995 * met.sum() and met.mean() > 0.2
        shapes |= set(hit.shape[same].tolist())
        for name in ("p", "ng", "ns", "s", "t"):
            a, b = columns(getattr(found, name)), columns(getattr(expected, name))
            off = np.abs(a - b).max(axis=0)[same]
            # Seen from the edge, the same rounding shifts a hit farther.
            assert np.quantile(off, 0.99) < 2e-3, (time, name, np.quantile(off, 0.99))
        for name in ("u", "v"):
            off = np.abs(np.asarray(getattr(found, name), float) - getattr(expected, name))[same]
            assert np.quantile(np.minimum(off, 1.0 - off), 0.99) < 2e-3, (time, name)
        ways = derivatives_of(moving, seen(moving, np.full(N, time)), found)
        for a, b in zip(ways, derivatives_of(scene, scene.tables, expected), strict=True):
            off = np.linalg.norm(a - b, axis=0)[same] / np.linalg.norm(b, axis=0)[same]
            assert np.quantile(off, 0.99) < 4e-3, (time, np.quantile(off, 0.99))
    assert len(shapes) == 12


@pytest.mark.parametrize("choice", ["power", "tree"])
def test_lights_and_their_densities_are_those_of_what_rests_there(choice):
    """A tree knows its lights by the boxes of their ways: there only samples are compared."""
    o, _, _ = rays(N, seed=8)
    u = np.random.default_rng(9).random((3, N)).astype(np.float32)
    up, every = Vec3(*np.tile(np.float32([[0], [0], [1]]), N)), np.ones(N, bool)
    (_, moving), *still = scenes(LAMPS, choice)
    for time, scene in still:
        at = seen(moving, np.full(N, time))
        s, resting = (
            twin_of(sample_light, one)(tables, Vec3(*o), up, u[0], (u[1], u[2]), every)
            for one, tables in ((moving, at), (scene, scene.tables))
        )
        wi = columns(s.wi).astype(np.float32)
        (met, density, light), (_, expected, its_light) = (
            density_of_rays(one, tables, o, wi)
            for one, tables in ((moving, at), (scene, scene.tables))
        )
        # The sample's own light, and not one before it.
        own = (s.pdf > 0.0) & (light > 0) & (np.abs(met / s.distance - 1.0) < 1e-3)
        assert set(light[own].tolist()) == set(range(1, AREA_LIGHTS + 1))
        check_close(density[own], s.pdf[own])
        if choice == "power":
            same = (light == its_light) & (light > 0) & (expected > 0.0)
            assert set(light[same].tolist()) == set(range(1, AREA_LIGHTS + 1))
            check_close(density[same], expected[same])
            # Lights at a point leave no choice of the direction.
            single = s.delta & (resting.pdf > 0.0)
            assert single.mean() > 0.02
            np.testing.assert_allclose(wi[:, single], columns(resting.wi)[:, single], atol=1e-5)
            radiance, its = columns(s.radiance)[:, single], columns(resting.radiance)[:, single]
            assert (its > 0.0).any()
            np.testing.assert_allclose(radiance, its, rtol=2e-3, atol=1e-4)


def density_of_rays(scene, at, o, wi):
    """(distance, density of light sampling, light + 1) of what rays come upon."""
    hit, met, surface = surfaces_of(scene, at, o, wi)
    light = np.where(met, surface.light, 0)
    density = twin_of(light_pdf, scene)(at, light, Vec3(*o), Vec3(*wi), hit.t, surface)
    return np.where(met, hit.t, np.inf), density, light


def check_close(found, expected):
    """Equal but for rounding, which is large where a light is seen from its edge."""
    off = np.abs(found.astype(float) / expected - 1.0)
    assert np.quantile(off, 0.97) < 4e-3, np.quantile(off, 0.97)
