"""What counts as a light of a glTF file."""

import pytest

from alight.core.errors import SceneError
from alight.formats import load
from tests.formats.gltf.maker import Maker


@pytest.mark.parametrize(("side", "studio"), [(0.3, True), (3.0, False)])
def test_a_lamp_of_a_model_counts_with_its_size_in_the_world(side, studio, tmp_path):
    m = Maker()
    lamp = m.square(m.material(emissiveFactor=[1, 1, 1]))
    m.node(mesh=m.square(m.material(pbrMetallicRoughness={})), scale=[5, 5, 5])
    m.node(mesh=lamp, scale=[side, side, 1])
    (tmp_path / "a.glb").write_bytes(m.glb())
    scene = load(tmp_path / "a.glb")
    assert (scene.environment is not None) is studio
    assert any("too faint to see it by" in line for line in scene.warnings) is studio


def test_unlit_surfaces_are_no_lamps(tmp_path):
    m = Maker()
    m.node(mesh=m.square(m.material(extensions={"KHR_materials_unlit": {}})), scale=[9, 9, 9])
    (tmp_path / "a.glb").write_bytes(m.glb())
    assert any("has no light" in line for line in load(tmp_path / "a.glb").warnings)


@pytest.mark.parametrize("both", [False, True])
def test_lamps_with_two_sides_are_told_of(both, tmp_path):
    m = Maker()
    m.node(mesh=m.square(m.material(emissiveFactor=[1, 1, 1], doubleSided=both)))
    m.node(mesh=m.square(m.material(pbrMetallicRoughness={}, doubleSided=True)))
    (tmp_path / "a.glb").write_bytes(m.glb())
    said = "\n".join(load(tmp_path / "a.glb").warnings)
    assert ("they shine on the outer side alone" in said) is both


def test_sides_are_true_or_false(tmp_path):
    m = Maker()
    m.node(mesh=m.square(m.material(pbrMetallicRoughness={}, doubleSided=2)))
    (tmp_path / "a.glb").write_bytes(m.glb())
    with pytest.raises(SceneError, match="/materials/0/doubleSided\n  must be true or false"):
        load(tmp_path / "a.glb")
