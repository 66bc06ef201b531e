"""A problem names what has it: by its own number, its whole pointer and its own key."""

import math
import random

import pytest

import alight
from alight.core.errors import SceneError
from alight.formats.gltf.models import rooted
from alight.formats.gltf.values import Item
from alight.formats.reading.report import Report
from alight.textures.checkerboard import Checkerboard
from alight.textures.multiply import Multiply
from tests.formats.gltf.maker import Maker


@pytest.mark.parametrize("bad", [0, 2, 3])
def test_an_instance_has_its_own_number_and_not_its_prototype_s(bad, tmp_path):
    scales = ", ".join("(1e20, 1, 1)" if i == bad else "(1, 1, 1)" for i in range(4))
    (tmp_path / "a.usda").write_text(f"""#usda 1.0
def PointInstancer "p" {{
    rel prototypes = [</p/one>, </p/two>]
    int[] protoIndices = [1, 1, 0, 1]
    point3f[] positions = [(0, 0, 1), (0, 0, 2), (0, 0, 3), (0, 0, 4)]
    float3[] scales = [{scales}]
    def Sphere "one" {{}}
    def Cube "two" {{}}
}}""")
    with pytest.raises(SceneError, match=f"the transform of instance {bad} must hold"):
        alight.load(tmp_path / "a.usda")


class TwoBuffers(Maker):
    """A file whose second buffer, which its first view means, has no bytes anywhere."""

    def _plain(self):
        return super()._plain() | {"buffers": [*self.json["buffers"], {"byteLength": 48}]}


def test_the_binary_part_of_a_file_is_its_first_buffer_alone(tmp_path):
    m = TwoBuffers()
    m.node(mesh=m.square())
    (tmp_path / "a.glb").write_bytes(m.glb())
    alight.load(tmp_path / "a.glb")
    m.json["bufferViews"][0] |= {"buffer": 1, "byteOffset": 0}
    (tmp_path / "a.glb").write_bytes(m.glb())
    with pytest.raises(SceneError) as caught:
        alight.load(tmp_path / "a.glb")
    assert "/buffers/1\n  needs a uri" in str(caught.value)


@pytest.mark.parametrize("seed", range(8))
def test_a_pointer_read_as_it_is_defined_gives_the_keys(seed):
    """RFC 6901: parts between slashes, in which ~1 is a slash and then ~0 a tilde."""
    rng = random.Random(seed)
    keys = ["".join(rng.choices("a~/01 ", k=rng.randrange(1, 7))) for _ in range(4)]
    pointer = ""
    for key in keys:
        pointer = Item({}, pointer, "a.gltf", Report()).at(key)
    first, *parts = pointer.split("/")
    assert first == ""
    assert [part.replace("~1", "/").replace("~0", "~") for part in parts] == keys


def test_a_roughness_that_no_picture_can_hold_becomes_its_mean_and_is_said_by_its_key():
    lost = []
    boards = [Checkerboard(color0=0.1, color1=0.4, scale=scale) for scale in (2.0, 3.0)]
    found = rooted(Multiply(a=boards[0], b=boards[1]), lost)
    assert found == pytest.approx(math.sqrt(0.25 * 0.25))
    assert lost == ["roughness: its texture became the mean"]
