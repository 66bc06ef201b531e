"""The small test scenes as Mitsuba 3 dictionaries, one function each.

Every function here has a twin of the same name in ``scenes/NAME.yaml`` (``cornell-box`` is built
in). The two are written separately, each in its renderer's own conventions, so that a mistake in
one of them shows up as a difference between the pictures.

Conventions that differ: Mitsuba's cameras look along local +z with +x to the left of the picture,
ours along -z with +x to the right (both are placed by look-at here, which hides it).
"""

from typing import Any

from mitsuba_parts import (
    AXIS,
    MESHES,
    WIDE,
    SceneDict,
    area,
    ball,
    base,
    camera,
    ceiling_light,
    checkerboard,
    diffuse,
    ground,
    parallelogram,
    rgb,
    room,
    scene,
    sphere_mesh,
)


@scene
def cornell_box(mi: Any) -> SceneDict:
    """Mitsuba's own Cornell box at 64x64."""
    box = mi.cornell_box()
    film = box["sensor"]["film"]
    film.update(width=64, height=64, pixel_format="rgb", component_format="float32")
    film["rfilter"] = {"type": "box"}
    box["sensor"]["sampler"] = {"type": "independent", "sample_count": 16}
    box["integrator"] = {"type": "path", "max_depth": 8, "rr_depth": 5}
    return box


@scene
def sphere_light(mi: Any) -> SceneDict:
    """Show a spherical light and a sphere in the room."""
    light = ball(mi, (0.3, 0.4, 0.1), 0.25, diffuse(0.0)) | {"emitter": area(4, 3, 2)}
    return room(mi) | {"lamp": light, "ball": ball(mi, (-0.35, -0.55, 0.1), 0.45, diffuse(0.6))}


@scene
def specular_spheres(mi: Any) -> SceneDict:
    """Show mirror, glass and gold spheres under a large light."""
    gold = {
        "type": "conductor",
        "eta": rgb(0.143, 0.375, 1.442),
        "k": rgb(3.983, 2.386, 1.603),
    }
    mirror = {"type": "conductor", "material": "none", "specular_reflectance": rgb(0.9, 0.8, 0.7)}
    glass = {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0}
    return room(mi, 12) | {
        "light": ceiling_light(mi, 0.9, 2.0, 1.9, 1.7),
        "mirror": ball(mi, (-0.5, -0.6, -0.3), 0.4, mirror),
        "glass": ball(mi, (0.45, -0.6, 0.2), 0.38, glass),
        "gold": ball(mi, (0.1, 0.25, -0.4), 0.35, gold),
    }


@scene
def point_light(mi: Any) -> SceneDict:
    """Show a point light in the room, off centre."""
    return room(mi) | {
        "lamp": {"type": "point", "position": [0.4, 0.3, 0.4], "intensity": rgb(1.5, 1.2, 0.9)},
        "ball": ball(mi, (-0.3, -0.5, -0.2), 0.4, diffuse(0.3, 0.5, 0.7)),
    }


@scene
def directional_light(mi: Any) -> SceneDict:
    """Sunlight falling into the room, seen from the side, picture wider than high."""
    sun = {"type": "directional", "direction": [0.5, -0.8, -1.0], "irradiance": rgb(3, 2.8, 2.4)}
    view = camera(mi, (0.5, 0.3, 2.9), (0, -0.15, 0), 42, WIDE, fov_axis="y")
    ball_ = ball(mi, (0.1, -0.5, 0.1), 0.5, diffuse(0.5))
    return room(mi) | {"sensor": view, "sun": sun, "ball": ball_}


@scene
def disk_light(mi: Any) -> SceneDict:
    """Show a tilted disk light in the room."""
    place = mi.ScalarTransform4f().translate([0.35, 0.6, -0.2]).rotate([0, 0, 1], -30)
    disk = {
        "type": "disk",
        "to_world": place.rotate([1, 0, 0], 90).scale(0.4),
        "bsdf": diffuse(0.4),
        "emitter": area(5, 5, 4),
    }
    return room(mi) | {"lamp": disk, "ball": ball(mi, (-0.3, -0.6, 0.2), 0.35, diffuse(0.6))}


@scene
def ellipsoid_light(mi: Any) -> SceneDict:
    """Show an ellipsoid as light and one as object; fine meshes here, scaled spheres in the twin.

    A subdivided icosahedron of 327 680 triangles misses 3e-5 of the sphere's area.
    """
    place = mi.ScalarTransform4f
    lamp = place().translate([0.3, 0.45, 0.0]).rotate([0, 0, 1], 25).scale([0.45, 0.12, 0.25])
    egg = place().translate([-0.3, -0.4, 0.1]).rotate([0.6, 0.8, 0], 40).scale([0.25, 0.55, 0.35])
    filename = str(sphere_mesh(mi))
    return room(mi) | {
        "lamp": {
            "type": "ply",
            "filename": filename,
            "to_world": lamp,
            "bsdf": diffuse(0.0),
            "emitter": area(6, 5, 4),
        },
        "egg": {"type": "ply", "filename": filename, "to_world": egg, "bsdf": diffuse(0.6)},
    }


@scene
def sheared_light(mi: Any) -> SceneDict:
    """Show a parallelogram as light (a sheared rectangle in the twin)."""
    corners = [(-0.9, 0.55, -0.5), (0.1, 0.55, -0.5), (0.7, 0.8, 0.5), (-0.3, 0.8, 0.5)]
    shape = parallelogram(mi, corners) | {"bsdf": diffuse(0.3), "emitter": area(3, 3.5, 3)}
    return room(mi) | {"lamp": shape, "ball": ball(mi, (0.3, -0.6, 0.2), 0.35, diffuse(0.6))}


@scene
def cube_light(mi: Any) -> SceneDict:
    """Show a flattened, rotated cube as light beside a rotated cube."""
    place = mi.ScalarTransform4f
    lamp = place().translate([0.2, 0.4, 0.0]).rotate(AXIS, 50).scale([0.35, 0.08, 0.2])
    block = place().translate([-0.3, -0.6, 0.1]).rotate([0, 1, 0], 35).scale([0.3, 0.4, 0.3])
    light = {"type": "cube", "to_world": lamp, "bsdf": diffuse(0.2), "emitter": area(5, 4, 4)}
    return room(mi) | {
        "lamp": light,
        "block": {"type": "cube", "to_world": block, "bsdf": diffuse(0.6)},
    }


@scene
def mesh_light(mi: Any) -> SceneDict:
    """Show an icosahedron from a file as light, face normals."""
    place = mi.ScalarTransform4f().translate([0.2, 0.3, 0.2]).rotate(AXIS, 30)
    lamp = {
        "type": "ply",
        "filename": str(MESHES / "icosahedron.ply"),
        "face_normals": True,
        "to_world": place.scale([0.2, 0.4, 0.3]),
        "bsdf": diffuse(0.0),
        "emitter": area(4, 4, 3),
    }
    return room(mi) | {"lamp": lamp, "ball": ball(mi, (-0.4, -0.6, 0.1), 0.35, diffuse(0.6))}


@scene
def environment(mi: Any) -> SceneDict:
    """Two balls on the ground under a constant sky; field of view over the diagonal."""
    return base() | {
        "sensor": camera(mi, (2, 2.6, 4), (0, 0.35, 0), 50, WIDE, fov_axis="diagonal"),
        "sky": {"type": "constant", "radiance": rgb(0.7, 0.9, 1.2)},
        "ground": ground(mi, 3.0, diffuse(0.5, 0.45, 0.4)),
        "ball": ball(mi, (-0.5, 0.7, 0), 0.7, diffuse(0.8, 0.4, 0.3)),
        "small": ball(mi, (0.8, 0.35, 0.6), 0.35, diffuse(0.3, 0.6, 0.4)),
    }


@scene
def infinite_plane(mi: Any) -> SceneDict:
    """Show a ball on ground that is as good as infinite: no horizon in view."""
    sun = {"type": "directional", "direction": [-0.6, -1.0, -0.3], "irradiance": rgb(1.5, 1.4, 1.2)}
    return base() | {
        "sensor": camera(mi, (0, 3, 5), (0, 0.3, 0), 40),
        "sky": {"type": "constant", "radiance": rgb(0.3, 0.4, 0.6)},
        "sun": sun,
        "ground": ground(mi, 4000.0, diffuse(0.5, 0.45, 0.4)),
        "ball": ball(mi, (0, 0.8, 0), 0.7, diffuse(0.6)),
    }


@scene
def thin_lens(mi: Any) -> SceneDict:
    """Three balls in a row, the middle one in focus."""
    view = camera(
        mi, (-2, 2.2, 4), (0, 0.2, 0), 34, type="thinlens", aperture_radius=0.2, focus_distance=4.5
    )
    return base() | {
        "sensor": view,
        "sky": {"type": "constant", "radiance": rgb(0.8, 0.9, 1.0)},
        "ground": ground(mi, 4.0, checkerboard(mi, 4.0)),
        "near": ball(mi, (-1.0, 0.4, 1.6), 0.4, diffuse(0.7, 0.3, 0.2)),
        "middle": ball(mi, (0, 0.5, 0), 0.5, diffuse(0.3, 0.7, 0.2)),
        "far": ball(mi, (1.2, 0.6, -2.0), 0.6, diffuse(0.2, 0.3, 0.7)),
    }


@scene
def orthographic(mi: Any) -> SceneDict:
    """Show the room from the side without perspective; the picture is 2.4 m wide."""
    look = mi.ScalarTransform4f().look_at(origin=[0.8, 0.6, 4], target=[0, 0, 0], up=[0, 1, 0])
    view = camera(mi, (0, 0, 1), (0, 0, 0), size=WIDE, type="orthographic", fov=None)
    view["to_world"] = look.scale([1.2, 1.2, 1])
    return room(mi) | {
        "sensor": view,
        "light": ceiling_light(mi, 0.5, 4, 4, 4),
        "ball": ball(mi, (0.3, -0.5, 0.2), 0.4, diffuse(0.6)),
    }


@scene
def checkerboard_texture(mi: Any) -> SceneDict:
    """Checkers on the ground, on a tilted rectangle and on a ball, under a sky and a lamp."""
    place = mi.ScalarTransform4f().translate([0.9, 0.8, -0.8]).rotate([0, 1, 0], -30)
    lamp = ball(mi, (-1.5, 2.5, 1.5), 0.4, diffuse(0.0)) | {"emitter": area(6, 6, 6)}
    return base() | {
        "sensor": camera(mi, (0.5, 2.6, 4), (0, 0.2, 0), 36),
        "sky": {"type": "constant", "radiance": rgb(0.4, 0.5, 0.6)},
        "lamp": lamp,
        "ground": ground(mi, 2.0, checkerboard(mi, 3.0)),
        "board": {"type": "rectangle", "to_world": place.scale(0.7), "bsdf": checkerboard(mi, 2.0)},
    }


@scene
def smooth_mesh(mi: Any) -> SceneDict:
    """Show a torus with interpolated normals above a faceted one."""
    place = mi.ScalarTransform4f
    smooth = place().translate([0.1, 0.15, -0.1]).rotate([1, 0, 0], 50).scale(0.55)
    faceted = place().translate([-0.1, -0.75, 0.1]).scale([0.6, 0.4, 0.6])
    torus = {"type": "ply", "filename": str(MESHES / "torus.ply"), "bsdf": diffuse(0.6)}
    return room(mi) | {
        "light": ceiling_light(mi, 0.5, 4, 4, 4),
        "smooth": torus | {"to_world": smooth, "face_normals": False},
        "faceted": torus | {"to_world": faceted, "face_normals": True},
    }


@scene
def instances(mi: Any) -> SceneDict:
    """Twelve instances of one faceted mesh, each turned and squeezed, one mirrored."""
    group = {
        "type": "shapegroup",
        "gem": {
            "type": "ply",
            "filename": str(MESHES / "icosahedron.ply"),
            "face_normals": True,
            "bsdf": diffuse(0.7, 0.5, 0.3),
        },
    }
    contents = room(mi) | {"light": ceiling_light(mi, 0.5, 4, 4, 4), "gems": group}
    for i in range(12):
        x, y, z = 0.45 * (i % 4) - 0.675, 0.6 * (i // 4) - 0.6, 0.3 * (i % 3) - 0.3
        place = mi.ScalarTransform4f().translate([x, y, z]).rotate(AXIS, 30 * i)
        scale = [0.2, 0.12 + 0.01 * i, -0.2 if i == 7 else 0.2]
        contents[f"gem{i}"] = {
            "type": "instance",
            "to_world": place.scale(scale),
            "shapegroup": {"type": "ref", "id": "gems"},
        }
    return contents


@scene
def two_sided(mi: Any) -> SceneDict:
    """Panels seen from behind: one two-sided, one one-sided (black from behind)."""
    place = mi.ScalarTransform4f
    both = {"type": "twosided", "bsdf": diffuse(0.7, 0.6, 0.2)}
    left = place().translate([-0.4, -0.3, 0.0]).rotate([0, 1, 0], 150).scale(0.35)
    right = place().translate([0.45, -0.3, 0.0]).rotate([0, 1, 0], 200).scale(0.35)
    return room(mi) | {
        "light": ceiling_light(mi, 0.5, 4, 4, 4),
        "both": {"type": "rectangle", "to_world": left, "bsdf": both},
        "one": {"type": "rectangle", "to_world": right, "bsdf": diffuse(0.7, 0.6, 0.2)},
    }


@scene
def null_surface(mi: Any) -> SceneDict:
    """Show a ball in an invisible one; unlimited depth: Mitsuba counts a crossing as a bounce."""
    shell = ball(mi, (0.1, -0.3, 0.1), 0.6, {"type": "null"})
    return room(mi, -1) | {
        "light": ceiling_light(mi, 0.7, 3, 3, 3),
        "shell": shell,
        "ball": ball(mi, (0.1, -0.4, 0.1), 0.35, diffuse(0.6, 0.5, 0.2)),
    }


@scene
def many_lights(mi: Any) -> SceneDict:
    """Every kind of light at once, with very different powers."""
    place = mi.ScalarTransform4f().translate([-0.6, 0.5, -0.5]).rotate([0, 1, 0], 40)
    disk = {
        "type": "disk",
        "to_world": place.scale(0.2),
        "bsdf": diffuse(0.0),
        "emitter": area(0.5, 1.0, 3.0),
    }
    lamp = ball(mi, (0.5, 0.3, 0.2), 0.1, diffuse(0.0)) | {"emitter": area(12, 8, 5)}
    return room(mi) | {
        "light": ceiling_light(mi, 0.3, 2, 2, 2),
        "disk": disk,
        "lamp": lamp,
        "bulb": {"type": "point", "position": [-0.5, -0.5, 0.6], "intensity": rgb(0.05, 0.1, 0.05)},
        "sky": {"type": "constant", "radiance": rgb(0.2)},
        "ball": ball(mi, (0.1, -0.6, 0.0), 0.35, diffuse(0.6)),
    }


@scene
def phong(mi: Any) -> SceneDict:
    """Two glossy balls; the model is our own plug-in for Mitsuba."""

    def glossy(reflectance: float, specular: float, exponent: float) -> SceneDict:
        return {
            "type": "modified_phong",
            "diffuse": reflectance,
            "specular": specular,
            "exponent": exponent,
        }

    return room(mi) | {
        "light": ceiling_light(mi, 0.6, 4, 4, 4),
        "wide": ball(mi, (-0.45, -0.55, -0.1), 0.43, glossy(0.2, 0.7, 5.0)),
        "narrow": ball(mi, (0.45, -0.5, 0.1), 0.43, glossy(0.3, 0.5, 40.0)),
    }


@scene
def uniform_scatter(mi: Any) -> SceneDict:
    """Show a ball and a panel that scatter uniformly; the model is our own plug-in for Mitsuba."""
    place = mi.ScalarTransform4f().translate([0.5, -0.4, -0.3]).rotate([0, 1, 0], -30)
    bsdf = {"type": "uniform_scatter", "reflectance": 0.7}
    return room(mi) | {
        "light": ceiling_light(mi, 0.6, 4, 4, 4),
        "ball": ball(mi, (-0.35, -0.55, 0.0), 0.43, bsdf),
        "panel": {"type": "rectangle", "to_world": place.scale(0.4), "bsdf": bsdf},
    }
