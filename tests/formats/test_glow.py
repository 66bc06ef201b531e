"""When the light of a model's own surfaces is enough to see it by."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image as Picture

from alight.core.constants import LUMINANCE
from alight.formats import load
from alight.formats.geometry.bounds import Bounds
from alight.formats.scenes.emission import LEAST, Glow
from alight.scene.files import Files
from alight.shapes.mesh import Mesh
from alight.textures.images import Image

#: A square of 1 m^2, its texture coordinates those of a picture.
SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
FACES = np.array([[0, 1, 2], [0, 2, 3]])


def square(uvs=SQUARE[:, :2]):
    return Mesh(vertices=SQUARE, faces=FACES, uvs=uvs)


def glow_of(radiance, mesh=None, to_world=None, folder=Path()):
    glow = Glow(Files(folder))
    glow.add(mesh or square(), np.eye(4) if to_world is None else to_world, radiance)
    return glow.total


def test_light_is_area_times_luminance():
    assert glow_of(2.0) == pytest.approx(2.0)
    assert glow_of([0.0, 1.0, 0.0]) == pytest.approx(LUMINANCE[1])
    assert glow_of(2.0, to_world=np.diag([2.0, 3.0, 1.0, 1.0])) == pytest.approx(12.0)
    assert glow_of({"type": "noise"}) == pytest.approx(1.0)


@pytest.mark.parametrize("packed", [True, False])
def test_pictures_count_where_the_mesh_shows_them(packed, tmp_path):
    # White at the upper left, 55 / 255 (linear 0.0382) at the lower right, black elsewhere.
    texels = np.zeros((2, 2, 1), np.uint8)
    texels[0, 0], texels[1, 1] = 255, 55
    Picture.fromarray(texels[..., 0]).save(tmp_path / "a.png")
    bitmap = {"type": "bitmap", **({"pixels": Image(texels)} if packed else {"file": "a.png"})}

    def shown(corner, texture=bitmap):
        mesh = square(0.1 + 0.3 * SQUARE[:, :2] + np.array(corner))
        return glow_of(texture, mesh, folder=tmp_path)

    assert shown((0.0, 0.5)) == pytest.approx(1.0)
    assert shown((0.0, 0.0)) == shown((0.5, 0.5)) == 0.0
    assert shown((0.5, 0.0)) == pytest.approx(((55 / 255 + 0.055) / 1.055) ** 2.4)
    assert shown((0.5, 0.0), bitmap | {"color_space": "linear"}) == pytest.approx(55 / 255)
    assert shown((3.0, -1.5)) == pytest.approx(1.0)
    assert shown((0, 0.5), {"type": "multiply", "a": [3.0] * 3, "b": bitmap}) == pytest.approx(3)
    moved = bitmap | {"to_uv": {"matrix": [[1, 0, 0], [0, 1, 0.5]]}}
    assert shown((0.0, 0.0), moved) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("shape", "area"),
    [("sphere", 4.0 * np.pi), ("cube", 24.0), ("rectangle", 4.0), ("disk", np.pi), ("plane", 0.0)],
)
def test_shapes_with_a_formula_shine_with_their_area(shape, area):
    glow = Glow(Files())
    glow.add_shape({"type": shape}, np.diag([2.0, 2.0, 2.0, 1.0]), 3.0)
    assert glow.total == pytest.approx(4.0 * area * 3.0, rel=1e-5)


def test_a_picture_that_cannot_be_read_is_left_to_who_reads_the_scene(tmp_path):
    assert glow_of({"type": "bitmap", "file": "none.png"}, folder=tmp_path) == pytest.approx(1.0)


def test_a_tenth_of_white_on_the_sides_of_the_box_is_enough():
    bounds = Bounds()
    bounds.add([[0, 0, 0], [1, 2, 3]], np.eye(4))
    glow = Glow(Files())
    assert not glow.suffices(bounds)
    glow.total = 0.99 * LEAST * 22.0
    assert not glow.suffices(bounds)
    glow.total *= 1.02
    assert glow.suffices(bounds)
    assert glow.suffices(Bounds())


MATERIALS = "newmtl dark\nKd 0.5 0.5 0.5\nnewmtl lamp\nKe {0} {0} {0}\n"
OBJECT = """mtllib a.mtl
v 0 0 0
v 4 0 0
v 4 0 4
v 0 4 4
usemtl dark
f 1 2 3
f 1 3 4
v 1 1 1
v 1.1 1 1
v 1.1 1.1 1
usemtl lamp
f 5 6 7
"""


@pytest.mark.parametrize(("radiance", "studio"), [(1.0, True), (5000.0, False)])
def test_a_faint_lamp_does_not_leave_a_model_in_the_dark(radiance, studio, tmp_path):
    (tmp_path / "a.mtl").write_text(MATERIALS.format(radiance))
    (tmp_path / "a.obj").write_text(OBJECT)
    scene = load(tmp_path / "a.obj")
    assert (scene.environment is not None) is studio
    assert any("too faint to see it by" in line for line in scene.warnings) is studio
    assert not any("has no light" in line for line in scene.warnings)
