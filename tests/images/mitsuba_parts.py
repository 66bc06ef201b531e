"""What the scenes for Mitsuba 3 are made of: walls, balls, lamps, cameras and colours."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

SceneDict = dict[str, Any]
SCENES: dict[str, Callable[[Any], SceneDict]] = {}
MESHES = Path(__file__).parent / "scenes"
SIDE = 72  # at least 1000 blocks of 2x2 pixels besides those that have no noise
WIDE = (88, 64)
AXIS = (0.48, 0.6, 0.64)  # a unit vector: Mitsuba does not normalise axes of rotation


def scene(function: Callable[[Any], SceneDict]) -> Callable[[Any], SceneDict]:
    """Register a scene under its function's name, with hyphens."""
    SCENES[function.__name__.replace("_", "-")] = function
    return function


def camera(
    mi: Any,
    origin: tuple[float, float, float],
    target: tuple[float, float, float],
    fov: float = 40.0,
    size: tuple[int, int] = (SIDE, SIDE),
    **options: Any,
) -> SceneDict:
    """Make a sensor with box filter and independent samples; `options` override or add keys."""
    look = mi.ScalarTransform4f().look_at(origin=origin, target=target, up=[0, 1, 0])
    sensor = {
        "type": "perspective",
        "fov": fov,
        "to_world": look,
        "film": {
            "type": "hdrfilm",
            "width": size[0],
            "height": size[1],
            "pixel_format": "rgb",
            "component_format": "float32",
            "rfilter": {"type": "box"},
        },
        "sampler": {"type": "independent", "sample_count": 16},
    }
    sensor.update(options)
    return {key: value for key, value in sensor.items() if value is not None}


def rgb(*value: float) -> SceneDict:
    """Make a colour; one number is a grey."""
    return {"type": "rgb", "value": list(value) if len(value) == 3 else [value[0]] * 3}


def diffuse(*reflectance: float) -> SceneDict:
    """Make a one-sided Lambertian reflector."""
    return {"type": "diffuse", "reflectance": rgb(*reflectance)}


def area(*radiance: float) -> SceneDict:
    """Make an emitter for a shape, W m^-2 sr^-1."""
    return {"type": "area", "radiance": rgb(*radiance)}


def base(max_depth: int = 8) -> SceneDict:
    """Make a scene with nothing but the path integrator, roulette from depth 5."""
    return {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": max_depth, "rr_depth": 5},
    }


def room(mi: Any, max_depth: int = 8) -> SceneDict:
    """Put up five walls of [-1, 1]^3, open towards +z."""
    place = mi.ScalarTransform4f

    def wall(transform: Any, *reflectance: float) -> SceneDict:
        return {"type": "rectangle", "to_world": transform, "bsdf": diffuse(*reflectance)}

    return base(max_depth) | {
        "sensor": camera(mi, (0, 0, 3.9), (0, 0, 0)),
        "floor": wall(place().translate([0, -1, 0]).rotate([1, 0, 0], -90), 0.7),
        "ceiling": wall(place().translate([0, 1, 0]).rotate([1, 0, 0], 90), 0.7),
        "back": wall(place().translate([0, 0, -1]), 0.7),
        "left": wall(place().translate([-1, 0, 0]).rotate([0, 1, 0], 90), 0.6, 0.2, 0.15),
        "right": wall(place().translate([1, 0, 0]).rotate([0, 1, 0], -90), 0.2, 0.5, 0.25),
    }


def ceiling_light(mi: Any, half: float, *radiance: float) -> SceneDict:
    """Hang a square light just below the ceiling of `room`, black as a reflector."""
    place = mi.ScalarTransform4f().translate([0, 0.99, 0]).rotate([1, 0, 0], 90).scale(half)
    return {
        "type": "rectangle",
        "to_world": place,
        "bsdf": diffuse(0.0),
        "emitter": area(*radiance),
    }


def ball(mi: Any, centre: tuple[float, float, float], radius: float, bsdf: SceneDict) -> SceneDict:
    """Make a sphere."""
    return {"type": "sphere", "center": list(centre), "radius": radius, "bsdf": bsdf}


def ground(mi: Any, half: float, bsdf: SceneDict) -> SceneDict:
    """Make a horizontal square at y = 0, its normal up."""
    place = mi.ScalarTransform4f().rotate([1, 0, 0], -90).scale([half, half, 1])
    return {"type": "rectangle", "to_world": place, "bsdf": bsdf}


def checkerboard(mi: Any, repeats: float) -> SceneDict:
    """Diffuse, red and white; `repeats` pairs of squares along each side of the UV square."""
    texture = {
        "type": "checkerboard",
        "color0": rgb(0.8, 0.2, 0.1),
        "color1": rgb(0.7, 0.7, 0.65),
        "to_uv": mi.ScalarTransform4f().scale([repeats, repeats, 1]),
    }
    return {"type": "diffuse", "reflectance": texture}


def parallelogram(mi: Any, corners: list[tuple[float, float, float]]) -> SceneDict:
    """Write a mesh of two triangles to a temporary file; normal by the right-hand rule."""
    return {"type": "ply", "filename": str(write_mesh(mi, corners, [(0, 1, 2), (0, 2, 3)]))}


def sphere_mesh(mi: Any) -> Path:
    """Write a unit icosphere with smooth normals to a temporary file."""
    import trimesh

    mesh = trimesh.creation.icosphere(subdivisions=7)
    return write_mesh(mi, mesh.vertices, mesh.faces, mesh.vertices)


def write_mesh(mi: Any, vertices: Any, faces: Any, normals: Any = None) -> Path:
    """Write a PLY file named by its size into the temporary folder."""
    import tempfile

    vertices = np.asarray(vertices, np.float32)
    faces = np.asarray(faces, np.uint32)
    mesh = mi.Mesh("mesh", len(vertices), len(faces), has_vertex_normals=normals is not None)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = vertices.ravel()
    parameters["faces"] = faces.ravel()
    if normals is not None:
        parameters["vertex_normals"] = np.asarray(normals, np.float32).ravel()
    parameters.update()
    path = Path(tempfile.gettempdir()) / f"alight-reference-{len(vertices)}.ply"
    mesh.write_ply(str(path))
    return path
