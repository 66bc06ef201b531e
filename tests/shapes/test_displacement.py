"""Displacement: heights and normals in closed form, no cracks, and the shading of a bump map."""

import numpy as np
import pytest

import alight
from alight.compiled import displacement
from alight.compiled.displacement import MOST_TRIANGLES, displaced, moved, told
from alight.compiled.kept import Kept
from alight.compiled.scene import compile_scene
from alight.core.errors import SceneError
from alight.films import fixed_point
from alight.formats import dumps, loads
from alight.integrators.walk import make_settings
from alight.laws.scene import pictures
from alight.meshes.tessellation import TooManyTrianglesError, tessellated
from alight.meshes.triangles import MeshArrays
from alight.rendering.tiles.tile import make_kernels, render_tile
from alight.rendering.tiles.tile_kernel import Tile
from alight.scene import content_hash, flatten
from alight.scene.description import Node
from alight.scene.meshes import mesh_of as mesh_spec

SQUARE = "vertices: [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], faces: [[0, 1, 2], [0, 2, 3]]"
UVS = "uvs: [[0, 0], [1, 0], [1, 1], [0, 1]]"

HEAD = """
alight: 1
film: {size: [16, 16]}
sampler: independent
integrator: direct
camera: {type: orthographic, height: 1.6, transform: {translate: [0, 0, 5]}}
textures:
  ramp: {type: bitmap, pixels: [[0, 1]], color_space: linear, wrap: clamp}
  hills: {type: bitmap, pixels: PIXELS, color_space: linear, wrap: repeat}
nodes:
  sun:
    light: {type: directional, irradiance: 3}
    transform: {look_at: {origin: [0, 0, 0], target: [2, 1, 2]}}
"""

#: One period of a smooth wave in u and v.
PHASES = 2 * np.pi * (np.arange(32) + 0.5) / 32
HILLS = np.round(0.5 + 0.25 * (np.sin(PHASES)[None, :] + np.cos(PHASES)[:, None]), 6)
HEAD = HEAD.replace("PIXELS", str(HILLS.tolist()))


#: Textures that name each other.
CIRCLE = """  circle: {type: add, a: round, b: 1}
  round: {type: add, a: circle, b: 1}
"""


def board(keys, bsdf="{type: diffuse, reflectance: 0.8}", more=UVS):
    """A scene of one square."""
    return HEAD + (f"  board: {{bsdf: {bsdf}, shape: {{type: mesh, {SQUARE}, {more}{keys}}}}}\n")


def mesh_of(text):
    return geometry_of(loads(text, "scene.yaml"))


def geometry_of(scene):
    after = displaced(flatten(scene))
    return after.geometries[after.shapes[-1].geometry]


def cube(split=True):
    """A cube whose faces have corners of their own, and their own charts."""
    faces, vertices = [], []
    for axis in range(3):
        for side in (-1.0, 1.0):
            corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], np.float32)[:: int(side)]
            rolled = np.roll(np.c_[np.full(4, side), corners], axis, axis=1)
            faces += [[len(vertices) + i for i in t] for t in ((0, 1, 2), (0, 2, 3))]
            vertices += rolled.tolist()
    uvs = np.array([[0, 0], [1, 0], [1, 1], [0, 1]] * 6, np.float32)
    return MeshArrays(np.array(vertices, np.float32), np.array(faces, np.int32), uvs=uvs)


def edges_of(mesh):
    """Directed edges between places, and how many places there are."""
    _, which = np.unique(mesh.vertices + 0.0, axis=0, return_inverse=True)
    faces = which.ravel()[mesh.faces]
    return np.concatenate([faces[:, [i, (i + 1) % 3]] for i in range(3)]), which.max() + 1


def lengths_of(mesh):
    corners = mesh.vertices[mesh.faces].astype(np.float64)
    return np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)


def is_closed(mesh):
    """Every edge is that of two triangles that are turned alike, as on a sphere."""
    edges, count = edges_of(mesh)
    there = {tuple(edge) for edge in edges.tolist()}
    paired = len(there) == len(edges) and all((b, a) in there for a, b in there)
    return paired and count - len(edges) // 2 + len(mesh.faces) == 2


def test_a_ramp_moves_to_the_heights_and_normals_of_its_slope():
    keys = ", displacement: ramp, displacement_scale: 0.6, displacement_midlevel: 0.5"
    mesh = mesh_of(board(keys + ", displacement_edge: 0.1"))
    x, y, z = mesh.vertices.T.astype(np.float64)
    # Between the centres of the two texels the height grows from 0 to 1.
    inner = np.abs(x) < 0.4
    np.testing.assert_allclose(z[inner], 0.6 * x[inner], atol=1e-6)
    np.testing.assert_allclose(z, 0.6 * np.clip(x, -0.5, 0.5), atol=1e-6)
    slope = np.array([-0.6, 0.0, 1.0]) / np.hypot(0.6, 1.0)
    np.testing.assert_allclose(mesh.normals[inner], np.tile(slope, (inner.sum(), 1)), atol=1e-5)
    assert inner.sum() > 100
    assert (np.abs(y) <= 1.0).all()


def test_a_wave_has_the_heights_and_normals_of_its_formula():
    flat = MeshArrays(
        np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32),
        np.array([[0, 1, 2], [0, 2, 3]], np.int32),
    )
    fine = tessellated(flat, 0.02, MOST_TRIANGLES)
    x = fine.vertices[:, 0].astype(np.float64)
    mesh = moved(fine, 0.1 * np.sin(3.0 * x), flat=False)
    np.testing.assert_allclose(mesh.vertices[:, 2], 0.1 * np.sin(3.0 * x), atol=1e-6)
    inner = (np.abs(fine.vertices[:, :2]) < 0.95).all(axis=1)
    wanted = np.stack([-0.3 * np.cos(3.0 * x), np.zeros_like(x), np.ones_like(x)], axis=1)
    wanted /= np.linalg.norm(wanted, axis=1, keepdims=True)
    # Normals of triangles are right to the order of their size.
    np.testing.assert_allclose(mesh.normals[inner], wanted[inner], atol=2e-3)


def test_charts_and_edges_of_a_cube_do_not_open():
    fine = tessellated(cube(), 0.3, MOST_TRIANGLES)
    assert is_closed(fine)
    assert lengths_of(fine).max() <= 0.3 * (1 + 1e-6)
    heights = 0.2 * np.sin(7.0 * fine.uvs[:, 0]) * np.cos(5.0 * fine.uvs[:, 1] + 1.0)
    mesh = moved(fine, heights, flat=False)
    assert is_closed(mesh)
    assert np.abs(mesh.vertices - fine.vertices).max() > 0.1
    outwards = (mesh.normals * mesh.vertices).sum(axis=1)
    assert (outwards > 0.0).all()


def test_seams_that_are_closed_but_for_rounding_stay_closed():
    # A tube, whose last column lies at sin(2 pi) where the first has 0; heights differ there.
    u, v = (grid.ravel() for grid in np.meshgrid(np.linspace(0, 1, 13), np.linspace(0, 1, 4)))
    points = np.stack([np.cos(2 * np.pi * u), np.sin(2 * np.pi * u), v], axis=1)
    corner = (13 * np.arange(3)[:, None] + np.arange(12)).ravel()
    faces = [np.stack([corner, corner + a, corner + b], axis=1) for a, b in ((1, 14), (14, 13))]
    arrays = MeshArrays(points.astype(np.float32), np.concatenate(faces).astype(np.int32))
    assert len(np.unique(arrays.vertices, axis=0)) == 4 * 13
    spec = mesh_spec(arrays._replace(uvs=np.stack([u, v], axis=1).astype(np.float32)))
    keys = {"displacement": "ramp", "displacement_edge": 0.2, "displacement_scale": 0.3}
    scene = loads(HEAD + "  ball: {shape: sphere}\n", "scene.yaml")
    scene = scene.replaced(nodes={"tube": Node(shape=spec.replaced(**keys))})
    mesh = geometry_of(scene)
    places = np.unique(mesh.vertices + 0.0, axis=0)
    edges, _ = edges_of(mesh)
    pairs, uses = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    # Only edges of the two rims have no triangle on their other side.
    height = places[pairs[uses == 1], 2]
    assert uses.max() == 2
    np.testing.assert_allclose(height, np.round(height), atol=1e-5)


def test_a_mesh_that_is_inside_out_keeps_its_outer_side():
    inverted = cube()._replace(faces=cube().faces[:, ::-1].copy())
    normals = np.array(cube().vertices) / np.sqrt(3.0)
    mesh = moved(
        inverted._replace(normals=normals.astype(np.float32)), np.full(24, 0.5), flat=False
    )
    np.testing.assert_allclose(np.linalg.norm(mesh.vertices, axis=1), np.sqrt(3.0) + 0.5, rtol=1e-6)
    assert ((mesh.normals * mesh.vertices).sum(axis=1) > 0.0).all()


def test_edges_are_short_enough_and_the_surface_is_the_same():
    # A long triangle beside small ones: some edges are halved often, others never.
    points = np.array([[0, 0, 0], [4, 0, 0], [4, 0.3, 0], [0, 0.2, 0], [4.1, 0.1, 0]], np.float32)
    uvs = (points[:, :2] @ np.array([[0.5, 0.1], [0.2, 2.0]])).astype(np.float32)
    rough = MeshArrays(points, np.array([[0, 1, 2], [0, 2, 3], [1, 4, 2]], np.int32), uvs=uvs)
    fine = tessellated(rough, 0.25, MOST_TRIANGLES)
    assert lengths_of(fine).max() <= 0.25 * (1 + 1e-6)
    corners = fine.vertices[fine.faces].astype(np.float64)
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] / 2
    assert (areas > 0.0).all()
    assert areas.sum() == pytest.approx(0.5 * 4 * 0.3 + 0.5 * 4 * 0.2 + 0.5 * 0.1 * 0.3, rel=1e-5)
    found = fine.vertices[:, :2] @ np.array([[0.5, 0.1], [0.2, 2.0]])
    np.testing.assert_allclose(fine.uvs, found, atol=1e-5)
    # No vertex lies inside an edge: those of one triangle only make up the border.
    edges, count = edges_of(fine)
    pairs, uses = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    assert uses.max() == 2
    assert count - len(pairs) + len(fine.faces) == 1
    with pytest.raises(TooManyTrianglesError):
        tessellated(rough, 0.25, len(fine.faces) - 1)


def picture_of(text, spp=16):
    scene = compile_scene(flatten(loads(text, "scene.yaml")), builder="median")
    settings = make_settings(scene.integrator, seed=1, replicates=4)
    film, _ = render_tile(
        make_kernels(scene), scene, settings, Tile(0, 0, 16, 16), np.full((2, 2, 2), [0, spp])
    )
    sums = film.sums.sum(axis=2)
    fixed_point.carry(sums)
    return fixed_point.to_float(sums)[..., 0] / spp


def test_shallow_hills_are_shaded_as_by_a_bump_map():
    bump = "{type: bump_map, texture: hills, scale: 0.06, fading: false, "
    bump += "bsdf: {type: diffuse, reflectance: 0.8}}"
    bumped = picture_of(board("", bump))
    keys = ", displacement: hills, displacement_scale: 0.06, displacement_edge: 0.03"
    hilly = picture_of(board(keys))
    assert np.ptp(bumped) > 0.1 * bumped.mean()
    # The sun has no noise; a height of 0.06 shifts what is seen nowhere, as rays are parallel.
    np.testing.assert_allclose(hilly, bumped, rtol=0.015)


def test_what_is_displaced_is_told_and_counts_for_the_hash():
    plain = flatten(loads(board(""), "scene.yaml"))
    assert displaced(plain) is plain
    once = displaced(flatten(loads(board(", displacement: 0.5, displacement_edge: 1"), "again")))
    assert displaced(once) is once
    keys = ", displacement: 0.5, displacement_edge: 0.5"
    flat = flatten(loads(board(keys), "scene.yaml"))
    after = displaced(flat)
    found = told(flat, after)["board"]
    assert found["before"] == 2
    assert found["triangles"] == len(after.geometries[-1].faces) > 16
    np.testing.assert_allclose(after.geometries[-1].vertices[:, 2], 0.5)
    other = loads(board(keys + ", displacement_scale: 2"), "scene.yaml")
    assert len({content_hash(plain), content_hash(flat), content_hash(other)}) == 3
    assert loads(dumps(other), "again.yaml") == other


def test_meshes_that_are_as_they_were_are_the_same_arrays():
    keys, kept = ", displacement: hills, displacement_edge: 0.5", Kept()

    def vertices_of(text):
        return displaced(flatten(loads(text, "scene.yaml")), kept).geometries[-1].vertices

    first = vertices_of(board(keys))
    assert vertices_of(board(keys, "{type: diffuse, reflectance: 0.1}")) is first
    # Everything that decides them: keys, the texture, the mesh.
    scaled = vertices_of(board(keys + ", displacement_scale: 2"))
    np.testing.assert_allclose(scaled[:, 2], 2 * first[:, 2], atol=1e-6)
    bent = vertices_of(board(keys).replace(str(HILLS[0, 0]), str(HILLS[0, 0] + 1)))
    assert np.abs(bent[:, 2] - first[:, 2]).max() > 0.1
    assert vertices_of(board(keys).replace("[1, 1, 0]", "[1, 1.5, 0]"))[:, 1].max() == 1.5


def test_info_says_how_many_triangles_there_are():
    scene = loads(board(", displacement: 0.5, displacement_edge: 0.5"), "scene.yaml")
    facts = dict(alight.info(scene, tree=True).facts)
    assert facts["displaced"] == "board: 64 triangles of 2"
    assert "displaced" not in facts["accelerator"]


@pytest.mark.parametrize(
    ("keys", "more", "said"),
    [
        (", displacement: hils", UVS, 'unknown texture "hils"; did you mean "hills"'),
        ("displacement: hills", "", "a bitmap needs texture coordinates, and the mesh has no uvs"),
        ("displacement: {type: add, a: 1, b: hills}", "", "an add needs texture coordinates"),
        ("displacement: circle", "", "contains itself: circle -> round -> circle"),
        (", displacement: 1, displacement_edge: 0", UVS, "displacement_edge"),
        (", displacement: 1, displacement_edge: 0.01", UVS, "make displacement_edge larger"),
        (", displacement: 1.e+9, displacement_scale: 1.e+9, displacement_edge: 1", UVS, "too far"),
    ],
)
def test_what_cannot_be_displaced_is_refused(keys, more, said, monkeypatch):
    monkeypatch.setattr(displacement, "MOST_TRIANGLES", 1000)
    text = board(keys, more=more)
    text = text.replace("nodes:\n", f"{CIRCLE}nodes:\n") if "circle" in keys else text
    with pytest.raises(SceneError, match=said):
        displaced(flatten(loads(text, "scene.yaml")))


def test_solid_textures_need_no_coordinates():
    mesh = mesh_of(board("displacement: {type: noise, scale: 3}, displacement_edge: 0.2", more=""))
    assert 0.1 < np.ptp(mesh.vertices[:, 2]) <= 1.0


@pytest.mark.parametrize(
    ("texture", "height"),
    [
        ("{type: constant, color: 0.5}", 0.5),
        ("{type: multiply, a: {type: constant, color: 0.5}, b: 3}", 1.5),
        ("{type: vertex_color}", 0.25),
        ("{type: vertex_color, fallback: 0.75}", 0.75),
    ],
)
def test_textures_that_kernels_treat_apart_displace_too(texture, height):
    more = "" if "fallback" in texture else f", colors: {[[0.25, 0.25, 0.25]] * 4}"
    mesh = mesh_of(board(f", displacement: {texture}, displacement_edge: 0.5", more=UVS + more))
    np.testing.assert_allclose(mesh.vertices[:, 2], height, rtol=1e-6)


def test_parts_of_a_texture_have_their_own_sets_of_coordinates():
    ramps = [f"{{type: bitmap, uv_set: {k}, pixels: [[1, 3]], color_space: linear, wrap: clamp}}"
             for k in (0, 1, 7)]  # fmt: skip
    # There is no set 7: the mesh's own.
    product = (
        f"{{type: multiply, a: {ramps[0]}, b: {{type: multiply, a: {ramps[1]}, b: {ramps[2]}}}}}"
    )
    sets = ", more_uvs: [[[0.5, 0], [0.5, 0], [1, 0], [1, 0]]]"
    keys = f", displacement: {product}, displacement_edge: 9"
    mesh = mesh_of(board(keys, more=UVS + sets))
    np.testing.assert_allclose(mesh.vertices[:, 2], [2, 18, 27, 3], rtol=1e-6)


#: Two triangles that share an edge, with corners of their own: x and y of one side are 0, or -0.
FOLDED = {
    "vertices": [[0, 0, 0], [2, 0, 0], [0, 1, 0], [2, -0.0, 0], [2, 1, 1], [-0.0, 1, 0]],
    "faces": [[0, 1, 2], [3, 4, 5]],
    "normals": [[0, 0, 3], [0, 0, 1], [0, 0, 0.2], [-2, 0, 1], [-1, 0, 1], [-4, 1, 2]],
    "uvs": [[0.25, 0], [0.75, 0], [0.25, 1], [0.5, 0], [0.75, 0], [0.3, 1]],
    "more_uvs": [
        [[0.3, 0], [0.4, 0], [0.5, 0], [0.6, 0], [0.7, 0], [0.75, 0]],
        [[0.75, 0], [0.5, 0], [0.25, 0], [0.3, 0], [0.3, 0], [0.7, 0]],
    ],
    "colors": [[0.9, 0.1, 0.2], [0.2, 0.8, 0.4], [0, 0.5, 1], [1, 0, 0], [0.1, 0, 0.9], [0, 1, 0]],
}  # fmt: skip


@pytest.mark.parametrize("band", [1 << 16, 3])
def test_a_displaced_mesh_is_that_of_its_formula(band, monkeypatch):
    """p + s (h - m) n once more, vertex by vertex: of several sets of coordinates, in colours."""
    monkeypatch.setattr(displacement, "_BAND", band)
    ramps, s, m = [(1.0, 0.5, 0.2), (0.2, 1.0, 0.1), (0.3, 0.1, 2.0)], -0.3, 0.4
    parts = [
        f"{{type: bitmap, uv_set: {k}, pixels: [[[0, 0, 0], {list(c)}]], color_space: linear, "
        "wrap: clamp}" for k, c in enumerate(ramps)
    ]  # fmt: skip
    texture = (
        f"{{type: multiply, a: {{type: vertex_color}}, b: {{type: add, a: {parts[0]}, "
        f"b: {{type: add, a: {parts[1]}, b: {parts[2]}}}}}}}"
    )
    rows = ", ".join(f"{name}: {table}" for name, table in FOLDED.items())
    keys = f"displacement: {texture}, displacement_scale: {s}, displacement_midlevel: {m}"
    found = mesh_of(
        HEAD + f"  folded: {{shape: {{type: mesh, displacement_edge: 0.6, {rows}, {keys}}}}}\n"
    )

    mesh = {name: np.array(table, np.float32) for name, table in FOLDED.items()}
    mesh["faces"] = mesh["faces"].astype(np.int32)
    fine = tessellated(MeshArrays(**mesh), 0.6, MOST_TRIANGLES)
    sets = [fine.uvs, *fine.more_uvs]
    ramp = sum(2.0 * (uv[:, :1] - 0.25) * c for uv, c in zip(sets, ramps, strict=True))
    heights = (fine.colors * ramp) @ [0.2126, 0.7152, 0.0722]
    unit = fine.normals / np.linalg.norm(fine.normals, axis=1, keepdims=True)
    expected = []
    for p in fine.vertices:
        here = (fine.vertices == p).all(axis=1)
        n = unit[here].sum(axis=0)
        expected.append(p + s * (heights[here].mean() - m) * n / np.linalg.norm(n))
    assert len(expected) > 20
    np.testing.assert_allclose(found.vertices, expected, atol=2e-5)


def test_an_even_texture_counts_by_its_luminance():
    keys = ", displacement: {type: constant, color: [1, 0.5, 0.25]}, displacement_edge: 9"
    np.testing.assert_allclose(mesh_of(board(keys)).vertices[:, 2], 0.58825, rtol=1e-4)


def test_edges_are_by_default_a_part_of_the_diagonal():
    """Of a box of 3 m by 4 m 5/256 m: its diagonal is halved eight times."""
    text = board(", displacement: 0.5").replace("[-1, -1, 0]", "[0, 0, 0]")
    text = text.replace("[1, -1, 0]", "[3, 0, 0]").replace("[1, 1, 0]", "[3, 4, 0]")
    mesh = mesh_of(text.replace("[-1, 1, 0]", "[0, 4, 0]"))
    assert lengths_of(mesh).max() == pytest.approx(5 / 256, rel=1e-4)


@pytest.mark.parametrize("mirrored", [False, True])
def test_of_two_diagonals_the_shorter_one_is_taken(mirrored):
    """Two edges of a triangle are halved: between what is left, by the shorter way across."""
    corners = np.array([[0, 0, 0], [3, 0, 0], [0.25, 2, 0]], np.float32)
    faces = np.array([[0, 1, 2]], np.int32)
    if mirrored:
        corners, faces = corners * np.float32([-1, 1, 1]), np.array([[2, 1, 0]], np.int32)
    halved = tessellated(MeshArrays(corners, faces), 2.5, MOST_TRIANGLES)
    # From the corner at 0 to the middle of the edge across.
    middle = halved.vertices.tolist().index([(-1.625 if mirrored else 1.625), 1.0, 0.0])
    shared = [{0, middle} <= set(face) for face in halved.faces.tolist()]
    assert (len(shared), sum(shared)) == (3, 2)


def test_shapes_of_formulas_have_no_displacement():
    with pytest.raises(SceneError, match='unknown key "displacement"'):
        loads(HEAD + "  ball: {shape: {type: sphere, displacement: hills}}\n", "scene.yaml")


def test_laws_of_a_scene_count_the_displaced_triangles(monkeypatch):
    text = board(", displacement: 0.5, displacement_edge: 0.1")
    text = text.replace("board: {", "board: {light: {type: area, radiance: 1}, ")
    scene = loads(text, "scene.yaml")
    said = {finding.part: finding.detail for finding in alight.check(scene, only="lights").findings}
    assert "triangles: too many" in said["light board"]
    monkeypatch.setattr(pictures, "MOST_TESTS", 1e6)
    assert "triangles: too many" in next(pictures.check_accelerators(scene, 1, str)).detail
