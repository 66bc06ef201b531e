"""OBJ and MTL files as programs and people leave them: what is meant is found, or it is said."""

import time

import numpy as np
import pytest
from PIL import Image

from alight.core.errors import SceneError
from alight.formats.obj.scene import parse
from alight.meshes import obj
from tests.formats.bare import load, nodes_of

HEAD = "mtllib a.mtl\n"
POINTS = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\n"
FACE = "usemtl m\nf 1/1 2/2 3/3 4/4\n"


def colour(folder, library=b"newmtl m\nKd 0.5 0.25 0\n", model=HEAD + POINTS + FACE, name="a.mtl"):
    """Base colour of a square with a library, and what was said."""
    (folder / "a.obj").write_bytes(model.encode() if isinstance(model, str) else model)
    (folder / name).parent.mkdir(exist_ok=True)
    (folder / name).write_bytes(library)
    scene = load(folder / "a.obj")
    (bsdf,) = scene.bsdfs.values()
    said = [line for line in scene.warnings if not line.startswith("the file has no")]
    return bsdf.bsdf.base_color, said


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
def test_libraries_in_any_encoding(encoding, tmp_path):
    found, said = colour(
        tmp_path,
        "newmtl Fläche\nKd 0.5 0.25 0\n".encode(encoding),
        (HEAD + POINTS + FACE.replace("m\n", "Fläche\n", 1)).encode("latin-1"),
    )
    assert found == (0.5, 0.25, 0.0) and not said


@pytest.mark.parametrize(
    ("statement", "name", "is_said"),
    [
        ("a.mtl", "a.mtl", False),
        ('"a.mtl"', "a.mtl", False),
        (".\\a.mtl", "a.mtl", False),
        ("a b.mtl", "a b.mtl", False),
        ("A.MTL", "a.mtl", True),
        ("C:\\work\\Lib\\a.mtl", "lib/a.mtl", True),
        ("/home/me/a.mtl", "a.mtl", True),
    ],
)
def test_libraries_are_found(statement, name, is_said, tmp_path):
    model = f"mtllib {statement}\n{POINTS}{FACE}"
    found, said = colour(tmp_path, model=model, name=name)
    assert found == (0.5, 0.25, 0.0)
    assert [f'was found as "{name}"' in line for line in said] == [True] * is_said


@pytest.mark.parametrize(
    ("statement", "is_said"),
    [
        ("maps/My Wood.png", False),
        ("-s 2 2 1 -o 0.5 0 0 maps/My Wood.png", False),
        ('"maps/My Wood.png"', False),
        ("maps\\My Wood.png", False),
        ("MAPS/my wood.PNG", True),
        ("D:\\textures\\maps\\My Wood.png", True),
        ("../other/maps/My Wood.png", True),
    ],
)
def test_pictures_are_found(statement, is_said, tmp_path):
    (tmp_path / "maps").mkdir()
    Image.new("RGB", (2, 2)).save(tmp_path / "maps" / "My Wood.png")
    found, said = colour(tmp_path, f"newmtl m\nKd 1 1 1\nmap_Kd {statement}\n".encode())
    assert found.file == "maps/My Wood.png"
    assert [line.endswith('was found as "maps/My Wood.png"') for line in said] == [True] * is_said


def test_pictures_are_looked_for_beside_their_library_first(tmp_path):
    (tmp_path / "lib").mkdir()
    for folder in (tmp_path, tmp_path / "lib"):
        Image.new("RGB", (2, 2)).save(folder / "a.png")
    model = "mtllib lib/a.mtl\n" + POINTS + FACE
    library = b"newmtl m\nKd 1 1 1\nmap_Kd a.png\n"
    assert colour(tmp_path, library, model, "lib/a.mtl")[0].file == "lib/a.png"
    (tmp_path / "lib" / "a.png").unlink()
    assert colour(tmp_path, library, model, "lib/a.mtl")[0].file == "a.png"


def test_names_that_two_files_share_are_not_guessed(tmp_path):
    for name in ("A.png", "a.PNG"):
        Image.new("RGB", (2, 2)).save(tmp_path / name, "PNG")
    if len(list(tmp_path.iterdir())) == 1:
        pytest.skip("names differ in more than upper and lower case here")
    with pytest.raises(SceneError, match=r'no such file: "a\.png"'):
        colour(tmp_path, b"newmtl m\nmap_Kd a.png\n")


def test_a_map_without_a_name_is_none(tmp_path):
    found, said = colour(tmp_path, b"newmtl m\nKd 0.5 0.25 0\nmap_Kd\n")
    assert found == (0.5, 0.25, 0.0) and not said
    assert '"map_kd": names no picture' in load(tmp_path / "a.obj").source.remarks.notes


@pytest.mark.parametrize(
    "text",
    [
        HEAD + FACE.split("\n")[0] + "\n" + POINTS + FACE.split("\n")[1] + "\n",
        POINTS + FACE + HEAD,
        (HEAD + POINTS + FACE).replace("\n", "\r\n"),
        (HEAD + POINTS + FACE).replace("\n", "\r"),
        HEAD + POINTS + FACE.replace("4/4", "4/4 # four").replace("f ", "\t f "),
        HEAD + POINTS.replace("v 1 1 0", "v 1 1 0 # three #3") + FACE,
        HEAD + POINTS + FACE.replace("2/2", "\\\n2/2"),
        HEAD + POINTS + FACE.replace("1/1 2/2 3/3 4/4", "-4/-4 -3/-3 -2/-2 -1/-1"),
        (HEAD + POINTS + FACE).replace("vt 1 0\n", "vt 1\n"),
    ],
)
def test_one_square_written_in_many_ways(text, tmp_path):
    assert colour(tmp_path, model=text) == ((0.5, 0.25, 0.0), [])
    mesh = load(tmp_path / "a.obj").nodes["mesh"].shape
    np.testing.assert_array_equal(mesh.vertices[:, :2], mesh.uvs)
    np.testing.assert_array_equal(mesh.vertices[:, :2], [[0, 0], [1, 0], [1, 1], [0, 1]])


def test_a_number_sign_is_a_part_of_names(tmp_path):
    model = HEAD + POINTS + FACE.replace("usemtl m", "usemtl Material #25")
    assert colour(tmp_path, b"newmtl Material #25\nKd 0.5 0.25 0\n", model)[0] == (0.5, 0.25, 0.0)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("f 9 1 2", "a face uses v number 9, the file holds 4"),
        ("f 1 \\\n2 \\\n9", "a face uses v number 9, the file holds 4"),
        ("f 1 2 9", "a face uses v number 9, the file holds 4"),
        ("f 1/1 2/7 3/3", "a face uses vt number 7, the file holds 4"),
        ("f 1//1 2//1 3//2", "a face uses vn number 2, the file holds 1"),
        ("vt -1.#IND 0", "holds a word that is not a number"),
        ("f 1 2 x", 'is not a corner of a face: "x"'),
    ],
)
def test_mistakes_have_their_line(line, message):
    text = f"{POINTS}f 1 2 \\\n3\nf 1 2\nf 2 3 4\n{line}\nf 1 2 3\n"
    with pytest.raises(SceneError) as caught:
        parse(text.encode(), "a.obj")
    (issue,) = caught.value.issues
    assert issue.place == "a.obj:14:1" and issue.message.startswith(message)


def test_what_only_some_faces_have_is_said():
    def said(faces):
        return [
            line for line in parse((POINTS + faces).encode(), "a.obj").warnings if "some" in line
        ]

    assert said("g a\nf 1/1 2/2 3/3\nf 1 3 4\n") == [
        'a.obj: "a": only some faces have texture coordinates: the others take (0, 0)'
    ]
    assert said("f 1//1 2//1 3//1\nf 1 3 4\n") == [
        "a.obj: only some faces have normals: none is used"
    ]
    assert not said("g a\nf 1/1 2/2 3/3\ng b\nf 1 3 4\n")


def test_faces_keep_their_texture_coordinates_beside_faces_without_any():
    points = POINTS.replace("vt 0 0\n", "vt 0.5 0.5\n")
    text = points + "f 1/1 2/2 3/3\nf 3 4 1\nf 1/3 3 4/1\n"
    (node,) = nodes_of(parse(text.encode(), "a.obj")).values()
    mesh = node["shape"]
    corners = {
        (tuple(mesh.vertices[row, :2]), tuple(mesh.uvs[row]))
        for face in mesh.faces[:1]
        for row in face
    }
    assert corners == {((0, 0), (0.5, 0.5)), ((1, 0), (1, 0)), ((1, 1), (1, 1))}
    np.testing.assert_array_equal(mesh.uvs[mesh.faces[1]], np.zeros((3, 2)))
    np.testing.assert_array_equal(mesh.uvs[mesh.faces[2]], [[1, 1], [0, 0], [0.5, 0.5]])
    np.testing.assert_array_equal(
        mesh.vertices[mesh.faces.reshape(-1), :2],
        np.float32([[0, 0], [1, 0], [1, 1], [1, 1], [0, 1], [0, 0], [0, 0], [1, 1], [0, 1]]),
    )


@pytest.mark.parametrize(
    ("kind", "word", "corner"), [("vn", "normals", "1//1"), ("vt", "texture coordinates", "1/1")]
)
def test_faces_may_name_rows_of_a_kind_that_the_file_lacks(kind, word, corner):
    text = f"v 0 0 0\nv 1 0 0\nv 0 1 0\nf {corner} {corner.replace('1', '2')} 3\n"
    found = parse(text.encode(), "a.obj")
    (node,) = nodes_of(found).values()
    assert node["shape"].normals is None and node["shape"].uvs is None
    said = f"a.obj:4:1: a face uses {kind} number 1, the file holds 0: its faces have no {word}"
    assert said in found.warnings
    # A mesh by itself has nobody to tell.
    with pytest.raises(SceneError, match=f"line 4: a face uses {kind} number 1"):
        obj.read(text.encode())


COLORED = "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0.5 0.5 0.5\n"


def test_colours_of_vertices_tint_the_materials_of_a_library(tmp_path):
    color, said = colour(tmp_path, model=HEAD + COLORED + "usemtl m\nf 1 2 3\n")
    assert (color.type, color.a, color.b.type) == ("multiply", (0.5, 0.25, 0.0), "vertex_color")
    (line,) = said
    assert line.endswith("the colours of its vertices tint its materials")
    white = COLORED.replace("0.5 0.5 0.5", "1 1 1").replace("1 0 0\nv 1", "1 1 1\nv 1")
    white = white.replace("0 1 0\nv 0", "1 1 1\nv 0")
    assert colour(tmp_path, model=HEAD + white + "usemtl m\nf 1 2 3\n") == ((0.5, 0.25, 0.0), [])


def test_vertices_without_colours_among_others_are_white_and_said():
    text = COLORED + "v 1 1 0\nv 2 1 0\nv 2 2 0\ng a\nf 1 2 4\ng b\nf 4 5 6\n"
    found = parse(text.encode(), "a.obj")
    assert "a.obj: only some vertices have colours: the others are white" in found.warnings
    one, other = (node["shape"] for node in nodes_of(found).values())
    np.testing.assert_allclose(one.colors, [[1, 0, 0], [0, 1, 0], [1, 1, 1]])
    assert other.colors is None


def test_materials_without_a_library_are_said():
    words = "a.obj: names materials but no library (mtllib): all is grey"
    assert words in parse((POINTS + FACE).encode(), "a.obj").warnings
    plain = (POINTS + FACE).replace("usemtl m\n", "")
    assert words not in parse(plain.encode(), "a.obj").warnings


def test_many_groups_take_no_longer_than_one():
    rows, columns = 100, 300
    x, y = np.meshgrid(np.arange(columns), np.arange(rows))
    points = "".join(f"v {a} {b} 0\n" for a, b in zip(x.flat, y.flat, strict=True))
    faces = [f"f {i} {i + 1} {i + columns + 1}\n" for i in range(1, columns * (rows - 1))]

    def seconds(groups):
        parts = np.array_split(np.arange(len(faces)), groups)
        text = points + "".join(
            f"g {n}\n" + "".join(faces[i] for i in part) for n, part in enumerate(parts)
        )
        begin = time.process_time()
        nodes = nodes_of(parse(text.encode(), "a.obj"))
        assert len(nodes) == groups
        return time.process_time() - begin, nodes

    # The least of some: in a large process one collection of garbage takes longer than the file.
    one = min(seconds(1)[0] for _ in range(3))
    times, nodes = zip(*(seconds(300) for _ in range(3)), strict=True)
    # Each part that goes through the points of all made this a hundred times.
    assert min(times) < 5.0 * one
    assert sum(len(node["shape"].faces) for node in nodes[0].values()) == len(faces)
    assert obj.read(points.encode() + "".join(faces).encode()).faces.shape == (len(faces), 3)
