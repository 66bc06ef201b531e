"""glTF files: what each part becomes."""

import numpy as np
import pytest

from alight.core.errors import SceneError
from alight.formats import load, loads, save
from alight.formats.gltf.write import write
from alight.lights.environment import map_of
from alight.scene import content_hash, flatten
from tests.formats.gltf.maker import Maker, everything


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
        "animations": 1,
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


def test_cameras_far_away_are_not_scaled(tmp_path):
    m = Maker()
    m.json["cameras"] = [{"type": "orthographic", "orthographic": {"xmag": 2, "ymag": 1}}]
    m.node(mesh=m.square())
    m.node(camera=0, scale=[2, 2, 2], translation=[1e7, 0, 0])
    (tmp_path / "a.glb").write_bytes(m.glb())
    to_world = flatten(load(tmp_path / "a.glb")).camera.to_world
    np.testing.assert_allclose(to_world[:3, :3], np.eye(3), atol=1e-12)


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
