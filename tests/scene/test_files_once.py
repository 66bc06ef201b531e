"""Meshes and pictures are read and checked once, from loading a scene to the end of its render."""

import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from PIL import Image as Picture

import alight
from alight.meshes import ply
from alight.meshes.triangles import MeshArrays
from alight.outputs.wraps import read_wraps
from alight.scene import checked, flatten, meshes
from alight.scene.images import read_image
from alight.scene.source import Source

#: All of a scene is read, whatever its integrator looks at; this one compiles soonest.
SMALL = ("film.size=[4, 4]", "integrator={type: ambient_occlusion}")
TRIANGLE = MeshArrays(
    np.array([[-1, -1, 0], [1, -1, 0], [0, 1, 0]], np.float32),
    np.array([[0, 1, 2]], np.int32),
    uvs=np.array([[0, 0], [1, 0], [0.5, 1]], np.float32),
)
OBJ = "mtllib a.mtl\nusemtl a\nv -1 -1 0\nv 1 -1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt .5 1\n"
FILES = {
    "a.mtl": "newmtl a\nKe 1 1 1\nmap_Ke a.png\nmap_Kd a.png\n",
    "scene.yaml": """alight: 1
camera: {type: pinhole, transform: [{translate: [0, 0, 4]}]}
environment: {type: environment, file: sky.png}
textures: {a: {type: bitmap, file: a.png}}
nodes:
  one: {shape: {type: mesh, file: a.ply}, bsdf: {type: diffuse, reflectance: a}}
  two: {shape: {type: mesh, file: a.ply, face_normals: true}, light: {type: area, radiance: a}}
""",
    "scene.obj": OBJ + "f 1/1 2/2 3/3\n",
    "scene.xml": """<scene version="3.0.0"><sensor type="perspective"/>
<emitter type="envmap"><string name="filename" value="sky.png"/></emitter>
<bsdf type="diffuse" id="a"><texture type="bitmap" name="reflectance">
<string name="filename" value="a.png"/></texture></bsdf>
<shape type="ply"><string name="filename" value="a.ply"/><ref id="a"/></shape>
<shape type="ply"><string name="filename" value="a.ply"/><boolean name="flip_normals" value="true"/>
<bsdf type="roughconductor"/></shape></scene>""",
    "scene.pbrt": """Camera "perspective"
WorldBegin
LightSource "infinite" "string filename" "sky.png"
LightSource "projection" "string filename" "a.png"
Texture "a" "spectrum" "imagemap" "string filename" "a.png"
AttributeBegin
AreaLightSource "diffuse" "string filename" "a.png" "float power" 3
Shape "plymesh" "string filename" "a.ply"
AttributeEnd
ReverseOrientation
Material "diffuse" "texture reflectance" "a"
Shape "plymesh" "string filename" "a.ply"
""",
    "scene.usda": """#usda 1.0
(
    upAxis = "Y"
    metersPerUnit = 1
)
def Mesh "m" (
    prepend apiSchemas = ["MaterialBindingAPI"]
) {
    point3f[] points = [(-1, -1, 0), (1, -1, 0), (0, 1, 0)]
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
    texCoord2f[] primvars:st = [(0, 0), (1, 0), (0.5, 1)] (interpolation = "vertex")
    rel material:binding = </a>
}
def Material "a" {
    token outputs:surface.connect = </a/s.outputs:surface>
    def Shader "s" {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:emissiveColor.connect = </a/t.outputs:rgb>
        token outputs:surface
    }
    def Shader "t" {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @a.png@
        float3 outputs:rgb
    }
}
""",
}


@pytest.fixture
def folder(tmp_path):
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    rng = np.random.default_rng(7)
    Picture.fromarray(rng.integers(1, 255, (4, 4, 3), np.uint8)).save(tmp_path / "a.png")
    Picture.fromarray(rng.integers(1, 255, (4, 8, 3), np.uint8)).save(tmp_path / "sky.png")
    ply.save(tmp_path / "a.ply", TRIANGLE)
    _write_gltf(tmp_path / "scene.gltf")
    return tmp_path


def _write_gltf(path):
    import json

    tables = (TRIANGLE.faces.astype(np.uint32), TRIANGLE.vertices, TRIANGLE.uvs)
    data = b"".join(table.tobytes() for table in tables)
    path.with_name("a.bin").write_bytes(data)
    ends = np.cumsum([table.nbytes for table in tables]).tolist()
    low, high = TRIANGLE.vertices.min(axis=0).tolist(), TRIANGLE.vertices.max(axis=0).tolist()
    textured = {"emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0}}
    content = {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": "a.bin", "byteLength": len(data)}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": end - table.nbytes, "byteLength": table.nbytes}
            for table, end in zip(tables, ends, strict=True)
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5125, "count": 3, "type": "SCALAR"},
            {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3"}
            | {"min": low, "max": high},
            {"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC2"},
        ],
        "images": [{"uri": "a.png"}],
        "textures": [{"source": 0}],
        "materials": [textured],
        "meshes": [
            {
                "primitives": [
                    {
                        "attributes": {"POSITION": 1, "TEXCOORD_0": 2},
                        "indices": 0,
                        "material": 0,
                    }
                ]
            }
        ],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
    }
    path.write_text(json.dumps(content))


class Opened:
    """Counts how often files of a folder are opened; a hook of the interpreter stays for good."""

    def __init__(self):
        self.folder, self.counts = None, Counter()
        sys.addaudithook(self.hear)

    def hear(self, event, arguments):
        if event != "open" or self.folder is None or not isinstance(arguments[0], str | Path):
            return
        path = Path(arguments[0])
        if path.is_absolute() and path.parent == self.folder:
            self.counts[path.name] += 1

    def during(self, folder, work):
        self.folder, self.counts = folder, Counter()
        try:
            work()
        finally:
            self.folder = None
        return self.counts


OPENED = Opened()


@pytest.mark.parametrize(
    "name", ["scene.yaml", "scene.obj", "scene.gltf", "scene.xml", "scene.pbrt", "scene.usda"]
)
def test_each_mesh_and_picture_is_read_once(folder, name):
    """Changes build the scene again, and so do renders; neither reads again."""
    if name.endswith(".usda"):
        pytest.importorskip("pxr")
    once = OPENED.during(folder, lambda: read_image(folder / "a.png"))["a.png"]
    if name.endswith(".usda"):
        # Its texture leaves the wrap to what the picture's header says.
        once += OPENED.during(folder, lambda: read_wraps(folder / "a.png"))["a.png"]
    expected = {"a.png": once, "sky.png": once, "a.ply": 1, "a.bin": 1, name: 1}

    def work():
        scene = alight.load(folder / name, SMALL)
        alight.render(scene, spp=1)
        alight.render(scene, spp=1)

    found = OPENED.during(folder, work)
    read = {file: found[file] for file in expected if found[file]}
    assert "a.png" in read and read == {file: expected[file] for file in read}


@pytest.mark.parametrize("name", ["scene.yaml", "scene.obj", "scene.gltf", "a.ply"])
def test_what_is_checked_is_not_checked_again(folder, name, monkeypatch):
    calls = []
    found = meshes.mesh_problem
    monkeypatch.setattr(meshes, "mesh_problem", lambda arrays: calls.append(1) or found(arrays))
    scene = alight.load(folder / name, SMALL)
    alight.render(scene, spp=1)
    assert len(calls) == 1


def test_a_scene_is_looked_at_once(folder, monkeypatch):
    calls, find = [], checked.find_problems
    monkeypatch.setattr(
        checked, "find_problems", lambda *given: calls.append(given[0]) or find(*given)
    )
    scene = alight.load(folder / "scene.yaml", SMALL)
    edited = alight.changed(scene, {"environment.scale": 0.5})
    notes = [flatten(edited).notes for _ in range(2)]
    assert len([one for one in calls if one is edited]) == 1 and notes[0] == notes[1]
    # What is made from it, or said to lie in another folder, may be wrong.
    for other in (
        edited.replaced(camera=None).made_from(edited),
        edited.from_source(Source(folder=folder / "elsewhere")),
    ):
        assert other.checked is None
        with pytest.raises(alight.SceneError):
            flatten(other)


def test_a_file_that_was_missing_is_found_when_it_is_there(folder):
    scene = alight.load(folder / "scene.yaml", SMALL)
    edited = alight.SceneManager(scene).set_value("nodes.one.shape.file=b.ply").scene
    with pytest.raises(alight.SceneError, match="no such file"):
        alight.render(edited, spp=1)
    (folder / "a.ply").rename(folder / "b.ply")
    alight.render(edited, spp=1)
