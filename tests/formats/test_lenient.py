"""Files that are missing: one error with its place, or, when lenient, a stand-in and a remark."""

import re

import pytest

import alight
from alight.core.errors import SceneError
from alight.formats.materials.textures import MISSING
from tests.formats import bare
from tests.formats.gltf.maker import Maker

XML = """<scene version="3.0.0">
<emitter type="envmap"><string name="filename" value="sky.exr"/></emitter>
<shape type="rectangle" id="wall"><bsdf type="diffuse">
<texture name="reflectance" type="bitmap"><string name="filename" value="wood.png"/></texture>
</bsdf></shape>
<shape type="rectangle"><bsdf type="normalmap">
<texture name="normalmap" type="bitmap">
<string name="filename" value="dents.png"/></texture>
<bsdf type="diffuse"/></bsdf></shape>
<shape type="ply"><string name="filename" value="head.ply"/></shape>
</scene>"""
PBRT = """Camera "perspective"
WorldBegin
LightSource "infinite" "string filename" "sky.exr"
Texture "wood" "spectrum" "imagemap" "string filename" "wood.png"
Material "diffuse" "texture reflectance" "wood" "string normalmap" "dents.png"
Shape "sphere"
Shape "plymesh" "string filename" "head.ply"
Include "lamps.pbrt"
"""
YAML = """alight: 1
camera: {type: pinhole, transform: {translate: [0, 0, 3]}}
environment: {type: environment, file: sky.exr}
nodes:
  wall: {shape: rectangle, bsdf: {type: diffuse, reflectance: {type: bitmap, file: wood.png}}}
  head: {shape: {type: mesh, file: head.ply}, bsdf: {type: diffuse}}
"""
OBJ = """mtllib a.mtl
v 0 0 0
v 1 0 0
v 0 1 0
usemtl wood
f 1 2 3
"""
MTL = "newmtl wood\nKd 1 1 1\nmap_Kd wood.png\nbump dents.png\n"
USD = """#usda 1.0
(
    upAxis = "Y"
    metersPerUnit = 1
)
def DomeLight "sky"
{
    asset inputs:texture:file = @sky.exr@
}
def "lost" (references = @head.usda@)
{
}
def Mesh "wall" (prepend apiSchemas = ["MaterialBindingAPI"])
{
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
    point3f[] points = [(0, 0, 0), (2, 0, 0), (2, 1, 0)]
    rel material:binding = </wood>
}
def Material "wood"
{
    token outputs:surface.connect = </wood/s.outputs:surface>
    def Shader "s"
    {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = </wood/p.outputs:rgb>
        float inputs:roughness.connect = </wood/q.outputs:r>
        token outputs:surface
    }
    def Shader "p"
    {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @wood.png@
        float3 outputs:rgb
    }
    def Shader "q"
    {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @dents.png@
        float outputs:r
    }
}
"""


def gltf():
    m = Maker()
    m.json["images"] = [{"uri": "wood.png"}, {"uri": "dents.png"}]
    m.json["textures"] = [{"source": 0}, {"source": 1}]
    wood = m.material(
        name="wood",
        pbrMetallicRoughness={
            "baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 1},
            "metallicFactor": 0.25,
        },
        normalTexture={"index": 1},
    )  # fmt: skip
    m.node(mesh=m.square(wood))
    return m.gltf().decode()


#: Name of the scene -> the text, and the files that it lacks.
FILES = {
    "a.xml": (XML, ("sky.exr", "wood.png", "dents.png", "head.ply")),
    "a.pbrt": (PBRT, ("sky.exr", "wood.png", "dents.png", "head.ply", "lamps.pbrt")),
    "a.yaml": (YAML, ("sky.exr", "wood.png", "head.ply")),
    "a.obj": (OBJ, ("wood.png", "dents.png")),
    "a.gltf": (gltf(), ("wood.png", "dents.png")),
    "a.usda": (USD, ("sky.exr", "wood.png", "dents.png", "head.usda")),
}


@pytest.fixture(params=FILES)
def case(request, tmp_path):
    """A scene file, and what it lacks."""
    if request.param == "a.usda":
        pytest.importorskip("pxr")
    text, lacking = FILES[request.param]
    (tmp_path / request.param).write_text(text)
    (tmp_path / "a.mtl").write_text(MTL)
    return tmp_path / request.param, lacking


def test_a_missing_file_is_an_error_with_its_place(case):
    path, _ = case
    with pytest.raises(SceneError) as caught:
        alight.load(path)
    assert path.name in str(caught.value) or "a.mtl:3" in str(caught.value)
    assert re.search(r"sky\.exr|wood\.png|head\.usda", str(caught.value))


def test_lenient_reading_lists_what_is_missing_and_shows_the_rest(case):
    path, lacking = case
    scene = bare.load(path, lenient=True)
    for name in lacking:
        assert sum(name in line for line in scene.warnings) >= 1, name
    parts = repr((scene.nodes, scene.bsdfs, scene.textures, scene.environment))
    assert parts.count(MISSING.digest) == 1
    assert not [name for name in lacking if name in parts]
    shapes = [node for _, _, node in scene.walk() if node.shape is not None]
    assert len(shapes) == (2 if path.suffix == ".xml" else 1)
    if "sky.exr" in lacking:
        lights = [scene.environment, *(node.light for _, _, node in scene.walk())]
        assert [light.type_name() for light in lights if light is not None] == ["constant"]


def native(tmp_path, nodes, rest=""):
    path = tmp_path / "a.yaml"
    path.write_text(
        "alight: 1\ncamera: {type: pinhole, transform: {translate: [0, 0, 3]}}\n"
        f"environment: constant\n{rest}nodes:\n  ball: {{shape: sphere}}\n{nodes}"
    )
    return path


def test_a_lost_mesh_takes_along_what_a_node_has_by_its_shape_only(tmp_path):
    lost = "shape: {type: mesh, file: lost.ply}"
    nodes = f"  lamp: {{{lost}, light: {{type: area, radiance: 3}}}}\n"
    nodes += f"  spark: {{{lost}, light: {{type: point, intensity: 1}}}}\n"
    nodes += f"  smoke: {{{lost}, interior: fog}}\n"
    fog = "media: {fog: {type: homogeneous, sigma_a: 0.1, sigma_s: 0.1}}\n"
    scene = bare.load(native(tmp_path, nodes, fog), lenient=True)
    assert scene.nodes["lamp"].light is None
    assert scene.nodes["spark"].light.type_name() == "point"
    assert scene.nodes["smoke"].interior is None
    assert sum("lost.ply" in line for line in scene.warnings) == 3


@pytest.mark.parametrize("kind", ["[mesh]", "{mesh: 1}"])
def test_types_that_are_no_names_are_told_as_ever(kind, tmp_path):
    path = native(tmp_path, f"  odd: {{shape: {{type: {kind}, file: lost.ply}}}}\n")
    with pytest.raises(SceneError, match=r"odd\.shape"):
        alight.load(path, lenient=True)


def test_pictures_of_numbers_and_normals_are_flat_where_they_are_missing(tmp_path):
    dents = "{type: bitmap, file: dents.png, color_space: linear}"
    rest = (
        f"bsdfs: {{b: {{type: normal_map, texture: {dents}, "
        f"bsdf: {{type: principled, roughness: {dents}}}}}}}\n"
    )
    scene = bare.load(native(tmp_path, "", rest), lenient=True)
    assert MISSING.digest not in repr(scene.bsdfs)
    assert "squares" not in " ".join(scene.warnings)
    (tmp_path / "a.pbrt").write_text(
        'Camera "perspective"\nWorldBegin\nLightSource "infinite"\n'
        'Texture "holes" "float" "imagemap" "string filename" "holes.png"\n'
        'Shape "sphere" "texture alpha" "holes"\n'
    )
    scene = bare.load(tmp_path / "a.pbrt", lenient=True)
    assert MISSING.digest not in repr((scene.bsdfs, scene.textures, scene.nodes))
    assert any("holes.png" in line for line in scene.warnings)


def test_what_lies_elsewhere_is_never_read(tmp_path):
    (tmp_path / "secret.ply").write_bytes(b"ply")
    (tmp_path / "inner").mkdir()
    path = tmp_path / "inner" / "a.xml"
    path.write_text(XML.replace("head.ply", "../secret.ply"))
    scene = bare.load(path, lenient=True)
    assert any("leads out of the folder" in line for line in scene.warnings)


def test_a_broken_file_is_an_error_all_the_same(tmp_path):
    path = tmp_path / "a.xml"
    path.write_text(XML)
    (tmp_path / "head.ply").write_bytes(b"ply\nnonsense")
    with pytest.raises(SceneError, match=r"head\.ply"):
        alight.load(path, lenient=True)


def test_a_broken_include_is_an_error_all_the_same(tmp_path):
    path = tmp_path / "a.pbrt"
    path.write_text(PBRT)
    (tmp_path / "lamps.pbrt").write_bytes(b"\xff")
    message = ""
    try:
        alight.load(path, lenient=True)
    except SceneError as error:
        message = str(error)
    assert '"lamps.pbrt" must be UTF-8 text' in message
