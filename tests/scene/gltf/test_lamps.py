"""What counts as a light of a glTF file."""

import pytest

from alight.scene import load
from tests.scene.gltf.maker import Maker


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
