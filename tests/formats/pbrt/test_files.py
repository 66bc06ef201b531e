"""Words, directives, attribute stacks, includes: what a file says, and what is wrong with it."""

import gzip

import numpy as np
import pytest

from alight.core.errors import SceneError
from alight.formats import load, loads
from alight.scene.keyframes import Keyframes
from tests.formats.pbrt.reading import HEAD, issues, messages, node, ray, read, read_old, world

SPHERE = 'Shape "sphere"'


def test_quotes_brackets_remarks_and_truth_values():
    body = """# a remark with "quotes" and [brackets
    Shape "sphere" "float radius" 2 # behind it
    Shape "sphere" "float radius" [ 3 ]
    LightSource "point" "rgb I" [1 2 # within
      3] Material "diffuse"
    """
    scene = read(body)
    radii = [n.shape.radius for n in scene.nodes.values() if n.shape is not None]
    assert radii == [2.0, 3.0]
    [light] = [n.light for n in scene.nodes.values() if n.light is not None]
    np.testing.assert_allclose(light.intensity, (1, 2, 3))
    for truth in ("true", '"true"', '[ "true" ]', "[true]"):
        text = f'Material "dielectric" "float roughness" 0.25 "bool remaproughness" {truth}'
        [bsdf] = read(f"{text}\n{SPHERE}").bsdfs.values()
        assert bsdf.alpha == 0.5


def test_transformations_multiply_from_the_right():
    body = f"Translate 1 2 3 Scale 2 2 2 Rotate 90 0 0 1 {SPHERE}"
    assert world(read(body), (1, 0, 0)) == [1.0, 4.0, 3.0]
    # Columns one after the other.
    rows = "0 1 0 0  0 0 1 0  1 0 0 0  5 6 7 1"
    assert world(read(f"Transform [ {rows} ] {SPHERE}"), (1, 0, 0)) == [5.0, 7.0, 7.0]
    assert world(read(f"Translate 1 0 0 ConcatTransform {rows} {SPHERE}"), (0, 0, 0)) == [6, 6, 7]
    assert world(read(f"Translate 1 0 0 Transform [{rows}] {SPHERE}"), (0, 0, 0)) == [5, 6, 7]


def test_stacks_give_back_what_they_kept():
    body = """Translate 1 0 0
        AttributeBegin Translate 0 1 0 ReverseOrientation Material "dielectric" Shape "sphere"
        AttributeEnd Shape "sphere"
        TransformBegin Translate 0 0 1 ReverseOrientation Material "dielectric"
        TransformEnd Shape "sphere" """
    for scene, rest in (
        (read(body), ("default", False)),
        (read_old(body), ("dielectric", True)),
    ):
        places = [n.transform.apply_point([0, 0, 0]).tolist() for n in scene.nodes.values()]
        assert places == [[1, 1, 0], [1, 0, 0], [1, 0, 0]]
        # TransformEnd brings back the place alone in pbrt 3, everything in pbrt 4.
        found = [(n.bsdf, n.shape.flip_normals) for n in scene.nodes.values()]
        assert [bsdf.rstrip("- 2") for bsdf, _ in found] == ["dielectric", "default", rest[0]]
        assert [flipped for _, flipped in found] == [True, False, rest[1]]


def test_coordinate_systems_by_name():
    head = f"Translate 0 0 5 {HEAD}"
    # The camera's place in the world is the inverse of the transformation before it.
    assert world(read(f'CoordSysTransform "camera" {SPHERE}', head), (0, 0, 0)) == [0, 0, -5]
    body = f'Translate 1 1 1 CoordinateSystem "here" Identity CoordSysTransform "here" {SPHERE}'
    assert world(read(body), (0, 0, 0)) == [1, 1, 1]
    [message] = messages(f'CoordSysTransform "camra" {SPHERE}')
    assert 'did you mean "camera"' in message


def test_camera_is_left_handed_with_fov_along_the_shorter_side():
    head = 'LookAt 0 0 0  0 0 1  0 1 0\nCamera "perspective" "float fov" 60\n' + HEAD.split("\n")[1]
    scene = read(SPHERE, head + "\n")
    np.testing.assert_allclose(ray(scene, 4, 2), [0, 0, 1], atol=1e-12)
    # Looking along +z with y up, x is to the right. The film is 8 x 4.
    right, top = ray(scene, 8, 2), ray(scene, 4, 0)
    np.testing.assert_allclose(top, [0, np.sin(np.pi / 6), np.cos(np.pi / 6)], atol=1e-12)
    assert right[0] / right[2] == pytest.approx(2.0 * np.tan(np.pi / 6))


def test_screen_window_and_halffov():
    window = 'Camera "perspective" "float fov" 90 "float screenwindow" [-1 1 -0.5 0.5]\n'
    scene = read(SPHERE, window + HEAD.split("\n")[1] + "\n")
    assert np.tan(np.radians(scene.camera.camera.fov) / 2) == pytest.approx(0.5)
    scene = read(SPHERE, 'Camera "orthographic"\n' + HEAD.split("\n")[1] + "\n")
    assert scene.camera.camera.height == pytest.approx(2.0)
    shifted = window.replace("[-1 1", "[0 2") + HEAD.split("\n")[1] + "\n"
    [message] = messages(SPHERE, shifted)
    assert "its middle where the camera looks" in message
    assert read(SPHERE, shifted, lenient=True).warnings


def test_animated_lights_without_a_shape_stand_at_the_start_time_and_it_is_said():
    light = 'LightSource "point"'
    scene = read(f"ActiveTransform StartTime Translate 9 8 7 ActiveTransform All {light}")
    [node] = scene.nodes.values()
    assert node.transform.matrix[:3, 3].tolist() == [9, 8, 7]
    assert not isinstance(node.transform, Keyframes)
    assert any("start time" in warning for warning in scene.warnings)


def test_objects_are_prototypes():
    body = """ObjectBegin "tree" Translate 0 1 0 Shape "sphere" ObjectEnd
    Translate 5 0 0 ObjectInstance "tree" Translate 5 0 0 ObjectInstance "tree" """
    scene = read(body)
    assert [n.instance for n in scene.nodes.values()] == ["tree", "tree"]
    [child] = scene.prototypes["tree"].children.values()
    assert child.transform.apply_point([0, 0, 0]).tolist() == [0, 1, 0]
    [message] = messages('ObjectBegin "tree" ObjectEnd ObjectInstance "treee"')
    assert 'did you mean "tree"' in message


def test_attributes_give_parameters_to_all_that_follows():
    scene = read(
        'Attribute "shape" "float radius" 3 Shape "sphere" Shape "sphere" "float radius" 4'
    )
    assert [n.shape.radius for n in scene.nodes.values()] == [3.0, 4.0]


def test_includes_and_imports(tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "a.pbrt").write_text('Translate 1 0 0\nInclude "in/b.pbrt.gz"\n')
    packed = gzip.compress(b'Shape "sphere"\nReverseOrientation\n')
    (tmp_path / "in" / "b.pbrt.gz").write_bytes(packed)
    main = tmp_path / "scene.pbrt"
    text = HEAD + 'WorldBegin\nInclude "in/a.pbrt"\nShape "sphere"\n'
    main.write_text(text)
    scene = load(main)
    assert [n.shape.flip_normals for n in scene.nodes.values()] == [False, True]
    assert all(n.transform.matrix[0, 3] == 1.0 for n in scene.nodes.values())
    main.write_text(text.replace("Include", "Import"))
    # What an imported file changes ends with it.
    assert [n.shape.flip_normals for n in load(main).nodes.values()] == [False, False]


def test_files_out_of_reach_and_files_that_include_themselves(tmp_path):
    main = tmp_path / "scene.pbrt"
    for name in ("../x.pbrt", "/etc/passwd", "nothing.pbrt"):
        [message] = messages(f'Include "{name}"', folder=tmp_path)
        assert name in message
    (tmp_path / "a.pbrt").write_text('Include "b.pbrt"\nInclude "b.pbrt"\n')
    (tmp_path / "b.pbrt").write_text('Include "a.pbrt"\nInclude "a.pbrt"\n')
    main.write_text(HEAD + 'WorldBegin\nInclude "a.pbrt"\n')
    with pytest.raises(SceneError, match="16 levels deep"):
        load(main)


def test_problems_are_told_all_at_once_with_their_places():
    found = issues(
        'Shape "sphere" "float raduis" 2\nMaterail "diffuse"\nShape "sphree"\n'
        'NamedMaterial "red"\nTranslate 1 2\nShape "sphere" "float radius" -1'
    )
    lines = [int(issue.place.split(":")[1]) for issue in found]
    # The number that Translate lacks is looked for behind it.
    assert lines == [4, 5, 6, 7, 9, 9]
    text = [issue.message for issue in found]
    assert 'did you mean "radius"' in text[0]
    assert 'did you mean "Material"' in text[1]
    assert 'did you mean "sphere"' in text[2]
    assert 'unknown material "red"' in text[3]
    assert 'Translate needs 3 finite numbers, got "Shape" as number 3' in text[4]
    assert "must be > 0, got -1" in text[5]
    assert found[0].place == "scene.pbrt:4:16"


BROKEN = {
    'Shape "sphere" "float radius" [ 1': "no closing bracket",
    'Shape "sphere" "float radius" [ 1 x ]': 'must be a finite number, got "x"',
    'Shape "sphere" "float radius" 1e999': "must be a finite number",
    'Shape "sphere" "float radius" [ nan ]': "must be a finite number",
    'Shape "sphere" "flaot radius" 1': 'did you mean "float"',
    'Shape "sphere" "radius" 1': 'must be declared as "type name"',
    'Shape "sphere': "no closing quote",
    "Shape sphere": "needs a text in quotes",
    'Shape "sphere" "float radius" 1 "float radius" 2': "is given twice",
    'Shape "sphere" "string radius" "1"': 'must be given as "float radius"',
    'Shape "sphere" "float radius" [ 1 2 ]': "must hold 1 values, got 2",
    "AttributeEnd": "has no AttributeBegin",
    "AttributeBegin": "has no AttributeEnd",
    "TransformEnd": "has no AttributeBegin",
    "ObjectEnd": "has no ObjectBegin",
    "LookAt 1 1 1 1 1 1 0 1 0": "has no direction",
    "Rotate 90 0 0 0": "has no direction",
    "Scale 0 1 1 " + SPHERE: "singular",
    'ActiveTransform "Sometimes"': "unknown time",
    "WorldBegin": "is given twice",
    'Camera "perspective"': "before WorldBegin",
}


@pytest.mark.parametrize("body", BROKEN)
def test_broken_files(body):
    assert any(BROKEN[body] in message for message in messages(body)), messages(body)


def test_file_without_a_world_and_with_too_many_problems():
    with pytest.raises(SceneError, match="no WorldBegin"):
        loads(HEAD, "scene.pbrt")
    found = messages('NamedMaterial "red"\n' * 5000)
    assert 100 < len(found) < 110
    assert any("these are the first" in message for message in found)


def test_lenient_replaces_what_is_not_covered_and_says_so():
    body = 'Material "hairy" "float eumelanin" 2\nShape "sphere"\nShape "torus"\nFoo'
    with pytest.raises(SceneError) as caught:
        read(body)
    assert len(caught.value.issues) == 3
    scene = read(body.removesuffix("Foo"), lenient=True)
    assert node(scene).shape.type_name() == "sphere"
    assert len([warning for warning in scene.warnings if "scene.pbrt:" in warning]) == 2


def test_what_is_not_closed_is_named_with_its_end():
    wrong = messages("TransformBegin AttributeEnd\nWorldEnd", 'Film "image"\n')
    assert "has no AttributeBegin before it: the last one open is TransformBegin" in wrong
    assert messages('ObjectBegin "a"') == ["has no ObjectEnd"]
    assert messages("TransformBegin") == ["has no TransformEnd"]


def test_depths_below_zero_are_refused():
    head = f'{HEAD}Integrator "path" "integer maxdepth" -1\n'
    assert messages('Shape "sphere"', head) == ["must be >= 0, got -1"]
