"""A smoky room lit through a gap: what guided paths meet in media, all in one scene."""

from alight.formats import loads
from alight.media.homogeneous import Homogeneous
from alight.scene.description import Scene

#: What fills the room.
FOG = Homogeneous(sigma_t=(0.3, 0.5, 0.8), albedo=(0.95, 0.9, 0.8))

#: Fog that dims channels differently, a cloud of another phase function without a surface, a
#: curtain with holes, glass with a medium within, a material of both lobes; the lamp is hidden.
ROOM = """
alight: 1
camera: {type: pinhole, fov: 70, transform: {look_at: {origin: [0, 0, 0.9], target: [0, -0.2, -1]}}}
film: {size: [40, 32]}
sampler: independent
integrator: {type: volpath, max_depth: 7, hide_emitters: true, guiding: "on"}
medium: fog
media:
  fog:
    type: homogeneous
    sigma_t: [0.3, 0.5, 0.8]
    albedo: [0.95, 0.9, 0.8]
    phase: {type: henyey_greenstein, g: 0.6}
  cloud: {type: homogeneous, sigma_t: 4, albedo: 0.9}
  tea: {type: homogeneous, sigma_t: [1, 2, 4], albedo: 0.5, phase: {type: rayleigh}}
textures:
  net: {type: checkerboard, color0: 1, color1: 0.2, scale: 6}
bsdfs:
  grey: {type: two_sided, bsdf: {type: diffuse, reflectance: 0.7}}
  shiny: {type: two_sided, bsdf: {type: plastic, diffuse_reflectance: [0.6, 0.3, 0.2]}}
  curtain: {type: mask, opacity: net, bsdf: grey}
nodes:
  floor: {shape: rectangle, bsdf: shiny, transform: [{scale: 2}, {rotate: {axis: x, angle: -90}}, {translate: [0, -1, -1]}]}
  ceiling: {shape: rectangle, bsdf: grey, transform: [{scale: 2}, {rotate: {axis: x, angle: 90}}, {translate: [0, 1, -1]}]}
  left: {shape: rectangle, bsdf: grey, transform: [{scale: 2}, {rotate: {axis: y, angle: 90}}, {translate: [-1, 0, -1]}]}
  right: {shape: rectangle, bsdf: grey, transform: [{scale: 2}, {rotate: {axis: y, angle: -90}}, {translate: [1, 0, -1]}]}
  far: {shape: rectangle, bsdf: grey, transform: [{scale: 1}, {translate: [0, 0, -3]}]}
  near: {shape: rectangle, bsdf: grey, transform: [{scale: 1}, {translate: [0, 0, 1]}]}
  wall: {shape: rectangle, bsdf: grey, transform: [{scale: [0.5, 1, 1]}, {translate: [-0.5, 0, -1]}]}
  curtain: {shape: rectangle, bsdf: curtain, transform: [{scale: [0.3, 1, 1]}, {translate: [0.7, 0, -1.2]}]}
  cloud:
    shape: {type: sphere, radius: 0.3}
    bsdf: {type: "null"}
    interior: cloud
    transform: {translate: [0.5, -0.4, -0.4]}
  cup:
    shape: {type: sphere, radius: 0.25}
    bsdf: {type: dielectric}
    interior: tea
    exterior: fog
    transform: {translate: [-0.4, -0.7, -0.3]}
  lamp:
    shape: rectangle
    light: {type: area, radiance: 10}
    transform: [{scale: 0.6}, {rotate: {axis: x, angle: 90}}, {translate: [-0.2, 0.98, -1.9]}]
"""  # noqa: E501


def room(text: str = ROOM, **options) -> Scene:
    """The room with other options of its integrator."""
    scene = loads(text, "room.yaml")
    return scene.replaced(integrator=scene.integrator.replaced(**options))
