"""Figure of docs/theory/acceleration.md: a thousand instances of one mesh."""

from pictures import icosphere, render, save_beside

SIDE = 10


def scene() -> str:
    """The scene as text: a block of 10 x 10 x 10 instances, each turned another way."""
    vertices, faces = icosphere(1)
    blocks = ""
    for i in range(SIDE**3):
        x, y, z = i % SIDE, i // SIDE % SIDE, i // SIDE**2
        blocks += f"""
  gem-{i}:
    instance: gem
    transform:
      - {{scale: [0.42, {0.25 + 0.17 * (i * 7 % 10) / 9:.3f}, 0.42]}}
      - {{rotate: {{axis: [1, 1, {i % 5}], angle: {i * 37 % 360}}}}}
      - {{translate: [{x}, {y}, {z}]}}"""
    return f"""
camera:
  fov: 28
  transform: {{look_at: {{origin: [24, 19, 28], target: [4.5, 3.9, 4.5]}}}}
film: {{size: [640, 480]}}
environment: {{type: constant, radiance: 0.5}}
prototypes:
  gem:
    shape:
      type: mesh
      vertices: {vertices.tolist()}
      faces: {faces.tolist()}
      face_normals: true
    bsdf: {{type: diffuse, reflectance: [0.25, 0.55, 0.75]}}
nodes:
  sun:
    light: {{type: directional, irradiance: 2.2}}
    transform: {{look_at: {{origin: [0, 0, 0], target: [-1, 3, 1.5]}}}}
  floor:
    shape: plane
    transform: [{{rotate: {{axis: x, angle: -90}}}}, {{translate: [0, -0.6, 0]}}]
    bsdf: {{type: diffuse, reflectance: 0.6}}{blocks}
"""


if __name__ == "__main__":
    save_beside("theory-acceleration", render(scene()))
