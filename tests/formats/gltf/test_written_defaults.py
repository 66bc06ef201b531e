"""What a scene leaves to our defaults, and glTF has others for: written files say it."""

import numpy as np
import pytest

from alight.lights.model import LIGHTS
from tests.formats.gltf.test_written_places import written
from tests.formats.gltf.written import SQUARE

NORMALS = {"type": "bitmap", "color_space": "linear", "pixels": [[[0.6, 0.5, 1.0]]]}


@pytest.mark.parametrize("cutoff", [12.0, 40.0, 80.0])
def test_a_spot_is_even_as_far_as_ours_is(cutoff, tmp_path):
    """Of a scene that does not say how far: the same light as of one that says so."""
    spot = {"type": "spot", "cutoff_angle": cutoff, "falloff": "quadratic"}
    first, _, file, _ = written(tmp_path, {"a": {"light": spot}})
    said = first.lights[0].light.replaced(beam_width=0.75 * cutoff)
    rows = [np.concatenate(LIGHTS["spot"].place(light, np.eye(4))) for light in
            (first.lights[0].light, said)]  # fmt: skip
    np.testing.assert_array_equal(*rows)
    cone = file["extensions"]["KHR_lights_punctual"]["lights"][0]["spot"]
    assert cone["innerConeAngle"] == pytest.approx(np.radians(0.75 * cutoff))


@pytest.mark.parametrize("own", [None, [0.5, 0.5, 1.0], "same"])
def test_a_coat_says_whether_it_follows_the_bumps_below(own, tmp_path):
    """Ours does where it has no normals of its own; that of glTF is smooth then."""
    coated = {"type": "principled", "clearcoat": 0.5}
    if own is not None:
        coated["clearcoat_normal"] = NORMALS if own == "same" else own
    bsdf = {"type": "normal_map", "texture": NORMALS, "scale": 0.5, "bsdf": coated}
    _, second, file, _ = written(tmp_path, {"a": {"shape": SQUARE, "bsdf": bsdf}})
    [material] = file["materials"]
    coat = material["extensions"]["KHR_materials_clearcoat"]
    if own is None:
        assert coat["clearcoatNormalTexture"] == material["normalTexture"]
    assert ("clearcoatNormalTexture" in coat) == (own is None or own == "same")
    [found] = second.bsdfs
    while "bsdf" in dict(found):
        found = found.bsdf
    if own is None:
        assert found.clearcoat_normal is None
    elif own == "same":
        texels = found.clearcoat_normal.pixels.texels.ravel()[:3]
        np.testing.assert_allclose(texels / 255.0, [0.6, 0.5, 1.0], atol=3e-3)
