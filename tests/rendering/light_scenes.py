"""Small scenes for paths from lights, and whether two pictures of one scene agree."""

from __future__ import annotations

import numpy as np

import alight
from alight.formats import loads
from alight.metrics.statistics import student_t_tail

REPLICATES, BLOCK, DEPTH = 32, 8, 6

SCENE = """
alight: 1
film: {size: [48, 48], filter: %s}
sampler: independent
camera: {%s}
nodes:
  floor:
    shape: rectangle
    bsdf: {type: diffuse, reflectance: [0.6, 0.5, 0.4]}
    transform: [{rotate: {axis: x, angle: -90}}, {scale: 4}]
  block:
    shape: cube
    bsdf: {type: plastic}
    transform: [{scale: 0.4}, {rotate: {axis: y, angle: 30}}, {translate: [0.8, 0.4, 0.3]}]
"""
LOOK = "transform: {look_at: {origin: [0, 2, 5], target: [0, 0.6, 0]}}"
PINHOLE, ORTHO = f"type: pinhole, fov: 50, {LOOK}", f"type: orthographic, height: 4, {LOOK}"
LENS = f"type: thin_lens, fov: 50, aperture_radius: 0.3, focus_distance: 3.5, {LOOK}"
BALL = "  ball: {shape: {type: sphere, center: [-0.7, 0.6, 0], radius: 0.6}, bsdf: %s}\n"
LAMP = """
  lamp:
    shape: disk
    light: {type: area, radiance: 15}
    transform: [{rotate: {axis: x, angle: 90}}, {scale: 0.7}, {translate: [0, 3, 1]}]
"""
SPOT = """
  spot:
    light: {type: spot, intensity: [60, 40, 30], cutoff_angle: 30}
    transform: {look_at: {origin: [2, 4, 3], target: [0, 0, 0]}}
  bulb: {light: {type: point, intensity: [9, 10, 15]}, transform: {translate: [-1.5, 2.5, 1]}}
  far:
    light: {type: directional, irradiance: [2, 2, 1]}
    transform: {rotate: {axis: x, angle: 60}}
"""
#: An octahedron that is shaded as a ball: shading normals far from those of its faces.
GEM = """
  gem:
    bsdf: {type: diffuse, reflectance: 0.8}
    transform: [{scale: 0.7}, {translate: [-0.7, 0.7, 0]}]
    shape:
      type: mesh
      vertices: [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]
      normals: [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]
      faces: [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4],
              [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
"""
SKY = "environment: {type: sunsky, sun_direction: [0.4, 1, 0.6], scale: 0.02}\n"
HOLES = "{type: mask, opacity: 0.4, bsdf: {type: diffuse, reflectance: 0.7}}"
ROUGH = "{type: rough_dielectric, alpha: 0.4}"

#: Everything is below the surface of water but the lamp.
UNDER_WATER = """
alight: 1
film: {size: [48, 48]}
sampler: independent
camera: {type: pinhole, fov: 60, transform: {look_at: {origin: [0, 1, 2], target: [0, 0, 0]}}}
nodes:
  floor: {shape: rectangle, transform: [{rotate: {axis: x, angle: -90}}, {scale: 3}]}
  surface:
    shape: rectangle
    bsdf: {type: dielectric, int_ior: 1.5}
    transform: [{rotate: {axis: x, angle: -90}}, {scale: 50}, {translate: [0, 1.5, 0]}]
  lamp:
    shape: rectangle
    light: {type: area, radiance: 3}
    transform: [{rotate: {axis: x, angle: 90}}, {scale: 2}, {translate: [0, 3, 0]}]
"""

#: The same water, stained and rough, seen from below.
STAINED = (
    "{type: rough_dielectric, alpha: 0.5, int_ior: 1.2, "
    "attenuation_color: [0.8, 0.3, 0.5], attenuation_distance: 1}"
)
STAINED_WATER = UNDER_WATER.replace(
    "origin: [0, 1, 2], target: [0, 0, 0]", "origin: [0, 0.4, 0.5], target: [0, 1.5, 0]"
).replace("{type: dielectric, int_ior: 1.5}", STAINED)

#: The lamp shines at the ceiling, which lights the floor: light comes over three edges at least.
CEILING = """
  ceiling:
    shape: rectangle
    bsdf: {type: diffuse, reflectance: 0.8}
    transform: [{rotate: {axis: x, angle: 90}}, {scale: 4}, {translate: [0, 4, 0]}]
"""
#: With a ball, as in "a lamp": so both need the same kernels.
ROOM = SCENE % ("box", PINHOLE) + BALL % "{type: phong}"
BY_THE_CEILING = ROOM + LAMP.replace("angle: 90", "angle: -90") + CEILING

CASES = {
    "a lamp": ROOM + LAMP,
    "points and directions by a lens, shading normals": SCENE % ("tent", LENS) + GEM + SPOT,
    "under water": UNDER_WATER,
}
LONG_CASES = {
    # The sun's image in a polished block is a caustic that path tracing hardly ever finds.
    "sun and sky": (SCENE % ("gaussian", PINHOLE) + BALL % "{type: diffuse}" + SKY).replace(
        "type: plastic", "type: rough_plastic, alpha: 0.3"
    ),
    "holes, in parallel": SCENE % ("box", ORTHO) + BALL % HOLES + LAMP,
    "rough glass": SCENE % ("box", PINHOLE) + BALL % ROUGH + LAMP,
}

#: A lamp that no shadow ray reaches, a mirror, shading normals, and what is seen through glass.
IN_GLASS = (
    SCENE % ("box", PINHOLE)
    + BALL % "{type: mirror, reflectance: 0.8}"
    + GEM.replace("[-0.7, 0.7, 0]", "[-1.6, 0.7, 1.2]")
    + """
  globe:
    shape: {type: sphere, center: [0.5, 1.7, 1], radius: 0.7}
    bsdf: {type: dielectric, int_ior: 1.5}
  lamp:
    shape: {type: sphere, center: [0.5, 1.7, 1], radius: 0.4}
    bsdf: {type: diffuse, reflectance: 0.3}
    light: {type: area, radiance: 8}
  walls:
    shape: cube
    bsdf: {type: diffuse, reflectance: 0.5}
    transform: [{scale: [4, 4, 6]}, {translate: [0, 3.99, 0]}]
"""
)

STAIN = "attenuation_color: [0.9, 0.4, 0.2], attenuation_distance: 0.4"
#: Where nothing of it is seen: what `MANY` or `IN_STAINED_GLASS` alone would have.
UNDER_THE_FLOOR = "".join(
    f"  under {i}: {{shape: {shape}, bsdf: {bsdf}, light: {{type: area, radiance: 1e-3}}, "
    f"transform: [{{scale: 1e-3}}, {{translate: [{0.1 * i}, -0.5, 0]}}]}}\n"
    for i, (shape, bsdf) in enumerate(
        [
            ("disk", "{type: mirror}"),
            ("sphere", f"{{type: dielectric, {STAIN}}}"),
            (
                "{type: mesh, vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], faces: [[0, 1, 2]]}",
                "{type: rough_conductor, alpha: 0.2}",
            ),
        ]
    )
)

#: Lamps of every kind, so many that a light tree is walked.
MANY = (
    SCENE % ("box", PINHOLE)
    + BALL % "{type: rough_conductor, alpha: 0.2}"
    + LAMP
    + "".join(
        f"  bulb{i}: {{light: {{type: {kind}, intensity: {1 + i % 3}}}, "
        f"transform: {{look_at: {{origin: [{-3 + 0.35 * i}, {0.5 + 0.1 * (i % 4)}, -1.5], "
        "target: [0, 0, 0]}}}\n"
        for i, kind in enumerate(["point", "spot"] * 10)
    )
    + """
  sun: {light: {type: directional, irradiance: 0.5}, transform: {rotate: {axis: x, angle: 70}}}
"""
    + UNDER_THE_FLOOR
    + "environment: {type: constant, radiance: 0.1}\n"
)

#: Glass that dims what leaves the lamp, but for the piece of the way that ends at the lamp. The
#: lamps under the floor are next to dark: with them it needs the same kernels as `MANY`.
IN_STAINED_GLASS = (
    IN_GLASS.replace("int_ior: 1.5", f"int_ior: 1.5, {STAIN}")
    + UNDER_THE_FLOOR
    + "".join(
        f"  dim{i}: {{light: {{type: {kind}: 1e-9}}, transform: {{translate: [0, -0.7, 0]}}}}\n"
        for i, kind in enumerate(
            ["point, intensity", "spot, intensity"] * 10 + ["directional, irradiance"]
        )
    )
    + "environment: {type: constant, radiance: 1e-9}\n"
)


def pictures(text, integrator, spp, seed):
    """Means of the replicates, (48, 48, REPLICATES, 3)."""
    scene = loads(text, "scene.yaml").replaced(integrator=integrator)
    film = alight.render(scene, spp=spp, seed=seed, replicates=REPLICATES)
    assert film.invalid == 0
    return film.replicate_means()[0].astype(float)


def p_value(mine, other):
    """Of the largest difference of blocks, and of the picture's channels, by Student's test."""
    n = len(mine) // BLOCK
    whole = [p.mean(axis=(0, 1)) for p in (mine, other)]
    parts = [
        p.reshape(n, BLOCK, n, BLOCK, REPLICATES, 3).mean(axis=(1, 3, 5)) for p in (mine, other)
    ]
    worst = 1.0
    for (a, b), axis in ((whole, 0), (parts, 2)):
        gap = np.abs(a.mean(axis=axis) - b.mean(axis=axis))
        error = np.sqrt((a.var(axis=axis, ddof=1) + b.var(axis=axis, ddof=1)) / REPLICATES)
        t = np.where(gap > 0.0, gap / np.maximum(error, 1e-12), 0.0)
        tail = 2.0 * student_t_tail(float(t.max()), REPLICATES - 1.0)
        worst = min(worst, tail * t.size)
    return worst


def small(integrator, **changes):
    """A lamp above a block, 24 x 40 pixels, with other options of the film."""
    scene = loads(CASES["a lamp"], "scene.yaml").replaced(integrator=integrator)
    return scene.replaced(film=scene.film.replaced(size=(24, 40), **changes))


def same(a, b):
    """Whether two films have the same bits."""
    return np.array_equal(a.sums, b.sums) and np.array_equal(a.counts, b.counts)
