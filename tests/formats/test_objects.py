"""Objects of other packages: what is seen of them is what they hold, and mistakes are told."""

import subprocess
import sys

import numpy as np
import pytest
import trimesh
from PIL import Image as Pillow

import alight
from alight.formats import load
from alight.formats.objects.color_maps import color_map, places_in, strip
from alight.formats.objects.creases import are_of, creased
from alight.formats.objects.points import ball, sensible_radius
from alight.formats.scenes.made_up import without_floor
from alight.meshes.triangles import srgb_to_linear

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
HALVES = np.array([[0, 1, 2], [0, 2, 3]])


def only(scene):
    """The one mesh of a scene, and its material; the floor is the studio's."""
    scene = without_floor(scene)
    ((_, _, node),) = [found for found in scene.walk() if found[2].shape is not None]
    return node.shape, scene.bsdfs[node.bsdf].bsdf


def corners(mesh, numbers):
    """What the corners of a mesh's faces have of a table of its vertices."""
    return numbers[mesh.faces]


def test_arrays_become_a_mesh_in_a_studio_before_a_camera_that_sees_it():
    scene = load((SQUARE, HALVES), ["film.size=[40, 20]"])
    mesh, _ = only(scene)
    assert np.array_equal(corners(mesh, mesh.vertices), SQUARE[HALVES].astype(np.float32))
    assert scene.film.size == (40, 20)
    assert scene.environment.file == "builtin:studio"
    assert len(scene.warnings) == 2


def test_quadrilaterals_are_cut_in_two_and_keep_their_colour():
    paint = np.array([[255, 0, 0]], np.uint8)
    mesh, bsdf = only(load((SQUARE, [[0, 1, 2, 3]], paint)))
    assert len(mesh.faces) == 2
    assert np.array_equal(mesh.colors, np.tile([[1, 0, 0]], (6, 1)))
    assert bsdf.base_color.type == "vertex_color"


@pytest.mark.parametrize("kind", [np.uint8, np.uint16, float])
def test_colours_are_those_of_a_display(kind):
    most = np.iinfo(kind).max if np.issubdtype(kind, np.integer) else 1.0
    paint = (np.array([[1.0, 0.5, 0.0]] * 4) * most).astype(kind)
    mesh, _ = only(load((SQUARE, HALVES, paint)))
    wanted = srgb_to_linear(np.float32(paint[0] / most))
    assert np.allclose(mesh.colors, wanted, atol=1e-6)


def test_numbers_lie_where_the_map_has_their_colour():
    numbers = np.array([2.0, 3.0, 4.0, np.nan])
    mesh, bsdf = only(load((SQUARE, HALVES, numbers)))
    of = {tuple(p): uv for p, uv in zip(mesh.vertices, mesh.uvs, strict=True)}
    places = np.array([of[tuple(p)] for p in SQUARE.astype(np.float32)])
    assert places[:3, 0] * 256 - 0.5 == pytest.approx([0.0, 127.5, 255.0], abs=1e-4)
    assert (places[:3, 1] > 0.75).all() and places[3, 1] < 0.25
    texels = np.asarray(bsdf.base_color.pixels.whole)
    assert np.array_equal(texels, strip("viridis"))
    # The purple and the yellow that viridis is known by.
    assert texels[0, 0].tolist() == [68, 1, 84]
    assert texels[0, 255].tolist() == [253, 231, 37]


def test_a_range_from_numpy_is_a_range():
    numbers = np.arange(4.0)
    of_array = load((SQUARE, HALVES, numbers), color_range=np.percentile(numbers, [2, 98]))
    assert only(of_array)[0] == only(load((SQUARE, HALVES, numbers), color_range=(0.06, 2.94)))[0]


def test_the_range_of_the_map_can_be_chosen_and_equal_numbers_are_its_middle():
    places = places_in([0.0, 5.0, 99.0], (0.0, 10.0))
    assert places[:, 0] * 256 - 0.5 == pytest.approx([0.0, 127.5, 255.0], abs=1e-4)
    assert places_in([7.0], (7.0, 7.0))[0, 0] == pytest.approx(0.5)
    assert color_map("grey")[128].tolist() == [128] * 3


def test_numbers_of_faces_leave_no_vertex_to_two_faces():
    mesh, _ = only(load((SQUARE, HALVES, np.array([0.0, 1.0]))))
    places = corners(mesh, mesh.uvs)[..., 0]
    assert (places == places[:, :1]).all()
    assert places[0, 0] < places[1, 0]


def test_a_ball_is_round_and_a_box_keeps_its_edges():
    sphere, _ = only(load(trimesh.creation.icosphere(subdivisions=3)))
    unit = sphere.vertices / np.linalg.norm(sphere.vertices, axis=1, keepdims=True)
    assert np.abs(sphere.normals - unit).max() < 0.01
    box, _ = only(load(trimesh.creation.box()))
    flat = np.cross(*(np.diff(corners(box, box.vertices), axis=1).transpose(1, 0, 2)))
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    assert np.allclose(corners(box, box.normals), flat[:, None], atol=1e-6)
    faceted, _ = only(load(trimesh.creation.icosphere(subdivisions=1), smooth=0.0))
    assert faceted.normals is None


def test_only_faces_within_the_angle_share_a_normal():
    bent = np.radians(40.0)
    points = np.array(
        [[0, 0, 0], [0, 0, 1], [1, 0, 0], [-np.cos(bent), -np.sin(bent), 0]], np.float32
    )
    faces = np.array([[0, 1, 2], [1, 0, 3]])
    for angle, count in ((39.0, 6), (41.0, 4)):
        origin, new, normals = creased(points, faces, angle)
        assert len(origin) == count
        assert np.array_equal(origin[new], faces)
        assert np.allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-6)


def test_a_vertex_of_very_many_faces_costs_no_square_of_their_number():
    # A cone, whose tip is shared by all: faces within 30 degrees are those of an arc.
    count = 200_000
    angles = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    rim = np.stack([np.cos(angles), np.sin(angles), np.zeros(count)], 1)
    points = np.concatenate([rim, [[0.0, 0.0, 1.0]]]).astype(np.float32)
    around = np.arange(count)
    faces = np.stack([around, np.roll(around, -1), np.full(count, count)], 1)
    origin, new, normals = creased(points, faces, 30.0)
    assert np.array_equal(origin[new], faces)
    middle = angles + np.pi / count
    meant = np.stack([np.cos(middle), np.sin(middle), np.ones(count)], 1)
    at_tip = normals[new[:, 2]]
    # The mean over an arc of half angle b lies somewhat nearer to the axis.
    between = np.degrees(np.arccos(np.clip((at_tip * meant).sum(1) / np.sqrt(2.0), -1.0, 1.0)))
    assert between.max() < 6.0


def test_normals_of_merged_vertices_are_not_those_of_the_surface():
    box = trimesh.creation.box()
    round_one = trimesh.creation.icosphere(subdivisions=1)
    assert are_of(round_one.vertex_normals, round_one.vertices, round_one.faces)
    assert not are_of(box.vertex_normals, box.vertices, box.faces)
    of_one_face = np.zeros((8, 3))
    of_one_face[box.faces.ravel()] = np.repeat(box.face_normals, 3, axis=0)
    assert not are_of(of_one_face, box.vertices, box.faces)


def test_scenes_of_trimesh_keep_places_names_and_their_camera():
    scene = trimesh.Scene()
    moved = np.eye(4)
    moved[:3, 3] = (3, 0, 0)
    scene.add_geometry(trimesh.creation.box(), node_name="one", geom_name="brick")
    scene.add_geometry(trimesh.creation.box(), node_name="two", geom_name="block", transform=moved)
    assert "camera" not in load(scene).nodes
    scene.set_camera(resolution=(200, 100), fov=(60, 30))
    found = load(scene)
    places = {name: node.transform.matrix[0, 3] for name, node in found.nodes.items()}
    assert places["brick"] == 0.0 and places["block"] == 3.0
    assert found.camera == "camera"
    assert found.nodes["camera"].camera.fov == 30.0
    wanted = np.tan(np.radians(30)) / np.tan(np.radians(15))
    assert found.film.size[0] / found.film.size[1] == pytest.approx(wanted, rel=0.01)


def test_instances_of_trimesh_share_their_mesh():
    scene = trimesh.Scene()
    for x in range(3):
        moved = np.eye(4)
        moved[0, 3] = x
        scene.add_geometry(trimesh.creation.box(), geom_name="brick", transform=moved)
        scene.graph.update(f"again{x}", geometry="brick", matrix=moved)
    found = without_floor(load(scene))
    geometries = len(scene.geometry)
    assert len(scene.graph.nodes_geometry) == len(found.nodes) > geometries
    shapes = {id(node.shape) for _, _, node in found.walk() if node.shape is not None}
    assert len(shapes) == geometries


def test_materials_and_pictures_of_trimesh_are_kept():
    material = trimesh.visual.material.PBRMaterial(
        baseColorFactor=[255, 51, 0, 255], metallicFactor=0.25, roughnessFactor=0.75,
        baseColorTexture=Pillow.new("RGB", (2, 2), (0, 255, 0)),
    )  # fmt: skip
    uv = SQUARE[:, :2]
    visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
    mesh = trimesh.Trimesh(SQUARE, HALVES, visual=visual, process=False)
    found, bsdf = only(load(mesh))
    assert (bsdf.metallic, bsdf.roughness) == (0.25, 0.75)
    assert bsdf.base_color.type == "multiply"
    assert np.asarray(bsdf.base_color.a.pixels.whole)[0, 0].tolist() == [0, 255, 0]
    # A linear multiplier, as in glTF.
    assert bsdf.base_color.b == (1.0, 0.2, 0.0)
    assert np.array_equal(found.uvs, found.vertices[:, :2])


def test_points_are_balls_that_just_touch():
    grid = np.stack(np.meshgrid(*[np.arange(4.0)] * 3), axis=-1).reshape(-1, 3)
    assert sensible_radius(grid) == pytest.approx(0.6)
    assert sensible_radius(np.concatenate([grid, grid])) == pytest.approx(0.6)
    colors = np.tile([[10, 20, 30, 255]], (len(grid), 1)).astype(np.uint8)
    mesh, _ = only(load(trimesh.PointCloud(grid, colors=colors)))
    each = len(mesh.vertices) // len(grid)
    distance = np.linalg.norm(mesh.vertices.reshape(-1, each, 3) - grid[:, None], axis=2)
    assert np.allclose(distance, 0.6, atol=1e-5)
    assert only(load(grid, point_radius=0.1))[0].vertices.max() == pytest.approx(3.1)


@pytest.mark.parametrize("level", [0, 1, 2])
def test_balls_are_closed_and_look_outwards(level):
    vertices, faces = ball(level)
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    assert len(faces) == 20 * 4**level
    assert mesh.is_watertight
    assert 0.6 * 4.19 < mesh.volume < 4.19


def test_a_hundred_thousand_points_are_one_mesh():
    points = np.random.default_rng(0).random((100_000, 3), np.float32)
    mesh, _ = only(load(points))
    assert len(mesh.faces) == 2_000_000


class FakeArray(np.ndarray):
    """As VTK's arrays, which give their memory to whoever asks."""

    def GetNumberOfComponents(self):
        return 1 if self.ndim == 1 else self.shape[1]


class FakeData:
    """A data set, or what holds its arrays: methods that give what it was made with."""

    def __init__(self, **found):
        for name, value in found.items():
            given = value.view(FakeArray) if isinstance(value, np.ndarray) else value
            setattr(self, name, lambda given=given: given)


FakeData.__module__ = "vtkmodules.vtkCommonDataModel"
PolyData = type("vtkPolyData", (FakeData,), {"__module__": "vtkmodules.vtkCommonDataModel"})


def poly_data(points, corners, offsets, of_points=None, of_cells=None, lines=0):
    cells = FakeData(
        GetNumberOfCells=len(offsets) - 1, GetConnectivityArray=corners, GetOffsetsArray=offsets
    )
    return PolyData(
        GetNumberOfStrips=0, GetNumberOfVerts=0, GetNumberOfLines=lines, GetPolys=cells,
        GetPoints=FakeData(GetData=points),
        GetPointData=FakeData(GetNormals=None, GetScalars=of_points),
        GetCellData=FakeData(GetScalars=of_cells),
    )  # fmt: skip


def test_polygons_of_vtk_stand_upright_in_the_colours_of_their_cells():
    points = np.concatenate([SQUARE, SQUARE + np.array([0, 0, 1])]).astype(np.float32)
    data = poly_data(
        points, np.array([0, 1, 2, 3, 4, 5, 6]), np.array([0, 4, 7]),
        of_cells=np.array([9.0, 0.0, 1.0]), lines=1,
    )  # fmt: skip
    scene = load(data)
    mesh, bsdf = only(scene)
    assert len(mesh.faces) == 3
    # The number of the line comes first, and is nobody's.
    assert (corners(mesh, mesh.uvs)[:, 0, 0] * 256 - 0.5).round() == pytest.approx([0, 0, 255])
    assert bsdf.base_color.type == "bitmap"
    assert scene.nodes["object"].transform.matrix[:3, 2] == pytest.approx([0, 1, 0])
    assert load(data, up="y").nodes["mesh"].shape is not None


def test_vectors_of_vtk_show_their_lengths_and_bytes_their_colours():
    vectors = np.array([[3.0, 4.0, 0.0], [0, 0, 0], [0, 0, 10], [0, 0, 0]])
    mesh, _ = only(load(poly_data(SQUARE, np.arange(4), np.array([0, 4]), of_points=vectors)))
    along = {tuple(p): uv[0] for p, uv in zip(mesh.vertices, mesh.uvs, strict=True)}
    assert along[(0, 0, 0)] * 256 - 0.5 == pytest.approx(127.5, abs=1e-4)
    paint = np.array([[255, 255, 255]] * 4, np.uint8)
    data = poly_data(SQUARE, np.arange(4), np.array([0, 4]), of_points=paint)
    assert (only(load(data))[0].colors == 1.0).all()


def test_dictionaries_are_native_scenes_as_python_data():
    data = {
        "camera": {"type": "pinhole"},
        "nodes": {"m": {"shape": {"type": "mesh", "vertices": SQUARE, "faces": HALVES}}},
    }
    scene = load(data)
    assert np.array_equal(scene.nodes["m"].shape.faces, HALVES)
    assert load({"alight": 1, **data}, ["film.size=[8, 8]"]).film.size == (8, 8)
    with pytest.raises(alight.SceneError, match=r"nodes\.m\.shape\.type\n.*did you mean \"mesh\""):
        load({**data, "nodes": {"m": {"shape": {"type": "mesg"}}}})


@pytest.mark.parametrize(
    ("value", "words", "message"),
    [
        (3, {}, r"cannot load 3: give a path"),
        (np.float64(3), {}, r"cannot load .*3.*: give a path"),
        ((SQUARE, HALVES + 2.0**40), {}, r"faces\n  must index vertices"),
        ((SQUARE, HALVES.astype(np.int64) + 2**40), {}, r"faces\n  must index vertices 0 to 3"),
        ((SQUARE, np.full((2, 3), np.inf)), {}, r"faces\n  must index vertices"),
        ((SQUARE, HALVES + 9), {}, r"faces\n  must index vertices 0 to 3, got 12"),
        ((SQUARE, HALVES, [1, 2, 3]), {}, r"row per vertex \(4\) or per face \(2\)"),
        ((SQUARE * np.nan, HALVES), {}, r"vertices\n  must be finite"),
        ((SQUARE, HALVES, np.full((4, 3), 2.0)), {}, r"in \[0, 1\], got \(2, 2, 2\) in row 0"),
        ((SQUARE[:, :2], HALVES), {}, r"vertices\n  must be a table of numbers, shape \(n, 3\)"),
        (np.zeros((0, 3)), {}, r"at least one point"),
        (trimesh.Trimesh(), {}, r"at least one triangle"),
        (trimesh.Scene(), {}, r"nothing to see"),
        ((SQUARE, HALVES), {"color_map": "viridas"}, r"did you mean \"viridis\""),
        ((SQUARE, HALVES), {"color_range": (1, 1)}, r"color_range: must be \(lowest, highest\)"),
        ((SQUARE, HALVES), {"up": "x"}, r"up: must be \"y\" or \"z\""),
        ((SQUARE, HALVES), {"root": "."}, r"root: says how a file is read"),
        ("cornell-box", {"up": "z"}, r"up: is for objects"),
    ],
)  # fmt: skip
def test_mistakes_are_told(value, words, message):
    with pytest.raises(alight.AlightError, match=message):
        load(value, **words)


def test_no_package_is_imported_to_look_at_an_object():
    code = (
        "import sys; from alight.formats import load; load(([[0,0,0],[1,0,0],[0,1,0]], [[0,1,2]]));"
        "print([m for m in ('trimesh', 'pyvista', 'vtkmodules', 'open3d') if m in sys.modules])"
    )
    run = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=True
    )
    assert run.stdout.strip() == "[]"


def test_a_transparent_background_shows_the_model_alone():
    """Whether an object or the scene made of it is rendered, no floor of the studio is left."""
    options = {"background": "transparent", "spp": 1, "size": (16, 12)}
    of_object, of_scene = (
        alight.render(given, **options).aov("alpha")
        for given in ((SQUARE, HALVES), load((SQUARE, HALVES)))
    )
    assert np.array_equal(of_object, of_scene)
    assert 0.05 < of_object.mean() < 0.95


@pytest.mark.parametrize(
    ("option", "value", "text"),
    [
        ("up", np.array([0, 0, 1]), 'must be "y" or "z"'),
        ("color_map", ["viridis"], "must be a name"),
        ("at", "1", "must be a number of seconds"),
    ],
)
def test_options_of_other_types_are_refused_by_name(option, value, text, tmp_path):
    scene = (SQUARE, HALVES)
    if option == "at":
        scene = tmp_path / "a.glb"
        scene.write_bytes(b"")
    with pytest.raises(alight.OptionError, match=f"{option}: {text}"):
        load(scene, **{option: value})
