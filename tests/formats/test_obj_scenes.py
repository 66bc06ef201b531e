"""OBJ, PLY and STL files opened by themselves: parts, materials, maps, what is said."""

import math

import numpy as np
import pytest
from PIL import Image

from alight.core.errors import SceneError
from alight.formats.obj import mtl
from alight.formats.obj.scene import parse
from alight.formats.reading.reach import OutOfReachError, Reach
from alight.formats.reading.report import Report
from alight.scene import flatten
from tests.formats.bare import load
from tests.formats.mutate import STL, mesh_file

OBJ = b"""mtllib a.mtl
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
vt 0 0
vt 1 0
vt 1 1
vt 0 1
g left
usemtl red
f 1/1 2/2 3/3
g right
usemtl lamp
f 1/1 3/3 4/4
usemtl red
s 1
f 4/4 3/3 1/1
"""
MTL = """newmtl red
Kd 0.8 0.1 0.1
Ks 0.5 0.5 0.5
Ns 98
newmtl lamp
Ke 3 2 1
"""


def material(text, tmp_path=None):
    """What the statements of one material become."""
    report = Report()
    found = mtl.read(f"newmtl it\n{text}", "a.mtl", Reach(tmp_path), report)
    assert not report.issues, report.issues
    return found["it"], report


def core(bsdf):
    while "bsdf" in bsdf:
        bsdf = bsdf["bsdf"]
    return bsdf


def test_groups_and_materials_become_nodes(tmp_path):
    (tmp_path / "a.obj").write_bytes(OBJ)
    (tmp_path / "a.mtl").write_text(MTL)
    scene = load(tmp_path / "a.obj")
    assert list(scene.nodes) == ["left", "right", "right-2"]
    assert set(scene.bsdfs) == {"red", "lamp"}
    flat = flatten(scene)
    assert [len(g.vertices) for g in flat.geometries] == [3, 3, 3]
    assert scene.nodes["left"].shape.normals is None
    np.testing.assert_allclose(scene.nodes["right-2"].shape.normals, [[0, 0, -1]] * 3)
    assert scene.nodes["right"].light.radiance == (3.0, 2.0, 1.0)
    # The lamp is light enough.
    assert not any("studio" in w for w in scene.warnings)


def test_legacy_highlights_are_those_of_a_varnish():
    bsdf = core(material("Kd 0.2 0.4 0.6\nKs 0.5 0.25 0.5\nNs 98")[0].bsdf)
    assert bsdf["base_color"] == [0.2, 0.4, 0.6]
    assert bsdf["roughness"] == pytest.approx(math.sqrt(math.sqrt(2 / 100)))
    assert bsdf["specular"] == 0.5
    assert bsdf["specular_color"] == [1.0, 0.5, 1.0]
    assert core(material("Kd 1 1 1\nKs 1 1 1\nillum 1")[0].bsdf)["specular"] == 0.0
    metal = core(material("Kd 0.1 0.1 0.1\nKs 0.9 0.8 0.7\nillum 3")[0].bsdf)
    assert metal["metallic"] == 1.0
    assert metal["base_color"] == [0.9, 0.8, 0.7]


def test_physical_keys_come_first():
    text = "Kd 0.5 0.5 0.5\nKs 1 1 1\nNs 10\nPr 0.3\nPm 0.7\nPs 0.2\nPc 0.5\nPcr 0.1\naniso 0.4"
    bsdf = core(material(text + "\nanisor 0.25\nKe 1 1 1")[0].bsdf)
    assert (bsdf["roughness"], bsdf["metallic"], bsdf["specular"]) == (0.3, 0.7, 1.0)
    assert (bsdf["clearcoat"], bsdf["clearcoat_roughness"]) == (0.5, 0.1)
    assert (bsdf["anisotropy"], bsdf["sheen_color"]) == (0.4, 0.2)
    assert bsdf["anisotropy_rotation"] == pytest.approx(math.pi / 2)


def test_opacity_and_glass():
    assert material("d 0.25")[0].bsdf["opacity"] == 0.25
    assert material("Tr 0.25")[0].bsdf["opacity"] == 0.75
    glass = material("illum 7\nNi 1.33\nTf 1 0.5 1\nd 0.1\nKs 1 1 1")[0].bsdf
    assert glass["type"] == "principled"
    assert (glass["transmission"], glass["ior"]) == (1.0, 1.33)
    assert glass["base_color"] == [1.0, 0.5, 1.0]


def test_maps_and_their_options(tmp_path):
    Image.new("RGBA", (2, 2), (255, 0, 0, 128)).save(tmp_path / "a b.png")
    Image.new("L", (2, 2), 9).save(tmp_path / "grey.png")
    text = """Kd 0 0 0
map_Kd -s 2 3 1 -o 0.5 -clamp on a b.png
map_d a b.png
map_Pr -imfchan g -mm 0.25 0.5 grey.png
bump -bm 0.3 C:\\work\\grey.png
Ka 1 1 1
"""
    found, report = material(text, tmp_path)
    bsdf = core(found.bsdf)
    assert bsdf["base_color"]["file"] == "a b.png"
    assert bsdf["base_color"]["wrap"] == "clamp"
    steps = [{"scale": [2.0, 3.0]}, {"translate": [0.5, 0.0]}]
    assert bsdf["base_color"]["to_uv"] == steps
    assert found.bsdf["opacity"]["channel"] == "a"
    assert bsdf["roughness"]["type"] == "add"
    assert bsdf["roughness"]["b"]["b"]["channel"] == "g"
    assert bsdf["roughness"]["b"]["b"]["texture"]["color_space"] == "linear"
    assert found.bsdf["bsdf"]["bsdf"]["type"] == "bump_map"
    assert found.bsdf["bsdf"]["bsdf"]["scale"] == 0.3
    assert any("was found as" in w for w in report.warnings)
    assert any('"ka"' in note for note in report.notes)


def pictures(folder):
    Image.new("RGBA", (2, 2), (255, 0, 0, 128)).save(folder / "a.png")
    Image.new("L", (2, 2), 9).save(folder / "grey.png")


def test_maps_of_transparency_are_turned_over_and_channels_chosen(tmp_path):
    pictures(tmp_path)
    opacity = material("map_Tr grey.png", tmp_path)[0].bsdf["opacity"]
    assert (opacity["type"], opacity["a"], opacity["b"]) == ("mix", 1.0, 0.0)
    assert opacity["weight"]["file"] == "grey.png"
    for word, channel in (("r", "r"), ("m", "a")):
        text = f"map_Kd a.png\nmap_d -imfchan {word} a.png\nmap_Pr -imfchan {word} a.png"
        bsdf = material(text, tmp_path)[0].bsdf
        assert (bsdf["opacity"]["type"], bsdf["opacity"]["channel"]) == ("channel", channel)
        assert core(bsdf)["roughness"]["channel"] == channel
    # A picture of its own is grey, whatever its alpha.
    assert material("map_d a.png", tmp_path)[0].bsdf["opacity"]["type"] == "bitmap"


def test_factors_of_maps(tmp_path):
    pictures(tmp_path)
    found, report = material("Kd 0 0 0\nmap_Kd -texres 8 a.png\nKe 0 0 0\nmap_Ke a.png", tmp_path)
    assert core(found.bsdf)["base_color"]["type"] == "bitmap"
    assert found.emission["file"] == "a.png"
    assert any("-texres" in note for note in report.notes)
    bsdf = core(material("Kd 0.5 1 1\nmap_Kd a.png\nPr 0\nmap_Pr grey.png", tmp_path)[0].bsdf)
    assert bsdf["roughness"]["type"] == "bitmap"
    found = material("Ke 4 2 1\nmap_Ke a.png\nmap_Bump -mm 0.25 0.5 grey.png", tmp_path)[0]
    assert (found.emission["a"], found.emission["b"]["file"]) == ([4.0, 2.0, 1.0], "a.png")
    bump = found.bsdf["bsdf"]
    assert bump["type"] == "bump_map"
    # Base, then gain.
    assert (bump["texture"]["a"], bump["texture"]["b"]["a"]) == (0.25, 0.5)


def test_metals_reflect_more_than_they_scatter():
    bsdf = core(material("Kd 0.8 0.8 0.8\nKs 0.5 0.5 0.5\nillum 3")[0].bsdf)
    assert "metallic" not in bsdf
    assert bsdf["specular"] == 0.5


def test_parts_that_come_again_keep_all_faces_and_smoothing_ends(tmp_path):
    again = b"g left\nusemtl red\ns off\nf 1/1 2/2 4/4\n"
    (tmp_path / "a.obj").write_bytes(OBJ + again)
    (tmp_path / "a.mtl").write_text(MTL)
    nodes = load(tmp_path / "a.obj").nodes
    assert list(nodes) == ["left", "right", "right-2"]
    assert len(nodes["left"].shape.faces) == 2
    assert nodes["left"].shape.normals is None


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("Ns a", 'a.mtl:2:1  ns\n  must be numbers, got "a"'),
        ("d 1.5", "must be in [0, 1], got 1.5"),
        ("Kd spectral a.rfl", "spectral is not covered"),
        ("map_Kd grey.pn", 'did you mean "grey.png"?'),
        ("map_Kd ../a.png", "leads out of the folder of the scene"),
    ],
)
def test_problems_have_a_line(line, words, tmp_path):
    (tmp_path / "grey.png").write_bytes(b"")
    (tmp_path / "a.obj").write_bytes(OBJ)
    (tmp_path / "a.mtl").write_text(f"newmtl red\n{line}\nnewmtl lamp\n")
    with pytest.raises(SceneError) as caught:
        load(tmp_path / "a.obj")
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("line", "words", "harmless"),
    [
        ("Kdd 1 1 1", 'a.mtl:2:1: unknown key "kdd" is left out; did you mean "kd"?', False),
        ("map_Ns grey.png", '"map_ns" is left out: highlights have one exponent', False),
        ("disp grey.png", '"disp" is left out', False),
        ("d -halo 0.5", "-halo", False),
        ("map_Kd -cc on grey.png", "-cc of map_kd is not covered", False),
        ("map_Kd -blendu on grey.png", "-blendu: plays no part", True),
        ("map_Kd -blendu off grey.png", "", True),
        ("map_Kd -mm 0 1.2 grey.png", "-mm of map_kd may reach 1.2: it is cut at 1", False),
        ("map_Ke -mm 0 1.2 grey.png", "", True),
        ("illum 7\nNi 0.5", "Ni 0.5 became 1.5", False),
        ("illum 7\nd 0.5", '"d": glass', True),
        ("Tf 0.5 0.5 0.5", '"tf": only glass', True),
        ("norm grey.png\nbump grey.png", "bump is left out beside norm", False),
    ],
)
def test_what_a_material_does_not_get_is_said(line, words, harmless, tmp_path):
    Image.new("L", (1, 1), 128).save(tmp_path / "grey.png")
    (tmp_path / "a.obj").write_bytes(OBJ)
    (tmp_path / "a.mtl").write_text(f"newmtl red\n{line}\nnewmtl lamp\n")
    remarks = load(tmp_path / "a.obj").source.remarks
    warnings = [w for w in remarks.warnings if not w.startswith("the file has no")]
    found = list(remarks.notes) if harmless else warnings
    assert [words] == [words for line in found if words in line] if words else not found
    assert not (warnings if harmless else remarks.notes)


@pytest.mark.parametrize(
    ("line", "words", "harmless"),
    [
        ("usemlt red", 'unknown statement "usemlt" is left out; did you mean "usemtl"?', False),
        ("curv 0 1 1 2", '"curv" is left out: curves and free-form surfaces', False),
        ("lod 3", '"lod": plays no part', True),
        ("f 1 2", "faces of fewer than 3 corners", True),
    ],
)
def test_statements_that_are_left_out_are_said(line, words, harmless):
    report = parse(OBJ.replace(b"mtllib a.mtl\n", b"") + f"{line}\n{line}\n".encode(), "a.obj")
    found = report.remarks.notes if harmless else report.remarks.warnings
    assert sum(words in line for line in found) == 1


@pytest.mark.parametrize("line", ["v 1 2", "f 0 1 2", "vt a b"])
def test_broken_statements_have_a_line(line):
    with pytest.raises(SceneError) as caught:
        parse(f"v 0 0 0\n{line}\n".encode(), "a.obj")
    assert [issue.place for issue in caught.value.issues] == ["a.obj:2:1"]


def test_broken_pictures_are_placed_at_their_material(tmp_path):
    (tmp_path / "grey.png").write_bytes(b"")
    (tmp_path / "a.obj").write_bytes(OBJ)
    (tmp_path / "a.mtl").write_text("newmtl lamp\nnewmtl red\nmap_Kd grey.png\n")
    with pytest.raises(SceneError) as caught:
        load(tmp_path / "a.obj")
    assert [issue.place for issue in caught.value.issues] == ["a.mtl:2:1"]


def test_a_missing_library_leaves_the_shape(tmp_path):
    (tmp_path / "a.obj").write_bytes(OBJ)
    scene = load(tmp_path / "a.obj")
    assert any("a.mtl" in w and "grey" in w for w in scene.warnings)
    assert len(flatten(scene).shapes) == 3


def test_unknown_materials_are_named():
    report = parse(OBJ.replace(b"mtllib a.mtl\n", b""), "a.obj")
    assert list(report.data["bsdfs"]) == ["grey"]


def test_ply_and_stl_stand_upright(tmp_path):
    (tmp_path / "a.stl").write_bytes(STL)
    (tmp_path / "a.ply").write_bytes(mesh_file("<"))
    (shape,) = flatten(load(tmp_path / "a.stl")).shapes
    np.testing.assert_allclose(shape.to_world @ [0, 0, 1, 0], [0, 1, 0, 0], atol=1e-12)
    assert len(flatten(load(tmp_path / "a.ply")).shapes) == 1


def test_names_that_no_library_holds_are_grey(tmp_path):
    (tmp_path / "a.mtl").write_text("newmtl red\nKd 1 0 0\nNi 0\n")
    text = OBJ.replace(b"usemtl lamp", b"usemtl lost")
    found = parse(text, "a.obj", Reach(tmp_path))
    assert any('a.obj:14:1: unknown material "lost"' in text for text in found.warnings)
    assert len(found.data["bsdfs"]) == 2
    # So programs write that there is no index of refraction.
    assert "Ni 0: it is not an index of refraction" in found.notes


def test_blenders_negative_exponents_are_the_widest_highlight(tmp_path):
    def read(exponent):
        (tmp_path / "a.mtl").write_text(f"newmtl red\nKs 1 1 1\nNs {exponent}\n")
        return parse(OBJ, "a.obj", Reach(tmp_path))

    found = read("-1.960784")
    assert found.data["bsdfs"] == read("0").data["bsdfs"] != read("100").data["bsdfs"]
    assert "Ns below 0: the highlight is as wide as at 0" in found.notes


@pytest.mark.parametrize(
    ("name", "near"),
    [("a.mtl", ""), ("concrte.mtl", '; did you mean "concrete.mtl"?'), ("a.png", "")],
)
def test_only_files_of_a_kind_are_proposed(tmp_path, name, near):
    for beside in ("a.obj", "concrete.mtl"):
        (tmp_path / beside).write_bytes(OBJ)
    with pytest.raises(OutOfReachError) as caught:
        Reach(tmp_path).find(name)
    assert str(caught.value) == f'no such file: "{name}"{near}'


def test_texts_of_16_bits_and_points_alone():
    plain = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n"
    meant = parse(plain, "a.obj").data["nodes"]["mesh"]["shape"]
    for encoding in ("utf-16", "utf-8-sig"):
        found = parse(plain.decode().encode(encoding), "a.obj").data["nodes"]["mesh"]["shape"]
        np.testing.assert_array_equal(found.vertices, meant.vertices)
    with pytest.raises(SceneError, match="got 3 points without a face"):
        parse(plain.partition(b"f ")[0], "a.obj")


def test_channels_of_colours_are_not_chosen(tmp_path):
    pictures(tmp_path)
    plain, chosen = (material(f"map_Kd {o} a.png", tmp_path)[0].bsdf for o in ("", "-imfchan r"))
    assert chosen == plain
