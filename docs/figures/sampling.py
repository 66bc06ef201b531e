"""Figure of docs/theory/sampling-and-monte-carlo.md: uniform next to cosine sampling."""

from pictures import render, save_beside

SPP = 16


def scene(sampling: str) -> str:
    """The scene as text; light is found by BSDF sampling alone, so the density shows."""
    return f"""
camera: {{fov: 34, transform: {{look_at: {{origin: [0, 1.6, 5.5], target: [0, 0.65, 0]}}}}}}
film: {{size: [400, 300]}}
sampler: independent
integrator: {{type: path, light_sampling: bsdf, max_depth: 6}}
environment: {{type: constant, radiance: 1}}
bsdfs:
  grey: {{type: diffuse, reflectance: 0.6, sampling: {sampling}}}
  red: {{type: diffuse, reflectance: [0.6, 0.2, 0.15], sampling: {sampling}}}
nodes:
  floor: {{shape: plane, bsdf: grey, transform: {{rotate: {{axis: x, angle: -90}}}}}}
  ball: {{shape: {{type: sphere, radius: 0.8, center: [0.75, 0.8, 0]}}, bsdf: red}}
  box:
    shape: cube
    bsdf: grey
    transform:
      - {{scale: [0.5, 0.9, 0.5]}}
      - {{rotate: {{axis: y, angle: 25}}}}
      - {{translate: [-0.9, 0.9, 0]}}
"""


if __name__ == "__main__":
    save_beside(
        "theory-sampling", render(scene("uniform"), spp=SPP), render(scene("cosine"), spp=SPP)
    )
