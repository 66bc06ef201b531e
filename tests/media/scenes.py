"""One scene for many tests: three bodies with media side by side, seen by parallel rays.

A ball with a border that is not there, a ball of glass, and a box with a grid. Every test changes
numbers only, so that one compilation serves them all.
"""

import numpy as np

import alight
from alight.formats import loads
from alight.phases.henyey_greenstein import HenyeyGreenstein

WIDE, HIGH = 96, 32
RADIUS = 0.9
#: Extinction of the bodies; three channels, so that each must choose its distances rightly.
EXTINCTION = (2.0, 1.0, 0.4)
DENSITIES = [
    [[0.2, 1.0, 0.5, 0.0], [0.7, 0.1, 0.9, 0.3], [0.4, 0.6, 0.2, 0.8]],
    [[0.9, 0.3, 0.0, 0.6], [0.1, 0.8, 0.5, 1.0], [0.3, 0.0, 0.7, 0.4]],
]
TO_SUN = np.array([0.0, 3.0, 1.0]) / np.sqrt(10.0)
#: As in the closed forms of surfaces: exceeded by chance once in 150 000 numbers.
SIGMAS = 4.5
LOW, HIGH_CORNER = (1.2, -0.8, -0.8), (2.8, 0.8, 0.8)

_TEXT = f"""
alight: 1
camera: {{type: orthographic, height: 2, transform: {{translate: [0, 0, 4]}}}}
film: {{size: [{WIDE}, {HIGH}]}}
sampler: independent
environment: {{type: constant, radiance: 1}}
integrator: {{type: volpath}}
media:
  inside: {{type: homogeneous}}
  grid: {{type: grid, values: {DENSITIES}, low: {list(LOW)}, high: {list(HIGH_CORNER)}}}
nodes:
  ball: {{shape: {{type: sphere, radius: 0.9}}, bsdf: {{type: "null"}}, interior: inside}}
  glass:
    shape: {{type: sphere, center: [-2, 0, 0], radius: 0.9}}
    bsdf: {{type: dielectric}}
    interior: inside
  box:
    transform: [{{scale: 0.8}}, {{translate: [2, 0, 0]}}]
    shape: cube
    bsdf: {{type: "null"}}
    interior: grid
  sun:
    transform: {{look_at: {{origin: [0, 0, 0], target: [0, 3, 1]}}}}
    light: {{type: directional, irradiance: 0}}
"""


def bodies(albedo, extinction=EXTINCTION, g: float = 0.0, emission=0.0, **changes) -> alight.Scene:
    """The scene with these numbers in all of its media; `changes` are fields of the scene."""
    scene = loads(_TEXT, "bodies")
    numbers = {"sigma_t": extinction, "albedo": albedo, "phase": HenyeyGreenstein(g=g)}
    numbers |= {"emission": emission}
    media = {name: medium.replaced(**numbers) for name, medium in scene.media.items()}
    return scene.replaced(media=media, **changes)


def sun(scene: alight.Scene, irradiance: float) -> alight.Scene:
    """The scene in the light of the sun alone, towards which `TO_SUN` points."""
    node = scene.nodes["sun"]
    light = node.light.replaced(irradiance=irradiance)
    return scene.replaced(
        nodes={**scene.nodes, "sun": node.replaced(light=light)},
        environment=scene.environment.replaced(radiance=0.0),
    )


def columns() -> tuple[slice, slice, slice]:
    """Columns of the picture that show the glass, the ball and the box."""
    third = WIDE // 3
    return slice(0, third), slice(third, 2 * third), slice(2 * third, WIDE)


def places(per_pixel: int) -> tuple[np.ndarray, np.ndarray]:
    """x and y of the rays through the pixels of one body, from its middle.

    Shape (HIGH, WIDE / 3, per_pixel^2).
    """
    n = HIGH * per_pixel
    at = (np.arange(n) + 0.5) / n * 2.0 - 1.0
    x, y = np.meshgrid(at, -at)

    def by_pixel(values: np.ndarray) -> np.ndarray:
        parts = values.reshape(HIGH, per_pixel, HIGH, per_pixel)
        return parts.transpose(0, 2, 1, 3).reshape(HIGH, HIGH, -1)

    return by_pixel(x), by_pixel(y)


def agree(found: np.ndarray, expected: np.ndarray, pixels: np.ndarray, largest: float) -> None:
    """Pixels are what they should be, within their own noise, and that is small.

    Parameters
    ----------
    found, expected : (h, w, 3)
    pixels : (h, w) bool
        Which count.
    largest : float
        Most noise of the mean, over the mean.
    """
    off = (found.astype(np.float64) - expected)[pixels]
    mean, error = off.mean(0), off.std(0, ddof=1) / np.sqrt(len(off))
    bright = expected[pixels].mean(0)
    assert np.all(np.abs(mean) <= SIGMAS * error + 3e-6 * bright), (mean / error, mean, bright)
    assert np.all(SIGMAS * error < largest * bright), SIGMAS * error / bright


def interpolated(x, y, z, values=DENSITIES) -> np.ndarray:
    """Values between the centres of the grid's cells, in float64."""
    values, result = np.asarray(values), np.zeros(())
    axes = []
    for at, low, high, count in zip((x, y, z), LOW, HIGH_CORNER, values.shape[::-1], strict=True):
        place = np.clip((at - low) / (high - low) * count - 0.5, 0, count - 1)
        first = np.minimum(place.astype(int), count - 2)
        axes.append(((first, 1.0 - place + first), (first + 1, place - first)))
    for ix, wx in axes[0]:
        for iy, wy in axes[1]:
            for iz, wz in axes[2]:
                result = result + values[iz, iy, ix] * wx * wy * wz
    return result
