"""Figure of docs/theory/vectors.md: one mesh with interpolated and with face normals."""

from pictures import icosphere, render, save_beside


def scene(face_normals: bool) -> str:
    """The scene as text."""
    vertices, faces = icosphere(2)
    return f"""
camera: {{fov: 30, transform: {{translate: [0, 0, 4.2]}}}}
film: {{size: [400, 400]}}
environment: {{type: constant, radiance: 0.25}}
nodes:
  sun:
    light: {{type: directional, irradiance: 2.2}}
    transform: {{look_at: {{origin: [0, 0, 0], target: [2, 3, 2]}}}}
  ball:
    shape:
      type: mesh
      vertices: {vertices.tolist()}
      faces: {faces.tolist()}
      normals: {vertices.tolist()}
      face_normals: {str(face_normals).lower()}
    bsdf: {{type: diffuse, reflectance: [0.8, 0.45, 0.2]}}
"""


if __name__ == "__main__":
    save_beside("theory-vectors", render(scene(False)), render(scene(True)))
