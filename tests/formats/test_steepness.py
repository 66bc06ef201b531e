"""Normals that a map bends back are told of, and those of matte stuff are not touched."""

import numpy as np
import pytest

from alight.formats import load
from tests.formats.gltf.maker import Maker

FLAT, STEEP = (128, 128, 255), (238, 128, 192)


def warnings_of(folder, share, metallic, size=10, **info):
    """What is said of a material, a share of whose normals lean by 60 degrees."""
    m = Maker()
    texels = np.full((size, 10, 3), FLAT, np.uint8)
    texels[: round(size * share)] = STEEP
    m.picture(texels)
    pbr = {"metallicFactor": metallic, "roughnessFactor": 0.5}
    material = m.material(name="it", pbrMetallicRoughness=pbr, normalTexture={"index": 0, **info})
    m.node(mesh=m.square(material))
    (folder / "a.gltf").write_bytes(m.gltf())
    return [line for line in load(folder / "a.gltf").warnings if "bent back" in line]


@pytest.mark.parametrize("share", [0.0, 0.2, 1.0])
def test_steep_normals_of_metals_are_told_of(tmp_path, share):
    said = warnings_of(tmp_path, share, 1.0)
    assert len(said) == (share > 0.0)
    assert all(f'"it": {100 * share:.0f} % of its normals' in line for line in said)


def test_large_pictures_are_looked_at_in_part(tmp_path):
    (line,) = warnings_of(tmp_path, 0.5, 1.0, size=1200)
    assert "50 % of its normals" in line


def test_the_scale_of_a_map_counts(tmp_path):
    assert warnings_of(tmp_path, 1.0, 1.0) and not warnings_of(tmp_path, 1.0, 1.0, scale=0.25)


def test_steep_normals_of_matte_stuff_stay(tmp_path):
    assert not warnings_of(tmp_path, 1.0, 0.0)
