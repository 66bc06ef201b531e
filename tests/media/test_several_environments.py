"""Fog in the light of several environments: single scattering against quadrature."""

import numpy as np
import pytest

from alight.lights.misses import environment_radiance
from lanewise.jit import instantiate
from lanewise.vec3 import Vec3
from tests.motion.moving import compiled, picture

EXTINCTION, ALBEDO, G, RADIUS = 1.2, 0.8, 0.4, 0.9
FOG = f"""
alight: 1
film: {{size: [8, 8]}}
sampler: independent
integrator: {{type: volpath, max_depth: 2, light_sampling: %s, light_choice: %s}}
camera: {{type: orthographic, height: 0.01, transform: {{translate: [0, 0, 4]}}}}
environment: {{type: environment, pixels: [[[1, 1, 1]], [[0.2, 1, 1]], [[0.5, 1, 1]]]}}
media:
  fog:
    type: homogeneous
    sigma_t: {EXTINCTION}
    albedo: {ALBEDO}
    phase: {{type: henyey_greenstein, g: {G}}}
nodes:
  ball:
    shape: {{type: sphere, radius: {RADIUS}}}
    bsdf: {{type: "null"}}
    interior: fog
  even: {{light: {{type: constant, radiance: 0.2}}}}
  sun: {{light: {{type: sun, sun_direction: [1, 2, -1], diameter: 40, scale: 0.004}}}}
  lamp: {{light: {{type: point, intensity: 0.5}}, transform: {{translate: [0, -3, 0]}}}}
"""


def sum_of_environments(scene, d):
    """Red radiance from directions (3, n)."""
    text = instantiate(environment_radiance, scene.program, compiled=False)
    with np.errstate(all="ignore"):
        found = text(scene.tables, Vec3(*d.astype(np.float32))).x
    return np.broadcast_to(found, d.shape[1]).astype(float)


def phase(cosine):
    return (1.0 - G * G) / (4.0 * np.pi * (1.0 + G * G - 2.0 * G * cosine) ** 1.5)


def expected(scene):
    """Red radiance along the axis: what comes through the ball, and what it scatters once."""
    nodes, weights = np.polynomial.legendre.leggauss(12)
    depth, step = RADIUS * (1.0 + nodes), RADIUS * weights
    n = 500
    z, turn = (np.mgrid[:n, : 2 * n] + 0.5) / [[[n]], [[2 * n]]]
    z, turn = 2.0 * z.ravel() - 1.0, 2.0 * np.pi * turn.ravel()
    d = np.stack([np.sqrt(1.0 - z * z) * np.cos(turn), np.sqrt(1.0 - z * z) * np.sin(turn), z])
    light = sum_of_environments(scene, d) * phase(-z) * (4.0 * np.pi / z.size)
    behind = sum_of_environments(scene, np.array([[0.0], [0.0], [-1.0]]))[0]
    total = behind * np.exp(-2.0 * RADIUS * EXTINCTION)
    for t, dt in zip(depth, step, strict=True):
        at = RADIUS - t
        out = -at * z + np.sqrt(at * at * z * z + RADIUS**2 - at * at)
        arriving = np.sum(light * np.exp(-EXTINCTION * out))
        # The lamp, 3 m below, and its way through the ball.
        far = np.hypot(3.0, at)
        cosine = at / far
        inside = -at * cosine + np.sqrt((at * cosine) ** 2 + RADIUS**2 - at * at)
        lamp = 0.5 / far**2 * phase(cosine) * np.exp(-EXTINCTION * inside)
        scattered = ALBEDO * EXTINCTION * np.exp(-EXTINCTION * t) * dt
        total += scattered * (arriving + lamp)
    return total


@pytest.mark.parametrize(
    ("how", "choice"),
    [
        ("mis", "power"),
        ("mis", "tree"),
        pytest.param("emitter", "power", marks=pytest.mark.proofs),
    ],
)
def test_fog_scatters_the_light_of_all_environments(how, choice):
    text = FOG % (how, choice)
    _, replicates = picture(text, 96)
    parts = replicates.reshape(-1)
    error = parts.std() / np.sqrt(len(parts))
    wanted = expected(compiled(text))
    assert abs(parts.mean() - wanted) < 4.0 * error
    assert error < 0.01 * wanted
