"""Figure of docs/theory/rays-and-intersections.md: radii from a millimetre to ten kilometres."""

from math import cos, radians, sin

from pictures import render, save_beside

EXPONENTS = range(-3, 5)
# Centres lie 12 radii away: every sphere looks 9.5 degrees wide.
DISTANCE = 12.0


def scene() -> str:
    """The scene as text."""
    balls = ""
    for i, exponent in enumerate(EXPONENTS):
        r = 10.0**exponent
        azimuth = radians(-38.5 + 11.0 * i)
        x, z = DISTANCE * r * sin(azimuth), -DISTANCE * r * cos(azimuth)
        hue = i / (len(EXPONENTS) - 1)
        balls += f"""
  ball-{i}:
    shape: {{type: sphere, radius: {r!r}, center: [{x!r}, {r!r}, {z!r}]}}
    bsdf: {{type: diffuse, reflectance: [{0.8 - 0.6 * hue:.3f}, 0.4, {0.2 + 0.6 * hue:.3f}]}}"""
    return f"""
camera: {{fov: 92, fov_axis: x, transform: {{translate: [0, 0.0015, 0]}}}}
film: {{size: [960, 260]}}
environment: {{type: constant, radiance: [0.6, 0.7, 0.85]}}
nodes:
  sun:
    light: {{type: directional, irradiance: 1.8}}
    transform: {{look_at: {{origin: [0, 0, 0], target: [-1, 1.2, 1.5]}}}}
  floor:
    shape: plane
    transform: {{rotate: {{axis: x, angle: -90}}}}
    bsdf: {{type: diffuse, reflectance: 0.5}}{balls}
"""


if __name__ == "__main__":
    save_beside("theory-rays", render(scene()))
