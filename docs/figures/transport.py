"""Figure of the README and docs/theory/light-transport.md: uniform scatter next to Lambert."""

from pictures import render, save_beside


def scene(bsdf: str) -> str:
    """The scene as text; only the ball's material differs."""
    return f"""
camera: {{fov: 32, transform: {{look_at: {{origin: [0, 1.5, 5], target: [0, 0.8, 0]}}}}}}
film: {{size: [400, 320]}}
environment: {{type: constant, radiance: 0.08}}
nodes:
  sun:
    light: {{type: directional, irradiance: 2.6}}
    transform: {{look_at: {{origin: [0, 0, 0], target: [-2, 2, 1.2]}}}}
  floor:
    shape: plane
    transform: {{rotate: {{axis: x, angle: -90}}}}
    bsdf: {{type: diffuse, reflectance: 0.5}}
  ball:
    shape: {{type: sphere, center: [0, 1, 0]}}
    bsdf: {{type: {bsdf}, reflectance: 0.8}}
"""


if __name__ == "__main__":
    save_beside("theory-transport", render(scene("uniform_scatter")), render(scene("diffuse")))
