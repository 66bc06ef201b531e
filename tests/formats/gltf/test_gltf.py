"""glTF files: what each part becomes."""

import numpy as np
import pytest

from alight.core.errors import SceneError
from alight.formats import load, loads, save
from alight.formats.gltf.accessors import read_accessor
from alight.formats.gltf.container import open_document
from alight.formats.gltf.scene import parse
from alight.formats.gltf.write import write
from alight.formats.reach import Reach
from alight.formats.report import Report
from alight.lights.environment import map_of
from alight.scene import content_hash, flatten
from tests.formats.gltf.maker import POINTS, Maker, everything


def parsed(maker):
    found = parse(maker.gltf(), "model.gltf")
    assert not found.issues
    return found


def material_of(**material):
    """The description of one material of a square."""
    m = Maker()
    pixels = np.zeros((2, 2, 4), np.uint8)
    pixels[..., 1] = 128
    m.picture(pixels)
    m.node(mesh=m.square(m.material(name="it", **material)))
    return parsed(m).data["bsdfs"]["it"]


def core(bsdf):
    while "bsdf" in bsdf:
        bsdf = bsdf["bsdf"]
    return bsdf


def test_binary_and_text_say_the_same(tmp_path):
    (tmp_path / "a.glb").write_bytes(everything().glb())
    (tmp_path / "a.gltf").write_bytes(everything().gltf())
    first, second = load(tmp_path / "a.glb"), load(tmp_path / "a.gltf")
    # Arrays make scenes unequal objects; what is rendered is the same.
    assert first.film.size == (900, 600)
    assert first.camera == "root/eye"
    one, other = flatten(first), flatten(second)
    assert [s.name for s in one.shapes] == [s.name for s in other.shapes]
    assert one.bsdfs == other.bsdfs
    assert [g.digest for g in one.geometries] == [g.digest for g in other.geometries]


def test_everything_is_read_or_listed(tmp_path):
    (tmp_path / "a.glb").write_bytes(everything().glb())
    scene = load(tmp_path / "a.glb")
    remarks = scene.source.remarks
    assert dict(remarks.read) == {
        "meshes": 3, "pictures": 2, "materials": 3, "cameras": 2, "lights": 3, "nodes": 8,
    }  # fmt: skip
    said = "\n".join((*remarks.notes, *remarks.warnings))
    for word in ("ACME_hats", "ACME_glitter", "occlusionTexture", "animations", "range",
                 "choose with --camera"):  # fmt: skip
        assert word in said, word
    assert "studio" not in said
    # The mesh that stands twice is one prototype; the two others are alike.
    assert list(scene.prototypes) == ["mesh 0"]
    assert len(flatten(scene).geometries) == 2


def test_cameras_look_along_minus_z_with_y_up(tmp_path):
    m = Maker()
    m.json["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1.0}}]
    # A quarter turn about y: from -z to -x.
    m.node(camera=0, rotation=[0, np.sin(np.pi / 4), 0, np.cos(np.pi / 4)], translation=[5, 0, 0])
    m.node(mesh=m.square())
    (tmp_path / "a.gltf").write_bytes(m.gltf())
    flat = flatten(load(tmp_path / "a.gltf"))
    np.testing.assert_allclose(flat.camera.to_world @ [0, 0, -1, 0], [-1, 0, 0, 0], atol=1e-12)
    np.testing.assert_allclose(flat.camera.to_world @ [0, 1, 0, 0], [0, 1, 0, 0], atol=1e-12)
    assert flat.camera.camera.fov == pytest.approx(np.degrees(1.0))


@pytest.mark.parametrize("wanted", ["1", "node 6"])
def test_other_cameras_are_chosen_by_number_or_name(wanted, tmp_path):
    (tmp_path / "a.glb").write_bytes(everything().glb())
    scene = load(tmp_path / "a.glb", [f"camera={wanted}"])
    assert flatten(scene).camera.camera.height == 2.0
    with pytest.raises(SceneError, match="number of camera nodes, 2, got 7"):
        load(tmp_path / "a.glb", ["camera=7"])


def test_converted_scenes_are_the_same(tmp_path):
    (tmp_path / "a.glb").write_bytes(everything().glb())
    scene = load(tmp_path / "a.glb")
    (tmp_path / "out").mkdir()
    save(scene, tmp_path / "out" / "a.yaml")
    assert content_hash(load(tmp_path / "out" / "a.yaml")) == content_hash(scene)


def test_written_files_come_back(tmp_path):
    m = Maker()
    pixels = np.random.default_rng(1).integers(0, 256, (4, 4, 3)).astype(np.uint8)
    pbr = {
        "baseColorTexture": {"index": m.picture(pixels, wrapS=33071, wrapT=33648)},
        "baseColorFactor": [0.5, 1, 1, 1], "metallicFactor": 0.25, "roughnessFactor": 0.75,
    }  # fmt: skip
    coat = {"KHR_materials_clearcoat": {"clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.25}}
    square = m.square(m.material(pbrMetallicRoughness=pbr, doubleSided=True, extensions=coat))
    m.node(mesh=square, translation=[1, 2, 3], scale=[2, 1, 1])
    m.node(mesh=m.square(m.material(emissiveFactor=[1, 0.5, 0.25])))
    m.json["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "spot", "intensity": 7}]}}
    m.node(extensions={"KHR_lights_punctual": {"light": 0}}, rotation=[0.6, 0, 0, 0.8])
    m.json["cameras"] = [{"type": "perspective", "perspective": {"yfov": 0.5, "aspectRatio": 1.5}}]
    m.node(camera=0, translation=[0, 0, 9])
    (tmp_path / "a.glb").write_bytes(m.glb())
    first = flatten(load(tmp_path / "a.glb"))
    assert write(first, tmp_path / "b.glb") == []
    second = flatten(load(tmp_path / "b.glb"))
    assert [g.digest for g in first.geometries] == [g.digest for g in second.geometries]
    assert first.bsdfs == second.bsdfs
    assert [s.light for s in first.shapes] == [s.light for s in second.shapes]
    for one, other in zip(first.shapes + first.lights, second.shapes + second.lights, strict=True):
        np.testing.assert_allclose(one.to_world, other.to_world, atol=1e-12)
    np.testing.assert_allclose(first.camera.to_world, second.camera.to_world)
    assert second.camera.camera.fov == pytest.approx(first.camera.camera.fov)
    assert first.lights[0].light.intensity == pytest.approx(second.lights[0].light.intensity)


HEAD = """alight: 1
camera: {type: orthographic, height: 3}
film: {size: [6, 4]}
"""


def rewritten(text, tmp_path):
    """A scene, and what comes back of it; meshes have the two triangles of a square."""
    mesh = "{type: mesh, vertices: [[0,0,0],[1,0,0],[1,1,0],[0,1,0]], faces: [[0,1,2],[0,2,3]]MORE}"
    for more in ("COLORED", "SQUARE"):
        extra = ", colors: [[1,0,0],[0,1,0],[0,0,1],[1,1,1]]" if more == "COLORED" else ""
        text = text.replace(more, mesh.replace("MORE", extra))
    first = flatten(loads(HEAD + text))
    lost = write(first, tmp_path / "a.glb")
    return first, flatten(load(tmp_path / "a.glb")), lost


WRITTEN = {
    "index": "principled, ior: 1.3, base_color: [0.5, 0.25, 1], metallic: 0.25, roughness: 0.75",
    "liquid": "principled, transmission: 1, attenuation_color: [1, 0.5, 0.25], "
    "attenuation_distance: 3",
    "pane": "principled, transmission: 0.5, thin: true",
    "cloth": "principled, sheen_color: [0.1, 0.2, 0.3], sheen_roughness: 0.6",
    "varnish": "principled, clearcoat: 0.5, clearcoat_roughness: 0.25, specular: 0.5, "
    "specular_color: [1, 0.5, 0.25]",
}


@pytest.mark.parametrize("kind", WRITTEN)
def test_written_materials_come_back(kind, tmp_path):
    bsdf = f"{{type: {WRITTEN[kind]}}}"
    if "transmission" not in bsdf:
        bsdf = f"{{type: two_sided, bsdf: {bsdf}}}"
    text = f"nodes: {{a: {{shape: SQUARE, bsdf: {bsdf}}}, b: {{light: point}}}}"
    first, second, lost = rewritten(text, tmp_path)
    assert lost == []
    assert first.bsdfs == second.bsdfs
    assert second.camera.camera.height == pytest.approx(3.0)


def test_written_layers_and_colors_come_back(tmp_path):
    picture = "{type: bitmap, pixels: [[[0.5, 0.5, 1]]], interpolation: nearest}"
    kind = f"type: normal_map, texture: {picture}, scale: 0.5, rims: black"
    bump = f"{{{kind}, bsdf: {{type: principled}}}}"
    text = f"""nodes:
  a:
    shape: SQUARE
    bsdf: {{type: mask, opacity: 0.25, bsdf: {{type: two_sided, bsdf: {bump}}}}}
  b:
    shape: COLORED
    bsdf: {{type: principled, base_color: {{type: vertex_color}}}}
    light: {{type: area, radiance: [8, 4, 2]}}
  c: {{light: {{type: spot, intensity: [4, 2, 1], cutoff_angle: 40, beam_width: 10}}}}
  e: {{light: {{type: spot, falloff: quadratic}}}}
  d: {{shape: SQUARE, bsdf: {{type: principled, base_color: 0.125}}}}
"""
    first, second, lost = rewritten(text, tmp_path)
    assert [line for line in lost if "normal_map" in line] == ["normal_map: its rims"]
    falloffs = [line for line in lost if "falloff" in line]
    assert falloffs == ["a spot's linear falloff: glTF's is quadratic"]
    mask = second.bsdfs[second.shapes[0].bsdf]
    assert (mask.type, mask.opacity) == ("mask", 0.25)
    found = mask.bsdf.bsdf
    assert (found.type, found.scale, found.texture.interpolation) == ("normal_map", 0.5, "nearest")
    np.testing.assert_allclose(second.shapes[1].light.radiance, (8.0, 4.0, 2.0))
    colors = [first.geometries[1].colors, second.geometries[second.shapes[1].geometry].colors]
    np.testing.assert_array_equal(*colors)
    light = second.lights[0].light
    assert (light.cutoff_angle, light.beam_width) == (pytest.approx(40.0), pytest.approx(10.0))
    # The same square with another material is another mesh.
    assert second.bsdfs[second.shapes[2].bsdf] != mask


def test_what_gltf_cannot_hold_is_listed(tmp_path):
    lost = write(flatten(load("infinite-plane")), tmp_path / "a.glb")
    assert any("a plane is not a mesh" in line for line in lost)
    lost = write(flatten(load("material-ball")), tmp_path / "b.glb")
    assert any("environment" in line for line in lost)
    assert any("media" in line for line in write(flatten(load("fog")), tmp_path / "c.glb"))


def test_textures_of_normals_are_numbers():
    bsdf = material_of(normalTexture={"index": 0, "scale": 0.5})["bsdf"]
    assert (bsdf["type"], bsdf["scale"]) == ("normal_map", 0.5)
    assert bsdf["texture"]["color_space"] == "linear"


def test_factors_multiply_channels():
    bsdf = core(
        material_of(
            pbrMetallicRoughness={
                "metallicRoughnessTexture": {"index": 0}, "roughnessFactor": 0.5,
                "baseColorFactor": [0.5, 1, 1, 1], "baseColorTexture": {"index": 0},
            }
        )
    )  # fmt: skip
    assert bsdf["roughness"]["type"] == "multiply"
    assert bsdf["roughness"]["a"] == 0.5
    assert bsdf["roughness"]["b"]["channel"] == "g"
    assert bsdf["roughness"]["b"]["texture"]["color_space"] == "linear"
    assert bsdf["metallic"]["channel"] == "b"
    assert bsdf["base_color"]["a"] == [0.5, 1.0, 1.0]
    assert "color_space" not in bsdf["base_color"]["b"]


def test_opacity_cuts_or_blends():
    pbr = {"baseColorTexture": {"index": 0}, "baseColorFactor": [1, 1, 1, 0.5]}
    cut = material_of(alphaMode="MASK", alphaCutoff=0.25, pbrMetallicRoughness=pbr)
    assert cut["type"] == "mask"
    assert cut["opacity"]["type"] == "threshold"
    assert cut["opacity"]["cutoff"] == 0.25
    assert cut["opacity"]["texture"]["a"] == 0.5
    assert cut["opacity"]["texture"]["b"]["channel"] == "a"
    faint = {"baseColorFactor": [1, 1, 1, 0.25]}
    # At the cutoff a surface is there.
    for cutoff, opacity in ((0.25, None), (0.26, 0.0)):
        edge = material_of(alphaMode="MASK", alphaCutoff=cutoff, pbrMetallicRoughness=faint)
        assert edge.get("opacity") == opacity
    blended = material_of(alphaMode="BLEND", pbrMetallicRoughness=faint)
    assert blended["opacity"] == 0.25
    assert material_of(pbrMetallicRoughness=pbr)["type"] == "two_sided"


@pytest.mark.parametrize(
    ("extension", "value", "wanted"),
    [
        ("ior", {"ior": 1.2}, {"ior": 1.2}),
        ("specular", {"specularFactor": 0.25, "specularColorFactor": [1, 0.5, 0]},
         {"specular": 0.25, "specular_color": [1.0, 0.5, 0.0]}),
        ("transmission", {"transmissionFactor": 0.5}, {"transmission": 0.5, "thin": True}),
        ("transmission", {"transmissionFactor": 0.0}, {}),
        ("clearcoat", {"clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.25},
         {"clearcoat": 0.5, "clearcoat_roughness": 0.25}),
        ("sheen", {"sheenColorFactor": [0, 0, 1]},
         {"sheen_color": [0.0, 0.0, 1.0], "sheen_roughness": 0.0}),
        ("anisotropy", {"anisotropyStrength": 0.5, "anisotropyRotation": 1.5},
         {"anisotropy": 0.5, "anisotropy_rotation": 1.5}),
        ("iridescence", {"iridescenceFactor": 1, "iridescenceIor": 1.8},
         {"iridescence": 1.0, "iridescence_ior": 1.8, "iridescence_thickness": 400.0}),
    ],
)  # fmt: skip
def test_extensions_of_materials(extension, value, wanted):
    bsdf = core(material_of(extensions={f"KHR_materials_{extension}": value}))
    plain = core(material_of())
    assert {key: bsdf[key] for key in bsdf if key not in plain} == wanted


def test_a_reflection_of_more_than_the_index_has_becomes_a_larger_index():
    """F0 = 0.04 times 2, as some exporters write it; of what transmits light the index stays."""
    bright = {"KHR_materials_specular": {"specularColorFactor": [2, 1, 0.5]}}
    bsdf = core(material_of(extensions=bright))
    assert ((bsdf["ior"] - 1.0) / (bsdf["ior"] + 1.0)) ** 2 == pytest.approx(0.08)
    assert bsdf["specular_color"] == [1.0, 0.5, 0.25]
    glass = bright | {"KHR_materials_transmission": {"transmissionFactor": 1}}
    bsdf = core(material_of(extensions=glass))
    assert "ior" not in bsdf
    assert bsdf["specular_color"] == [1.0, 1.0, 0.5]
    mirror = {"KHR_materials_specular": {"specularColorFactor": [99, 99, 99]}}
    assert core(material_of(extensions=mirror))["ior"] == 5.0


def test_glass_has_a_volume_and_needs_no_second_side():
    extensions = {
        "KHR_materials_transmission": {"transmissionFactor": 1},
        "KHR_materials_volume": {"thicknessFactor": 0.1, "attenuationDistance": 3},
    }
    bsdf = material_of(extensions=extensions)
    assert bsdf["type"] == "principled"
    assert bsdf["attenuation_distance"] == 3.0
    assert "thin" not in bsdf


def test_lights_keep_their_units_and_directions(tmp_path):
    (tmp_path / "a.glb").write_bytes(everything().glb())
    flat = flatten(load(tmp_path / "a.glb"))
    found = {placed.light.type_name(): placed for placed in flat.lights}
    assert found["spot"].light.intensity == (5.0, 2.5, 1.0)
    assert found["spot"].light.cutoff_angle == pytest.approx(np.degrees(0.5))
    assert found["spot"].light.beam_width == pytest.approx(np.degrees(0.1))
    assert found["spot"].light.falloff == "quadratic"
    # Along -z of its node, which stands upright at x = -2.
    np.testing.assert_allclose(found["spot"].to_world @ [0, 0, 1, 0], [0, 0, -1, 0], atol=1e-12)
    np.testing.assert_allclose(found["spot"].to_world[:3, 3], [-2, 0, 0])
    np.testing.assert_allclose(
        found["directional"].to_world @ [0, 0, 1, 0], [0, 0, -1, 0], atol=1e-12
    )
    area = [s.light for s in flat.shapes if s.light is not None]
    # Half of it is there.
    assert area[0].radiance.a == (2.0, 1.0, 0.0)


@pytest.mark.parametrize("azimuth", [0.0, 30.0, 200.0])
def test_the_studio_looks_the_same_from_any_camera(azimuth, tmp_path):
    m = Maker()
    m.node(mesh=m.square())
    m.json["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1.0}}]
    half = 0.5 * np.radians(azimuth)
    m.node(camera=0, rotation=[0, np.sin(half), 0, np.cos(half)])
    (tmp_path / "a.glb").write_bytes(m.glb())
    flat = flatten(load(tmp_path / "a.glb"))
    (light,) = flat.environments
    # A direction of the studio's picture, seen from the camera: columns are to_world's axes.
    to_studio = map_of(light.light, light.to_world, compensated=False).table[:9].reshape(3, 3)
    seen = flat.camera.to_world[:3, :3].T @ to_studio.T @ [0.0, 0.0, 1.0]
    # Its front is 30 degrees to the left of the viewer.
    np.testing.assert_allclose(seen, [-0.5, 0.0, np.sqrt(0.75)], atol=1e-6)


def test_a_file_without_light_or_camera_gets_both_and_says_so(tmp_path):
    m = Maker()
    m.node(mesh=m.square(), scale=[10, 10, 10], translation=[100, 0, 0])
    (tmp_path / "a.gltf").write_bytes(m.gltf())
    scene = load(tmp_path / "a.gltf")
    assert any("no light" in w for w in scene.warnings)
    assert any("no camera" in w for w in scene.warnings)
    eye = scene.camera.transform.matrix
    # Two opposite sides of the square are equally far from the edges of the picture.
    seen = np.linalg.inv(eye) @ [[100, 110, 110, 100], [0, 0, 10, 10], [0] * 4, [1] * 4]
    places = seen[:2] / seen[2]
    assert abs(places.min(axis=1) + places.max(axis=1)).min() < 1e-9


ACCESSORS = {
    "bytes": (np.array([[-128, 0, 127]], "i1"), True, [[-1, 0, 1]]),
    "unsigned bytes": (np.array([[0, 51, 255]], "u1"), True, [[0, 0.2, 1]]),
    "shorts": (np.array([[-32767, 0, 32767]], "<i2"), True, [[-1, 0, 1]]),
    "unsigned shorts": (np.array([[0, 13107, 65535]], "<u2"), True, [[0, 0.2, 1]]),
    "plain shorts": (np.array([[-5, 300, 7]], "<i2"), False, [[-5, 300, 7]]),
    "floats": (np.array([[-5, 300, 7]], "<f4"), False, [[-5, 300, 7]]),
}


@pytest.mark.parametrize("kind", ACCESSORS)
def test_accessors_of_every_type(kind):
    table, normalized, wanted = ACCESSORS[kind]
    m = Maker()
    index = m.accessor(table, normalized=normalized)
    document = open_document(m.glb(), "a", Reach(), Report())
    np.testing.assert_allclose(read_accessor(document, index), wanted, atol=1e-7)


def test_accessors_with_strides_and_sparse_rows():
    m = Maker()
    rows = np.arange(20, dtype="<f4").reshape(4, 5)
    view = m.view(rows.tobytes(), byteStride=20)
    m.json["accessors"].append(
        {"bufferView": view, "byteOffset": 4, "componentType": 5126, "count": 4, "type": "VEC3",
         "sparse": {
             "count": 2,
             "indices": {"bufferView": m.view(np.array([1, 3], "<u2").tobytes()),
                         "componentType": 5123},
             "values": {"bufferView": m.view((-np.ones((2, 3), "<f4")).tobytes())},
         }}
    )  # fmt: skip
    document = open_document(m.glb(), "a", Reach(), Report())
    wanted = rows[:, 1:4].copy()
    wanted[[1, 3]] = -1
    np.testing.assert_array_equal(read_accessor(document, 0), wanted)


def test_strips_and_fans_keep_their_sides():
    for mode, order in ((5, [0, 1, 3, 2]), (6, [0, 1, 2, 3])):
        m = Maker()
        m.node(mesh=m.square())
        primitive = m.json["meshes"][0]["primitives"][0]
        primitive |= {"mode": mode, "indices": m.accessor(np.array(order, "<u1"))}
        faces = parsed(m).data["nodes"]["node 0"]["shape"].faces
        a, b, c = (POINTS[faces[:, i]] for i in range(3))
        assert (np.cross(b - a, c - a)[:, 2] > 0).all(), mode
        wanted = {5: [{0, 1, 3}, {1, 2, 3}], 6: [{0, 1, 2}, {0, 2, 3}]}[mode]
        assert [set(face) for face in faces.tolist()] == wanted


def test_nodes_are_scaled_then_turned_then_moved(tmp_path):
    m = Maker()
    # A quarter turn about z: from x to y.
    turn = [0, 0, np.sin(np.pi / 4), np.cos(np.pi / 4)]
    m.node(mesh=m.square(), scale=[2, 3, 4], rotation=turn, translation=[5, 6, 7])
    (tmp_path / "a.gltf").write_bytes(m.gltf())
    (shape,) = flatten(load(tmp_path / "a.gltf")).shapes
    np.testing.assert_allclose(shape.to_world @ [1, 0, 0, 1], [5, 8, 7, 1], atol=1e-12)
    np.testing.assert_allclose(shape.to_world @ [0, 1, 1, 1], [2, 6, 11, 1], atol=1e-12)


@pytest.mark.parametrize("normalized", [True, False])
def test_colors_of_vertices_in_bytes_reach_one(normalized):
    m = Maker()
    table = np.array([[0, 51, 255]] * 4, "u1")
    m.node(mesh=m.square(COLOR_0=m.accessor(table, normalized=normalized)))
    colors = parsed(m).data["nodes"]["node 0"]["shape"].colors
    np.testing.assert_allclose(colors, [[0, 0.2, 1]] * 4, atol=1e-7)


def test_the_same_mesh_with_other_weights_is_another_one():
    m = Maker()
    square = m.square()
    targets = {
        "POSITION": m.accessor(np.tile(np.array([[0, 0, 2]], "<f4"), (4, 1))),
        "NORMAL": m.accessor(np.tile(np.array([[1, 0, 0]], "<f4"), (4, 1))),
    }
    primitive = m.json["meshes"][0]["primitives"][0]
    primitive["targets"] = [targets]
    upright = np.tile(np.array([[0, 0, 1]], "<f4"), (4, 1))
    primitive["attributes"]["NORMAL"] = m.accessor(upright)
    for weight in (0.5, 1.5):
        m.node(mesh=square, weights=[weight])
    data = parsed(m).data
    for node, weight in zip(data["nodes"].values(), (0.5, 1.5), strict=True):
        [part] = data["prototypes"][node["instance"]]["children"].values()
        np.testing.assert_array_equal(part["shape"].vertices[:, 2], 2 * weight)
        np.testing.assert_array_equal(part["shape"].normals, [[weight, 0, 1]] * 4)


def test_morph_targets_move_vertices():
    m = Maker()
    m.node(mesh=m.square(), weights=[0.5])
    up = np.tile(np.array([[0, 0, 2]], "<f4"), (4, 1))
    m.json["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": m.accessor(up)}]
    shape = parsed(m).data["nodes"]["node 0"]["shape"]
    np.testing.assert_array_equal(shape.vertices, POINTS + np.array([0, 0, 1]))


def test_hierarchies_deeper_than_ours_are_multiplied_out(tmp_path):
    m = Maker()
    last = m.node(mesh=m.square())
    for _ in range(60):
        last = m.node(children=[last], translation=[1, 0, 0], scale=[1, 1, 1])
    (tmp_path / "a.gltf").write_bytes(m.gltf())
    (shape,) = flatten(load(tmp_path / "a.gltf")).shapes
    np.testing.assert_allclose(shape.to_world[:3, 3], [60, 0, 0])
