"""What glTF allows places, normals, spots and cameras to be, in files that are written and read."""

import json
import math
import struct
from dataclasses import replace

import numpy as np
import pytest

from alight.compiled.scene import compile_scene
from alight.films import fixed_point
from alight.formats import load, loads
from alight.formats.gltf.write import write
from alight.integrators.walk import make_settings
from alight.rendering.tiles.tile import make_kernels, render_tile
from alight.rendering.tiles.tile_kernel import Tile
from alight.scene import flatten
from tests.formats.gltf.maker import Maker

SQUARE = {
    "type": "mesh", "vertices": [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]],
    "faces": [[0, 1, 2], [0, 2, 3]],
}  # fmt: skip
SHEAR = [
    {"rotate": {"axis": "x", "angle": 30}}, {"scale": [3, 1, 2]},
    {"rotate": {"axis": "z", "angle": 40}}, {"translate": [1, 2, 3]},
]  # fmt: skip
MIRROR = [*SHEAR, {"scale": [1, 1, -1]}]
GREY = {"type": "bitmap", "pixels": ["40 80", "c0 ff"], "color_space": "linear"}


def written(tmp_path, nodes, camera=None, **more):
    """A scene as it was and as it comes back, the file's document, and what was lost."""
    camera = camera or {"type": "orthographic", "height": 3}
    head = {"alight": 1, "film": {"size": [6, 4]}, "camera": camera, "nodes": nodes} | more
    first = flatten(loads(json.dumps(head), "scene.json"))
    lost = write(first, tmp_path / "a.glb")
    data = (tmp_path / "a.glb").read_bytes()
    length = struct.unpack_from("<I", data, 12)[0]
    return first, flatten(load(tmp_path / "a.glb")), json.loads(data[20 : 20 + length]), lost


def corners(flat):
    """Corners of all triangles in the world and their normals, in the order of the shapes."""
    points, normals = [], []
    for placed in flat.shapes:
        mesh = flat.geometries[placed.geometry]
        linear, shift = placed.to_world[:3, :3], placed.to_world[:3, 3]
        points.append(mesh.vertices[mesh.faces] @ linear.T + shift)
        if mesh.normals is not None:
            turned = mesh.normals[mesh.faces] @ np.linalg.inv(linear)
            normals.append(turned / np.linalg.norm(turned, axis=2, keepdims=True))
    return np.concatenate(points), np.concatenate(normals) if normals else None


def has_place(matrix):
    """Whether a node of glTF may have a matrix: its axes are at right angles."""
    axes = np.array(matrix).reshape(4, 4)[:3, :3]
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    return np.abs(axes @ axes.T - np.eye(3)).max() < 1e-4


# ---------------------------------------------------------------- shapes


@pytest.mark.parametrize("steps", [SHEAR, MIRROR], ids=["sheared", "mirrored"])
def test_what_is_sheared_is_sheared_in_its_vertices(steps, tmp_path):
    smooth = SQUARE | {"normals": [[0, 0, 1], [0.6, 0, 0.8], [0, 0.6, 0.8], [0, 0, 1]]}
    nodes = {
        "a": {"shape": smooth, "transform": steps},
        "b": {"shape": smooth},
        "c": {"shape": smooth, "transform": steps},
        "disk": {"shape": {"type": "disk"}, "transform": steps},
    }
    first, second, file, _ = written(tmp_path, {k: nodes[k] for k in "abc"})
    (points, normals), (points_2, normals_2) = corners(first), corners(second)
    np.testing.assert_allclose(points_2, points, atol=1e-5)
    np.testing.assert_allclose(normals_2, normals, atol=1e-5)
    for one, other in zip(first.shapes, second.shapes, strict=True):
        # So the same side is the outer one.
        assert np.linalg.det(one.to_world[:3, :3]) * np.linalg.det(other.to_world[:3, :3]) > 0.0
    assert all(has_place(node["matrix"]) for node in file["nodes"])
    assert len(file["meshes"]) == 2
    _, _, file, _ = written(tmp_path, nodes)
    assert all(has_place(node["matrix"]) for node in file["nodes"])


def test_very_long_and_tiny_things_are_written(tmp_path):
    """No node takes scales so different; no warning is shown."""
    stretch = [{"scale": [2, 1e12, 1]}, {"rotate": {"axis": "z", "angle": 30}}]
    nodes = {"a": {"shape": SQUARE, "transform": stretch}}
    nodes["b"] = {"shape": {"type": "sphere", "radius": 1e-15}}
    nodes["c"] = {"shape": {"type": "cylinder", "radius": 1e-15}}
    first, second, file, _ = written(tmp_path, nodes)
    matrix = np.array(file["nodes"][0]["matrix"]).reshape(4, 4)[:3, :3]
    np.testing.assert_allclose(matrix @ matrix.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(corners(second)[0][:2], corners(first)[0][:2], rtol=1e-5)


@pytest.mark.parametrize("fov", [1e-7, 179.99])
def test_very_narrow_and_wide_pictures_come_back(fov, tmp_path):
    camera = {"type": "pinhole", "fov": fov}
    _, second, _, _ = written(tmp_path, {"a": {"shape": SQUARE}}, camera)
    assert second.camera.camera.fov == pytest.approx(fov)


def test_written_normals_have_the_length_1(tmp_path):
    """That of a vertex without one is the triangles' mean."""
    long = SQUARE | {"normals": [[0, 0, 0], [0, 0, 3], [0, 3, 4], [0, 0, 1e-20]]}
    _, flat, _, _ = written(tmp_path, {"a": {"shape": long}})
    expected = [[0, 0, 1], [0, 0, 1], [0, 0.6, 0.8], [0, 0, 1]]
    np.testing.assert_allclose(flat.geometries[0].normals, expected, atol=1e-7)
    none = {"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": [[0, 1, 2]]}
    for vertices in (none["vertices"], [[0, 0, 0]] * 3):
        mesh = {"type": "mesh", **none, "vertices": vertices, "normals": [[0, 0, 0]] * 3}
        _, flat, _, _ = written(tmp_path, {"a": {"shape": mesh}})
        np.testing.assert_array_equal(flat.geometries[0].normals, [[0, 0, 1]] * 3)


@pytest.mark.parametrize("flip", [False, True])
def test_a_mesh_without_coordinates_gets_those_of_its_triangles(flip, tmp_path):
    """So a picture lies on it as before; a file whose pictures lack coordinates is no glTF."""
    bsdf = {"type": "diffuse", "reflectance": GREY}
    colored = SQUARE | {"colors": [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]]}
    shape = colored | {"flip_normals": flip}
    tint = {"type": "multiply", "a": GREY, "b": {"type": "vertex_color"}}
    nodes = {
        "a": {"shape": shape, "bsdf": bsdf},
        "b": {"shape": shape, "bsdf": {"type": "diffuse"}},
    }
    nodes["c"] = {"shape": shape, "bsdf": {"type": "diffuse", "reflectance": tint}}
    first, second, file, _ = written(tmp_path, nodes)
    mapped, plain, tinted = (second.geometries[shape.geometry] for shape in second.shapes)
    assert plain.uvs is None
    assert len(file["meshes"]) == 3
    # Corners in the order in which the scene had them.
    order = [2, 1, 0] if flip else [0, 1, 2]
    for mesh in (mapped, tinted):
        np.testing.assert_array_equal(
            mesh.uvs[mesh.faces][:, order], [[[0, 0], [1, 0], [0, 1]]] * 2
        )
    np.testing.assert_array_equal(corners(second)[0][:2][:, order], corners(first)[0][:2])
    faces = first.geometries[0].faces
    found = tinted.colors[tinted.faces][:, order]
    np.testing.assert_array_equal(found, first.geometries[0].colors[faces])


# ---------------------------------------------------------------- lights


def test_a_sharp_spot_has_angles_that_the_format_allows(tmp_path):
    spot = {"type": "spot", "cutoff_angle": 20, "beam_width": 20, "falloff": "quadratic"}
    first, second, file, lost = written(tmp_path, {"a": {"light": spot, "transform": SHEAR}})
    cone = file["extensions"]["KHR_lights_punctual"]["lights"][0]["spot"]
    assert 0.0 <= cone["innerConeAngle"] < cone["outerConeAngle"]
    assert second.lights[0].light.beam_width == pytest.approx(20.0, abs=1e-4)
    axes = [flat.lights[0].to_world[:3, 2] for flat in (first, second)]
    lengths = [np.linalg.norm(axis) for axis in axes]
    np.testing.assert_allclose(axes[1] / lengths[1], axes[0] / lengths[0], atol=1e-12)
    np.testing.assert_allclose(second.lights[0].to_world[:3, 3], first.lights[0].to_world[:3, 3])
    assert has_place(file["nodes"][0]["matrix"])
    assert lost == []


def test_a_spot_that_shines_backwards_is_told_of(tmp_path):
    spot = {"type": "spot", "cutoff_angle": 120, "beam_width": 100, "falloff": "quadratic"}
    _, second, file, lost = written(tmp_path, {"a": {"light": spot}})
    cone = file["extensions"]["KHR_lights_punctual"]["lights"][0]["spot"]
    assert cone["innerConeAngle"] < cone["outerConeAngle"] == math.pi / 2.0
    assert second.lights[0].light.cutoff_angle == pytest.approx(90.0)
    assert lost == ["a spot's cutoff_angle: became 90 degrees, the most that glTF has"]


# ---------------------------------------------------------------- cameras

CAMERAS = {
    "scaled": ({"type": "orthographic", "height": 3}, [{"scale": 2}]),
    "sides": ({"type": "orthographic", "height": 3}, [{"scale": [2, 4, 1]}]),
    "wide": ({"type": "pinhole", "fov": 40, "fov_axis": "x"}, [{"scale": [2, 3, 5]}]),
    "mirrored": ({"type": "pinhole", "fov": 40}, [{"scale": [-1, 1, 1]}]),
    "upside down": ({"type": "orthographic", "height": 3}, [{"scale": [2, -2, 2]}]),
}


def seen(flat):
    """Where the film sees the corners of all triangles: (n, 2) from -1 to 1."""
    from alight.cameras.basis import project_points

    camera, (width, height) = flat.camera.camera, flat.film.size
    module = __import__(f"alight.cameras.{camera.type_name()}", fromlist=["half_extents"])
    half = module.half_extents(camera, width, height)
    points = corners(flat)[0].reshape(-1, 3)
    film = project_points(points, half, (width, height), flat.camera.to_world, module.PERSPECTIVE)
    return 2.0 * film[:, :2] / [width, height] - 1.0


@pytest.mark.parametrize("kind", CAMERAS)
def test_cameras_see_the_same_though_nodes_do_not_scale_them(kind, tmp_path):
    camera, steps = CAMERAS[kind]
    turn = [{"rotate": {"axis": "y", "angle": 25}}, {"translate": [2, 1, 6]}]
    lamp = {"light": {"type": "spot"}, "transform": [{"rotate": {"axis": "x", "angle": 35}}]}
    nodes = {"a": {"shape": SQUARE, "transform": SHEAR[:2]}, "lamp": lamp}
    first, second, file, lost = written(tmp_path, nodes, {**camera, "transform": [*steps, *turn]})
    np.testing.assert_allclose(seen(second), seen(first), atol=1e-5)
    matrix = np.array(file["nodes"][-1]["matrix"]).reshape(4, 4).T
    np.testing.assert_allclose(matrix[:3, :3].T @ matrix[:3, :3], np.eye(3), atol=1e-12)
    assert np.linalg.det(matrix) > 0.0
    mirrored = kind in ("mirrored", "upside down")
    expected = ["a camera that mirrors: the whole scene is mirrored instead (x became -x)"]
    assert [line for line in lost if "falloff" not in line] == (expected if mirrored else [])
    signs = [-1.0 if mirrored else 1.0, 1.0, 1.0]
    one, other = first.lights[0].to_world, second.lights[0].to_world
    np.testing.assert_allclose(other[:3, 2], signs * one[:3, 2], atol=1e-12)
    np.testing.assert_allclose(other[:3, 3], signs * one[:3, 3], atol=1e-12)


def test_brushed_metal_turns_the_other_way_in_a_mirrored_world(tmp_path):
    """Angles run from the tangent round the normal, as they did before."""
    metal = {"type": "principled", "anisotropy": 0.5, "anisotropy_rotation": 0.7}
    nodes = {"a": {"shape": SQUARE, "bsdf": metal}}
    for steps, angle in (([], 0.7), ([{"scale": [-1, 1, 1]}], -0.7)):
        camera = {"type": "orthographic", "transform": steps}
        _, flat, _, _ = written(tmp_path, nodes, camera)
        assert flat.bsdfs[0].bsdf.anisotropy_rotation == pytest.approx(angle)


def test_crops_and_sheared_pictures_are_told_of(tmp_path):
    camera = {"type": "orthographic", "transform": SHEAR}
    film = {"size": [6, 4], "crop": [1, 1, 2, 2]}
    _, _, file, lost = written(tmp_path, {"a": {"shape": SQUARE}}, camera, film=film)
    assert lost == ["camera: the shear of its picture", "film: the crop of its picture"]
    assert has_place(file["nodes"][-1]["matrix"])


@pytest.mark.parametrize("scale", [[2, 2, 2], [1, 3, 1], [-1, 1, 1]])
def test_the_scale_of_a_cameras_node_is_ignored(scale, tmp_path):
    """Also of those above it; what stands below the node is scaled."""
    m = Maker()
    m.json["cameras"] = [{"type": "orthographic", "orthographic": {"ymag": 1.5, "xmag": 1.5}}]
    half = math.sqrt(0.5)
    m.node(mesh=m.square())
    m.node(camera=0, name="eye", rotation=[0, half, 0, half], children=[0])
    m.node(scale=scale, translation=[1, 2, 3], children=[1])
    m.json["scenes"] = [{"nodes": [2]}]
    (tmp_path / "a.glb").write_bytes(m.glb())
    flat = flatten(load(tmp_path / "a.glb"))
    assert flat.camera.camera.height == 3.0
    expected = np.array([[0, 0, 1, 1], [0, 1, 0, 2], [-1, 0, 0, 3], [0, 0, 0, 1]])
    if scale[0] < 0:
        expected[:3, 2] *= -1
    np.testing.assert_allclose(flat.camera.to_world[:3, 1:], expected[:3, 1:], atol=1e-12)
    assert np.linalg.det(flat.camera.to_world) == pytest.approx(1.0)
    lengths = np.linalg.norm(flat.shapes[0].to_world[:3, :3], axis=0)
    np.testing.assert_allclose(sorted(lengths), sorted(np.abs(scale)), atol=1e-12)
    for name in ("eye", "0"):
        again = flatten(load(tmp_path / "a.glb", [f"camera={name}"]))
        np.testing.assert_allclose(again.camera.to_world, flat.camera.to_world)


def test_a_scene_without_anything_is_a_file_all_the_same(tmp_path, monkeypatch):
    """The file names the scene that it shows; an empty list of nodes is not allowed."""
    _, _, file, _ = written(tmp_path, {"a": {"shape": SQUARE}})
    assert file["scene"] == 0
    monkeypatch.setattr("alight.formats.gltf.write._Writer.add_camera", lambda self: None)
    assert written(tmp_path, {})[2]["scenes"] == [{}]


def shown(flat):
    """A picture by a lamp, in the twin: the same numbers for the same scene."""
    scene = compile_scene(flat, structure="list")
    settings = make_settings(scene.integrator, seed=1, replicates=1)
    kernels = make_kernels(scene, compiled=False)
    width, height = flat.film.size
    ranges = np.array([[[0, 64]]], np.int64)
    film, _ = render_tile(kernels, scene, settings, Tile(0, 0, width, height), ranges)
    fixed_point.carry(film.sums)
    return fixed_point.to_float(film.sums)[:, :, 0] / 64


def test_a_mirrored_world_looks_the_same(tmp_path):
    """Bent normals, brushed metal and pictures too, on things that are mirrored themselves."""
    hills = {"type": "bitmap", "pixels": ["c080d0 40a0e0", "90f0a0 805080"],
             "color_space": "linear"}  # fmt: skip
    square = {"shape": SQUARE | {"uvs": [[0, 0], [1, 0], [1, 1], [0, 1]]}}
    metal = {"type": "principled", "metallic": 1.0, "base_color": GREY, "roughness": 0.5,
             "anisotropy": 0.9, "anisotropy_rotation": 0.6}  # fmt: skip
    bent = {"type": "normal_map", "texture": hills, "bsdf": {"type": "diffuse"}}
    nodes = {"lamp": {"light": {"type": "point"}, "transform": {"translate": [0.3, 0.5, 1.5]}}}
    sides = (([-0.4, 0.4, 1], -1, 1), ([0.4, 0.4, 1], 1, 1))
    for bsdf, below in ((metal, 0), (bent, -2)):
        for scale, x, y in sides:
            steps = [{"scale": scale}, {"translate": [0.5 * x, 0.5 * (y + below), 0]}]
            inner = {"type": "two_sided", "bsdf": bsdf}
            nodes[f"{x}{below}"] = {**square, "bsdf": inner, "transform": steps}
    steps = [{"scale": [-1, 1, 1]}, {"rotate": {"axis": "y", "angle": 10}}]
    camera = {"type": "orthographic", "height": 2, "transform": [*steps, {"translate": [0, 0, 3]}]}
    film = {"size": [8, 8]}
    first, second, _, lost = written(tmp_path, nodes, camera, film=film)
    assert len(lost) == 1
    second = replace(second, film=first.film, integrator=first.integrator, environments=[])
    one, other = shown(first), shown(second)
    assert one.mean() > 0.02
    np.testing.assert_allclose(other, one, rtol=0.02, atol=0.002)


def test_files_that_are_too_large_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("alight.formats.gltf.store.MOST_BYTES", 1000)
    with pytest.raises(OSError, match="at most 1000 bytes, this would be 1"):
        written(tmp_path, {"a": {"shape": SQUARE}})
    assert not list(tmp_path.iterdir())
