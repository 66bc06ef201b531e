"""Figure of docs/theory/camera.md: pinhole next to thin lens."""

from pictures import render, save_beside

DISTANCES = (3.0, 4.5, 6.0, 9.0, 14.0)


def scene(camera: str) -> str:
    """The scene as text; spheres lie along a diagonal, at `DISTANCES` from the camera."""
    balls = "".join(
        f"""
  ball-{i}:
    shape: {{type: sphere, radius: 0.5, center: [{(i - 2) * 0.19 * z}, 0.5, {-z}]}}
    bsdf: {{type: phong, diffuse: [0.1, {0.15 + 0.1 * i}, 0.5], specular: 0.2, exponent: 60}}"""
        for i, z in enumerate(DISTANCES)
    )
    return f"""
camera: {{{camera}, fov: 34, transform: {{translate: [0, 1, 0]}}}}
film: {{size: [440, 300]}}
environment: {{type: constant, radiance: 0.8}}
nodes:
  lamp:
    shape: disk
    light: {{type: area, radiance: 12}}
    transform: [{{rotate: {{axis: x, angle: 90}}}}, {{translate: [-3, 8, -5]}}]
  floor:
    shape: plane
    transform: {{rotate: {{axis: x, angle: -90}}}}
    bsdf:
      type: diffuse
      reflectance: {{type: checkerboard, scale: 1, color0: 0.75, color1: 0.35}}{balls}
"""


if __name__ == "__main__":
    save_beside(
        "theory-camera",
        render(scene("type: pinhole")),
        render(scene(f"type: thin_lens, aperture_radius: 0.12, focus_distance: {DISTANCES[2]}")),
    )
